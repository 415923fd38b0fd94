"""Workers, local or on a cluster: one that dies is replaced, and what fails twice is no mark."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.batch import cluster, grade_one, pool
from grader.batch.grade_one import BuildFolder
from grader.batch.records import BatchError, Settings, Task
from grader.course.exercises import ROOT
from grader.sandbox import budget, scratch

AROUND = {"missing": (), "refused": (), "sources": (), "changed": (), "converted": ()}
START_SECONDS = 60


def tasks(count: int, isolation: str = "portable") -> Iterator[Task]:
    """Yield submissions whose files cannot be linked: quick to grade, at nothing."""
    for number in range(count):
        files = {"main.c": b"int x = ;\n", "raytracer.c": b"#error\n", "octree.c": b"#error\n"}
        yield Task(f"S{number}", "S", files, AROUND, Settings("fr", isolation))


@pytest.mark.long
def test_a_worker_that_is_killed_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its submission is graded by another; no process is left at the end."""
    started: list[int] = []
    start = pool._start

    def starting(folder: Path) -> pool._Worker:
        worker = start(folder)
        started.append(worker.process.pid)
        if len(started) == 1:
            os.kill(worker.process.pid, signal.SIGKILL)
        return worker

    monkeypatch.setattr(pool, "_start", starting)
    done = list(pool.run(tasks(2), 1, tmp_path))
    assert {each.name: each.failure for each in done} == {"S0": "", "S1": ""}
    assert all("results.json" in each.files for each in done)
    assert len(started) == 2
    assert not any(Path(f"/proc/{pid}").exists() for pid in started)


def a_program(folder: Path, text: str) -> str:
    """Return a program to run in the place of Python."""
    path = folder / "python"
    path.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    path.chmod(0o755)
    return str(path)


def test_what_kills_every_worker_is_a_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After two tries it is told, and the others go on."""
    monkeypatch.setattr(sys, "executable", a_program(tmp_path, "kill -9 $$"))
    done = list(pool.run(tasks(2), 2, tmp_path))
    assert {each.name: each.failure for each in done} == dict.fromkeys(
        ("S0", "S1"), "le processus qui évaluait ce rendu a disparu"
    )


def test_workers_that_cannot_start_end_the_batch_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A package is missing, say: the reason is told once, whatever the number of submissions."""
    started = tmp_path / "started"
    script = f"echo >> '{started}'\necho Traceback >&2\necho 'No module named x' >&2\nexit 1"
    monkeypatch.setattr(sys, "executable", a_program(tmp_path, script))
    with pytest.raises(BatchError) as raised:
        list(pool.run(tasks(50), 1, tmp_path))
    assert (raised.value.code, raised.value.values["reason"]) == (3, "No module named x")
    assert len(started.read_text(encoding="ascii").splitlines()) == pool.TRIES


def test_a_worker_that_does_not_start_among_others_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The machine is short of something for a moment: its submission is graded by another."""
    first = tmp_path / "first"
    script = f"[ -e '{first}' ] && exec '{sys.executable}' \"$@\"\ntouch '{first}'\nexit 1"
    monkeypatch.setattr(sys, "executable", a_program(tmp_path, script))
    done = list(pool.run(tasks(1), 1, tmp_path))
    assert [(each.name, each.failure) for each in done] == [("S0", "")]


def test_what_gives_no_answer_is_not_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would take as long again; the deadline is that of the budgets, not half an hour."""
    most = 2 * budget.SECONDS[budget.WALL]
    assert most >= pool.MOST_SECONDS
    started = tmp_path / "started"
    silent = tmp_path / "silent"
    silent.write_text(f"#!/bin/sh\necho >> '{started}'\nexec sleep 60\n", encoding="utf-8")
    silent.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(silent))
    monkeypatch.setattr(pool, "MOST_SECONDS", 0.5)
    monkeypatch.setattr(pool, "LOOK_SECONDS", 0.1)
    (done,) = pool.run(tasks(1), 1, tmp_path)
    assert done.failure == "pas de réponse après 0,5 s"
    assert started.read_text(encoding="ascii") == "\n"


def test_a_fault_of_the_grader_is_a_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever is raised: never a mark, never the end of the batch; and nothing stays behind."""
    (task,) = tasks(1)
    monkeypatch.setattr(BuildFolder, "warm", lambda self: (self.folder / "left").touch())

    def broken(*_: object, **__: object) -> None:
        raise RuntimeError("a bug")

    monkeypatch.setattr(grade_one, "run_checks", broken)
    graded = grade_one.grade(task, BuildFolder(tmp_path))
    assert (graded.failure, dict(graded.files)) == ("RuntimeError: a bug", {})
    assert list(tmp_path.iterdir()) == []


# pytest remembers what lies beside the folders on its way, at most 1000 names: others come and go.
FREED = """
import functools, gc, itertools, sys
from pathlib import Path
from grader.batch.grade_one import BuildFolder, grade
from grader.tests.batch import test_crew
place, counts = BuildFolder(Path(sys.argv[1])), []
for task in test_crew.first_tps(5):
    assert not grade(task, place).failure
    for each in gc.get_objects():
        if isinstance(each, functools._lru_cache_wrapper) and each.__module__ == "_pytest.nodes":
            each.cache_clear()
    gc.collect()
    counts.append(len(gc.get_objects()))
print(min(b - a for a, b in itertools.pairwise(counts[1:])))
"""


def first_tps(count: int) -> Iterator[Task]:
    """Yield submissions that are judged, no two of them the same."""
    for number in range(count):
        files = {"main.c": f"{main_c(STUDENT_MAIN)}/* {number} */\n".encode()}
        files["raytracer.h"] = b'#include "exercises.h"\n'
        yield Task(f"S{number}", "S", files, AROUND, Settings("fr", "portable"))


@pytest.mark.long
def test_a_worker_keeps_nothing_of_a_submission(tmp_path: Path) -> None:
    """However many it grades: what each of them left would be found after every one.

    One of them may: what is needed for the first time is loaded and stays, and Python sometimes
    keeps the last exception, with all that it has seen, until the next.
    """
    command = [sys.executable, "-c", FREED, str(tmp_path)]
    more = subprocess.check_output(command, cwd=ROOT, text=True, timeout=300)
    assert float(more) < 3


def test_a_full_disk_is_no_mistake_of_the_student(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The compiler fails then on right code: nothing is judged."""
    (task,) = tasks(1)
    monkeypatch.setattr(grade_one, "LEAST_BYTES", 1 << 62)
    graded = grade_one.grade(task, BuildFolder(tmp_path))
    assert "No space left on device" in graded.failure
    assert dict(graded.files) == {}


OWNER = """
import sys, time
from grader.sandbox import scratch
print(scratch.own_folder(), flush=True)
time.sleep(float(sys.argv[1]))
"""


@contextlib.contextmanager
def owner(folder: Path, seconds: int) -> Iterator[tuple[subprocess.Popen[str], Path]]:
    """Start a process that has a folder of temporary files there; yield both."""
    command = [sys.executable, "-c", OWNER, str(seconds)]
    environment = {**os.environ, "TMPDIR": str(folder)}
    pipe = subprocess.PIPE
    with subprocess.Popen(command, cwd=ROOT, env=environment, stdout=pipe, text=True) as process:
        assert process.stdout is not None
        try:
            yield process, Path(process.stdout.readline().strip())
        finally:
            process.kill()


def test_what_a_killed_process_left_is_removed_by_the_next(tmp_path: Path) -> None:
    """And nothing else: not the folder of one that lives, nor one that is not known to be ours."""
    (tmp_path / f"{scratch.PREFIX}unknown").mkdir()
    (tmp_path / f"{scratch.PREFIX}link").symlink_to(tmp_path)
    kept = {each.name for each in tmp_path.iterdir()}
    with owner(tmp_path, 60) as (_, living):
        with owner(tmp_path, 60) as (_, left):
            (left / "builds").mkdir()
        assert (left / "builds").is_dir()
        with owner(tmp_path, 0) as (process, own):
            assert process.wait(60) == 0
        assert {each.name for each in tmp_path.iterdir()} == {*kept, living.name}
    assert own != left


def test_what_a_killed_grade_left_is_removed_by_the_next(tmp_path: Path) -> None:
    """Of `make grade` too, by whatever command comes next; one that ends leaves nothing."""
    build, place = tmp_path / "build", tmp_path / "tmp"
    place.mkdir()
    environment = {**os.environ, "TMPDIR": str(place), "PYTHONPATH": str(ROOT)}

    def command(path: Path) -> list[str]:
        words = ["grade", str(path), "--tp", "1", "--build", str(build)]
        return [sys.executable, "-m", "grader", *words]

    pipe = subprocess.DEVNULL
    for each in (signal.SIGKILL, signal.SIGTERM):
        with subprocess.Popen(
            command(ROOT / "core_c"), cwd=tmp_path, env=environment, stdout=pipe
        ) as process:
            while not list(place.glob(f"{scratch.PREFIX}*/mrt-*")):
                assert process.poll() is None
            process.send_signal(each)
        assert list(place.iterdir())
        done = subprocess.run(
            command(tmp_path / "none"), env=environment, stderr=pipe, timeout=60, check=False
        )
        assert (done.returncode, list(place.iterdir())) == (2, [])


# ---- Dask ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """Start a real scheduler, as the instructors' page says; return its address."""
    with started(str(ROOT)) as address:
        yield address


@contextlib.contextmanager
def started(path: str) -> Iterator[str]:
    """Start a scheduler with that PYTHONPATH; yield its address."""
    pytest.importorskip("distributed")
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    process = subprocess.Popen(
        [*command, "--port", "0", "--no-dashboard", "--host", "127.0.0.1"],
        cwd="/",
        env={**os.environ, "PYTHONPATH": path},
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    address = next(
        found[0] for line in process.stderr if (found := re.search(r"tcp://127\.0\.0\.1:\d+", line))
    )
    yield address
    process.terminate()
    process.stderr.close()
    process.wait(START_SECONDS)


def worker(address: str, folder: Path) -> subprocess.Popen[bytes]:
    """Start a real worker, as the instructors' page says; `folder` is for its temporary files."""
    command = [sys.executable, "-m", "distributed.cli.dask_worker", address]
    options = ["--nthreads", "1", "--no-dashboard", "--no-nanny"]
    return subprocess.Popen(
        [*command, *options],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(folder)},
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )


@pytest.mark.exhaustive
@pytest.mark.filterwarnings("ignore")  # distributed's own, on shutdown
def test_a_dask_worker_that_dies_is_replaced_by_another(scheduler: str, tmp_path: Path) -> None:
    """All of the submissions come back, each once; as from the local workers.

    What it leaves is where the next one finds it.
    """
    workers = [worker(scheduler, tmp_path), worker(scheduler, tmp_path)]
    try:
        names = []
        for graded in cluster.run(tasks(5), scheduler):
            assert (graded.failure, "results.json" in graded.files) == ("", True)
            names.append(graded.name)
            if len(names) == 1:
                workers[0].kill()
        assert sorted(names) == [f"S{number}" for number in range(5)]
    finally:
        for each in workers:
            each.kill()
            each.wait(START_SECONDS)
    assert {each.name[: len(scratch.PREFIX)] for each in tmp_path.glob("mrt-*")} == {scratch.PREFIX}
    with owner(tmp_path, 0) as (process, _):
        assert process.wait(60) == 0
    assert not list(tmp_path.glob("mrt-*"))


@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_without_the_project_is_told_at_once(tmp_path: Path) -> None:
    """Before anything is sent, with the exception's own text; and another version too."""
    with started(str(tmp_path)) as address, pytest.raises(BatchError) as caught:
        list(cluster.run(tasks(1), address))
    assert (caught.value.key, caught.value.values["who"]) == ("batch.cluster_without", "scheduler")
    assert "grader" in str(caught.value.values["error"])


@pytest.mark.filterwarnings("ignore")
def test_another_version_is_told(scheduler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The code of both sides must be the same."""
    monkeypatch.setattr(cluster, "__version__", "0.0")
    with pytest.raises(BatchError) as caught:
        list(cluster.run(tasks(1), scheduler))
    assert caught.value.key == "batch.cluster_other"


def test_a_scheduler_that_is_not_there_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """One sentence with its address; and one where the package is missing."""
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 1)
    with pytest.raises(BatchError) as caught:
        list(cluster.run(tasks(1), "tcp://127.0.0.1:1"))
    assert caught.value.key == "batch.no_scheduler"
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BatchError) as caught:
        list(cluster.run(tasks(1), "tcp://127.0.0.1:1"))
    assert caught.value.key == "batch.no_dask"

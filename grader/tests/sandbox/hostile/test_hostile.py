"""Nothing that a submission does harms the grader or the machine, nor earns a point.

Everything here runs at level `strong`: as whoever runs the tests and, when that is root, once more
as an ordinary user.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import re
import shutil
import site
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from grader.authoring.specimens import hostile
from grader.authoring.specimens.hostile import MARK, SECRET_TEXT, Quick
from grader.build import builder
from grader.build.records import BuildResult, Target
from grader.course.exercises import ROOT
from grader.execution.canary import prove
from grader.execution.records import OUT_OF_TIME, Cause, Death, Limits
from grader.execution.session import Library, open_core
from grader.execution.worker_process import Died, Missing
from grader.intake.submission import read_submission
from grader.sandbox import tools
from grader.sandbox.budget import load
from grader.sandbox.levels import IsolationError, Level, using
from grader.tests.support.sampling import sampled
from grader.tests.support.shell import NOBODY

SIZE = (96, 64)
PIXELS = np.zeros((96 * 64, 3), np.float32)
ZERO = (0, 0, 0)
# Of one program, its limits and the end of its process, on a machine that is not busy.
LONGEST_SECONDS = 6
MOST_MEGABYTES = 1000  # that a program takes which may have 512, before it is seen and ended
STOLEN = re.compile(f"{SECRET_TEXT}|root:[x*]:|EXPECTED")
KEY = str(0x4D525421)  # of what the programs share, if they can
_SUBREAPER = 36


@pytest.fixture(autouse=True, scope="module")
def strong() -> Iterator[None]:
    """Work at level `strong`; only a machine that cannot, and is not CI, may skip."""
    try:
        with using(Level.STRONG):
            yield
    except IsolationError as error:
        if os.environ.get("MRT_CI"):
            raise
        pytest.skip(f"no strong isolation here: {error.best.reason}")


@pytest.fixture(scope="module")
def secret() -> Iterator[Path]:
    """Plant a file that everybody may read, as far as its rights go."""
    with tempfile.TemporaryDirectory(prefix="mrt-secret-") as name:
        folder = Path(name)
        folder.chmod(0o777)
        path = folder / "secret"
        path.write_text(SECRET_TEXT, encoding="ascii")
        yield path
        assert path.read_text(encoding="ascii") == SECRET_TEXT
        assert os.listdir(folder) == ["secret"]


@pytest.fixture(autouse=True, scope="module")
def nothing_left(cache: Path) -> Iterator[None]:
    """Hold that no process, file or shared memory outlives these tests."""
    ctypes.CDLL(None).prctl(_SUBREAPER, 1, 0, 0, 0)  # orphans become ours, and are seen
    before = len(_descendants())
    yield
    _wait_for(before)
    places = [Path("/"), Path("/tmp"), Path("/var/tmp"), Path("/dev/shm"), ROOT, ROOT / "build"]
    assert [path for each in places for path in each.glob(f"*{MARK}*")] == []
    assert list(cache.rglob(f"*{MARK}*")) == []
    for kind in ("shm", "msg", "sem"):
        assert KEY not in Path(f"/proc/sysvipc/{kind}").read_text(encoding="ascii")


def _wait_for(count: int) -> None:
    """Hold that no more processes run than so many, within a moment.

    One look decides: after it the worker may prepare its next session while the last one still
    ends, and a second look would see both.
    """
    deadline = time.monotonic() + 30
    while len(seen := _descendants()) > count:
        assert time.monotonic() < deadline, "\n".join(map(_told, sorted(seen, key=int)))
        time.sleep(0.01)


def _told(pid: str) -> str:
    """Return a process' state, parent and command, for the message of a failure."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        command = Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8").replace("\0", " ")
    except OSError:
        return f"{pid}: gone"
    return f"{pid}: {state[0]}, of {state[1]}: {command}"


def _descendants(pid: str = "self") -> set[str]:
    """Return the running processes that this one, or another, has started, and theirs."""
    found: set[str] = set()
    with contextlib.suppress(OSError):  # it may end while we look
        for task in Path(f"/proc/{pid}/task").glob("*/children"):
            found |= set(task.read_text(encoding="ascii").split())
    return {each for each in found if _runs(each)}.union(*map(_descendants, found))


def _runs(pid: str) -> bool:
    """Whether a process exists and is not merely waiting to be buried."""
    try:
        return ") Z " not in Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
    except OSError:
        return False


@pytest.fixture(scope="module")
def opened(cache: Path, secret: Path, strong: None) -> Iterator[tuple[dict[str, Library], int]]:
    """Build all the programs that run, without and with the sanitizers; count the processes.

    They are the most that there may be when no program runs: the workers, with a session each that
    is ready for the next program.
    """
    folder = hostile.write(cache / "hostile" / "rendu", secret, os.getpid())
    with (
        open_core(folder, *SIZE, cache=cache) as plain,
        open_core(folder, *SIZE, sanitized=True, cache=cache) as sanitized,
    ):
        built = {"plain": plain, "sanitized": sanitized}
        for core in built.values():
            core._process._control.pid()  # waits for the worker, which has no session yet
        yield built, len(_descendants()) + len(built)


@pytest.fixture(scope="module")
def cores(opened: tuple[dict[str, Library], int]) -> dict[str, Library]:
    """Return the builds by their names."""
    return opened[0]


@pytest.fixture(scope="module")
def quiet(opened: tuple[dict[str, Library], int]) -> int:
    """Return how many processes there may be when no program runs."""
    return opened[1]


def _run(core: Library, name: str) -> tuple[bool, Death | None, str]:
    """Run a program; return whether it could do what it tried, its end, and all that came back.

    Only what may end by its time has little of it: a busy machine ends nothing else early.
    """
    number = hostile.attacks().index(name)
    limits = Quick() if hostile.ends_of(name) & {*OUT_OF_TIME} else Limits()
    with core.session(limits) as session:
        try:
            reply = session.call("fill_circle", PIXELS, number, ZERO, ZERO)
        except Died as error:
            return False, error.death, error.death.text
        picture = reply.args["img"]
        return bool(picture[0, 0] == 1), None, session.output() + picture.tobytes().decode("latin1")


# What hangs does so in either build: once is enough.
BOTH = [
    (build, name)
    for build in ("plain", "sanitized")
    for name in hostile.attacks()
    if build == "plain" or not hostile.ends_of(name) & {*OUT_OF_TIME}
]


@pytest.mark.parametrize(
    ("build", "name"), sampled(BOTH, [each for each in BOTH if each[0] == "plain"])
)
def test_a_hostile_program_gets_nowhere(
    cores: dict[str, Library], quiet: int, build: str, name: str
) -> None:
    """It is refused, or ends as it must; nothing stolen comes back, and the worker goes on."""
    core = cores[build]
    started = time.monotonic()
    could, death, seen = _run(core, name)
    assert time.monotonic() - started < LONGEST_SECONDS * load()
    _wait_for(quiet)
    assert not could
    assert not STOLEN.search(seen)
    assert all(each.isprintable() or each in "\n\t" for each in (death.text if death else ""))
    ends = hostile.ends_of(name)
    if build == "sanitized" and death:
        # The sanitizers' own watch may end it first.
        assert death.cause in ends | {Cause.SIGNAL, Cause.EXIT, Cause.MEMORY}
    else:
        assert {death.cause} <= ends if death else not ends
    with core.session() as session:
        assert session.call("fill", PIXELS, (1, 1, 1)).args["img"].all()


@pytest.mark.parametrize(
    ("name", "function", "file"),
    [
        ("null_pointer", "attack_null_pointer", "ending.c"),
        ("one_past", "attack_one_past", "ending.c"),
        ("endless_loop", "attack_endless_loop", "ending.c"),
        ("sleep_for_ever", "attack_sleep_for_ever", "ending.c"),
        ("divide_by_zero", "attack_divide_by_zero", "ending.c"),
        ("endless_recursion", "deeper", "ending.c"),
        ("abort_at_once", "attack_abort_at_once", "ending.c"),
    ],
)
@pytest.mark.parametrize("build", ["plain", "sanitized"])
def test_an_end_is_placed(
    cores: dict[str, Library], build: str, name: str, function: str, file: str
) -> None:
    """Where the code was is told by its function and its own line, with or without sanitizers."""
    _, death, _ = _run(cores[build], name)
    assert death is not None
    place, line = death.location.split(":")
    source = (hostile.FOLDER / "run" / file).read_text(encoding="utf-8").splitlines()
    assert (place, death.function) == (file, function)
    heads = [each for each in source[: int(line)] if re.match(r"ATTACK|static", each)]
    assert function.removeprefix("attack_") in heads[-1]


def test_memory_is_bounded_under_the_sanitizers(cores: dict[str, Library]) -> None:
    """Where RLIMIT_AS does not count: the shadow of AddressSanitizer, filled megabyte by megabyte.

    While the code is loaded, and in a session that is only made ready, too.
    """
    _, death, said = _run(cores["sanitized"], "fill_shadow")
    assert death is not None
    assert (death.cause, death.word) == (Cause.MEMORY, "")
    reached = [int(each) for each in re.findall(r"^(\d+) MB$", said, re.MULTILINE)]
    assert 100 <= max(reached) < MOST_MEGABYTES


@pytest.mark.parametrize(
    ("name", "code"), list(hostile.loads()), ids=[name for name, _ in hostile.loads()]
)
def test_what_acts_while_loading_gains_nothing(
    name: str, code: str, cache: Path, tmp_path: Path
) -> None:
    """A session that ends, hangs or forges before the first call is the submission's own end."""
    folder = hostile.lay(tmp_path / "rendu", {"extra.c": code})
    with open_core(folder, *SIZE, cache=cache) as core:
        assert core.constants["EPSILON"] == pytest.approx(1e-4, rel=10)
        overruled = contextlib.nullcontext() if name in hostile.OVERRULED else None
        with overruled or pytest.raises((Died, Missing)), core.session(Quick()) as session:
            picture = session.call("fill_red", PIXELS).args["img"]
            assert (picture == (1, 0, 0)).all()


def _built(folder: Path, cache: Path) -> tuple[BuildResult, float]:
    started = time.monotonic()
    (result,) = builder.build(read_submission(folder), [Target(*SIZE)], cache)
    return result, time.monotonic() - started


def test_hostile_sources_steal_nothing_and_end(
    cache: Path, secret: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each is rejected or harmless within its limits, and no byte of the machine comes back."""
    monkeypatch.setattr(tools, "CPU_SECONDS", 1)
    monkeypatch.setattr(tools, "MEMORY_BYTES", 512 << 20)
    sources = dict(hostile.compilations(secret))
    assert len(sources) >= 25

    def outcome(name: str) -> tuple[BuildResult, float]:
        return _built(hostile.lay(tmp_path / name, {"extra.c": sources[name]}), cache)

    with ThreadPoolExecutor(2) as pool:
        results = dict(zip(sources, pool.map(outcome, sources), strict=True))
    for name, (result, seconds) in results.items():
        assert seconds < 20, name
        said = result.log + "".join(result.warnings) + result.linker
        assert not STOLEN.search(said), name
        if result.library:
            assert not STOLEN.search(Path(result.library).read_bytes().decode("latin1")), name
        if name.startswith(("steal", "bomb")):
            assert "extra.c" in result.rejected, name


def test_the_canary_sings(cache: Path) -> None:
    """At level strong every forbidden act is refused; without isolation the canary says so."""
    assert prove(cache).permitted == ()
    with using(Level.MEDIUM):
        assert "process" not in prove(cache).permitted
    with using(Level.PORTABLE):
        assert {"read", "process", "network", "include"} <= set(prove(cache).permitted)


@pytest.mark.exhaustive
@pytest.mark.skipif(os.geteuid() != 0, reason="this is the ordinary user")
def test_the_same_as_an_ordinary_user() -> None:
    """Everything of this file holds for a user without rights."""
    with tempfile.TemporaryDirectory(prefix="mrt-ordinary-") as name:
        folder = Path(name)
        for each in ("core_c", "reference", "grader"):
            shutil.copytree(ROOT / each, folder / each)
        for each in ("pyproject.toml", "INSTRUCTORS.md"):
            shutil.copy(ROOT / each, folder)
        packages = [path for path in map(Path, site.getsitepackages()) if path.is_dir()]
        (folder / "home").mkdir()
        subprocess.run(["chmod", "-R", "a+rX", folder], check=True, timeout=60)
        os.chown(folder / "home", NOBODY, NOBODY)
        command = [
            sys.executable,
            "-B",
            "-m",
            "pytest",
            "-q",
            "-x",
            "--basetemp=home/tests",
            "-m",
            "",
        ]
        done = subprocess.run(
            [*command, "grader/tests/sandbox/hostile"],
            cwd=folder,
            env={**os.environ, "HOME": str(folder / "home"), "PYTHONPATH": str(packages[0])},
            capture_output=True,
            text=True,
            timeout=1200,
            check=False,
            user=NOBODY,
            group=NOBODY,
            extra_groups=[],
        )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]

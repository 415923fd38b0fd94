"""The Python environment of the commands: which interpreter, which packages, and its failures."""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from grader.setup import environment, install
from grader.tests.support.shell import ROOT, run, script


def pythons() -> list[str]:
    """Return every interpreter of the machine that a person could have chosen."""
    folders = [Path(part) for part in os.environ.get("PATH", "").split(os.pathsep)]
    folders += [Path("/usr/bin"), *sorted(Path.home().glob(".pyenv/versions/*/bin"))]
    readable = [folder for folder in folders if os.access(folder, os.R_OK | os.X_OK)]
    found = {str(path) for folder in readable for path in folder.glob("python3*")}
    return sorted(path for path in found if re.search(r"python3(\.\d+)?$", path))


def version_of(python: str) -> tuple[int, ...]:
    """Return an interpreter's version, empty when it does not start."""
    code = "import sys; print(*sys.version_info[:2])"
    return tuple(map(int, run(python, "-I", "-S", "-c", code, cwd=ROOT).stdout.split()))


@pytest.mark.long
def test_every_python_from_3_10_on_is_accepted() -> None:
    """Each interpreter of the machine is accepted from 3.10 on, and refused before."""
    for python in pythons():
        version = version_of(python)
        done = run("sh", "grader/setup/environment.sh", "python", cwd=ROOT, PYTHON=python)
        if version >= (3, 10):
            assert (done.returncode, version_of(done.stdout.strip())) == (0, version), python
        else:
            assert done.returncode == 1, python
            assert done.stderr.startswith(f"PYTHON={python} : ce n'est pas un Python 3.10")


@pytest.mark.parametrize(
    ("first", "second", "chosen"),
    [
        ("0 /open/python3", "0 /other/python3", "/open/python3"),
        ("1 /closed/python3", "0 /open/python3", "/open/python3"),
        ("2 /incomplete/python3", "0 /open/python3", "/open/python3"),
    ],
)
def test_interpreter_preference(tmp_path: Path, first: str, second: str, chosen: str) -> None:
    """An interpreter that everybody can start, and make an environment with, comes first."""
    for name, answer in (("a b", first), ("c", second)):
        script(tmp_path / name / "python3", f'echo "{answer}"')
    path = f"{tmp_path / 'a b'}:{tmp_path / 'c'}:{os.environ['PATH']}"
    done = run("sh", "grader/setup/environment.sh", "python", cwd=ROOT, PATH=path)
    assert done.stdout.strip() == chosen


def test_shared_environment_is_used_as_it_is() -> None:
    """MRT_ENV=DIR gives that environment's interpreter."""
    done = run("sh", "grader/setup/environment.sh", "dev", cwd=ROOT, MRT_ENV=sys.prefix)
    assert (done.returncode, done.stderr) == (0, "")
    assert Path(done.stdout.strip()) == Path(sys.prefix) / "bin" / "python"


def test_shared_environment_without_python(tmp_path: Path) -> None:
    """MRT_ENV=DIR without bin/python is one line that names the folder and the cure."""
    place = str(tmp_path / "pas d'ici")
    done = run("sh", "grader/setup/environment.sh", "grade", cwd=ROOT, MRT_ENV=place)
    assert done.returncode == 1
    assert done.stderr.startswith(f"MRT_ENV={place} : bin/python manque")
    assert done.stderr.count("\n") == 1


def test_shared_environment_without_packages(tmp_path: Path) -> None:
    """MRT_ENV=DIR without the packages names each of them, in the person's language."""
    place = tmp_path / "vide"
    run(sys.executable, "-m", "venv", "--without-pip", str(place), cwd=tmp_path)
    command = ("sh", "grader/setup/environment.sh", "grade")
    done = run(*command, cwd=ROOT, MRT_ENV=str(place), MRT_LANG="en")
    names = "cffi, pycparser, numpy, pytest, rich, scipy, scikit-image, jinja2, pillow"
    names += ", tomli" * (sys.version_info < (3, 11))
    assert done.returncode == 1
    assert done.stderr.startswith(f"MRT_ENV={place}: it lacks {names}. ")


def pins(level: str) -> list[str]:
    """Return the lines of a level's list."""
    return install.requirements(level).read_text(encoding="utf-8").splitlines()


@pytest.mark.parametrize("level", environment.LEVELS)
def test_pins_are_plain(level: str) -> None:
    """A list holds `name==version`, with a condition at most, and everything that is asked for."""
    pattern = (
        r"[\w.-]+==[\w.]+( ; \(?(python_full_version|sys_platform|os_name|platform_\w+) [^/]+)?"
    )
    asked = install.requirements(level).with_suffix(".in").read_text(encoding="utf-8")
    names = {line.partition("==")[0] for line in pins(level)}
    assert [line for line in pins(level) if not re.fullmatch(pattern, line)] == []
    assert set(re.findall(r"^[a-z][\w-]*", asked, re.M)) <= names


@pytest.mark.parametrize(("lower", "higher"), [("grade", "lab"), ("lab", "dev")])
def test_levels_agree(lower: str, higher: str) -> None:
    """Each level holds the one below, at the same versions."""
    below, above = ({line.partition(" ;")[0] for line in pins(name)} for name in (lower, higher))
    assert below - above == set()


@pytest.fixture
def own_root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make a scratch project the one whose environment is made."""
    monkeypatch.setattr(environment, "ROOT", tmp_path)
    return tmp_path


def installer(problem: str) -> Callable[[Path, str], str]:
    """Return an installer that makes a folder, and that fails when given a problem."""

    def fill(folder: Path, level: str) -> str:
        (folder / level).mkdir(parents=True)
        return problem

    return fill


def test_failed_environment_is_never_ready(own_root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """When every installer fails nothing stays, and the last words and the cure are told."""
    monkeypatch.setattr(environment, "installers", lambda: [installer("no network")])
    with pytest.raises(install.SetupError, match=r"no network\n.*make WHEELS="):
        environment.make("grade", own_root / "build")
    assert not (own_root / ".venv").exists()


def test_second_installer_takes_over(own_root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """When uv fails pip goes on, from nothing; the level is then ready, and not the one above."""
    both = [installer("no mirror"), installer("")]
    monkeypatch.setattr(environment, "installers", lambda: both)
    folder = environment.make("lab", own_root / "build")
    ready = [environment.is_ready(folder, level) for level in environment.LEVELS]
    assert ready == [True, True, False]


def test_half_made_environment_is_made_again(
    own_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An environment of ours without a stamp is thrown away."""
    (own_root / ".venv" / "half").mkdir(parents=True)
    environment.lock_path(own_root / ".venv").touch()
    monkeypatch.setattr(environment, "installers", lambda: [installer("")])
    assert environment.make("grade", own_root / "build") == own_root / ".venv"
    assert not (own_root / ".venv" / "half").exists()


def test_environment_of_somebody_else_is_left_alone(own_root: Path) -> None:
    """A .venv that we did not make is not touched: ours goes to the folder of outputs."""
    (own_root / ".venv").mkdir()
    assert environment.choose_folder(own_root / "build") == own_root / "build" / "venv"


def test_environment_with_other_pins_is_not_ready(
    own_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stamp of other pins, or of another Python, does not count."""
    (own_root / environment.STAMP).write_text(environment.stamp_text("grade"), encoding="utf-8")
    assert environment.is_ready(own_root, "grade")
    monkeypatch.setattr(environment, "requirements", lambda level: ROOT / "LICENSE")
    assert not environment.is_ready(own_root, "grade")


def test_one_make_at_a_time(tmp_path: Path) -> None:
    """While one process makes the environment another one cannot; then it can."""
    folder = tmp_path / ".venv"
    with environment.lock_path(folder).open("w") as other:
        with environment.locked(folder):
            assert not environment.try_lock(other.fileno())
        assert environment.try_lock(other.fileno())


def test_full_disk_names_the_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    """A full disk, or a full quota, is told as such."""
    monkeypatch.setenv("MRT_LANG", "en")
    for words in ("OSError: [Errno 28] No space left on device", "Disk quota exceeded"):
        told = install.explain(Path("/home/me/.venv"), words).splitlines()[-1]
        assert told.startswith("No space left for /home/me/.venv")


def test_a_full_disk_is_seen_before_anything_is_downloaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is there already counts; nothing is undone, and no installer is started."""
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=140 * 10**6))
    monkeypatch.setattr(
        environment, "installers", lambda: pytest.fail("an installer was asked for")
    )
    monkeypatch.setenv("MRT_LANG", "en")
    folder = tmp_path / ".venv"
    for level, needed in (("grade", 150), ("lab", 650)):
        with pytest.raises(install.SetupError) as caught:
            environment.fill(folder, level)
        said = f"No space left for {folder} ({needed} MB are needed, 140 are left). Make room"
        assert str(caught.value).startswith(said)
    install.check_room(folder, "lab", "lab")
    with pytest.raises(install.SetupError, match="500 MB are needed"):
        install.check_room(folder, "lab", "grade")

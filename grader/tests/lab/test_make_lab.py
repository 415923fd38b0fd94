"""make lab: the layout, the settings and the environment of JupyterLab."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from grader.course.exercises import ROOT
from grader.lab import __main__, server


def test_notebook_and_c_file_stand_side_by_side(tmp_path: Path) -> None:
    """The layout is where JupyterLab looks for it, and one that was changed stays."""
    from jupyterlab_server.workspaces_handler import WorkspacesManager

    name = __main__.write_workspace(tmp_path, "notebooks/fr/TP2.ipynb", "core_c/raytracer.c")
    kept = WorkspacesManager(str(tmp_path / "workspaces")).load(name)
    areas = kept["data"]["layout-restorer:data"]["main"]["dock"]["children"]
    assert [each["widgets"] for each in areas] == [
        ["notebook:notebooks/fr/TP2.ipynb"],
        ["editor:core_c/raytracer.c"],
    ]
    (path,) = (tmp_path / "workspaces").iterdir()
    path.write_text("{}", encoding="utf-8")
    __main__.write_workspace(tmp_path, "notebooks/fr/TP2.ipynb", "core_c/raytracer.c")
    assert path.read_text(encoding="utf-8") == "{}"


def test_nothing_of_the_person_is_touched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All of Jupyter's folders are ours; no news, no updates; paths hold from any folder."""
    monkeypatch.setenv("BUILD", "somewhere")
    variables = __main__.environment(tmp_path)
    for key in ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "MPLCONFIGDIR"):
        assert variables[key].startswith(str(tmp_path))
    assert variables["BUILD"] == str(ROOT / "somewhere")
    assert variables["PYTHONPATH"] == str(ROOT)
    __main__.write_settings(tmp_path)
    notifications = tmp_path / "settings/@jupyterlab/apputils-extension"
    content = json.loads((notifications / "notification.jupyterlab-settings").read_text("utf-8"))
    assert content == {"checkForUpdates": False, "fetchNews": "false"}
    manager = tmp_path / "settings/@jupyter-widgets/jupyterlab-manager"
    content = json.loads((manager / "plugin.jupyterlab-settings").read_text("utf-8"))
    assert content == {"saveState": True}  # widgets are there the next day
    style = tmp_path / "config" / "custom" / "custom.css"  # where JupyterLab looks for it
    assert style.read_bytes() == __main__.STYLE.read_bytes()
    assert "--LabApp.custom_css=True" in __main__.command(ROOT, "name", True)


@pytest.mark.parametrize(
    ("outcomes", "edited", "expected"),
    [
        ([], False, 0),
        ([("todo", 1), ("blocked", 2)], False, 0),  # the first grade, of nothing
        ([], True, 1),
        ([("todo", 1), ("blocked", 2)], True, 1),
        ([("failed", 1), ("todo", 2)], False, 1),
        ([("passed", 1), ("todo", 2)], False, 2),
        ([("passed", 1)], False, 0),
    ],
)
def test_the_next_tp(
    outcomes: list[tuple[str, int]],
    edited: bool,
    expected: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first TP with something left; the tools' notebook before any work, and when all is."""
    monkeypatch.setenv("BUILD", str(tmp_path))
    monkeypatch.setattr(__main__, "CORE", tmp_path / "core_c")
    shutil.copytree(ROOT / "core_c", tmp_path / "core_c")
    if edited:
        with (tmp_path / "core_c" / "main.c").open("a", encoding="utf-8") as file:
            file.write("int mine;\n")
    rows = [{"tp": tp, "outcome": outcome, "bonus": False} for outcome, tp in outcomes]
    (tmp_path / "grade").mkdir()
    if rows:
        text = json.dumps({"exercises": rows})
        (tmp_path / "grade" / "results.json").write_text(text, "utf-8")
    assert __main__._next_tp() == expected


def test_each_notebook_opens_with_the_file_that_it_is_about() -> None:
    """That of the tools with its own, which is there."""
    found = {tp: __main__._source(tp) for tp in (0, 1, 2, 5)}
    assert found == {
        0: "notebooks/first_steps/main.c",
        1: "core_c/main.c",
        **dict.fromkeys((2, 5), "core_c/raytracer.c"),
    }
    assert all((ROOT / each).is_file() for each in found.values())


def test_a_missing_notebook_and_a_closed_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each is one sentence with its cure, and nothing starts."""
    monkeypatch.setenv("MRT_LANG", "en")
    monkeypatch.setattr(__main__, "ROOT", tmp_path)
    with pytest.raises(SystemExit, match="Put the original folder"):
        __main__.main(["--tp", "1"])
    (tmp_path / "notebooks/en").mkdir(parents=True)
    (tmp_path / "notebooks/en/TP1.ipynb").touch()
    (tmp_path / "file").touch()
    monkeypatch.setenv("BUILD", str(tmp_path / "file"))
    with pytest.raises(SystemExit, match="make lab BUILD="):
        __main__.main(["--tp", "1"])


# Stands for JupyterLab: says much, and where it answers, as it does.
LAB = """
import json, os, pathlib, sys
print("[I 2026 ServerApp] many words")
place = pathlib.Path(os.environ["JUPYTER_RUNTIME_DIR"])
place.mkdir(parents=True)
known = {"url": "http://localhost:8890/", "token": "abc"}
(place / f"jpserver-{os.getpid()}.json").write_text(json.dumps(known))
sys.exit(4)
"""


def served(
    code: str, folder: Path, capsys: pytest.CaptureFixture[str], *, quiet: bool = False
) -> tuple[int, str]:
    """Run what stands for JupyterLab; return its exit code and what is told."""
    environment = {**os.environ, "JUPYTER_RUNTIME_DIR": str(folder / "runtime")}
    before = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)]
    try:
        line = [sys.executable, "-c", code]
        ended = server.serve(line, environment, folder / "log", "lab/x", quiet=quiet)
    finally:
        for each, handler in zip((signal.SIGINT, signal.SIGTERM), before, strict=True):
            signal.signal(each, handler)
    return ended, capsys.readouterr().out


@pytest.mark.parametrize("quiet", [False, True])
def test_the_terminal_has_the_address_and_how_to_stop(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], quiet: bool
) -> None:
    """In the person's language, and not a word of JupyterLab's, which a file keeps."""
    wait = "import time\ntime.sleep(1)\nsys.exit(4)"  # until it was seen
    code, said = served(LAB.replace("sys.exit(4)", wait), tmp_path, capsys, quiet=quiet)
    lines = said.splitlines()
    assert code == 4
    assert lines[0].startswith("Préparation des carnets")
    assert ("votre navigateur" in lines[1]) is not quiet
    assert lines[2:] == [
        "  http://localhost:8890/lab/x?token=abc",
        "Pour arrêter : Ctrl+C ici.",
        "Carnets fermés.",
    ]
    assert "many words" in (tmp_path / "log").read_text(encoding="utf-8")


def test_a_lab_that_does_not_start_says_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the last lines, and where the others are."""
    code, said = served("raise SystemExit('no such port')", tmp_path, capsys)
    assert code == 1
    assert f"{tmp_path / 'log'}" in said
    assert said.endswith("\n  no such port\n")


@pytest.mark.parametrize(
    ("said", "cure"),
    [
        ("OSError: [Errno 28] No space left on device", "make clean"),
        ("OSError: [Errno 122] Disk quota exceeded", "make lab BUILD="),
        ("could not be started because no available port could be found.", "Ctrl+C"),
    ],
)
def test_a_known_cause_has_its_cure(
    said: str, cure: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A full disk, and ports that are all taken, wherever that stands in what it said."""
    lines = f"[E] {said}\\n" + "and then more\\n" * 9
    code, told = served(f"raise SystemExit('{lines}')", tmp_path, capsys)
    assert code == 1
    assert cure in " ".join(told.split())


@pytest.mark.long
def test_ports_that_are_taken_are_told_as_jupyter_says_it(tmp_path: Path) -> None:
    """JupyterLab itself, asked for a port that is taken and for no other, says those words."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        line = __main__.command(tmp_path, "x", True)
        line += [f"--ServerApp.port={port}", "--ServerApp.port_retries=0", "--ip=127.0.0.1"]
        done = subprocess.run(
            line, env=__main__.environment(tmp_path), capture_output=True, text=True, timeout=100
        )
    assert done.returncode == 1
    assert any(each in done.stderr for each in server.CAUSES["ports_taken"])


def test_a_closed_notebook_s_kernel_ends(tmp_path: Path) -> None:
    """JupyterLab is told how long to keep one that nobody looks at; not one that is open."""
    options = __main__.command(tmp_path, "x", True)
    assert f"--MappingKernelManager.cull_idle_timeout={__main__.CLOSED_SECONDS}" in options
    assert not any("cull_connected" in each for each in options)


def test_a_lab_that_is_stopped_at_once_is_no_failure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ctrl+C before it answers ends both."""
    stop = "import os, signal; os.kill(os.getppid(), signal.SIGINT); raise SystemExit(1)"
    code, said = served(stop, tmp_path, capsys)
    assert (code, said.splitlines()[1:]) == (0, ["Carnets fermés."])

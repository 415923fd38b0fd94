"""make lab: the layout, the settings and the environment of JupyterLab."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from grader.course.exercises import ROOT
from grader.lab import __main__


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
    for key in ("CONFIG_DIR", "DATA_DIR", "RUNTIME_DIR"):
        assert variables[f"JUPYTER_{key}"].startswith(str(tmp_path))
    assert variables["BUILD"] == str(ROOT / "somewhere")
    assert variables["PYTHONPATH"] == str(ROOT)
    __main__.write_settings(tmp_path)
    notifications = tmp_path / "settings/@jupyterlab/apputils-extension"
    content = json.loads((notifications / "notification.jupyterlab-settings").read_text("utf-8"))
    assert content == {"checkForUpdates": False, "fetchNews": "false"}


@pytest.mark.parametrize(
    ("outcomes", "expected"),
    [([], 0), ([("passed", 1), ("todo", 2)], 2), ([("passed", 1)], 0)],
)
def test_the_next_tp(
    outcomes: list[tuple[str, int]],
    expected: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first TP with something left; the tools' notebook before any grade, and when all is."""
    monkeypatch.setenv("BUILD", str(tmp_path))
    rows = [{"tp": tp, "outcome": outcome, "bonus": False} for outcome, tp in outcomes]
    (tmp_path / "grade").mkdir()
    (tmp_path / "grade" / "results.json").write_text(json.dumps({"exercises": rows}), "utf-8")
    assert __main__._next_tp() == expected


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

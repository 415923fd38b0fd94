"""`make lab`: JupyterLab on a notebook, with the C file that it speaks of beside it.

Everything that JupyterLab keeps lies in build/lab/: the person's own settings are neither read nor
changed. Nothing is fetched from the network.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from grader.console.parser import Parser, tp_number
from grader.course import exercises as manifest
from grader.course.exercises import CORE, ROOT
from grader.course.message import UserError
from grader.course.texts import preferred
from grader.files import write_whole
from grader.intake import originals
from grader.lab.display import store
from grader.lab.display.links import graded, outputs
from grader.lab.display.words import say, texts
from grader.lab.server import serve

FIRST, FIRST_SOURCE = "00", "notebooks/first_steps/main.c"
UNWRITTEN = ("todo", "blocked")  # outcomes of what is still a stub, or waits for one
SETTINGS: dict[str, dict[str, Any]] = {
    # No news and no update checks: a room may have no network.
    "@jupyterlab/apputils-extension/notification": {"checkForUpdates": False, "fetchNews": "false"},
    # Without a kernel, the next day, sliders and inspectors show what they showed.
    "@jupyter-widgets/jupyterlab-manager/plugin": {"saveState": True},
    # On a narrow screen, or enlarged, a line of code needs no scroll bar of its own.
    "@jupyterlab/notebook-extension/tracker": {"codeCellConfig": {"lineWrap": True}},
    # A C file that was not saved is not the one that is built.
    # On a slow disk, JupyterLab takes what it has just written itself for somebody else's change.
    "@jupyterlab/docmanager-extension/plugin": {
        "autosaveInterval": 10,
        "lastModifiedCheckMargin": 5000,
    },
}
STYLE = Path(__file__).with_name("jupyter.css")
CLOSED_SECONDS = 1200  # that the kernel of a closed notebook is kept
SIZES = [0.58, 0.42]  # of the window: notebook, C file


def main(arguments: Sequence[str] | None = None) -> None:
    """Run JupyterLab on the notebook of a TP, or on the next one.

    Raises SystemExit, with a sentence when it cannot be.
    """
    parser = Parser(texts=texts(), prog="python -m grader.lab")
    parser.add_argument("--tp", type=tp_number, choices=sorted(manifest.load().tps))
    parser.add_argument("--no-browser", action="store_true")
    asked = parser.parse_args(arguments)
    tp = asked.tp or _next_tp()
    notebook = f"notebooks/{preferred()}/{f'TP{tp}' if tp else FIRST}.ipynb"
    if not (ROOT / notebook).is_file():
        sys.exit(say("no_notebook", path=notebook))
    home = outputs() / "lab" / "jupyter"
    try:
        name = write_workspace(home, notebook, _source(tp))
        write_settings(home)
        quiet = asked.no_browser or not _has_display()
        line = command(ROOT, name, quiet)
        os.chdir(ROOT)
        log, path = home.parent / "jupyter.log", f"lab/workspaces/{name}"
        sys.exit(serve(line, environment(home), log, path, quiet=quiet))
    except OSError as error:
        sys.exit(say("cannot_open", path=error.filename, error=error.strerror))


def environment(home: Path) -> dict[str, str]:
    """Return the environment of JupyterLab and of its kernels."""
    folders = {
        "JUPYTER_CONFIG_DIR": home / "config",
        "JUPYTER_DATA_DIR": home / "data",
        "JUPYTER_RUNTIME_DIR": home / "runtime",
        "JUPYTERLAB_SETTINGS_DIR": home / "settings",
        "JUPYTERLAB_WORKSPACES_DIR": home / "workspaces",
        "IPYTHONDIR": home / "ipython",
        "MPLCONFIGDIR": home / "matplotlib",  # its list of fonts, too, is not the home's
        "BUILD": outputs(),
        "PYTHONPATH": ROOT,
    }
    return {**os.environ, **{key: str(path) for key, path in folders.items()}}


def write_settings(home: Path) -> None:
    """Write the settings that are not JupyterLab's own, unless the person has changed them."""
    write_whole(home / "config" / "custom" / "custom.css", STYLE.read_bytes())
    for name, content in SETTINGS.items():
        path = home / "settings" / f"{name}.jupyterlab-settings"
        if not path.exists():
            store.write_json(path, content)


def write_workspace(home: Path, notebook: str, source: str) -> str:
    """Write the layout, notebook and C file side by side, unless it is there; return its name.

    Both are paths in the folder that JupyterLab opens.
    """
    from jupyterlab_server.workspaces_handler import slugify

    name = notebook.removesuffix(".ipynb").replace("/", "-").lower()
    path = home / "workspaces" / f"{slugify(name)}.jupyterlab-workspace"
    if not path.exists():
        store.write_json(path, _layout(name, notebook, source))
    return name


def _layout(name: str, notebook: str, source: str) -> dict[str, Any]:
    widgets = {
        f"notebook:{notebook}": {"path": notebook, "factory": "Notebook"},
        f"editor:{source}": {"path": source, "factory": "Editor"},
    }
    areas = [{"type": "tab-area", "currentIndex": 0, "widgets": [each]} for each in widgets]
    dock = {"type": "split-area", "orientation": "horizontal", "sizes": SIZES, "children": areas}
    closed = {"collapsed": True, "visible": True, "widgets": []}
    layout = {
        "main": {"dock": dock, "current": f"notebook:{notebook}"},
        "left": closed,
        "right": closed,
        "relativeSizes": [0, 1, 0],
    }
    data: dict[str, Any] = {key: {"data": value} for key, value in widgets.items()}
    return {"data": {"layout-restorer:data": layout, **data}, "metadata": {"id": name}}


def command(root: Path, workspace: str, quiet: bool) -> list[str]:
    """Return the command of JupyterLab on a folder; `quiet`: it opens no browser."""
    options = [
        f"--ServerApp.root_dir={root}",
        f"--LabApp.default_url=/lab/workspaces/{workspace}",
        "--LabApp.extension_manager=readonly",
        "--LabApp.custom_css=True",
        # A notebook that was closed: one that is open keeps its kernel, and its variables.
        f"--MappingKernelManager.cull_idle_timeout={CLOSED_SECONDS}",
        "--ServerApp.answer_yes=True",  # Ctrl+C once is enough: what is open is saved
    ]
    if quiet:
        options.append("--no-browser")
    if os.geteuid() == 0:
        options.append("--allow-root")
    return [sys.executable, "-m", "jupyterlab", *options]


def _has_display() -> bool:
    return sys.platform != "linux" or any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "WSL_DISTRO_NAME")
    )


def _next_tp() -> int:
    """Return the first TP that the last grade does not show as done; 0 before any work."""
    judged = graded().get("exercises", [])
    begun = any(each["outcome"] not in UNWRITTEN for each in judged)
    if not begun and not _is_edited():
        return 0
    if not judged:
        return min(manifest.load().tps)
    left = [each["tp"] for each in judged if each["outcome"] != "passed" and not each["bonus"]]
    return min(left, default=0)


def _is_edited() -> bool:
    """Whether a file to complete is not as it was handed out, as far as can be read."""
    paths = [CORE / name for name in manifest.load().student]
    try:
        files = {path.name: path.read_bytes() for path in paths if path.is_file()}
        return len(originals.untouched(files, in_place=True)) < len(files)
    except (OSError, UserError):  # whoever needs them will say what is wrong
        return True


def _source(tp: int) -> str:
    """Return the C file that a TP, or the tools' notebook, is about."""
    files = [each.file for each in manifest.load().exercises if each.tp == tp]
    return f"{CORE.name}/{files[0]}" if files else FIRST_SOURCE


if __name__ == "__main__":
    main()

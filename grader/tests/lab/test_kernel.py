"""In a kernel: what a cell shows when the C goes wrong, and that the cells behind it run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient
from nbclient.exceptions import DeadKernelError

from grader.course.exercises import ROOT
from grader.sandbox.scratch import PREFIX
from grader.tests.lab.conftest import Edit

DOT = "float n_l = vector_dot(n, l);"
SHADE = "core.shade((0, 0, 1), (0, 0, 1), (0, 0, 1), (1, 1, 1), core.material())"


def run(folder: Path, *cells: str) -> list[list[Any]]:
    """Run cells in a fresh kernel, in a folder named en; return the outputs of each."""
    home = folder.parent / "notebooks" / "en"
    home.mkdir(parents=True, exist_ok=True)
    made = [nbformat.v4.new_code_cell(each) for each in cells]  # type: ignore[no-untyped-call]
    book = nbformat.v4.new_notebook(cells=made)  # type: ignore[no-untyped-call]
    settings = {"metadata": {"path": str(home)}}
    NotebookClient(book, timeout=300, kernel_name="python3", resources=settings).execute()
    return [list(cell.outputs) for cell in book.cells]


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the kernel find the grader, as `make lab` does; its language is the folder's."""
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("MRT_LANG", "fr")


def test_a_card_instead_of_a_traceback_and_the_notebook_goes_on(folder: Path, edit: Edit) -> None:
    """A crash ends its cell only: no output is an error, and the next cell has its picture."""
    edit("raytracer.c", DOT, f"{DOT} volatile int *p = 0; *p = 1;")
    setup, crash, after, checked = run(
        folder,
        "from grader.lab import Core, check\ncore = Core()\ncore.size = (96, 64)",
        f"{SHADE}\nprint('not reached')",
        "core.render(scene=0, shading=False)",
        "check('TP1.1')",
    )
    assert setup == []
    (card,) = crash
    assert card.output_type == "display_data"
    assert "shade() uses a null pointer (NULL), in shade (raytracer.c:" in card.data["text/plain"]
    assert "(raytracer.c:" in card.data["text/html"]
    assert 'alt="Picture of 96 x 64 pixels."' in after[0].data["text/html"]
    assert "right, 2 / 2" in checked[0].data["text/plain"]


def test_what_is_printed_and_other_errors_stay_as_they_are(folder: Path, edit: Edit) -> None:
    """Printf shows in the cell; an error of the notebook's own Python is still one."""
    edit("raytracer.c", DOT, f'{DOT} printf("n.l %g\\n", n_l);')
    edit("raytracer.c", '#include "raytracer.h"', '#include "raytracer.h"\n#include <stdio.h>')
    _, printed, wrong = run(
        folder,
        "from grader.lab import Core\ncore = Core()\ncore.size = (96, 64)",
        SHADE,
        "try:\n    core.fil_red\nexcept AttributeError as error:\n    print(error)",
    )
    assert (printed[0].name, printed[0].text) == ("stdout", "n.l 1\n")
    assert "fill_red" in wrong[0].text


@pytest.mark.long
def test_what_a_killed_kernel_left_is_removed_by_the_next(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Folders of staged libraries, as for commands and batches."""
    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setenv("TMPDIR", str(place))
    start = "from grader.lab import Core\ncore = Core()\ncore.size = (96, 64)\n"
    with pytest.raises(DeadKernelError):
        run(folder, f"{start}core.render(scene=0)\nimport os\nos.kill(os.getpid(), 9)")
    (left,) = place.glob(f"{PREFIX}*")
    assert list(left.glob("mrt-*"))
    run(folder, start)
    assert not left.exists()

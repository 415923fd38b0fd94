"""Make the workbook's notebooks, notebooks/{fr,en}/*.ipynb, from the text files beside them.

A notebook is written as Markdown (jupytext's form): a block fenced as ``python`` is a cell of code,
two blank lines end a cell of text. The .ipynb that comes out has no outputs and no counts, and the
id of a cell is its place (tp2-07), so that the same text always gives the same bytes.
Both languages have the same cells and the same code: only the text differs. In French text, the
spaces that must not break, as in « Où ? », are put in here.

``--pictures`` draws notebooks/images/ again too: the handout's figures, which the texts show first.
Run it as ``python -m grader.authoring.workbook.notebooks [--check | --pictures] [--folder DIR]``.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import jupytext  # type: ignore[import-untyped]
from PIL import Image

from grader.authoring.drawings import figures
from grader.authoring.drawings.contact_sheet import save
from grader.authoring.skeleton.skeleton import SkeletonError, read_text, shown
from grader.course.exercises import ROOT
from grader.course.message import GraderError, UserError
from grader.execution.session import open_core
from grader.execution.worker_process import Died, MachineError
from grader.files import write_whole

NOTEBOOKS = ROOT / "notebooks"
LANGUAGES = ("fr", "en")
PICTURE_WIDTH = 640  # of the images that the texts show, pixels
PICTURES = (
    *(f"figure_1_mrt_{number}" for number in range(4)),
    *(f"figure_{number}" for number in (3, 4, 5)),
    *(f"figure_{number}_{side}" for number in (6, 7, 8) for side in ("left", "right")),
    "figure_9",
    *(f"scene_{number}" for number in (5, 6, 7)),
)


# What stays as it is in a text: blocks of code, code, formulas, the targets of links, and HTML.
VERBATIM = re.compile(
    r"```.*?```|`[^`]+`|\$\$.+?\$\$|\$[^$]+\$|\]\([^)]*\)|<[^>]+>|^\|[ :|-]+$", re.S | re.M
)
HARD = "\N{NO-BREAK SPACE}"


class NotebookError(GraderError):
    """What stopped the generator: one line that names the file and the cure."""


@dataclass(frozen=True)
class Cell:
    """One cell of a notebook: "markdown" or "code", and its text."""

    kind: str
    source: str


def cells_of(text: str) -> list[Cell]:
    """Return the cells of a source, in order."""
    return [Cell(each.cell_type, each.source) for each in jupytext.reads(text, fmt="md").cells]


def french(text: str) -> str:
    """Return French text with no-break spaces inside « » and before : ; ! ? and %."""
    kept = VERBATIM.findall(text)
    plain = re.sub(r"(?<=\S) (?=[:;!?%»])|(?<=«) ", HARD, VERBATIM.sub("\0", text))
    return re.sub("\0", lambda _: kept.pop(0), plain)


def notebook(stem: str, cells: Sequence[Cell]) -> str:
    """Return the text of a .ipynb file; the ids of its cells are made from its name, ``stem``."""
    content = {
        "cells": [_cell(f"{stem.lower()}-{n:02d}", cell) for n, cell in enumerate(cells, 1)],
        "metadata": {
            "kernelspec": {
                "display_name": "Python 3 (ipykernel)",
                "language": "python",
                "name": "python3",
            },
            "language_info": {"name": "python"},
        },
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(content, ensure_ascii=False, indent=1) + "\n"


def _cell(identity: str, cell: Cell) -> dict[str, Any]:
    made: dict[str, Any] = {"cell_type": cell.kind, "id": identity, "metadata": {}}
    if cell.kind == "code":
        made |= {"execution_count": None, "outputs": []}
    return made | {"source": cell.source.splitlines(keepends=True)}


def check_same_code(name: str, cells: dict[str, list[Cell]]) -> None:
    """Raise NotebookError at the first cell whose kind or code is not the same in all languages."""
    for n, row in enumerate(zip_longest(*cells.values()), 1):
        code = {each and (each.kind, each.source if each.kind == "code" else "") for each in row}
        if len(code) > 1:
            raise NotebookError(
                f"{name}: cell {n} is not the same code, or not of the same kind, in "
                f"{' and '.join(cells)}; give both languages the same cells"
            )


def make_all(folder: Path) -> dict[Path, str]:
    """Return the text of each .ipynb of the workbook, by its path.

    Raises NotebookError or SkeletonError when a source is missing, unreadable, or has not the same
    cells in both languages.
    """
    made: dict[Path, str] = {}
    for name in sorted({path.name for each in LANGUAGES for path in (folder / each).glob("*.md")}):
        paths = {language: folder / language / name for language in LANGUAGES}
        cells = {language: cells_of(read_text(path)) for language, path in paths.items()}
        check_same_code(name, cells)
        cells["fr"] = [
            Cell(each.kind, french(each.source)) if each.kind == "markdown" else each
            for each in cells["fr"]
        ]
        for language, path in paths.items():
            made[path.with_suffix(".ipynb")] = notebook(path.stem, cells[language])
    if not made:
        raise NotebookError(f"{shown(folder)}: no text to make notebooks from; check the folder")
    return made


def check(folder: Path, made: dict[Path, str]) -> None:
    """Raise NotebookError when the folder's notebooks are not those that would be written."""
    for path, text in made.items():
        if not path.exists() or read_text(path) != text:
            raise NotebookError(f"{shown(path)}: not what its text gives; run `make notebooks`")
    for path in sorted(folder.glob("*/*.ipynb")):
        if path not in made:
            raise NotebookError(
                f"{shown(path)}: has no text beside it; remove it, or add {path.stem}.md"
            )


def draw_pictures(folder: Path, names: Sequence[str] = PICTURES) -> None:
    """Draw figures of the handout with the reference, as PNG files."""
    width = PICTURE_WIDTH
    folder.mkdir(parents=True, exist_ok=True)
    with open_core(ROOT / "reference", width, width * 9 // 16) as core:
        for figure in figures.FIGURES:
            if figure.name in names:
                pixels = figures.draw(core, figure).pixels
                save(Image.fromarray(pixels), folder / f"{figure.name}.png")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, or 1 after one line on stderr."""
    parser = argparse.ArgumentParser(
        prog="python -m grader.authoring.workbook.notebooks", description=__doc__
    )
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--folder", type=Path, default=NOTEBOOKS, metavar="DIR")
    choice = parser.add_mutually_exclusive_group()
    choice.add_argument("--check", action="store_true", help="write nothing; exit 1 on a drift")
    choice.add_argument("--pictures", action="store_true", help="draw images/ again as well")
    arguments = parser.parse_args(argv)
    try:
        made = make_all(arguments.folder)
        if arguments.check:
            check(arguments.folder, made)
            return 0
        for path, text in made.items():
            write_whole(path, text)
        if arguments.pictures:
            draw_pictures(arguments.folder / "images")
    except OSError as error:
        where, why = error.filename or arguments.folder, error.strerror or error
        print(f"{where}: cannot be written ({why}); give a writable --folder", file=sys.stderr)
        return 1
    except (NotebookError, SkeletonError, UserError, Died, MachineError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

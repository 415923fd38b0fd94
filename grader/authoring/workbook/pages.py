"""Run the workbook's notebooks from top to bottom, and export what they show as HTML pages.

Run it as ``python -m grader.authoring.workbook.pages OUT [--core DIR] [--language fr] [NAME ...]``.
The pages can be read without a kernel, or on paper. With reference/ as the C code (the default)
they show what the finished program does: they are for instructors.
"""

from __future__ import annotations

import argparse
import base64
import copy
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError
from nbconvert import HTMLExporter
from traitlets.config import Config

from grader.authoring.skeleton.skeleton import shown
from grader.authoring.workbook.mathml import formulas
from grader.authoring.workbook.notebooks import LANGUAGES, NOTEBOOKS
from grader.course.exercises import ROOT
from grader.lab.display.links import VARIABLE

SECONDS = 180  # of one cell
# What a page without a kernel can show, the best first: no widget.
SHOWN = ["text/html", "text/markdown", "image/svg+xml", "image/png", "text/plain"]
# Scripts that would be fetched: for formulas, which are MathML, and widgets, which are not there.
OUTSIDE = re.compile(r'<script src="https://[^>]*>\s*</script>')
# On paper nothing can be scrolled or unfolded: long lines of code are broken, what is folded is
# open, and a cell's code stays with what it shows.
PRINTED = """\
<style>@media print {
  .highlight pre { white-space: pre-wrap }
  .jp-CodeCell, .jp-OutputArea-output, details { break-inside: avoid }
  .jp-Cell-inputWrapper { break-after: avoid }
}</style>
<script>
addEventListener("beforeprint", () => {
  for (const each of document.querySelectorAll("details")) each.open = true;
});
</script>"""
IMAGE = re.compile(r"\]\((\.\./images/[\w.]+\.png)\)")


def execute(path: Path, core: Path, build: Path, setup: str = "") -> Any:
    """Return a notebook with the outputs of all its cells, run in a fresh kernel in its folder.

    `core` is the folder of C code, `build` that of the outputs; `setup` is run with the first cell
    of code. Raises CellExecutionError.
    """
    notebook = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
    first = next(each for each in notebook.cells if each.cell_type == "code")
    first.source = f"{first.source}\n{setup}".rstrip()
    variables = {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        VARIABLE: str(core.resolve()),
        "BUILD": str(build.resolve()),
    }
    where = {"metadata": {"path": str(path.parent)}}
    client = NotebookClient(notebook, timeout=SECONDS, kernel_name="python3", resources=where)
    client.execute(env=variables)
    return notebook


def page(notebook: Any, folder: Path, title: str) -> str:
    """Return a notebook that was run as one HTML page, with every picture in it."""

    def embedded(match: re.Match[str]) -> str:
        data = base64.b64encode((folder / match[1]).read_bytes()).decode()
        return f"](data:image/png;base64,{data})"

    notebook = copy.deepcopy(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            cell.source = formulas(IMAGE.sub(embedded, cell.source))
    notebook.metadata.pop("widgets", None)  # their state: nothing reads it without a kernel
    settings = Config()
    settings.NbConvertBase.display_data_priority = SHOWN
    exporter = HTMLExporter(config=settings)  # type: ignore[no-untyped-call]
    text, _ = exporter.from_notebook_node(notebook, resources={"metadata": {"name": title}})
    return OUTSIDE.sub("", str(text)).replace("</head>", f"{PRINTED}</head>", 1)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, or 1 after one line on stderr."""
    parser = argparse.ArgumentParser(
        prog="python -m grader.authoring.workbook.pages", description=__doc__
    )
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("names", nargs="*", metavar="NAME", help="such as TP1; all by default")
    parser.add_argument("--core", type=Path, default=ROOT / "reference", metavar="DIR")
    parser.add_argument("--language", choices=LANGUAGES, default=LANGUAGES[0])
    arguments = parser.parse_intermixed_args(argv)
    folder = NOTEBOOKS / arguments.language
    names = arguments.names or sorted(path.stem for path in folder.glob("*.ipynb"))
    try:
        arguments.out.mkdir(parents=True, exist_ok=True)
        for name in names:
            path = folder / f"{name}.ipynb"
            notebook = execute(path, arguments.core, arguments.out / "build")
            target = arguments.out / f"{name}.html"
            target.write_text(page(notebook, folder, name), encoding="utf-8")
            print(shown(target))
    except CellExecutionError as error:
        print(f"{name}: {error.ename}: {error.evalue}; run it in JupyterLab", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"{error.filename}: {error.strerror}; check the path", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

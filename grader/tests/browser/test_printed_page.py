"""An exported page of the workbook on paper, as the machine's Chromium prints it."""

from __future__ import annotations

from pathlib import Path

import nbformat

from grader.authoring.workbook import pages
from grader.authoring.workbook.notebooks import Cell, notebook
from grader.tests.browser.chromium import chromium

FOLDED = "<details>\n<summary>The answer</summary>\n\nForty-two.\n\n</details>"


def test_what_is_folded_is_printed(tmp_path: Path) -> None:
    """Closed on the screen, open on paper; a cell's code is not parted from what it shows."""
    made = notebook("TP9", [Cell("markdown", FOLDED), *[Cell("code", "draw()")] * 9])
    book = nbformat.reads(made, as_version=4)  # type: ignore[no-untyped-call]
    for each in book.cells[1:]:
        data = {"text/html": "<p style='height:300px'>a drawing</p>"}
        shown = {"output_type": "display_data", "data": data, "metadata": {}}
        each.outputs = [nbformat.NotebookNode(shown)]  # type: ignore[no-untyped-call]
    text = pages.page(book, tmp_path, "TP9")
    (tmp_path / "page.html").write_text(text, encoding="utf-8")
    with chromium() as browser:
        page = browser.new_page()
        page.goto((tmp_path / "page.html").as_uri())
        answer = page.get_by_text("Forty-two.")
        assert not answer.is_visible()
        paper = page.pdf(format="A4")
        assert answer.is_visible()
        page.emulate_media(media="print")
        styles = "(each) => getComputedStyle(each).breakInside"
        assert page.locator(".jp-CodeCell").first.evaluate(styles) == "avoid"
    assert paper.count(b"/Type /Page\n") > 2

"""The workbook from top to bottom, as a student runs it: started, finished, crashing, looping."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from grader.authoring.workbook import pages
from grader.authoring.workbook.notebooks import LANGUAGES, NOTEBOOKS
from grader.course.exercises import CORE, ROOT
from grader.tests.support.notebooks import checks, shown
from grader.tests.support.outputs import outputs
from grader.tests.support.sampling import sampled

NAMES = sorted(path.stem for path in (NOTEBOOKS / "fr").glob("*.ipynb"))
REFERENCE = ROOT / "reference"
PICTURE = r'<img\b[^>]*>|<svg\b[^>]*\brole="img"[^>]*>'
DONE, TO_DO, WRONG = "✓", "○", "✗"

EACH = [f"{language}/{name}" for name in NAMES for language in LANGUAGES]
# Every notebook finished, in one language or the other; two not begun.
FINISHED = sampled(EACH, ["fr/00", "fr/TP2", "en/TP5"], ["fr/00", "fr/TP2"])
NOT_BEGUN = sampled(EACH, ["fr/TP1"])


@pytest.fixture(scope="module")
def finished(
    request: pytest.FixtureRequest, cache: Path, tmp_path_factory: pytest.TempPathFactory
) -> Any:
    """Return a notebook, "fr/TP1", run on the reference."""
    build = outputs(tmp_path_factory.mktemp("finished") / "build", cache)
    return pages.execute(NOTEBOOKS / f"{request.param}.ipynb", REFERENCE, build)


def texts_of(notebook: Any) -> list[str]:
    """Return the text cells of a notebook."""
    return [each.source for each in notebook.cells if each.cell_type == "markdown"]


@pytest.mark.parametrize("name", NOT_BEGUN)
def test_on_the_skeleton_everything_is_to_do(name: str, cache: Path, tmp_path: Path) -> None:
    """No cell fails, and each check is a calm line: nothing is wrong yet."""
    build = outputs(tmp_path / "build", cache)
    notebook = pages.execute(NOTEBOOKS / f"{name}.ipynb", CORE, build)
    assert [source for source, text in shown(notebook) if "ERROR" in text] == []
    for exercise, text in checks(notebook).items():
        assert text.startswith(f"{TO_DO} {exercise}"), text
        assert WRONG not in text


@pytest.mark.parametrize("finished", FINISHED, indirect=True)
def test_on_the_reference_everything_is_right(finished: Any) -> None:
    """No cell fails, each check passes, and the handout's figures are drawn."""
    notebook = finished
    assert [source for source, text in shown(notebook) if "ERROR" in text] == []
    for source, text in shown(notebook):
        if re.search(r'compare\(.*"figure', source):
            # Another compiler may round some pixels on an edge otherwise.
            share = re.search(r"([\d.,]+) %", text)
            assert share is None or float(share[1].replace(",", ".")) < 0.5, text
    for exercise, text in checks(notebook).items():
        assert text.startswith(f"{DONE} {exercise}"), text
        assert WRONG not in text


def spoilt(folder: Path, function: str, statement: str) -> Path:
    """Write the reference with a statement at the start of a function of raytracer.c."""
    shutil.copytree(REFERENCE, folder, ignore=shutil.ignore_patterns("expected", "mistakes"))
    path = folder / "raytracer.c"
    text = path.read_text(encoding="utf-8")
    changed = re.sub(rf"^(\w+ {function}\(.*\{{)$", rf"\1\n    {statement}", text, flags=re.M)
    assert changed != text
    path.write_text(changed, encoding="utf-8")
    return folder


def run(core: Path, name: str, build: Path, setup: str = "") -> Any:
    """Return a notebook that was run, none of whose cells has failed."""
    notebook = pages.execute(NOTEBOOKS / f"{name}.ipynb", core, build, setup)
    assert [source for source, text in shown(notebook) if "ERROR" in text] == []
    return notebook


@pytest.mark.long
@pytest.mark.parametrize("language", sampled(LANGUAGES, ["fr"]))
def test_a_crash_in_tp2_ends_only_its_cells(language: str, cache: Path, tmp_path: Path) -> None:
    """intersect_sphere crashes: its cells say so with the line, the other cells work."""
    core = spoilt(tmp_path / "crash", "intersect_sphere", "*(volatile int *)0 = 1;")
    notebook = run(core, f"{language}/TP2", outputs(tmp_path / "build", cache))
    crashed = [text for source, text in shown(notebook) if "core.intersect_sphere" in source]
    assert len(crashed) == 1
    assert re.search(r"(dans|in) intersect_sphere \(raytracer\.c:\d+\)", crashed[0])
    told = checks(notebook)
    assert told["TP2.1"].startswith(f"{DONE} TP2.1")
    assert told["TP2.3"].startswith(f"{DONE} TP2.3")
    assert told["TP2.4"].startswith(f"{WRONG} TP2.4")
    assert told["TP2.B2"].startswith(f"{DONE} TP2.B2")


# Shorter limits than a student's: nothing here takes long unless it never ends.
IMPATIENT = """\
core.seconds = 1.0
from grader.checking import student
student.PICTURE_LIMITS = student.UNIT_LIMITS"""


@pytest.mark.exhaustive
@pytest.mark.parametrize("language", LANGUAGES)
def test_an_endless_loop_in_tp4_ends_only_its_cells(
    language: str, cache: Path, tmp_path: Path
) -> None:
    """in_shadow never returns: its cells are stopped and name it, the other cells work."""
    core = spoilt(tmp_path / "loop", "in_shadow", "for (volatile int k = 0;; k = 1) {}")
    notebook = run(core, f"{language}/TP4", outputs(tmp_path / "build", cache), IMPATIENT)
    assert any("in_shadow (raytracer.c:" in text for _, text in shown(notebook))
    told = checks(notebook)
    assert told["TP4.1"].startswith(f"{WRONG} TP4.1")
    assert told["TP4.2"].startswith(f"{DONE} TP4.2")
    assert told["TP4.3"].startswith(f"{DONE} TP4.3")
    assert told["TP4.B1"].startswith(f"{DONE} TP4.B1")


@pytest.mark.parametrize("finished", FINISHED, indirect=True)
def test_exported_pages_show_every_picture(finished: Any, request: pytest.FixtureRequest) -> None:
    """Each picture is in the page itself and has words; formulas and all need no network."""
    notebook = finished
    language, name = request.node.callspec.params["finished"].split("/")
    folder = NOTEBOOKS / language
    drawn = sum(
        len(re.findall(PICTURE, output.data.get("text/html", "")))
        for each in notebook.cells
        if each.cell_type == "code"
        for output in each.outputs
        if "data" in output
    )
    written = sum(each.count("![") for each in texts_of(notebook))
    page = pages.page(notebook, folder, name)
    assert not re.search(r"<(script|link|img)\b[^>]*https?://", page)
    assert ("<math" in page) == any("$" in text for text in texts_of(notebook))
    images = re.findall(PICTURE, page)
    assert len(images) == drawn + written
    assert drawn > 3
    for image in images:
        assert image.startswith("<svg") or re.search(r'\bsrc="data:image/png;base64,', image)
        words = re.search(r'\b(?:alt|aria-label)="([^"]*)"', image)
        assert words
        assert len(words[1]) > 10

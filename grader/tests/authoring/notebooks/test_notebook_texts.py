"""The workbook's texts: what every notebook must have, what none may hold, and its spelling."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grader.authoring.skeleton import leaks
from grader.authoring.skeleton.skeleton import SkeletonError
from grader.authoring.workbook import notebooks
from grader.authoring.workbook.notebooks import LANGUAGES, NOTEBOOKS, Cell, NotebookError
from grader.course import exercises
from grader.course.exercises import CORE, ROOT

RULES = exercises.load()
TPS = sorted(RULES.tps)
NAMES = sorted(path.stem for path in (NOTEBOOKS / "fr").glob("*.md"))
MOST_LINES = 12  # of a cell of code
OPENING = {"fr": "À vous de prévoir", "en": "Your prediction"}
FURTHER = {"fr": "## Pour aller plus loin", "en": "## Going further"}
NUMBERS = re.compile(r"[\d.]*\d")
HANDOUT = {"fr": "*Dans le sujet : §", "en": "*In the handout: §"}
BELOW_TITLE = re.compile(r"^## \d\. .*\n\n(.*)", re.MULTILINE)
CORRECTION = {"fr": "**Correction du sujet.**", "en": "**Correction of the handout.**"}
CONTRACTS = {"fr": "## Les contrats du TP", "en": "## The contracts of TP"}


def cells(language: str, name: str) -> list[Cell]:
    """Return the cells of a text of the workbook."""
    return notebooks.cells_of((NOTEBOOKS / language / f"{name}.md").read_text(encoding="utf-8"))


def text_of(language: str, name: str) -> str:
    """Return all the text cells of a notebook."""
    return "\n\n".join(each.source for each in cells(language, name) if each.kind == "markdown")


def code_of(name: str) -> list[str]:
    """Return the cells of code of a notebook, the same in both languages."""
    return [each.source for each in cells("fr", name) if each.kind == "code"]


def test_the_workbook_is_whole() -> None:
    """A first notebook about the tools, and one for each TP."""
    assert ["00", *(f"TP{tp}" for tp in TPS)] == NAMES


def test_notebooks_are_what_their_texts_give() -> None:
    """The committed .ipynb files are generated, and both languages have the same code."""
    notebooks.check(NOTEBOOKS, notebooks.make_all(NOTEBOOKS))


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_has_no_outputs_and_stable_ids(language: str, name: str) -> None:
    """No outputs, no counts, no metadata of one machine; the ids are the cells' places."""
    book = json.loads((NOTEBOOKS / language / f"{name}.ipynb").read_text(encoding="utf-8"))
    expected = [f"{name.lower()}-{n:02d}" for n in range(1, len(book["cells"]) + 1)]
    assert [each["id"] for each in book["cells"]] == expected
    assert all(each["metadata"] == {} for each in book["cells"])
    code = [each for each in book["cells"] if each["cell_type"] == "code"]
    assert all(each["outputs"] == [] and each["execution_count"] is None for each in code)
    assert set(book["metadata"]) == {"kernelspec", "language_info"}


QUICK = ("figure_1_mrt_3", "figure_3", "figure_4", "figure_5")


def test_images_are_what_the_reference_draws(tmp_path: Path) -> None:
    """The images of the texts are those of the reference of today, and all are used."""
    folder = NOTEBOOKS / "images"
    assert sorted(path.stem for path in folder.iterdir()) == sorted(notebooks.PICTURES)
    used = "".join(text_of("fr", name) for name in NAMES)
    assert [name for name in notebooks.PICTURES if f"images/{name}.png" not in used] == []
    notebooks.draw_pictures(tmp_path, QUICK)
    for name in QUICK:
        fresh, kept = (
            np.asarray(Image.open(each / f"{name}.png"), dtype=int) for each in (tmp_path, folder)
        )
        # Other compilers may round a pixel on an edge otherwise.
        assert np.mean(np.abs(fresh - kept) > 2) < 0.001, name


# ---- What each notebook has ---------------------------------------------------------------------


@pytest.mark.parametrize("tp", TPS)
def test_every_exercise_is_checked(tp: int) -> None:
    """Each exercise that is judged has its check cell, in the order of the course."""
    asked = re.findall(r'^check\("(\S+)"\)$', "\n".join(code_of(f"TP{tp}")), re.M)
    judged = [each.id for each in RULES.exercises if each.tp == tp and each.checks]
    assert asked == judged


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("name", NAMES)
def test_predictions_come_before_results(language: str, name: str) -> None:
    """A prediction has its question and its options just above; its answer is shown afterwards."""
    found = cells(language, name)
    asked = {}
    for n, each in enumerate(found):
        if match := re.fullmatch(r'predict\("([\w.]+)", "([A-Z]+)"\)', each.source):
            asked[match[1]] = n
            above = found[n - 1].source
            assert OPENING[language] in above
            assert re.findall(r"^- \*\*([A-Z])\.\*\*", above, re.M) == list(match[2]), match[1]
    shown = re.findall(r'^predicted\("([\w.]+)"\)$', "\n".join(code_of(name)), re.M)
    assert sorted(shown) == sorted(asked)
    assert len(asked) >= (1 if name == "00" else 3)


@pytest.mark.parametrize("tp", TPS)
def test_a_tp_has_sliders(tp: int) -> None:
    """At least two sliders in each TP."""
    assert "\n".join(code_of(f"TP{tp}")).count("slider(") >= 2


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("tp", TPS)
def test_a_tp_has_its_parts(language: str, tp: int) -> None:
    """Goals, duration and picture first; a table of symbols; the core, then more; contracts."""
    name = f"TP{tp}"
    text = text_of(language, name)
    first = cells(language, name)[0].source
    assert re.search("90 minutes|trois heures|three hours", first)
    assert "../images/" in first
    written = RULES.exercises[[each.tp for each in RULES.exercises].index(tp)].file
    assert f"](../../core_c/{written})" in first  # it opens beside
    assert "| `" in text
    assert FURTHER[language] in text
    contracts = text[text.index(CONTRACTS[language]) :]
    for exercise in RULES.exercises:
        for function in exercise.functions if exercise.tp == tp else ():
            assert f"`{function}(" in contracts, function


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("tp", TPS)
def test_each_part_names_the_handout_s(language: str, tp: int) -> None:
    """Below its title, the section and the figures that it goes with, in both languages alike."""
    here, french = (
        BELOW_TITLE.findall(text_of(each, f"TP{tp}")) for each in (language, LANGUAGES[0])
    )
    assert here
    assert all(each.startswith(HANDOUT[language]) for each in here), here
    assert [*map(NUMBERS.findall, here)] == [*map(NUMBERS.findall, french)]


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_handout_s_corrections_are_marked_and_listed(language: str) -> None:
    """As often in a notebook as in the lecturer's list, in both languages."""
    page = (ROOT / "INSTRUCTORS.md").read_text(encoding="utf-8")
    table = page.partition("## Where the handout errs")[2].partition("\n## ")[0]
    listed = re.findall(r"\| (TP\d) \|$", table, re.MULTILINE)
    found = {
        name: text_of(language, name).count(CORRECTION[language])
        for name in (f"TP{tp}" for tp in TPS)
    }
    assert found == {name: listed.count(name) for name in found}
    assert len(listed) == 6


@pytest.mark.parametrize("name", NAMES)
def test_cells_of_code_are_short(name: str) -> None:
    """Fewer than twelve lines, none longer than a line of the screen."""
    for source in code_of(name):
        lines = source.splitlines()
        assert len(lines) < MOST_LINES, source
        assert max(map(len, lines)) <= 100, source


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("name", NAMES)
def test_text_is_plain_markdown(language: str, name: str) -> None:
    """No HTML but <details>, no directive that JupyterLab does not show; images have words."""
    text = re.sub(r"```.*?```|`[^`]*`|\$[^$]*\$", "", text_of(language, name), flags=re.S)
    assert set(re.findall(r"</?(\w+)", text)) <= {"details", "summary"}
    assert text.count("<details>") == text.count("</details>") == text.count("<summary>")
    assert ":::" not in text
    for alternative, target in re.findall(r"!\[([^]]*)\]\(([^)]*)\)", text):
        assert len(alternative) > 10
        assert (NOTEBOOKS / language / target).is_file(), target


@pytest.mark.parametrize("name", NAMES)
def test_rayon_is_never_alone(name: str) -> None:
    """In French "rayon" is a ray and a radius: each one says which it is."""
    text = text_of("fr", name).replace("« rayon »", "").replace("*rayon*", "")
    before = r"(?<!disque de )(?<!sphère de )(?<!boule de )(?<!lancer de )(?<!lanceur de )"
    before += r"(?<!disque un )(?<!lanceurs de )(?<!sphères de )"
    after = r"(?! (?:lumineux|de la sphère|du disque|réfléchi|réfracté|d'ombre|et le centre))"
    alone = re.findall(rf".*{before}\brayons?\b{after}.*", text)
    assert alone == []


# ---- What none may hold -------------------------------------------------------------------------


def test_no_solution_is_handed_out() -> None:
    """No line of the solution stands in a notebook, in its trial C file, or in its drawings."""
    paths = [path for kind in ("md", "ipynb", "c") for path in NOTEBOOKS.rglob(f"*.{kind}")]
    paths += (ROOT / "grader/lab/drawings").glob("tp*.py")
    assert len(paths) > 4 * len(NAMES) + len(TPS)
    files = {path.relative_to(ROOT).as_posix(): path.read_bytes() for path in paths}
    assert list(leaks.find(files, ROOT / "reference", CORE)) == []


def test_a_solution_would_be_found() -> None:
    """The search is not blind: a notebook that holds a function of the reference is named."""
    solution = (ROOT / "reference/main.c").read_text(encoding="utf-8")
    cells = [Cell("markdown", f"```c\n{solution}\n```")]
    files = {"notebooks/fr/TP1.ipynb": notebooks.notebook("TP1", cells).encode()}
    assert [leak.path for leak in leaks.find(files, ROOT / "reference", CORE)]


# ---- Spelling and typography --------------------------------------------------------------------


def words_of(language: str, name: str) -> str:
    """Return a notebook's text without code, formulas, links and commands."""
    text = re.sub(
        r"```.*?```|`[^`]*`|\$\$.*?\$\$|\$[^$]*\$", " ", text_of(language, name), flags=re.S
    )
    text = re.sub(r"\]\([^)]*\)|\S*/\S*|\*\*|<[^>]+>|-{3,}", " ", text)
    return text.replace("\N{RIGHT SINGLE QUOTATION MARK}", "'")


@pytest.mark.parametrize(("language", "dictionary"), [("fr", "fr"), ("en", "en_US")])
@pytest.mark.parametrize("name", NAMES)
def test_spelling(language: str, dictionary: str, name: str) -> None:
    """Hunspell knows every word, or our own list does."""
    program = shutil.which("hunspell")
    if program is None:
        assert not os.environ.get("MRT_CI"), "CI must have hunspell, with fr and en_US"
        pytest.skip("hunspell is not installed")
    own = NOTEBOOKS / f"words-{language}.txt"
    done = subprocess.run(
        [program, "-l", "-i", "utf-8", "-d", dictionary],
        input=words_of(language, name),
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    known = set(own.read_text(encoding="utf-8").split())
    assert sorted({word.strip(".") for word in done.stdout.split()} - known) == []


def test_french_spaces() -> None:
    """No-break spaces come before : ; ! ? and %, and inside quotes, but not in code or formulas."""
    text = "Où ? « Ici » ; `a ? b : c` $x : y$ ! 60 % de [ça](a ; b) :\n| :---: | --- |"
    hard = "\N{NO-BREAK SPACE}"
    expected = text.replace(" ?", f"{hard}?", 1).replace("« Ici » ;", f"«{hard}Ici{hard}»{hard};")
    expected = (
        expected.replace(" !", f"{hard}!").replace(" %", f"{hard}%").replace(" :\n", f"{hard}:\n")
    )
    assert notebooks.french(text) == expected


# ---- The generator ------------------------------------------------------------------------------

TEXT = "# Un\n\nDu texte ?\n\n```python\nx = 1\n```\n"


def write(folder: Path, french: str, english: str) -> Path:
    """Write a small workbook."""
    for language, text in (("fr", french), ("en", english)):
        (folder / language).mkdir(exist_ok=True)
        (folder / language / "TP1.md").write_text(text, encoding="utf-8")
    return folder


def test_notebooks_are_made_and_checked(tmp_path: Path) -> None:
    """Making them twice gives the same bytes; a change in the text is a drift."""
    folder = write(tmp_path, TEXT, TEXT.replace("Du texte ?", "Some text."))
    assert notebooks.main(["--folder", str(folder)]) == 0
    before = (folder / "fr/TP1.ipynb").read_bytes()
    assert notebooks.main(["--folder", str(folder), "--check"]) == 0
    assert notebooks.main(["--folder", str(folder)]) == 0
    assert (folder / "fr/TP1.ipynb").read_bytes() == before
    source = json.loads(before)["cells"][0]["source"]
    assert source == ["# Un\n", "\n", "Du texte\N{NO-BREAK SPACE}?"]
    write(folder, TEXT.replace("Un", "Deux"), TEXT)
    assert notebooks.main(["--folder", str(folder), "--check"]) == 1


def test_other_code_in_one_language_is_refused(tmp_path: Path) -> None:
    """The error names the notebook, the cell and the cure."""
    folder = write(tmp_path, TEXT, TEXT.replace("x = 1", "x = 2"))
    with pytest.raises(NotebookError, match=r"TP1\.md: cell 2 is not the same code.*same cells"):
        notebooks.make_all(folder)
    write(folder, TEXT, TEXT + "\nMore.\n")
    with pytest.raises(NotebookError, match="cell 3"):
        notebooks.make_all(folder)


def test_a_text_in_one_language_only_is_refused(tmp_path: Path) -> None:
    """A notebook that has no English text is named, and so is a stray .ipynb."""
    folder = write(tmp_path, TEXT, TEXT)
    (folder / "en/TP1.md").unlink()
    with pytest.raises(SkeletonError, match=r"en/TP1\.md: cannot be read"):
        notebooks.make_all(folder)
    write(folder, TEXT, TEXT)
    made = notebooks.make_all(folder)
    notebooks.main(["--folder", str(folder)])
    (folder / "en/TP9.ipynb").write_text("{}", encoding="utf-8")
    with pytest.raises(NotebookError, match=r"TP9\.ipynb: has no text beside it; remove it"):
        notebooks.check(folder, made)


def test_an_empty_folder_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One line on stderr, and exit code 1."""
    assert notebooks.main(["--folder", str(tmp_path)]) == 1
    assert (
        capsys.readouterr().err == f"{tmp_path}: no text to make notebooks from; check the folder\n"
    )

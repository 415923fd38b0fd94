"""`make alike`: copies stand before honest pairs, and what is written names nobody unasked."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest

from grader.authoring.alike import command, pieces, sharing, tools
from grader.authoring.alike.command import INDEPENDENT
from grader.authoring.specimens import patches
from grader.batch import alike_list, class_page
from grader.batch.records import Candidate, Graded
from grader.course import settings as course
from grader.course.exercises import ROOT
from grader.course.texts import Texts
from grader.intake import definitions
from grader.tests.support.shell import run

WRITINGS = [path.read_text("utf-8") for path in sorted(INDEPENDENT.glob("*.c"))]
WRITINGS.append(patches.reference()["raytracer.c"])
SIZE, PRIME = 40, 7


def of(function: str, text: str) -> str:
    """Return a function's text."""
    found = definitions.find(function, {"raytracer.c": text})
    assert found is not None
    return found.text


FUNCTIONS = [
    each
    for each in pieces.functions()
    if all(definitions.find(each, {"a.c": text}) for text in WRITINGS)
]


def helpers(text: str) -> str:
    """Return what of a program is no function of the course."""
    for function in FUNCTIONS:
        text = text.replace(of(function, text), "")
    return text


HELPERS = [helpers(text) for text in WRITINGS[:-1]]


def program(number: int) -> str:
    """Return a program of the class: for each function, one of the writings.

    Two programs are two lines of a finite plane, so they have few writings in common.
    """
    a, b = divmod(number, PRIME)
    last = len(WRITINGS) - 1
    values = [a + b * (k % PRIME) + k // PRIME * 3 for k in range(len(FUNCTIONS))]
    chosen = [min(each % PRIME, last) for each in values]
    own = [HELPERS[k] for k in sorted({*chosen}) if k < last]
    return "\n".join(
        [*own, *(of(name, WRITINGS[k]) for name, k in zip(FUNCTIONS, chosen, strict=True))]
    )


def mixed(one: str, other: str, numbers: Iterable[int]) -> str:
    """Return the functions of a program, those of some numbers from another one."""
    taken = {*numbers}
    return "\n".join(of(name, one if k in taken else other) for k, name in enumerate(FUNCTIONS))


def copies(of_class: list[str]) -> dict[str, tuple[set[int], str]]:
    """Return what six copiers make: whose programs they had, and what they hand in."""
    own = r"\b(t|r|it|l|v|n|h|k|c|d|a|b|o|sum|seen|total|obj|mat)\b(?!\s*\()"
    layout = re.sub(r"/\*.*?\*/", "", of_class[2], flags=re.DOTALL)
    loop = "for (int k = 0; k < num_lights; k++) {"
    return {
        "renamed": ({0}, re.sub(own, r"my_\1", of_class[0])),
        "reordered": ({1}, "\n\n".join(of(name, of_class[1]) for name in reversed(FUNCTIONS))),
        "commented": ({2}, layout.replace(";\n", "; // done\n").replace("{\n", "\n{ /* so */\n")),
        "mixed": ({3, 4}, mixed(of_class[3], of_class[4], range(len(FUNCTIONS) // 2))),
        "one_file": ({5}, mixed(of_class[5], program(SIZE + 5), range(6, 12))),
        "loop": ({6}, of_class[6].replace(loop, "int k = -1; while (++k < num_lights) {")),
    }


def compared(texts: Iterable[str]) -> list[sharing.Program]:
    """Return programs as they are compared."""
    return [pieces.pieces({"raytracer.c": text.encode()}) for text in texts]


def tool(name: str) -> tools.Tool:
    """Return a tool; the test is skipped where it is not, but in CI."""
    here = {"sim_c": shutil.which("sim_c"), "copydetect": importlib.util.find_spec("copydetect")}
    if not here[name]:
        assert not os.environ.get("MRT_CI"), f"CI must have {name}"
        pytest.skip(f"{name} is not installed")
    return {"sim_c": tools.by_sim, "copydetect": tools.by_copydetect}[name]


@pytest.fixture(scope="module")
def usual() -> list[sharing.Program]:
    """Return what everybody may have."""
    return [*command.usual_ways()]


@pytest.mark.long
@pytest.mark.parametrize("name", ["sim_c", "copydetect"])
def test_six_copies_stand_before_every_honest_pair(name: str, usual: list[sharing.Program]) -> None:
    """In a class of 40 made of six writings of each function: honest pairs have up to three."""
    found_by = tool(name)
    of_class = [program(number) for number in range(SIZE)]
    made = copies(of_class)
    programs = compared([*of_class, *(text for _, text in made.values())])
    found = sharing.pairs(programs, usual, found_by)
    first_honest = next(k for k, each in enumerate(found) if each.other < SIZE)
    before = {(each.one, each.other) for each in found[:first_honest]}
    for number, (kind, (sources, _)) in enumerate(made.items(), SIZE):
        assert any((source, number) in before for source in sources), kind
    assert len(before) == len(made)


@pytest.mark.parametrize("name", ["sim_c", "copydetect"])
def test_copies_of_whole_programs_stand_before_independent_ones(
    name: str, usual: list[sharing.Program]
) -> None:
    """Five programs that were written apart: each with a copy under other names."""
    found_by = tool(name)
    own = WRITINGS[:-1]
    renamed = [re.sub(r"\b([a-z]{1,3})\b(?!\s*\()", r"\1_", text) for text in own]
    keywords = re.compile(r"\b(if|for|int|do)_\b")
    texts = [*own, *(keywords.sub(r"\1", text) for text in renamed)]
    found = sharing.pairs(compared(texts), usual, found_by)
    size = len(own)
    assert {(each.one, each.other) for each in found[:size]} == {(k, k + size) for k in range(size)}
    assert found[size - 1].weight > 1.5 * found[size].weight


def test_names_numbers_comments_and_layout_do_not_count() -> None:
    """Calls of given functions do; TP1's functions are not compared."""
    one = "float f(float a){return vector_dot(a,a)*2.f;} // x\n"
    other = "float squared(float value)\n{\n  /* y */ return vector_dot(value, value) * 3;\n}\n"
    first, second = compared([one, other])
    assert first[pieces.OTHERS].items == second[pieces.OTHERS].items
    assert "vector_dot" in first[pieces.OTHERS].items
    assert "fill_red" not in pieces.functions()


def test_what_everybody_writes_is_left_out(usual: list[sharing.Program]) -> None:
    """Two people who both write as the course does share nothing."""
    texts = [patches.reference()["raytracer.c"]] * 2
    assert sharing.pairs(compared(texts), usual, tool("sim_c")) == []


# ---- The command --------------------------------------------------------------------------------


def hand_in(folder: Path, name: str, text: str, authors: str = "") -> None:
    """Write a submission."""
    (folder / name).mkdir(parents=True)
    (folder / name / "raytracer.c").write_text(text, encoding="utf-8")
    if authors:
        (folder / name / "AUTEURS.txt").write_text(authors, encoding="utf-8")


def alike(*words: str, language: str = "fr") -> tuple[int, str, str]:
    """Run the command; return how it ended."""
    done = run(sys.executable, "-m", "grader", "alike", *words, cwd=ROOT, MRT_LANG=language)
    return done.returncode, done.stdout, done.stderr


@pytest.mark.long
def test_a_class_is_listed_under_pseudonyms_that_the_class_page_has(tmp_path: Path) -> None:
    """Names only when asked for; another year's too; not those who have signed together."""
    tool("sim_c")
    now, past, out = (tmp_path / name for name in ("rendus", "2025", "notes"))
    hand_in(now, "Ada Lovelace", WRITINGS[0])
    hand_in(now, "Alan Turing", WRITINGS[0].replace("below", "under"))
    hand_in(now, "Grace Hopper", WRITINGS[1], "Hopper Grace 21900001\n")
    hand_in(now, "Hopper again", WRITINGS[1], "HOPPER Grace 21900001\n")
    hand_in(past, "Old Hand", WRITINGS[2])
    hand_in(now, "New <b>Hand", WRITINGS[2])
    code, said, _ = alike(str(now), "--out", str(out), "--past", str(past))
    assert (code, said.count("\n")) == (0, 1)
    html = (out / alike_list.PAGE).read_text("utf-8")
    assert not re.search("Ada|Turing|Hopper|Hand", html)
    pairs = json.loads((out / alike_list.NAME).read_text("utf-8"))["pairs"]
    names = [{each["one"]["name"], each["other"]["name"]} for each in pairs]
    assert {"Ada Lovelace", "Alan Turing"} in names[:2]
    assert {"New -b-Hand", "2025/Old Hand"} in names[:2]
    assert {"Grace Hopper", "Hopper again"} not in names
    graded = {"Ada Lovelace", "Alan Turing"}
    listed = alike_list.read(out, graded, names=False)
    assert [each["one"] in html and each["other"] in html for each in listed] == [True] * len(
        listed
    )
    assert alike(str(now), "--out", str(out), "--names")[0] == 0
    assert "Ada Lovelace – Alan Turing" in (out / alike_list.PAGE).read_text("utf-8")


def test_the_class_page_lists_the_pairs(tmp_path: Path) -> None:
    """Under pseudonyms in a fold, without what is no submission of the class; without, nothing."""
    people = [{"name": f"Name {k}", "pseudonym": f"PSEUDO{k}"} for k in range(3)]
    pairs = [
        {"one": people[k], "other": people[2], "lines": 7 + k, "exercises": ["TP2.4"]}
        for k in range(2)
    ]
    (tmp_path / alike_list.NAME).write_text(json.dumps({"pairs": pairs}), encoding="utf-8")
    graded = {"Name 0": Graded(Candidate("Name 0", "Name 0", tmp_path))}

    def page(hidden: dict[str, str] | None) -> str:
        settings = course.load()
        return class_page.render([], graded, settings, hidden, Texts("fr"), tmp_path / "students")

    shown = page({})
    assert "PSEUDO0 – PSEUDO2" in shown
    assert "7 lignes en commun" in shown
    assert not re.search("PSEUDO1|Name|alike.html", shown)
    assert 'href="alike.html"' in page(None)
    (tmp_path / alike_list.NAME).write_text("{", encoding="utf-8")
    assert Texts("fr").say("alike.list") not in page({})


def test_a_student_s_text_is_no_html(tmp_path: Path) -> None:
    """Nor anything but text on the page."""
    tool("sim_c")
    text = WRITINGS[3].replace("roots found", "roots /* <script>alert(1)</script> */ found")
    assert "<script>alert" in text
    hand_in(tmp_path / "in", "a", text)
    hand_in(tmp_path / "in", "b", text)
    assert alike(str(tmp_path / "in"), "--out", str(tmp_path / "out"))[0] == 0
    html = (tmp_path / "out" / alike_list.PAGE).read_text("utf-8")
    assert "<script>alert" not in html
    assert "&lt;script&gt;alert" in html


@pytest.mark.parametrize("language", ["fr", "en"])
def test_what_is_wrong_is_one_line(language: str, tmp_path: Path) -> None:
    """It names the place: one submission, no folder, no tool."""
    tool("sim_c")
    hand_in(tmp_path / "in", "a", WRITINGS[0])
    for path in (tmp_path / "in", tmp_path / "none"):
        code, _, said = alike(str(path), "--out", str(tmp_path / "out"), language=language)
        assert (code, said.count("\n"), str(path) in said.replace("\n", "")) == (2, 1, True), said


def test_without_a_tool_a_line_says_how_to_get_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """sim_c first, then copydetect."""
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(tools.AlikeError) as caught:
        tools.found()
    assert caught.value.key == "alike.no_tool"

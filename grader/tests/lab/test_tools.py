"""check, predict, source, progress, help_card, show, compare: what a cell shows."""

from __future__ import annotations

import io
import itertools
import json
import logging
import os
import re
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grader.course import exercises
from grader.course.exercises import CORE, ROOT
from grader.evaluation.records import Outcome
from grader.lab import (
    Core,
    Stopped,
    check,
    compare,
    help_card,
    predict,
    predicted,
    progress,
    show,
    slider,
    source,
)
from grader.lab.cells import record
from grader.lab.cells import slider as slide
from grader.lab.cells.source import find
from grader.lab.display import store
from grader.lab.display.card import capital
from grader.lab.display.picture import black, figure, levels, new_figure, png
from grader.tests.lab.conftest import Edit

DOT = "float n_l = vector_dot(n, l);"


@pytest.fixture
def outputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder of outputs of its own."""
    monkeypatch.setenv("BUILD", str(tmp_path / "sorties"))
    monkeypatch.setenv("MRT_LANG", "en")
    return tmp_path / "sorties" / "lab"


# ---- check, progress, help_card ------------------------------------------------------------------


def test_a_right_exercise_is_said_to_be_right(folder: Path) -> None:
    """All its points, every check named; progress knows it afterwards."""
    text = check("tp1.1", "TP1.2").text
    assert "TP1.1 fill_red: right, 2 / 2" in text
    assert "TP1.2 fill: right, 2 / 2" in text
    row = next(line for line in progress().text.splitlines() if line.startswith("TP1.1"))
    assert "right" in row
    assert "this session" in row


def test_a_wrong_exercise_has_a_question_and_hints_to_unfold(
    core: Core, folder: Path, edit: Edit
) -> None:
    """The first failing check in full; help_card has it with the function and the last change."""
    core.vector_norm((0, 0, 0))
    edit("main.c", "void fill_red(color *img) {", "void fill_red(color *img) { return;")
    shown = check("TP1.1")
    assert "TP1.1 fill_red: to review, 0 / 2" in shown.text
    assert "pixel (0, 0)" in shown.text
    assert shown.html.count("<details>") >= 2
    assert "A more direct hint" in shown.html
    core.vector_norm((0, 0, 0))
    card = help_card().text
    assert "void fill_red(color *img) { return;" in card
    assert "+void fill_red(color *img) { return;" in card
    assert "pixel (0, 0)" in card


def test_progress_keeps_what_other_notebooks_have_checked(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the last grade; of both, what was seen last. Points by TP and the next step follow."""
    check("TP1.1")
    monkeypatch.setattr(record, "_START", time.time() + 1)  # another session
    lines = progress().text.splitlines()
    assert any(line.startswith("TP1.1 ") and "an earlier session" in line for line in lines)
    assert any("TP1 2 / 15, TP2 0 /" in line for line in lines)
    assert lines[-1] == "Next step: TP1.2, the function fill in main.c. Notebook: TP1.ipynb"
    row = {"id": "TP1.1", "outcome": "failed", "points": 0.5}
    results = {"exercises": [row], "graded_at": "2000-01-01T00:00:00+00:00"}
    path = Path(os.environ["BUILD"]) / "grade" / "results.json"
    path.parent.mkdir()
    path.write_text(json.dumps(results), encoding="utf-8")
    assert "TP1 2 / 15" in progress().text
    path.write_text(json.dumps({**results, "graded_at": "2999-01-01T00:00:00+00:00"}), "utf-8")
    text = progress().text
    assert "TP1 0.5 / 15" in text
    assert "last make grade" in text
    assert "Next step: TP1.1" in text


@pytest.mark.parametrize("content", ['{"TP1.1": {}}', '{"TP1.1": 3}', '{"TP1.1": {"at": 1}}'])
def test_a_damaged_record_is_as_good_as_none(outputs: Path, content: str) -> None:
    """Nothing is known then, and nothing is lost."""
    outputs.mkdir(parents=True)
    (outputs / "checks.json").write_text(content, encoding="utf-8")
    assert "TP1 0 / 15" in progress().text


def test_what_comes_next_is_said_after_a_check_that_passes(folder: Path, edit: Edit) -> None:
    """Onwards from there; not after one that fails, which says what to look at."""
    assert "Next step: TP1.3, the function horizontal_gradient" in check("TP1.2").text
    edit("main.c", "void fill_red(color *img) {", "void fill_red(color *img) { return;")
    assert "Next step" not in check("TP1.1").text


def test_the_next_step_is_the_first_that_is_wrong() -> None:
    """Then what is to do, bonuses last; what waits comes when nothing else is left."""
    rows = {each.id: each for each in exercises.load().exercises if each.checks}
    states = {"TP1.1": "passed", "TP2.2": "todo", "TP2.4": "crashed", "TP3.1": "failed"}
    order = []
    while True:
        found = [
            record.Known(each, Outcome(states[name]) if name in states else Outcome.BLOCKED)
            for name, each in rows.items()
            if name in ("TP2.B1", "TP4.1", *states)
        ]
        if (following := record.following(found)) is None:
            break
        order.append(following.id)
        states[following.id] = "passed"
    assert order == ["TP2.4", "TP3.1", "TP2.2", "TP4.1", "TP2.B1"]


@pytest.mark.parametrize(
    ("name", "waits_for", "then"),
    [
        ("TP2.2", ["TP2.6"], "TP2.3"),  # onwards: that comes later
        ("TP2.5", ["TP2.1"], "TP2.1"),  # what is missing before it
        ("TP2.6", [], "TP3.1"),
        ("TP5.3", [], "TP1.1"),  # then what was left behind
    ],
)
def test_what_comes_after(name: str, waits_for: list[str], then: str) -> None:
    """Of a course of which nothing is done, behind an exercise that is right or waits."""
    rows = [record.Known(each) for each in exercises.load().exercises if each.checks]
    found = record.after(rows, name, waits_for)
    assert found is not None
    assert found.id == then
    done = [record.Known(each.exercise, Outcome.PASSED) for each in rows]
    assert record.after(done, name) is None


def test_the_help_card_has_the_last_change_when_only_checks_ran(folder: Path, edit: Edit) -> None:
    """Without any picture drawn, and of the file as it is now."""
    check("TP1.1")
    edit("main.c", "void fill_red(color *img) {", "void fill_red(color *img) { return;")
    check("TP1.1")
    assert "+void fill_red(color *img) { return;" in help_card().text
    edit("main.c", "{ return;", "{ if (!img) return;")
    card = help_card().text
    assert "-void fill_red(color *img) { return;" in card
    assert "+void fill_red(color *img) { if (!img) return;" in card


def test_the_skeleton_is_calm(folder: Path) -> None:
    """Nothing is wrong with what is not written yet."""
    (folder / "main.c").write_bytes((CORE / "main.c").read_bytes())
    text = check("TP1.1").text
    assert "to do" in text
    assert "main.c" in text
    assert "✗" not in text


@pytest.mark.parametrize("name", ["TP9.9", "TP1.6"])
def test_exercises_without_checks(folder: Path, name: str) -> None:
    """An unknown exercise, or a free one, is told in a sentence."""
    with pytest.raises(Stopped, match=name):
        check(name)


# ---- predict -------------------------------------------------------------------------------------


def test_a_prediction_is_kept(outputs: Path) -> None:
    """It outlives the kernel, and stands beside the result."""
    assert "answer" in repr(predict("tp1.first_pixel", "ABC"))
    assert "not chosen" in predicted("tp1.first_pixel").text
    predict("tp1.first_pixel", "ABC", answer="B")
    predict("tp1.other", "AB", answer="A")
    assert predicted("tp1.first_pixel").text == "You had chosen B."
    assert store.read("predictions.json") == {"tp1.first_pixel": "B", "tp1.other": "A"}
    with pytest.raises(Stopped, match="A, B, C"):
        predict("tp1.first_pixel", "ABC", answer="AB")


@pytest.mark.parametrize("content", ["{", "[1]", "\xff"])
def test_damaged_predictions_are_set_aside(outputs: Path, content: str) -> None:
    """The notebook goes on; the damaged file is kept under another name."""
    outputs.mkdir(parents=True)
    (outputs / "predictions.json").write_text(content, encoding="latin-1")
    assert "not chosen" in predicted("tp1.x").text
    assert (outputs / "predictions.damaged").is_file()
    predict("tp1.x", "AB", answer="B")
    assert predicted("tp1.x").text == "You had chosen B."


def test_buttons_keep_the_choice(outputs: Path) -> None:
    """Clicking a button is answering; the next display shows it chosen."""
    from grader.lab.cells.predict import _buttons

    buttons = _buttons("tp2.y", "ABC")
    assert buttons.value is None
    buttons.value = "C"
    assert predicted("tp2.y").text == "You had chosen C."
    assert _buttons("tp2.y", "ABC").value == "C"
    bundle = predict("tp2.y", "ABC")._repr_mimebundle_()
    assert {"text/html", "text/plain", "application/vnd.jupyter.widget-view+json"} <= set(bundle)


# ---- source --------------------------------------------------------------------------------------


def test_a_function_is_found_among_traps(tmp_path: Path) -> None:
    """Prototypes, calls, comments, strings and braces in them are not its definition."""
    body = """color
shade(vec3 n,
      vec3 v) {
    char brace = '}'; /* } */ // }
    const char *text = "\\"} shade(x) {";
    if (n.x) { return v; }
    return n;
}"""
    text = f"color shade(vec3 n, vec3 v);\n/* shade(a) {{ */\nint k = 0;\n{body}\nint shade_two;\n"
    (tmp_path / "raytracer.c").write_text(text, encoding="utf-8")
    found = find("shade", tmp_path)
    assert found is not None
    assert body.endswith(found.text)
    assert found.text.startswith("shade(vec3 n,")
    assert text.splitlines()[found.line - 1].startswith("shade(")
    assert find("shad", tmp_path) is None


def test_source_shows_the_function_and_opens_its_file(folder: Path) -> None:
    """Coloured, escaped, with a relative link to its line."""
    shown = source("intersect_sphere")
    assert shown.text.splitlines()[1].startswith("bool intersect_sphere(")
    assert "raytracer.c#line=" in shown.html
    with pytest.raises(Stopped, match="nowhere"):
        source("nowhere")


def test_every_exercise_is_found_where_it_is_defined() -> None:
    """Not where it is called: `if (... in_shadow(it, &lights[k])) {` stands before in_shadow."""
    names = [name for each in exercises.load().exercises for name in each.functions]
    assert "in_shadow" in names
    for name, folder in itertools.product(names, (CORE, ROOT / "reference")):
        found = find(name, folder)
        assert found
        assert re.match(rf"\w+ \*?{name}\(", found.text), found


# ---- pictures ------------------------------------------------------------------------------------


def test_row_0_is_at_the_bottom_of_what_is_shown(outputs: Path) -> None:
    """The file's first row is the top; colours are cut off, NaN is magenta."""
    img = black((4, 3))
    img[0, 0] = (2, -1, 0.5)
    img[2, 3] = np.nan
    with Image.open(io.BytesIO(png(img))) as file:
        assert file.size == (4, 3)
        assert file.getpixel((0, 2)) == (255, 0, 127)
        assert file.getpixel((3, 0)) == (255, 0, 255)
    assert repr(img).endswith("(NaN), in magenta: 1.")
    assert levels(img).flags.c_contiguous


def test_pictures_have_a_text_for_who_cannot_see_them(core: Core) -> None:
    """Every image and every drawing carries a text, escaped."""
    img = core.image()
    assert re.match('<img [^>]*alt="[^"]', img._repr_mimebundle_()["text/html"])
    for shown in (
        show(img, 'a "title"').html,
        show(img[:, :, 0], label="t", zoom=(0, 0, 5, 5)).html,
        compare(img, img).html,
    ):
        assert re.match('<svg role="img" aria-label="[^"]', shown)
    assert "a &quot;title&quot;" in show(img, 'a "title"').html
    assert repr(img[0, 0]) == "(0, 0, 0)"


def test_the_reference_is_as_expected(core: Core) -> None:
    """The figures of the reference show no difference; another picture does, and a size is told."""
    flat = core.figure("figure_4")
    assert "no difference" in compare(flat, "figure_4").text
    assert "% of the pixels differ" in compare(core.figure("figure_5"), "figure_4").text
    with pytest.raises(Stopped, match="320 x 180"):
        compare(core.image(), "figure_4")
    with pytest.raises(Stopped, match="figure_99"):
        compare(flat, "figure_99")


def test_a_comparison_is_told_in_the_language(monkeypatch: pytest.MonkeyPatch) -> None:
    """In French: its colon, its decimal comma, its sides."""
    monkeypatch.setenv("MRT_LANG", "fr")
    img = black((320, 180))
    img[0, 0] = 1
    assert "0,0017 % des pixels" in compare(img, black((320, 180))).text
    assert "figure 7, à gauche : 100 % des pixels" in compare(img + 0.5, "figure_7_left").text


def test_a_comparison_tells_the_places_and_how_to_read_its_map(core: Core) -> None:
    """Of an expected picture with what is seen there; of equal ones there is nothing to tell."""
    flat = core.figure("figure_4")
    assert "SSIM" not in compare(flat, "figure_4").html
    flat[20:40, 30:60] = 1
    shown = compare(flat, "figure_4")
    for words in (
        "in one place: at the bottom left, mostly on the floor (600 pixels).",
        "Likeness of shapes (SSIM): 1 (yellow)",
    ):
        assert words in shown.html.partition("<p>")[2]
        assert words in shown.text
    plain = compare(black((320, 180)) + 1, black((320, 180)))
    assert "The differences are" not in plain.text
    tiny = black((5, 4))
    assert "100 % of the pixels" in compare(tiny + 1, tiny).text


def test_the_first_run_is_not_red() -> None:
    """Matplotlib keeps to itself that it lists the machine's fonts, which it writes on stderr."""
    assert not logging.getLogger("matplotlib.font_manager").isEnabledFor(logging.WARNING)


# ---- slider --------------------------------------------------------------------------------------


def test_a_slider_has_a_picture_without_a_front_end(core: Core) -> None:
    """What the function gives at the start is there as HTML; moving it changes the picture."""
    moved = slider(
        lambda epsilon, deep: core.render(scene=0, epsilon=epsilon, max_depth=int(deep)),
        epsilon=(0.0, 0.1, 1e-4),
        deep=[1, 5],
    )
    bundle = moved._repr_mimebundle_()
    assert 'alt="' in bundle["text/html"]
    assert "epsilon = 0.0001, deep = 1" in bundle["text/plain"]
    box, shown = moved._box()
    slide, _, area, *_ = box.children
    assert area.value == shown.html
    slide.value = 0.1
    assert area.value != shown.html
    assert "epsilon = 0.1" in area.value


def test_a_slider_survives_a_crash(core: Core, edit: Edit) -> None:
    """The card takes the picture's place, and the picture comes back."""
    box, shown = slider(lambda k: core.render(scene=k), k=(0, 4))._box()
    slide, area, *_ = box.children
    edit("raytracer.c", DOT, f"{DOT} volatile int *p = 0; *p = 1;")
    slide.value = 1
    assert "in shade (raytracer.c:" in area.value
    edit("raytracer.c", "volatile int *p = 0; *p = 1;", "")
    slide.value = 0
    assert area.value == shown.html


TRIPLE = re.compile(r"\((-?[0-9.e-]+), (-?[0-9.e-]+)(?:, (-?[0-9.e-]+))?\)")


def decimal_ranges() -> list[tuple[float, float, float]]:
    """Return the ranges of decimals of the sliders of all notebooks."""
    found = set()
    for path in (ROOT / "notebooks").glob("*/*.md"):
        for call in re.findall(r"slider\((.*?)\n?\)\n", path.read_text("utf-8"), re.DOTALL):
            for low, high, start in TRIPLE.findall(call):
                if "." in low + high:
                    found.add((float(low), float(high), float(start or low)))
    return sorted(found)


@pytest.mark.parametrize(("low", "high", "start"), decimal_ranges())
def test_sliders_stand_on_their_grid(low: float, high: float, start: float) -> None:
    """Both ends and the start are among their values, to the last bit, as are round numbers."""
    values = slide.grid(low, high, start)
    assert {low, high, start} <= {*values}
    assert 20 <= len(values) - 1 <= 2000
    assert all(len(f"{each:.10g}") <= 6 for each in values)


def test_a_slider_without_a_grid_is_refused() -> None:
    """Who writes a notebook is told so at once."""
    assert len(decimal_ranges()) > 5
    with pytest.raises(ValueError, match="no round step"):
        slide.grid(0.0, 1.0, 1 / 3)


def test_a_slider_writes_numbers_as_the_language(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a comma in French; choices are in order, and begin with the first that is given."""
    monkeypatch.setenv("MRT_LANG", "fr")
    box, _ = slider(lambda x, s: x, x=(0.5, 5.0, 4.0), s=[20, 0.5, 5])._box()
    number, choice, *_ = box.children
    assert (number.label, choice.label) == ("4", "20")
    assert number.options[1] == ("0,6", 0.6)
    assert [label for label, _ in choice.options] == ["0,5", "5", "20"]


# ---- Drawings ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("title", "shown"),
    [
        ("écart à la surface", "Écart à la surface"),
        ("distance t", "Distance t"),
        ("la vôtre", "La vôtre"),
        ("longueur de out->dir : 1", "Longueur de out->dir : 1"),
        *(
            (each, each)
            for each in ("t = 3", "kr = 0", "d.n = 0", "max_depth = 2", "in_shadow : true")
        ),
        *((each, each) for each in ("true, un objet", "./mrt 4", "f(t)", "Scène 0", "", "(0, 1)")),
    ],
)
def test_titles_begin_with_a_capital(title: str, shown: str) -> None:
    """But where they begin with a symbol or a value of C's."""
    assert capital(title) == shown


@pytest.mark.parametrize(
    ("language", "tick", "title"), [("fr", "0,5", "Écart"), ("en", "0.5", "Écart")]
)
def test_ticks_are_written_as_the_language(
    monkeypatch: pytest.MonkeyPatch, language: str, tick: str, title: str
) -> None:
    """With a comma in French; the title of all has its capital too."""
    monkeypatch.setenv("MRT_LANG", language)
    drawn, axes = new_figure()
    axes.plot([0, 1], [0, 1])
    axes.set_xticks([0, 0.5, 1])
    drawn.suptitle("écart")
    figure(drawn, "words")
    assert [each.get_text() for each in axes.get_xticklabels()][1] == tick
    assert drawn.get_suptitle() == title


def test_values_have_names_of_the_language(core: Core, monkeypatch: pytest.MonkeyPatch) -> None:
    """No "Miss" in a French notebook."""
    ball = core.sphere((0, 0, 0), 1)
    rays = [core.ray((0, y, -3), (0, 0, 1)) for y in (0, 5)]
    monkeypatch.setenv("MRT_LANG", "fr")
    texts = [repr(core.intersect_sphere(each, ball)) for each in rays]
    assert [each.splitlines()[0] for each in texts] == ["Rencontre", "Aucune rencontre"]
    assert repr(ball).startswith("Sphère")


def test_one_check_by_its_name(folder: Path) -> None:
    """It says its outcome without points, is not kept as the exercise's, and leads nowhere yet."""
    text = check("tp4.octree.overlap", "tp4.octree.tall").text
    assert text.count("TP4.B1 box_overlaps_object: right") == 2
    assert " / 5" not in text
    assert "Next step" not in text
    row = next(line for line in progress().text.splitlines() if line.startswith("TP4.B1"))
    assert "right" not in row

"""`make oral`: questions on a person's own code, from the known mistakes."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from markupsafe import escape

from grader.authoring.oral import choice, command, matching, page, rules, tracing
from grader.authoring.oral.records import Drawn, Question, Swapped, Traced, Value
from grader.authoring.oral.tokens import functions, tokens
from grader.authoring.oral.trials import Laboratory, views
from grader.authoring.release import collect
from grader.authoring.specimens import mistakes, patches
from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.course.exercises import ROOT
from grader.course.texts import Texts
from grader.intake.records import Submission
from grader.intake.submission import read_submission
from grader.report.page import markup
from grader.tests.conftest import Write

FRENCH = Texts("fr")
KNOWN = {each.id: each for each in mistakes.load()}
REFERENCE = patches.submission("reference", patches.reference())
# Of every TP, and of every kind of change: a name, a sign, a factor, a call, a line that goes.
SAMPLE = (
    *("fill_misses_last", "gradient_upside_down", "circle_radius_not_squared", "raytrace_corner"),
    *("plane_sign", "sphere_normal_inwards", "trace_black_sky", "shade_factor_precedence"),
    *("light_starts_at_kd", "shadow_beyond_light", "reflection_not_unit", "mirror_kd"),
    *("schlick_added", "samples_divided_by_side", "glass_odds_reversed", "fractal_below"),
)
# A sphere by another hand: other names, the handout's quadratic, no helper.
SPHERE = """\
#include "raytracer.h"
bool intersect_sphere(ray *rayon, intersection *inter, const object *boule) {
    vec3 oc = vector_minus(rayon->orig, boule->center);
    double a = vector_dot(rayon->dir, rayon->dir); /* 1 if dir is unit */
    double b = 2 * vector_dot(oc, rayon->dir);
    double c = vector_dot(oc, oc) - boule->radius * boule->radius;
    double delta = b*b - 4.0 * a*c;
    return delta >= 0;
}
"""
EVIL = "/* <script>alert(1)</script> \u202e */"


def written(**files: str) -> Submission:
    """Return a submission of these files, `raytracer` standing for raytracer.c."""
    content = {f"{name}.c": text.encode() for name, text in files.items()}
    return Submission("rendu", content, missing=())


# ---- Finding lines ------------------------------------------------------------------------------


def test_functions_are_found_whatever_stands_around_them() -> None:
    """Comments, strings, other lines of the preprocessor and prototypes hide nothing."""
    text = (
        "#define F(x) { x\nint f(int a);\n/* int g(void) { */\nint f(int a, const ray *b)\n"
        "{ char *s = \"}\"; if (a) { return '{'; } return 0; }\nstatic void g(void) { f(1, 0); }\n"
    )
    found = functions(text)
    assert {name: each.parameters for name, each in found.items()} == {
        "f": ("a", "b"),
        "g": ("void",),
    }
    assert text[found["g"].start :].startswith("g(void)")
    assert found["f"].body[-1].text == "}"


@pytest.mark.parametrize("name", SAMPLE)
def test_a_mistake_put_into_the_reference_is_its_patch(name: str) -> None:
    """The same tokens in the same file, in a line or three."""
    change = matching.changes(REFERENCE, KNOWN[name])[0]
    patched = KNOWN[name].files()[change.place.file]
    assert [each.key for each in tokens(change.content)] == [each.key for each in tokens(patched)]
    assert change.place.text.count("\n") < matching.MOST_LINES
    assert change.new in change.content


def test_a_line_is_found_under_other_names() -> None:
    """Parameters, variables, 4.0 for 4.f; what is written in its place keeps the names."""
    (change,) = matching.changes(written(raytracer=SPHERE), KNOWN["sphere_discriminant_without_4"])
    assert change.place.at == "raytracer.c:7"
    assert change.place.text.strip() == "double delta = b*b - 4.0 * a*c;"
    assert change.new.strip() == "double delta = b*b - a*c;"
    assert change.content == SPHERE.replace("4.0 * a*c", "a*c")


def test_what_is_not_there_or_there_twice_is_not_changed() -> None:
    """Neither another function's line, nor one of two that look the same, nor a mistake made."""
    mistake = KNOWN["sphere_discriminant_without_4"]
    for text in (
        SPHERE.replace("intersect_sphere", "helper"),
        SPHERE.replace("return delta", "delta = b*b - 4 * a*c; return delta"),
        SPHERE.replace("4.0 * a*c", "a*c"),
        "bool intersect_sphere(ray *r {{{ ((",
        "",
    ):
        assert matching.changes(written(raytracer=text), mistake) == []


def test_a_helper_of_the_students_is_searched_too() -> None:
    """What the function calls in its own file, but no other exercise's function."""
    helper = "static float disc(float p, float q, float s) { return q*q - 4 * p*s; }\n"
    call = SPHERE.replace("b*b - 4.0 * a*c", "disc(a, b, c)")
    mistake = KNOWN["sphere_discriminant_without_4"]
    (change,) = matching.changes(written(raytracer=helper + call), mistake)
    assert change.place.function == "disc"
    assert matching.changes(written(raytracer=helper + SPHERE.replace("4.0", "3")), mistake) == []


def test_bytes_that_are_no_text_stay_as_they_are() -> None:
    """A comment in Latin-1 comes back in the changed file."""
    text = SPHERE.encode().replace(b"1 if", b"\xe9t\xe9")
    submission = Submission("rendu", {"raytracer.c": text}, missing=())
    (change,) = matching.changes(submission, KNOWN["sphere_discriminant_without_4"])
    assert b"\xe9t\xe9" in change.content.encode("utf-8", "surrogateescape")


def test_every_form_is_of_a_known_mistake_and_brings_in_no_free_name() -> None:
    """What a form writes, it has read."""
    assert set(rules.forms()) <= set(KNOWN)
    for name, rows in rules.forms().items():
        for old, new in rows:
            known = set(re.findall(r"\$\w+", old))
            assert old != new, name
            assert set(re.findall(r"\$\w+", new)) <= known, f"{name}: {new}"


# ---- Asking -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a submission: a hostile comment, a wrong disc, a sphere never hit."""
    todo = 'MRT_TODO("TP1.{}"); (void)img; (void)c{};'
    bodies = {
        **STUDENT_MAIN,
        "fill": f"{EVIL} {STUDENT_MAIN['fill']}",
        "horizontal_gradient": todo.format(3, "1; (void)c2"),
        "fill_rect": todo.format(4, "; (void)p1; (void)p2"),
        "fill_circle": STUDENT_MAIN["fill_circle"].replace("< radius * radius", "< radius"),
    }
    path = tmp_path_factory.mktemp("oral") / "rendu"
    path.mkdir()
    sphere = SPHERE.replace("return delta >= 0", "(void)inter; return delta > 1e30")
    for name, text in {"main.c": main_c(bodies), "raytracer.c": sphere}.items():
        (path / name).write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def laboratory(folder: Path) -> Iterator[Laboratory]:
    """Return the submission, built where the command finds it again."""
    with Laboratory(read_submission(folder), folder.parent / "cache", FRENCH) as made:
        yield made


@pytest.fixture(scope="module")
def questions(laboratory: Laboratory) -> list[Question]:
    """Return the three questions that it has in TP1."""
    return choice.choose(laboratory, 5, tp=1)


def test_questions_are_on_what_is_written_and_right(questions: list[Question]) -> None:
    """On the one line that is right, then on values; what is to do is not asked about."""
    swapped, *traced = questions
    assert isinstance(swapped, Swapped)
    assert swapped.change.mistake.exercise == "TP1.2"
    assert [getattr(each, "exercise", "") for each in traced] == ["TP1.5", "TP1.2"]


def test_an_answer_is_what_the_changed_program_does(questions: list[Question]) -> None:
    """Points are lost on the checks that see the mistake, and the picture changes."""
    for each in questions:
        if isinstance(each, Swapped):
            assert {check.id for check in each.failed} & set(each.change.mistake.shows)
            assert 0 < each.lost <= each.points
            assert each.sight is not None
            assert each.sight.changed > 0


def test_a_value_is_what_their_own_code_gives(questions: list[Question]) -> None:
    """Of a wrong disc its own number of pixels, with the right one beside it."""
    disc = questions[1]
    assert isinstance(disc, Traced)
    assert disc.place.text.startswith("void fill_circle(")
    assert [(each.got, each.expected) for each in disc.values] == [("5", "9")]


def test_the_page_is_whole_inert_and_keeps_the_answers_apart(
    laboratory: Laboratory, questions: list[Question]
) -> None:
    """Nothing from elsewhere, what students wrote as text, every answer folded and at the end."""
    for language in ("fr", "en"):
        html = page.render(laboratory.submission, questions, "strong", Texts(language))
        assert "<script>alert" not in html
        assert "\u202e" not in html
        assert not re.search(r"(src|href)=\"(?!data:image/png|#)", html)
        student, assistant = html.split('id="assistant"')
        assert student.count('<article class="asked">') == 3
        assert assistant.count('<details class="answer">') == 3
        assert "<details" not in student
        for each in questions:
            if isinstance(each, Swapped):
                title = Texts(language).get(f"mistake.{each.change.mistake.id}.title")
                shown = str(escape(markup.typeset(title, language)))
                assert shown in assistant
                assert shown not in student


def test_a_change_that_ends_the_program_is_told(
    laboratory: Laboratory, questions: list[Question]
) -> None:
    """The picture of before, and a sentence in the place of the other one."""
    swapped = questions[0]
    assert isinstance(swapped, Swapped)
    assert swapped.sight is not None
    ended = replace(swapped, sight=replace(swapped.sight, after=Drawn(death="Plus de pile.")))
    html = page.render(laboratory.submission, [ended], "strong", FRENCH)
    assert "Le programme ne termine pas cette image. Plus de pile." in html
    assert html.count("<img") == 2


def test_the_same_code_gives_the_same_questions(laboratory: Laboratory) -> None:
    """The choice depends on the code, not on its name or its day; another code, another choice."""
    own = laboratory.submission
    assert choice.seed(own) == choice.seed(replace(own, name="copie"))
    changed = {**own.files, "main.c": own.files["main.c"] + b"\n"}
    assert choice.seed(own) != choice.seed(replace(own, files=changed))


def test_pictures_follow_what_is_written() -> None:
    """A student in TP2 sees flat colours; without the camera there is no scene to see."""
    tp2 = {f"TP2.{k}" for k in range(1, 7)}
    (view, *_) = views("TP2.4", tp2)
    assert view.call == "./mrt 9 image --no-shading --no-shadows --no-reflections --no-fresnel"
    assert list(views("TP2.4", tp2 - {"TP2.1"})) == []
    assert list(views("TP4.2", tp2)) == []
    (view, *_) = views("TP2.B2", tp2)
    assert view.scene == 5


def test_values_of_a_miss_end_with_it(laboratory: Laboratory) -> None:
    """Where false is right nothing else is asked; of a function that is not there, nothing."""
    source, libraries = laboratory.submission, laboratory.libraries
    asked = [tracing.traced("TP2.4", source, libraries, random.Random(k)) for k in range(4)]
    values = {tuple(each.values) for each in asked if each}
    assert (Value("result", "false"),) in values
    wrong = {(each[0].name, each[0].got, each[0].expected) for each in values if len(each) > 1}
    assert wrong == {("result", "false", "true")}
    assert tracing.traced("TP2.1", source, libraries, random.Random(1)) is None


# ---- The command --------------------------------------------------------------------------------


def test_the_command_writes_the_page(
    folder: Path,
    questions: list[Question],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """One line, and build/oral/NAME.html; where there is nothing to ask, a line and 2."""
    words = [str(folder), "--questions", "3", "--build", str(folder.parent), "--lang", "en"]
    monkeypatch.setattr(command, "choose", lambda made, count, tp: questions[:count])
    assert command.main(words) == 0
    path = folder.parent / "oral" / "rendu.html"
    assert path.read_text(encoding="utf-8").count('<article class="asked">') == 3
    line = "rendu - questions: 3, of which 1 on changed lines and 2 on values; page: "
    assert capsys.readouterr().out == f"{line}{path}\n"
    monkeypatch.setattr(command, "choose", lambda made, count, tp: [])
    assert command.main(words) == 2
    assert "no exercise is far enough" in capsys.readouterr().err


def test_what_cannot_be_asked_is_one_line(
    submission: Write,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A path that is not there, nothing that compiles, no reference: exit code 2."""
    broken = submission(files=dict.fromkeys(("main.c", "raytracer.c", "octree.c"), "int x = ;\n"))
    build = ["--build", str(tmp_path), "--lang", "fr"]
    assert command.main([str(tmp_path / "absent"), *build]) == 2
    assert "n'existe pas" in capsys.readouterr().err
    assert command.main([str(broken), *build]) == 2
    assert capsys.readouterr().err.startswith("rendu : rien ne compile (main.c:1: expected")
    monkeypatch.setattr(command, "REFERENCE", tmp_path)
    assert command.main([str(broken), *build]) == 2
    said = capsys.readouterr().err
    assert said.startswith("reference/main.c n'est pas là")
    assert said.count("\n") == 1


def test_students_do_not_get_it() -> None:
    """Neither the questions' module nor its target, since it holds parts of solutions."""
    files = collect(ROOT)
    assert not [path for path in files if path.startswith("grader/authoring/")]
    assert b"\noral:" not in files["Makefile"]

"""The rules from findings to points, the manifest, and the sentences."""

from __future__ import annotations

import ast
import inspect
import re
import string
from dataclasses import replace
from pathlib import Path

import pytest

from grader.checking.records import Evidence
from grader.course import exercises
from grader.course.exercises import ManifestError, load, shares
from grader.course.message import Message
from grader.course.texts import LANGUAGES, Texts, preferred, sentences
from grader.evaluation.grading import grade
from grader.evaluation.records import Finding, Outcome

RULES = load()
TEXTS = Texts("fr")
INSIDE, OFF_SCREEN = "tp1.fill_rect.inside", "tp1.fill_rect.off_screen"


def judged(*findings: Finding) -> dict[str, tuple[str, int]]:
    """Return outcome and points of each check."""
    checks, _ = grade(findings, RULES, TEXTS)
    return {each.id: (each.outcome.value, each.points) for each in checks}


def finding(check: str, outcome: Outcome, *todo: str) -> Finding:
    """Return what a check found."""
    return Finding(check, "title", outcome, todo=frozenset(todo))


def test_a_negative_check_needs_its_twin() -> None:
    """Refusing everything is worth nothing; refusing and drawing is worth both."""
    passed = finding(OFF_SCREEN, Outcome.PASSED)
    assert judged(finding(INSIDE, Outcome.PASSED), passed)[OFF_SCREEN] == ("passed", 40)
    assert judged(finding(INSIDE, Outcome.CRASHED), passed)[OFF_SCREEN] == ("blocked", 0)
    own = finding(INSIDE, Outcome.FAILED, "TP1.4")
    assert judged(own, passed)[OFF_SCREEN] == ("todo", 0)


SHADOW, ACNE, SHADOWS = "tp4.in_shadow.blocked", "tp4.in_shadow.own_surface", "tp4.scene.shadows_0"


def test_a_picture_counts_with_a_function() -> None:
    """One that is right where none of its exercise's functions is was not drawn by them."""
    picture, part = finding(SHADOWS, Outcome.PASSED), finding(SHADOWS, Outcome.FAILED)
    part = replace(part, evidence=Evidence(share=0.5))
    right, wrong = finding(SHADOW, Outcome.PASSED), finding(SHADOW, Outcome.FAILED)
    points = RULES.checks()[SHADOWS].points
    assert judged(picture)[SHADOWS] == ("passed", points)  # no other was asked for
    assert judged(right, finding(ACNE, Outcome.CRASHED), picture)[SHADOWS] == ("passed", points)
    assert judged(right, part)[SHADOWS] == ("failed", round(points / 2))
    assert judged(wrong, finding(ACNE, Outcome.CRASHED), picture)[SHADOWS] == ("blocked", 0)
    assert judged(wrong, part)[SHADOWS] == ("failed", 0)
    todo = [finding(each, Outcome.FAILED, "TP4.1") for each in (SHADOW, ACNE)]
    assert judged(*todo, picture)[SHADOWS] == ("todo", 0)


@pytest.mark.parametrize(
    ("outcome", "todo", "expected"),
    [
        (Outcome.FAILED, ["TP1.4"], "todo"),
        (Outcome.CRASHED, ["TP1.4", "TP1.2"], "todo"),
        (Outcome.FAILED, ["TP1.2"], "failed"),
        (Outcome.FAILED, [], "failed"),
        (Outcome.PASSED, ["TP1.4"], "passed"),
        (Outcome.ERROR, ["TP1.4"], "error"),
    ],
)
def test_markers_decide_between_to_do_and_wrong(
    outcome: Outcome, todo: list[str], expected: str
) -> None:
    """Own marker: to do; one that right code never meets there, right answers: nothing changes."""
    assert judged(finding(INSIDE, outcome, *todo))[INSIDE][0] == expected


PLANE, NEAREST = "tp2.intersect_plane.meets", "tp2.intersect_scene.nearest"


def test_what_may_be_anothers_fault_waits_for_it() -> None:
    """A scene with a wrong plane is not judged; by itself, or with the right plane, it is wrong."""
    nearest = finding(NEAREST, Outcome.FAILED)
    right, wrong = finding(PLANE, Outcome.PASSED), finding(PLANE, Outcome.CRASHED)
    assert judged(nearest)[NEAREST] == ("failed", 0)
    assert judged(nearest, right)[NEAREST] == ("failed", 0)
    assert judged(nearest, wrong)[NEAREST] == ("blocked", 0)
    assert judged(replace(nearest, alone=True), wrong)[NEAREST] == ("failed", 0)
    (_, told), _ = grade([wrong, nearest], RULES, TEXTS)
    assert told.waits_for == ("TP2.3",)
    assert told.note.startswith("À revoir après TP2.3 : l'erreur peut venir de là.")
    assert told.hint == ""  # nobody is asked about what may be right


RAYTRACE, FLAT = "tp2.raytrace.colors", "tp2.scene.flat_0"
TRACED, FLAT_1 = "tp2.trace_ray.object", "tp2.scene.flat_1"
LIGHT, MIRROR = "tp3.direct_light.one", "tp4.mirror_color.sky"


@pytest.mark.parametrize(
    ("check", "later"),
    [
        (RAYTRACE, ["TP2.6", "TP4.B1"]),
        (LIGHT, ["TP4.1"]),
        (MIRROR, ["TP5.2"]),
        (TRACED, ["TP3.2", "TP4.1", "TP4.3", "TP5.2"]),
        ("tp3.scene.checker_6", ["TP3.B2", "TP2.B1"]),
    ],
)
def test_what_comes_later_hides_no_mistake(check: str, later: list[str]) -> None:
    """Stubs of later exercises and of bonuses were met: the mistake is shown all the same."""
    assert judged(finding(check, Outcome.FAILED, *later))[check][0] == "failed"


def test_a_bonus_waits_for_the_bonus_that_its_picture_holds() -> None:
    """Scene 5 has cylinders beside its cones: without them the picture says nothing of the cone."""
    stub = finding("tp2.intersect_cylinder.meets", Outcome.FAILED, "TP2.B1")
    cones = finding("tp2.scene.flat_5", Outcome.FAILED, "TP2.B1")
    assert judged(stub, cones)["tp2.scene.flat_5"][0] == "blocked"


@pytest.mark.parametrize("outcome", [Outcome.CRASHED, Outcome.TIMEOUT])
def test_what_crashes_or_loops_never_waits_for_a_stub(outcome: Outcome) -> None:
    """intersect_scene is a stub; trace_ray crashes all the same by itself."""
    stub = finding(NEAREST, Outcome.FAILED, "TP2.5")
    assert judged(stub, finding(TRACED, outcome, "TP2.5"))[TRACED][0] == outcome.value


def test_a_crash_inside_a_wrong_function_is_that_ones() -> None:
    """intersect_plane crashes, called by itself and by intersect_scene: one exercise is red."""
    inside = Message(
        "death.SIGSEGV", {"call": "f()", "calls": [("intersect_plane", "raytracer.c:9")]}
    )
    own = replace(finding(PLANE, Outcome.CRASHED), message=inside)
    through = replace(finding(NEAREST, Outcome.CRASHED), message=inside)
    assert judged(own, through)[NEAREST][0] == "blocked"
    elsewhere = Message(
        "death.SIGSEGV", {"call": "f()", "calls": [("intersect_scene", "raytracer.c:19")]}
    )
    assert judged(own, replace(through, message=elsewhere))[NEAREST][0] == "crashed"


def test_a_function_that_crashes_by_itself_is_looked_at_first_wherever_it_is_called() -> None:
    """octree_free, which every change of scene calls: trace_ray, which comes before it, waits."""
    values: dict[str, object] = {
        "call": "f()",
        "calls": [("octree_free", "octree.c:9"), ("scene_changed", "")],
    }
    inside = Message("death.SIGSEGV", values)
    traced = replace(finding(TRACED, Outcome.CRASHED), message=inside)
    tree = replace(finding("tp4.octree.again", Outcome.CRASHED), message=inside)
    checks, _ = grade([traced, tree], RULES, TEXTS)
    assert [each.outcome.value for each in checks] == ["blocked", "crashed"]
    assert checks[0].waits_for == ("TP4.B1",)
    assert judged(traced)[TRACED][0] == "crashed"  # no check of the octree was asked for


def test_calls_without_end_are_those_of_the_function_that_is_wrong() -> None:
    """A mirror that traces the ray that arrives: trace_ray, which it calls, waits for it."""
    calls = [("direct_light", ""), ("trace_ray", ""), ("mirror_color", ""), ("trace_ray", "")]
    values: dict[str, object] = {"call": "f()", "calls": calls, "again": "trace_ray"}
    endless = Message("death.recursion", values)
    lit = replace(finding("tp2.trace_ray.lit", Outcome.CRASHED), message=endless)
    mirror = finding("tp4.mirror_color.object", Outcome.FAILED)
    checks, _ = grade([lit, mirror], RULES, TEXTS)
    assert [each.waits_for for each in checks] == [("TP4.3",), ()]
    assert judged(lit)["tp2.trace_ray.lit"][0] == "crashed"
    elsewhere = replace(lit, message=Message("death.SIGSEGV", values))
    assert judged(elsewhere, mirror)["tp2.trace_ray.lit"][0] == "crashed"
    # Whichever of them comes first, the mirror's own check does not wait for trace_ray.
    endless = Message("death.recursion", {**values, "calls": calls[1:]})
    ends = replace(finding("tp4.mirror_color.depth", Outcome.CRASHED), message=endless)
    checks, _ = grade([replace(lit, message=endless), ends], RULES, TEXTS)
    assert [each.waits_for for each in checks] == [("TP4.3",), ()]


def test_what_comes_after_a_barred_light_waits_for_in_shadow() -> None:
    """A wrong in_shadow makes neither direct_light nor trace_ray red; as a stub it excuses none."""
    barred, lit = "tp3.direct_light.barred", "tp2.trace_ray.lit"
    for check in (barred, lit):
        wrong = [finding(check, Outcome.FAILED), finding(SHADOW, Outcome.FAILED)]
        checks, _ = grade(wrong, RULES, TEXTS)
        assert [each.waits_for for each in checks] == [("TP4.1",), ()]
        stub = [finding(check, Outcome.FAILED, "TP4.1"), finding(SHADOW, Outcome.FAILED, "TP4.1")]
        assert judged(*stub)[check][0] == "failed"


def test_in_a_circle_the_first_on_the_way_of_a_ray_is_shown() -> None:
    """Raytrace and trace_ray need each other's pictures: the one with a wrong check of its own."""
    pictures = [finding(FLAT, Outcome.FAILED), finding(FLAT_1, Outcome.FAILED)]
    found = judged(finding(RAYTRACE, Outcome.FAILED), *pictures)
    assert [found[each][0] for each in (RAYTRACE, FLAT, FLAT_1)] == ["failed", "failed", "blocked"]
    found = judged(finding(TRACED, Outcome.FAILED), *pictures)
    assert [found[each][0] for each in (TRACED, FLAT, FLAT_1)] == ["failed", "blocked", "failed"]
    # When no function tells, the first exercise of the course.
    found = judged(*pictures)
    assert [found[each][0] for each in (FLAT, FLAT_1)] == ["failed", "blocked"]


def test_only_root_causes_are_named() -> None:
    """The plane is wrong, so the scene waits, and trace_ray waits for the plane: not the scene."""
    wrong = [finding(each, Outcome.FAILED) for each in (PLANE, NEAREST, TRACED)]
    checks, _ = grade(wrong, RULES, TEXTS)
    assert [each.waits_for for each in checks] == [(), ("TP2.3",), ("TP2.3",)]


def test_what_is_not_written_waits_for_nothing() -> None:
    """Another's marker first, and its own in another check: it is to do."""
    own = finding("tp2.intersect_scene.meets", Outcome.FAILED, "TP2.5")
    assert judged(own, finding(NEAREST, Outcome.FAILED, "TP2.3"))[NEAREST] == ("todo", 0)


def test_points_earned_among_the_references_functions_are_told() -> None:
    """All the points, and whose mistake it was."""
    passed = replace(finding(NEAREST, Outcome.PASSED), through=("TP2.3", "TP2.4"))
    ((told,), _) = grade([passed], RULES, TEXTS)
    assert told.points == told.max_points
    assert told.note == "Points acquis : votre fonction est juste, l'erreur vient de TP2.3, TP2.4."


def test_an_exercise_is_as_good_as_its_worst_check() -> None:
    """Its points are the sum, its outcome the worst; exercises without findings are not there."""
    findings = [finding(INSIDE, Outcome.PASSED), finding("tp1.fill_rect.clipped", Outcome.TIMEOUT)]
    _, (exercise,) = grade(findings, RULES, TEXTS)
    assert (exercise.id, exercise.outcome, exercise.points) == ("TP1.4", Outcome.TIMEOUT, 120)


def test_a_message_is_filled_with_its_values() -> None:
    """The place of a crash is part of the sentence when it is known, and only then."""
    message = Message("death.SIGSEGV", {"call": "f(img)"})
    where = Finding(INSIDE, "title", Outcome.CRASHED, message, location="main.c:7")
    nowhere = Finding(INSIDE, "title", Outcome.CRASHED, message)
    messages = [grade([each], RULES, TEXTS)[0][0].message for each in (where, nowhere)]
    said = "f(img) lit ou écrit hors de la mémoire permise"
    assert messages == [f"{said}, dans main.c:7.", f"{said}."]


def test_points_of_the_manifest_make_a_hundred_and_twenty() -> None:
    """The points of each TP, and of the bonuses, are those of the course."""
    points = dict.fromkeys(RULES.tps, 0)
    for each in RULES.exercises:
        points[each.tp] += 0 if each.bonus else each.points
    assert points == {1: 1500, 2: 3000, 3: 2000, 4: 2000, 5: 1500}
    assert sum(each.points for each in RULES.exercises if each.bonus) == 2000


def test_shares_are_whole_and_complete() -> None:
    """No hundredth is lost in the split, whatever the weights."""
    assert shares(100, [1, 1, 1]) == [34, 33, 33]
    assert shares(0, [2, 1]) == [0, 0]
    for weights in ([1, 2, 4], [7], [3, 3, 1, 9]):
        assert sum(shares(1234, weights)) == 1234


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("not toml", "put the original file back"),
        ("[files]\n", "missing or malformed key: 'exercise'"),
    ],
)
def test_a_broken_manifest_is_named(tmp_path: Path, text: str, words: str) -> None:
    """One line with the file and the cure."""
    path = tmp_path / "exercises.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ManifestError, match=rf"exercises\.toml.*{words}"):
        load(path)


def test_a_check_needs_exercises_that_there_are(tmp_path: Path) -> None:
    """What it judges besides is among what it needs, and what proves a function is a check."""
    text = exercises.MANIFEST.read_text(encoding="utf-8")
    path = tmp_path / "exercises.toml"
    wrong = {
        'needs = ["TP2.5"]': 'needs = ["TP9.9"]',
        '["TP3.2"] }': '["TP9.9"] }',
        'shade = "tp5.fresnel_use.lobe"': 'shade = "TP9.9"',
    }
    for old, new in wrong.items():
        assert old in text
        path.write_text(text.replace(old, new), encoding="utf-8")
        load.cache_clear()
        with pytest.raises(ManifestError, match=r"TP9\.9"):
            load(path)


def test_a_manifest_with_an_unknown_twin_is_refused(tmp_path: Path) -> None:
    """Names in the manifest hold together."""
    text = exercises.MANIFEST.read_text(encoding="utf-8")
    path = tmp_path / "exercises.toml"
    path.write_text(text.replace(f'twin = "{INSIDE}"', 'twin = "tp1.nothing"'), encoding="utf-8")
    with pytest.raises(ManifestError, match=r"tp1\.nothing"):
        load(path)


@pytest.mark.parametrize("name", ["TP1.8", "TP9.1", "TP1.B8", "TP1.06"])
def test_an_id_that_has_no_marker_is_refused(tmp_path: Path, name: str) -> None:
    """MRT_TODO knows seven exercises and seven bonuses in each of eight TPs."""
    text = exercises.MANIFEST.read_text(encoding="utf-8")
    path = tmp_path / "exercises.toml"
    path.write_text(text.replace('id = "TP1.6"', f'id = "{name}"'), encoding="utf-8")
    with pytest.raises(ManifestError, match=re.escape(name)):
        load(path)


def checks_in_the_tests() -> dict[str, str]:
    """Return the first line of each check's docstring, by the id of its marker."""
    found: dict[str, str] = {}
    for path in (exercises.PACKAGE / "checks").glob("test_tp*.py"):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                (marker,) = node.decorator_list
                assert isinstance(marker, ast.Call)
                identity = ast.literal_eval(marker.args[0])
                assert identity not in found
                found[identity] = inspect.cleandoc(ast.get_docstring(node) or "").split("\n")[0]
                assert f"test_{identity.split('.', 1)[1].replace('.', '_')}" == node.name
    return found


def test_manifest_tests_and_sentences_name_the_same_checks() -> None:
    """Every check has a line or one test, a title, a question and two hints in both languages.

    The English title of a test is its docstring.
    """
    tests, known = checks_in_the_tests(), set(RULES.checks())
    lines = {name for name, each in RULES.checks().items() if each.line}
    assert set(tests) == known - lines
    assert all(tests.values())
    assert titles("en") == lines
    french = sentences("fr")
    assert titles("fr") == known
    assert {key[9:] for key in french if key.startswith("question.")} == known
    hints = {key[5:] for key in french if key.startswith("hint.")}
    assert hints == {f"{each}.{level}" for each in known for level in (2, 3)}


def titles(language: str) -> set[str]:
    """Return the checks that have a title in a language's messages."""
    return {key[6:] for key in sentences(language) if key.startswith("title.")}


def placeholders(text: str) -> set[str]:
    """Return the names between braces."""
    return {name for _, name, _, _ in string.Formatter().parse(text) if name}


def test_both_languages_say_the_same_things() -> None:
    """Same keys (but the titles that are docstrings in English), same values in each."""
    english = sentences("en")
    docstrings = {f"title.{name}" for name in titles("fr") - titles("en")}
    french = {key: text for key, text in sentences("fr").items() if key not in docstrings}
    assert set(french) == set(english)
    for key, text in french.items():
        assert placeholders(text) == placeholders(english[key]), key


FILES = (
    ".c",
    ".css",
    ".h",
    ".html",
    ".js",
    ".json",
    ".png",
    ".py",
    ".sh",
    ".so",
    ".toml",
    ".txt",
    ".zip",
)


def test_every_sentence_is_asked_for_somewhere() -> None:
    """No sentence without use, no use without sentence, as far as literal keys go."""
    paths = [*exercises.PACKAGE.rglob("*.py"), *exercises.PACKAGE.rglob("*.html")]
    own = [path for path in paths if "tests" not in path.relative_to(exercises.PACKAGE).parts]
    code = "".join(path.read_text(encoding="utf-8") for path in own)
    known = {key.split(".")[0] for key in sentences("en")}
    sections = "|".join(name for name in known if name.isalpha())  # tp1.name may be a prediction's
    asked = set(re.findall(rf'["\']((?:{sections})\.[a-zA-Z_]+)["\']', code))
    scripts = "".join(path.read_text() for path in (exercises.PACKAGE / "setup").glob("*.sh"))
    asked |= set(re.findall(r"\b(?:say|fail|sentence) (setup\.[a-z_]+)", scripts))
    # Keys that are completed when running end in a mark; a file's name is no key.
    asked = {key for key in asked if not key.endswith((".", "_", *FILES))}
    assert asked <= set(sentences("en"))
    words = re.findall(r'"([a-z]+)"', code)
    asked |= {f"refused.{word}" for word in words} & set(sentences("en"))
    # These are completed when running, or have a part of their key before them (grader/lab).
    sections = r"death|outcome|title|question|hint|isolation|canary|mistake|history|lab|plot|tp\d"
    sections += "|ask|exercise|language|new|thing|part|places?|feature|heading|why|class|replay"
    sections += "|help|drawn"
    built = re.compile(
        rf"({sections})\.|failure\.(missed|touched|wrong)_pixel|(page|oral)\.(alt|role)_"
        r"|picture\.(channels|shifted|all|lit|missing|recolored)_|submission\.nothing_in_|note\.worked_"
    )
    unused = {key for key in sentences("en") if key not in asked and not built.match(key)}
    assert unused == set()


def test_the_language_is_asked_for_or_preferred(monkeypatch: pytest.MonkeyPatch) -> None:
    """--lang, then MRT_LANG, then French."""
    monkeypatch.delenv("MRT_LANG", raising=False)
    assert preferred() == "fr"
    monkeypatch.setenv("MRT_LANG", "en_GB.UTF-8")
    assert preferred() == "en"
    assert preferred("fr") == "fr"
    monkeypatch.setenv("MRT_LANG", "de")
    assert preferred() == "fr"
    assert [Texts(each).number(1.5) for each in LANGUAGES] == ["1,5", "1.5"]

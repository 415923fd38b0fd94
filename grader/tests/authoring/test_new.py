"""make new: the files of an exercise, a check and a mistake, tried for real in a copy."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from grader.authoring.new import check, exercise, mistake, scene
from grader.authoring.new.edits import MARK, NewError
from grader.authoring.specimens import mistakes
from grader.course import exercises

ROOT = exercises.ROOT
RULES = exercises.load()
DATA = ("reference/expected/", "grader/intake/originals.zip", "core_c/raytracer.c")  # by command
LEFT = shutil.ignore_patterns("tests", "__pycache__", "independent", "hostile", "*.ipynb")


class Project:
    """A copy of the project, and what has changed in it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in ("core_c", "grader", "reference", "notebooks"):
            shutil.copytree(ROOT / name, folder / name, ignore=LEFT)
        self.before = self.contents()

    def contents(self) -> dict[str, bytes]:
        """Return every file, but for builds."""
        files = (path for path in self.folder.rglob("*") if path.is_file())
        found = {str(path.relative_to(self.folder)): path.read_bytes() for path in files}
        return {name: each for name, each in found.items() if "__pycache__" not in name}

    def run(self, *words: str) -> str:
        """Run a module of the copy; return what it printed."""
        command = [sys.executable, "-B", "-m", *words]
        done = subprocess.run(
            command, cwd=self.folder, capture_output=True, text=True, timeout=300, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def changed(self) -> tuple[set[str], set[str]]:
        """Return the files that differ: those written by hand, and those that commands make."""
        now = self.contents()
        names = {name for name, each in now.items() if self.before.get(name) != each}
        names = {name for name in names if not name.startswith("build/")}
        made = {name for name in names if name.startswith(DATA)}
        return names - made, made

    def write(self, path: str, *pairs: tuple[str, str]) -> None:
        """Write what stubs ask for: patterns, and what comes in their place."""
        text = (self.folder / path).read_text(encoding="utf-8")
        for pattern, written in pairs:
            text, count = re.subn(pattern, written, text)
            assert count, (path, pattern)
        assert MARK not in text, path
        (self.folder / path).write_text(text, encoding="utf-8")

    def outcomes(self, folder: str, keyword: str) -> dict[str, str]:
        """Grade a folder of the copy; return the outcomes of its checks."""
        self.run("grader", "grade", folder, "-k", keyword, "--build", "build")
        path = self.folder / "build" / "grade" / "partial" / "results.json"
        content = json.loads(path.read_text(encoding="utf-8"))
        return {each["id"]: each["outcome"] for each in content["checks"]}


@pytest.fixture
def project(tmp_path: Path) -> Project:
    """Return a copy that a test may change."""
    return Project(tmp_path / "cours")


NOTE = rf" # {MARK}.*"
WRONG = "reference/mistakes/TP3.B3.toml"


def write_fog(project: Project) -> None:
    """Write the exercise whose stubs `make new EXERCISE=TP3.B3 FUNCTION=fog_color` makes."""
    title, argument = "The share of fog on a way.", "the length of the way, from 0 on"
    contract = [(rf"{MARK} what fog.*", title), ("x  what it is", f"x  {argument}")]
    contract.append(("Returns what", "Returns 1 - exp(-x)"))
    french = (rf"{MARK} le contrat.*'''", "La part de brume.'''")
    project.write("core_c/exercises.h", *contract)
    project.write(
        "reference/raytracer.c", (rf"return x \* x; /\* {MARK}.*", "return 1.f - expf(-x);")
    )
    project.write("grader/course/exercises.toml", (NOTE, ""))
    for language in ("fr", "en"):
        messages = f"grader/course/messages/{language}/fog_color.toml"
        translated = (*contract, french) if language == "fr" else ()
        project.write(messages, *translated, (NOTE, ""), ('""', '"?"'))
        project.write(f"notebooks/{language}/TP3.md", (rf"<!-- {MARK}.* -->|{MARK}[^|]*", "... "))
    rows = "".join(f'\n"{each}" = "says"' for each in (title, f"x {argument}"))
    project.write(WRONG, (NOTE, f'{rows}\n"Returns 1 - exp(-x)." = ["fog"]'))


@pytest.mark.long
def test_an_exercise_takes_eight_files_and_its_mistake_none(project: Project) -> None:
    """Written where the stubs say, it is judged; of the data only its own and the index change."""
    told = project.run("grader.authoring.new", "--exercise", "TP3.B3", "--function", "fog_color")
    by_hand, _ = project.changed()
    assert len(by_hand) == 8
    assert all(name in told for name in by_hand)
    write_fog(project)
    for part in ("skeleton", "originals"):
        project.run(f"grader.authoring.skeleton.{part}")
    project.run("grader.authoring.expected.command", "--suite", "fog_color.any")
    data = {"reference/expected/fog_color.any.npz", "reference/expected/manifest.json"}
    data |= {"core_c/raytracer.c", "grader/intake/originals.zip"}
    assert project.changed() == (by_hand, data)
    assert project.outcomes("reference", "fog_color") == {"tp3.fog_color.any": "passed"}
    assert project.outcomes("core_c", "fog_color") == {"tp3.fog_color.any": "todo"}
    words = ("--mistake", "fog", "--exercise", "TP3.B3", "--worth", "whole")
    project.run("grader.authoring.new", *words)
    project.write(WRONG, (NOTE, ""), ("after = .*", 'after = "return x;"'))
    for language in ("fr", "en"):
        path = f"grader/course/messages/{language}/fog_color.toml"
        project.write(path, (NOTE, ""), ('""', '"?"'))
    project.run("grader.authoring.expected.command", "--mistake", "fog")
    # Which checks see it is not written anywhere: that is what the bank has.
    assert project.changed()[0] == by_hand
    # It shows in no picture; the index of these has it all the same.
    data |= {f"reference/expected/{each}" for each in ("mistakes.npz", "pictures/manifest.json")}
    assert project.changed()[1] == data
    project.run("grader.authoring.expected.mistake_bank", "--check")


@pytest.mark.exhaustive
def test_a_check_takes_three_files(project: Project) -> None:
    """Of a suite that is there; of the data, the bank's mistakes of its exercise change."""
    name, suite = "tp5.reflectance.again", "reflectance.any"
    told = project.run("grader.authoring.new", "--check", name, "--suite", suite)
    by_hand, _ = project.changed()
    messages = {f"grader/course/messages/{language}/checks.toml" for language in ("fr", "en")}
    assert by_hand == {"grader/course/exercises.toml", *messages}
    assert [told.index(each) for each in by_hand]
    for path in by_hand:
        project.write(path, (NOTE, ""))
    project.run("grader.authoring.expected.command", "--suite", suite)
    data = {f"reference/expected/{each}" for each in ("mistakes.npz", "manifest.json")}
    assert project.changed() == (by_hand, data)
    assert project.outcomes("reference", name) == {name: "passed"}


@pytest.mark.long
def test_a_check_of_a_new_suite_takes_no_file_more(project: Project) -> None:
    """Its inputs are lines of the manifest; of the data only that suite and the index."""
    name, suite = "tp3.texture_color.bare", "texture_color.bare"
    project.run("grader.authoring.new", "--check", name, "--suite", suite)
    by_hand, _ = project.changed()
    assert len(by_hand) == 3
    manifest, said = "grader/course/exercises.toml", r"drawn = 20\ninputs.mat.pattern = 2"
    vector = ("inputs.p = .*", "inputs.p = { low = -1, high = 1, unit = true }")
    project.write(manifest, (r"inputs\.mat .*\n", ""), (NOTE, ""), vector, ("drawn = 20", said))
    for path in by_hand - {manifest}:
        project.write(path, (NOTE, ""))
    project.run("grader.authoring.expected.command", "--suite", suite)
    data = {f"reference/expected/{each}" for each in (f"{suite}.npz", "manifest.json")}
    assert project.changed() == (by_hand, data)  # no mistake shows there
    assert project.outcomes("reference", name) == {name: "passed"}


SCENE = {"core_c/scene.c", "core_c/utils.h", "grader/course/scenes.toml"}


def new_scene(project: Project) -> None:
    """Write a scene where the stubs of `make new SCENE=11` say, of which one picture is judged."""
    project.run("grader.authoring.new", "--scene", "11")
    project.write("core_c/scene.c", (rf" /\* {MARK}.*", ""))
    project.write("core_c/utils.h", (f"{MARK} what it is", "?"))
    project.write("grader/course/scenes.toml", (NOTE, ""), (r'\["short"\]', '["flat"]'))
    project.run("grader.authoring.skeleton.originals")


def test_a_scene_takes_three_files(project: Project) -> None:
    """Its C, its line of the table, and the program's help; it compiles, and is told in order."""
    new_scene(project)
    assert project.changed() == (SCENE, {"grader/intake/originals.zip"})
    help_text = (project.folder / "core_c/utils.h").read_text(encoding="utf-8")
    assert "5 à 16   lancer de rayons, scènes 0 à 11 :" in help_text
    assert help_text.count(' 15 poster,\\n"\n') == help_text.count(' 16 ?\\n"\n') / 2 == 1
    command = ["gcc", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", "core_c/scene.c"]
    subprocess.run(command, cwd=project.folder, check=True)


@pytest.mark.exhaustive
def test_a_picture_of_a_new_scene_is_judged(project: Project) -> None:
    """By a check of three files; of the data only the scene's own files and the index are new."""
    new_scene(project)
    name, picture = "tp2.scene.flat_11", "scene11.flat"
    words = ("--check", name, "--picture", picture, "--exercise", "TP2.6")
    project.run("grader.authoring.new", *words)
    messages = {f"grader/course/messages/{language}/checks.toml" for language in ("fr", "en")}
    for path in ("grader/course/exercises.toml", *messages):
        project.write(path, (NOTE, ""))
    project.run("grader.authoring.expected.command", "--picture", "scene11")
    by_hand, data = project.changed()
    assert by_hand == SCENE | {"grader/course/exercises.toml", *messages}
    drawn = "reference/expected/pictures/"
    new = {f"scene11.{each}.npz" for each in ("flat", "flat.mistakes", "maps", "light")}
    new |= {"manifest.json", "scene11.flat.png"}
    assert data == {"grader/intake/originals.zip", *(f"{drawn}{each}" for each in new)}
    assert project.outcomes("reference", name) == {name: "passed"}
    assert project.outcomes("core_c", name) == {name: "todo"}


@pytest.mark.exhaustive
def test_a_hint_takes_its_message_file_and_grades_nobody_again(project: Project) -> None:
    """The page of who was graded before has it."""
    work = project.folder / "class" / "Ada"
    shutil.copytree(project.folder / "core_c", work)
    main = (work / "main.c").read_text(encoding="utf-8")
    begin = "void fill_red(color *img) {\n"
    wrong = "    fill(img, vector_init(0.f, 0.f, 1.f));\n    return;\n"
    assert begin in main
    (work / "main.c").write_text(main.replace(begin, begin + wrong), encoding="utf-8")
    words = ("grader", "batch", "class", "--out", "out", "--public", "--lang", "en", "--yes")
    project.run(*words)
    (state,) = (project.folder / "out" / "state").iterdir()
    project.before, graded = project.contents(), json.loads(state.read_bytes())
    path, asked = "grader/course/messages/en/checks.toml", '"tp1.fill_red.color" = '
    project.write(path, (rf'{asked}".*\?"', f'{asked}"Which blue?"'))
    assert project.changed() == ({path}, set())
    project.run(*words)
    page = (project.folder / "out" / "students" / "Ada" / "report.html").read_text("utf-8")
    assert "Which blue?" in page
    assert json.loads(state.read_bytes())["seconds"] == graded["seconds"]


def test_a_mistake_stands_behind_those_of_its_exercise() -> None:
    """In the list and in the sentences; it begins as a line of the exercise's solution."""
    listed, *said = mistake.edits("plane_odd", "TP2.3", "idea", RULES, mistakes.load())
    assert listed.path == "reference/mistakes/TP2.3.toml"
    assert listed.notes() == ["what stands there once", "the mistake in its place"]
    (line,) = re.findall(r"^before = \"(.*)\" # TO WRITE", listed.text, re.M)
    assert line in mistakes.solutions()["TP2.3"]
    last = [each.id for each in mistakes.load() if each.exercise == "TP2.3"][-1]
    for each in (listed, *said):
        ids = re.findall(r"^\[mistake\.(\w+)\]", each.text, re.M)
        assert ids[ids.index(last) + 1] == "plane_odd"


@pytest.mark.parametrize(
    ("name", "suite", "told"),
    [
        ("tp2.intersect_plane.range", "intersect_plane.range", "there is one already, in"),
        ("tp2.hit_plane.range2", "intersect_plane.range", "the nearest is intersect_plane"),
        ("intersect_plane.range", "intersect_plane.range", "an id is like tp2."),
        ("tp2.intersect_plane.odd", "plane.range", "begins with intersect_plane."),
        ("tp2.intersect_plane.odd", "", "begins with intersect_plane."),
    ],
)
def test_a_check_that_cannot_be_is_refused(name: str, suite: str, told: str) -> None:
    """In one line that says what is wrong."""
    with pytest.raises(NewError, match=told) as error:
        check.edits(name, suite, RULES)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("name", "picture", "own", "told"),
    [
        (
            "tp4.scene.shadows_9",
            "scene9.shadows",
            "TP4.1",
            "PICTURE=scene9.shadows: the nearest",
        ),
        ("tp4.scene.shadows_9", "scene0.shadows", "TP4.11", "the nearest is TP4.1"),
        ("tp4.scene.shadows_9", "scene0.shadows", "TP2.1", "the nearest is TP4.1"),
        ("tp4.scene.shadows_0", "scene0.shadows", "TP4.1", "there is one already, in"),
        ("tp4.in_shadow.odd", "scene0.shadows", "TP4.1", "the nearest is none: the check's id is"),
    ],
)
def test_a_check_of_a_picture_that_cannot_be_is_refused(
    name: str, picture: str, own: str, told: str
) -> None:
    """In one line that says what is wrong."""
    with pytest.raises(NewError, match=told):
        check.picture_edits(name, picture, own, RULES)


@pytest.mark.parametrize("number", ["10", "12", "x", "011"])
def test_a_scene_that_is_not_the_next_is_refused(number: str) -> None:
    """With the number that is."""
    with pytest.raises(NewError, match=f"^SCENE={number}: the next one is 11"):
        scene.edits(number)


@pytest.mark.parametrize(
    ("name", "function", "told"),
    [
        ("TP3.B1", "fog_color", "EXERCISE=TP3.B1: there is one already"),
        ("TP3.9", "fog_color", "EXERCISE=TP3.9: an id is like"),
        ("TP3.B3", "", "FUNCTION=: name the function"),
        ("TP3.B3", "shade", r"FUNCTION=shade: core_c/exercises\.h has one already"),
        ("TP3.B3", "vector_dot", r"FUNCTION=vector_dot: core_c/vector\.h has one already"),
    ],
)
def test_an_exercise_that_cannot_be_is_refused(name: str, function: str, told: str) -> None:
    """In one line that says what is wrong."""
    with pytest.raises(NewError, match=told):
        exercise.edits(name, function, RULES)


@pytest.mark.parametrize(
    ("name", "own", "worth", "told"),
    [
        ("sphere_far_root", "TP2.4", "idea", "there is one already"),
        ("odd one", "TP2.4", "idea", "an id is like"),
        ("odd", "", "idea", "EXERCISE=: name the one of the mistake"),
        ("odd", "TP2.44", "idea", "the nearest is TP2.4"),
        ("odd", "TP2.4", "much", "WORTH=much: one of edge, idea, whole"),
    ],
)
def test_a_mistake_that_cannot_be_is_refused(name: str, own: str, worth: str, told: str) -> None:
    """In one line that says what is wrong."""
    with pytest.raises(NewError, match=told):
        mistake.edits(name, own, worth, RULES, mistakes.load())


def test_nothing_is_left_to_write() -> None:
    """No stub stays in what students and graders read."""
    places = ("core_c", "reference", "notebooks", "grader/course", "grader/authoring/expected")
    kinds = (".c", ".h", ".toml", ".md", ".py", ".patch")
    paths = (path for place in places for path in (ROOT / place).rglob("*"))
    left = [path for path in paths if path.suffix in kinds and MARK in path.read_text("utf-8")]
    assert left == []

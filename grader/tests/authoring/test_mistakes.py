"""The known mistakes: patches that apply and compile, entries and texts that go together."""

from __future__ import annotations

import subprocess
from collections import Counter
from pathlib import Path

import pytest

from grader.authoring.expected import mistake_bank
from grader.authoring.specimens import mistakes, patches, shares, wrong
from grader.authoring.specimens.patches import PatchError, patched, reference
from grader.checking.expected_data import FOLDER
from grader.course import exercises
from grader.course.exercises import CORE, ManifestError
from grader.course.texts import LANGUAGES, sentences
from grader.evaluation import recognition

RULES = exercises.load()
KNOWN = mistakes.load()


def test_every_patch_has_an_entry_and_texts() -> None:
    """And the other way round, in both languages; a few words stand in the entry itself."""
    names = {each.id for each in KNOWN}
    patched_ones = {each.id for each in KNOWN if not each.edit}
    assert {path.stem for path in wrong.FOLDER.glob("*.patch")} == patched_ones
    for language in LANGUAGES:
        keys = {key for key in sentences(language) if key.startswith("mistake.")}
        parts = ("title", "question", "hint")
        assert keys == {f"mistake.{name}.{part}" for name in names for part in parts}


def test_every_function_has_its_mistakes() -> None:
    """Sixty at least; two for each function of the exercises that count, one for each bonus."""
    assert len(KNOWN) >= 60
    count = Counter(each.exercise for each in KNOWN)
    for exercise in RULES.exercises:
        if exercise.functions[0] not in ("draw", "fill_red"):
            assert count[exercise.id] >= (1 if exercise.bonus else 2), exercise.id
    schlick = sum(each.id.startswith("schlick_") for each in KNOWN)
    assert min(schlick, count["TP5.1"] - schlick) >= 2


def test_every_mistake_shows_in_its_exercise() -> None:
    """Each mistake shows in a check of its own, by the bank."""
    stored = recognition.read(FOLDER)
    assert set(stored) == {each.id for each in KNOWN}
    for each in KNOWN:
        assert each.shows, each.id
        assert set(stored[each.id].signature) == set(each.shows), each.id


def test_only_twins_are_alike() -> None:
    """No two mistakes of an exercise have the same answers, but those that say so."""
    stored = recognition.read(FOLDER)
    for each in KNOWN:
        if not (known := stored[each.id]).signature:
            continue  # it shows in pictures only
        alike = {
            name
            for name, other in stored.items()
            if name != each.id and recognition.same(known.signature, other.signature)
        }
        assert alike == set(each.twins), each.id
        assert len(alike) < recognition.MOST


def test_a_mistake_costs_what_it_is_worth() -> None:
    """Within the range that a teacher gives it; pictures, which it may spoil, are not counted."""
    stored = recognition.read(FOLDER)
    unfair = {}
    for each in KNOWN:
        share = shares.of_functions(RULES.exercise(each.exercise), stored[each.id].signature)
        if not each.worth[0] <= round(share, 2) <= each.worth[1]:
            unfair[each.id] = round(share, 2)
    assert unfair == {}


@pytest.mark.long
def test_every_mistake_compiles(tmp_path: Path) -> None:
    """The file that a patch changes is C, on top of today's reference."""
    base = reference()
    (tmp_path / "raytracer.h").write_text(base["raytracer.h"], encoding="utf-8")
    sources = []
    for each in KNOWN:
        (changed,) = (name for name, text in each.files().items() if text != base[name])
        sources.append(f"{each.id}-{changed}")
        (tmp_path / sources[-1]).write_text(each.files()[changed], encoding="utf-8")
    command = ["gcc", "-std=gnu11", "-fsyntax-only", "-Wall", "-Wextra", f"-I{CORE}", *sources]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


PATCH = """\
--- a/reference/main.c
+++ b/reference/main.c
@@ -1,3 +1,3 @@
     for (int k = 0; k < WIDTH * HEIGHT; k++) {
-        img[k] = c;
+        img[k] = vector_init(1.f, 1.f, 1.f);
     }
"""


def test_a_mistake_is_added_by_a_patch_and_an_entry(tmp_path: Path, cache: Path) -> None:
    """What the patch changes is found by its text, wherever it stands; the bank then knows it."""
    (tmp_path / "white.patch").write_text(PATCH, encoding="utf-8")
    (tmp_path / "worth.toml").write_text("[worth]\nall = [0.4, 1]\n", encoding="utf-8")
    (tmp_path / "TP1.2.toml").write_text('[mistake.white]\nworth = "all"\n', encoding="utf-8")
    (white,) = mistakes.load(tmp_path)
    assert (white.tp, white.exercise) == (1, "TP1.2")
    before, after = reference(), white.files()
    text = before["main.c"].replace("img[k] = c;", "img[k] = vector_init(1.f, 1.f, 1.f);")
    assert after == {**before, "main.c": text}
    known = mistake_bank.answers(white, FOLDER, cache)
    names = ("color", "every_pixel", "as_it_is")
    assert set(known.signature) == {f"tp1.fill_color.{name}" for name in names}
    others = recognition.read(FOLDER).values()
    assert not any(recognition.same(known.signature, each.signature) for each in others)


def test_a_malformed_list_is_named(tmp_path: Path) -> None:
    """One line with the file."""
    (tmp_path / "worth.toml").write_text("[worth]\nall = [0.4, 1]\n", encoding="utf-8")
    (tmp_path / "TP1.2.toml").write_text("[mistake.white]\n", encoding="utf-8")
    with pytest.raises(ManifestError, match=r"TP1\.2\.toml: missing or malformed key: 'worth'"):
        mistakes.load(tmp_path)
    (tmp_path / "TP1.22.toml").write_text("", encoding="utf-8")
    mistakes.load.cache_clear()
    with pytest.raises(ManifestError, match=r"TP1\.22\.toml: exercises\.toml has no such"):
        mistakes.load(tmp_path)


def test_a_mistake_of_a_few_words_needs_no_patch(tmp_path: Path) -> None:
    """They stand in the exercise's file; it goes onto other files as a patch does."""
    (tmp_path / "worth.toml").write_text("[worth]\nall = [0.4, 1]\n", encoding="utf-8")
    entry = '[mistake.white]\nworth = "all"\nfunction = "fill"\nbefore = "= c;"\nafter = "= d;"\n'
    (tmp_path / "TP1.2.toml").write_text(entry, encoding="utf-8")
    (white,) = mistakes.load(tmp_path)
    main = reference()["main.c"]
    assert white.files()["main.c"] == main.replace("img[k] = c;", "img[k] = d;")
    assert white.files({"main.c": f"{main}\n"}) == {"main.c": f"{white.files()['main.c']}\n"}
    with pytest.raises(PatchError, match=r"TP1\.2\.toml: white: what comes before stands 0 times"):
        white.files(white.files())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("nothing\n", r"not a unified diff of reference/: unknown line 'nothing'"),
        ("", r"changes no file of reference/"),
        (PATCH.replace("img[k] = c;", "img[k] = d;"), r"line 1 of main\.c has changed"),
        (PATCH.replace("main.c", "scene.c"), r"scene\.c is no file of students"),
    ],
)
def test_a_patch_that_does_not_fit_is_named(tmp_path: Path, text: str, words: str) -> None:
    """The file and the cure in one line."""
    path = tmp_path / "odd.patch"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(PatchError, match=rf"odd\.patch: {words}"):
        patched(path, reference())


def test_the_place_nearest_to_the_line_number_is_taken(tmp_path: Path) -> None:
    """Where the same text stands twice."""
    path = tmp_path / "second.patch"
    text = "+++ b/reference/main.c\n@@ -4 +4 @@\n-same\n+other\n"
    path.write_text(text, encoding="utf-8")
    assert patches.patched(path, {"main.c": "same\n\n\nsame\n"})["main.c"] == "same\n\n\nother\n"

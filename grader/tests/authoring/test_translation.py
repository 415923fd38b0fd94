"""The French comments of what students get: all of them, and nothing but comments."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from grader.authoring import release, translation
from grader.authoring.translation import FOLDER, TranslationError, in_language
from grader.course import exercises
from grader.course.texts import LANGUAGES, Texts
from grader.intake import authors, originals
from grader.intake.submission import read_submission
from grader.setup.release_record import ORIGINALS
from grader.tests.support.shell import ROOT

Files = dict[str, bytes]
WIDEST = 120  # columns, as in .clang-format
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wconversion", "-Wstrict-prototypes")
# Words that are no French and stand in no code: names, and terms of the field.
WORDS = {
    *("balls", "blinn-phong", "databases", "draw", "floats", "k-ième", "libpng", "lowbias", "make"),
    *(
        "mondessin",
        "not",
        "procedural",
        "rodrigues",
        "schlick",
        "sqrt",
        "stdout",
        "texel",
        "try",
        "wellons",
    ),
}


@pytest.fixture(scope="module")
def english() -> Files:
    """Collect what is released with the comments of the sources."""
    return release.collect(ROOT)


@pytest.fixture(scope="module")
def french() -> Files:
    """Collect what is released in French."""
    return release.collect(ROOT, "fr")


def read(files: Files) -> dict[str, str]:
    """Return the texts whose comments students read."""
    return {path: files[path].decode() for path in files if translation.is_read(path)}


def test_every_comment_has_its_french_one(english: Files, french: Files) -> None:
    """None is missing, none is left of a comment that is gone, and no catalogue serves nothing."""
    paths = {path.relative_to(FOLDER / "fr").as_posix() for path in FOLDER.rglob("*.toml")}
    assert paths == {f"{path}.toml" for path in read(english)} - {f"{translation.CONTRACTS}.toml"}
    for path, text in read(english).items():
        known = translation.catalogue(path, "fr")
        assert [*translation.comments(path, read(french)[path])] == [
            known[each] for each in translation.comments(path, text)
        ]


def test_the_code_is_the_same(english: Files, french: Files) -> None:
    """But for comments every byte is; the files of the grader are, whole."""
    own = {"grader/release.json", ORIGINALS}
    for path, content in english.items():
        if translation.is_read(path):
            texts = [files[path].decode() for files in (english, french)]
            one, other = (translation.without_comments(path, each) for each in texts)
            assert one == other, path
        elif path not in own:
            assert french[path] == content, path


def test_a_string_is_no_comment() -> None:
    """Nothing between quotes is replaced; rules end where they did, and margins stay."""
    text = 'a = "/* x */";\n  /* ---- Glue ------ */\n  /* x\n   *\n   * y */ c /* z\n */\n'
    assert [*translation.comments("a.c", text)] == ["Glue", "x\n\ny", "z"]
    assert translation.without_comments("a.c", 'a "/* x */" /* y */') == 'a "/* x */" '


@pytest.mark.parametrize(
    ("text", "key"), [("/* new */\n", "untranslated"), ("int x;\n", "stale_comment")]
)
def test_a_comment_without_its_pair_is_told(text: str, key: str) -> None:
    """One line names the file, the comment and the catalogue, and nothing is released."""
    with pytest.raises(TranslationError) as caught:
        in_language("core_c/raytracer.h", text, "fr")
    assert caught.value.key == f"release.{key}"
    for language in LANGUAGES:
        said = Texts(language).say(caught.value.key, **caught.value.values)
        assert "reference/comments/fr/core_c/raytracer.h.toml" in said
        assert "\n" not in said
    with pytest.raises(TranslationError) as caught:
        in_language(translation.CONTRACTS, text, "fr")
    assert str(caught.value.values["file"]) == "grader/course/messages/fr/contracts.toml"


# ---- What the French files are like -------------------------------------------------------------


@pytest.fixture
def core(french: Files, tmp_path: Path) -> Path:
    """Write the French core_c/."""
    for path, content in french.items():
        if path.startswith("core_c/"):
            (tmp_path / Path(path).name).write_bytes(content)
    return tmp_path


def run(*command: str, cwd: Path) -> str:
    """Return all that a program prints; skip the test, but not in CI, where there is none."""
    if shutil.which(command[0]) is None:
        assert not os.environ.get("MRT_CI"), f"CI must have {command[0]}"
        pytest.skip(f"{command[0]} is not installed")
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    return f"{done.stdout}{done.stderr}"


def test_it_is_laid_out_as_ours(core: Path) -> None:
    """clang-format would change nothing, and no line is too wide."""
    shutil.copy(ROOT / ".clang-format", core)
    names = sorted(path.name for path in core.glob("*.[ch]"))
    program = Path(sys.executable).with_name("clang-format")
    assert run(str(program), "--dry-run", "-Werror", *names, cwd=core) == ""
    for name in names:
        lines = (core / name).read_text(encoding="utf-8").splitlines()
        assert [line for line in lines if len(line) > WIDEST] == []


@pytest.mark.parametrize(
    "command",
    [
        ("gcc", "-std=c11", *STRICT, "-Werror", "-fsyntax-only"),
        ("clang", "-std=c11", *STRICT, "-Werror", "-fsyntax-only"),
        ("g++", "-x", "c++", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"),
    ],
)
def test_it_compiles_without_a_word(core: Path, command: tuple[str, ...]) -> None:
    """As C with both compilers, and with the handout's."""
    names = sorted(path.name for path in core.glob("*.c"))
    assert run(*command, *names, cwd=core) == ""


def test_spelling(french: Files) -> None:
    """Hunspell knows every word, or the code does."""
    program = shutil.which("hunspell")
    if program is None:
        assert not os.environ.get("MRT_CI"), "CI must have hunspell, with fr and en_US"
        pytest.skip("hunspell is not installed")
    texts = read(french)
    code = " ".join(translation.without_comments(path, text) for path, text in texts.items())
    known = {*re.findall(r"[A-Za-z]\w*", code)} | WORDS
    known |= {*(ROOT / "notebooks" / "words-fr.txt").read_text(encoding="utf-8").split()}
    words = " ".join(each for path in texts for each in translation.comments(path, texts[path]))
    words = re.sub(
        r"\S*[_/(\[>]\S*|\S*\w\.\w\S*|\w*[A-Z0-9]\w*[A-Z0-9]\w*|(?<=\s)-+\S*", " ", words
    )
    said = subprocess.run(
        [program, "-l", "-i", "utf-8", "-d", "fr"],
        input=words,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    ).stdout.split()
    unknown = {word.strip(".").removeprefix("l'") for word in said}
    assert sorted(each for each in unknown if not {each, each.lower()} & known) == []


def test_rayon_is_never_alone(french: Files) -> None:
    """In French "rayon" is a ray and a radius: each one says which it is."""
    which = r"lumineux|réfléchi|réfracté|d'une sphère|de la sphère|du disque|radius|1\b"
    alone = re.compile(rf".*(?<!lanceur de )\brayons?\b(?! (?:{which})).*")
    for path, text in read(french).items():
        assert [
            found for each in translation.comments(path, text) for found in alone.findall(each)
        ] == []


# ---- Where both languages meet ------------------------------------------------------------------


def test_a_french_copy_is_known_where_the_files_are_english(core: Path) -> None:
    """No given file is called changed, every starting file is untouched; a changed one is not."""
    found = read_submission(core)
    assert (found.changed, found.missing) == ((), ())
    assert originals.untouched(found.files, found.in_place) == {*exercises.load().student}
    assert authors.parse(found.authors).people == ()
    scene = (core / "scene.c").read_text(encoding="utf-8")
    (core / "scene.c").write_text(scene.replace("0.2f, 0.2f, 0.6f", "0.2f, 0.2f, 0.7f"), "utf-8")
    (core / "main.c").write_text("/* moi */\nint mine;\n", encoding="utf-8")
    found = read_submission(core)
    assert found.changed == ("scene.c",)
    assert "main.c" not in originals.untouched(found.files, found.in_place)


def test_an_english_copy_is_known_where_the_files_are_french(
    french: Files, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The student's own archive packs the French originals."""
    (tmp_path / "originals.zip").write_bytes(french[ORIGINALS])
    monkeypatch.setattr(originals, "PACK", tmp_path / "originals.zip")
    monkeypatch.setattr(originals, "REFERENCE", tmp_path / "absent")
    assert originals.read(in_place=True)["scene.h"] == french["core_c/scene.h"]
    assert read_submission(exercises.CORE).changed == ()

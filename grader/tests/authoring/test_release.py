"""`make release`: what students get, and never the solution."""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
import shutil
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from grader.authoring import release, translation
from grader.authoring.release import ReleaseError
from grader.authoring.skeleton import leaks, skeleton
from grader.course import exercises
from grader.course.texts import LANGUAGES, Texts
from grader.intake import originals
from grader.setup import release_record
from grader.tests.support.shell import NOBODY, ROOT, reachable, run

COURSE = (ROOT / "grader" / "course" / "course.toml").read_bytes()  # ends in [people]
Files = dict[str, bytes]
FOLDERS = ("core_c", "grader", "reference", "notebooks")


@pytest.fixture(scope="module")
def files() -> Files:
    """Collect what is released."""
    return release.collect(ROOT)


@pytest.fixture(scope="module")
def line() -> str:
    """Return a line of the solution, as it stands in reference/raytracer.c."""
    text = (ROOT / "reference" / "raytracer.c").read_text(encoding="utf-8")
    lines = leaks.solution_lines(ROOT / "reference", ROOT / "core_c")
    found = [row.strip() for row in text.splitlines() if leaks.squeezed(row) in lines]
    return max(found, key=len)


def refused(files: Files, key: str) -> dict[str, object]:
    """Return the values of the sentence that refuses these files."""
    with pytest.raises(ReleaseError) as caught:
        release.verify(files, ROOT)
    assert caught.value.key == f"release.{key}"
    for language in LANGUAGES:
        assert "\n" not in Texts(language).say(caught.value.key, **caught.value.values)
    return caught.value.values


def test_the_release_is_clean(files: Files) -> None:
    """What is released now holds nothing of the solution."""
    release.verify(files, ROOT)


def test_what_is_in_it(files: Files) -> None:
    """The student's folders without our tools, tests and sources."""
    assert {path.split("/")[0] for path in files} == {
        *("LICENSE", "Makefile", "README.md", "pyproject.toml", ".editorconfig", ".vscode"),
        *(".devcontainer", ".dockerignore"),
        *FOLDERS,
    }
    rules = exercises.load()
    core = {*rules.student, *rules.given, *rules.ungraded, *release.CORE_FILES}
    assert {path for path in files if path.startswith("core_c/")} == {f"core_c/{n}" for n in core}
    hidden = re.compile(
        r"/(authoring|tests|mistakes|variants|readings|__pycache__)/|\.(patch|md|pyc)$|/\."
    )
    assert [path for path in files if hidden.search(path) and path != "README.md"] == []
    needed = ("course/course.toml", "course/exercises.toml", "intake/originals.zip")
    assert {f"grader/{name}" for name in (*needed, "report/results.schema.json")} <= set(files)
    assert "reference/expected/manifest.json" in files


def test_the_record_names_every_file(files: Files) -> None:
    """An update finds what was handed out, and which files are the student's."""
    record = release_record.parse(files["grader/release.json"])
    assert set(record.files) == set(files) - {"grader/release.json"}
    assert record.files["LICENSE"] == hashlib.sha256(files["LICENSE"]).hexdigest()
    own = ("main.c", "raytracer.c", "raytracer.h", "octree.c", "my_tests.c", "AUTEURS.txt")
    first_steps = "notebooks/first_steps/main.c"
    assert record.own == (*sorted(f"core_c/{name}" for name in own), first_steps)


@pytest.mark.parametrize(
    ("epoch", "date"), [("0", (1980, 1, 1, 0, 0, 0)), ("1700000000", (2023, 11, 14, 22, 13, 20))]
)
def test_the_bytes_depend_on_the_files_alone(
    epoch: str, date: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Same bytes in whatever order; the sources' date, one mode, nothing compressed by a zlib."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    files = release.collect(ROOT)
    content = release.packed(files)
    assert content == release.packed(dict(reversed(files.items())))
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        entries = archive.infolist()
    assert [each.filename for each in entries] == sorted(f"miniraytracer/{path}" for path in files)
    traits = {(each.date_time, each.external_attr, each.compress_type) for each in entries}
    assert traits == {(date, 0o100644 << 16, zipfile.ZIP_STORED)}


def test_the_students_makefile(files: Files) -> None:
    """Its targets are the student's, and none needs what was left behind."""
    text = files["Makefile"].decode()
    assert tuple(re.findall(r"^([a-z-]+):", text, re.MULTILINE)) != ()
    assert set(re.findall(r"^([a-z-]+):", text, re.MULTILINE)) == set(release.TARGETS)
    assert not re.search(r"grader\.authoring|reference|grader/tests|C_FILES", text)
    assert f".PHONY: {' '.join(release.TARGETS)}\n" in text


def test_the_students_readme(files: Files) -> None:
    """The first five minutes in both languages; nothing for instructors, no broken link."""
    text = files["README.md"].decode()
    titles = re.findall(r"^## (.*)$", text, re.MULTILINE)
    assert titles == list(release.SECTIONS)
    assert not re.search(r"reference|CONTRIBUTING|skeleton`|make expected", text)


@pytest.mark.parametrize(
    ("cut", "key"),
    [
        (lambda: release.student_makefile("help:\n\ngrade:\n"), "no_target"),
        (lambda: release.student_readme("# Title\n\n## Commands\n"), "no_section"),
    ],
)
def test_a_part_that_is_gone_is_told(cut: Callable[[], str], key: str) -> None:
    """A renamed target or section stops the release: a student's would be missing."""
    with pytest.raises(ReleaseError) as caught:
        cut()
    assert caught.value.key == f"release.{key}"


# ---- Planted leaks ------------------------------------------------------------------------------


def in_a_zip(text: str) -> bytes:
    """Return an archive in an archive, with a text in it."""
    inner, outer = io.BytesIO(), io.BytesIO()
    with zipfile.ZipFile(inner, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("deep.txt", text)
    with zipfile.ZipFile(outer, "w") as archive:
        archive.writestr("inner.zip", inner.getvalue())
    return outer.getvalue()


PLANTED: dict[str, tuple[str, Callable[[str], bytes], str]] = {
    "as it is": ("grader/a.py", lambda line: f"\n\n  {line}  \n".encode(), "grader/a.py:3"),
    "spaced": ("grader/a.py", lambda line: line.replace(" ", "\t  ").encode(), "grader/a.py:1"),
    "comment": ("grader/a.py", lambda line: f"#\n# see {line}".encode(), "grader/a.py:2"),
    "commented": ("core_c/a.h", lambda line: f"/* x */ {line} // y".encode(), "core_c/a.h:1"),
    "string": ("grader/a.py", lambda line: f'say("{line}\\n")'.encode(), "grader/a.py:1"),
    "cut": ("grader/a.py", lambda line: line.replace(" ", "\n", 1).encode(), "grader/a.py"),
    "notebook": (
        "notebooks/fr/a.ipynb",
        lambda line: json.dumps({"cells": [{"source": ["a\n", f"{line}\n"]}]}).encode(),
        "notebooks/fr/a.ipynb:1",
    ),
    "zip": ("grader/a.zip", in_a_zip, "grader/a.zip/inner.zip/deep.txt:1"),
    "binary": ("grader/a.json", lambda line: b"\0\1" + line.encode() + b"\0", "grader/a.json:1"),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_line_is_found(line: str, name: str) -> None:
    """One line of the solution, in any file and disguise, is found once, and located."""
    path, disguise, place = PLANTED[name]
    (leak,) = leaks.find({path: disguise(line)}, ROOT / "reference", ROOT / "core_c")
    assert leak.place == place
    assert leak.what.startswith("raytracer.c:")


def test_a_planted_line_stops_the_release(files: Files, line: str) -> None:
    """Among all the files of the release, the one that holds it is named."""
    values = refused(
        {
            **files,
            "grader/commands/__init__.py": files["grader/commands/__init__.py"] + line.encode(),
        },
        "leak",
    )
    assert str(values["place"]).startswith("grader/commands/__init__.py:")


def test_every_line_of_the_solution_is_found() -> None:
    """Not only the one above: each line that counts is found alone in a file."""
    lines = leaks.solution_lines(ROOT / "reference", ROOT / "core_c")
    assert len(lines) > 300
    files = {f"{number}.py": key.encode() for number, key in enumerate(lines)}
    found = leaks.find(files, ROOT / "reference", ROOT / "core_c")
    places = dict(zip(files, lines.values(), strict=True))
    assert [(each.place, each.what) for each in found] == [
        (f"{path}:1", where) for path, where in places.items()
    ]


def test_a_short_line_is_found_in_a_notebook() -> None:
    """A line too short to be looked for within others is still one between its quotes."""
    lines = leaks.solution_lines(ROOT / "reference", ROOT / "core_c")
    short = min(lines, key=len)
    content = json.dumps({"cells": [{"source": ["a\n", f"  {short}\n"]}]}, indent=1).encode()
    (leak,) = leaks.find({"a.ipynb": content}, ROOT / "reference", ROOT / "core_c")
    assert (leak.line, leak.what) == (6, lines[short])


def test_marks_and_whole_files_are_found() -> None:
    """A mark by itself; a file of reference/, a patch of a mistake, under another name."""
    mark = b"x\n/* BEGIN SOL" + b"UTION TP1.1 */\n"
    patches = sorted((ROOT / "reference" / "mistakes").rglob("*.patch"))
    sources = [ROOT / "reference" / "octree.c", *patches[:1]]
    planted = {f"grader/{path.stem}.txt": path.read_bytes() for path in sources}
    found = [*leaks.find({"a.py": mark, **planted}, ROOT / "reference", ROOT / "core_c")]
    assert (found[0].place, found[0].what) == ("a.py:2", "BEGIN SOL" + "UTION")
    whole = {each.path: each.what for each in found if not each.line}
    names = [str(path.relative_to(ROOT)) for path in sources]
    assert whole == dict(zip(planted, names, strict=True))


def test_what_students_have_is_no_leak(files: Files) -> None:
    """A given line, a short one, a loop over an array: anybody's."""
    common = b"for (int k = 0; k < WIDTH * HEIGHT; k++) {\nreturn false;\nhit = true;\n"
    given = files["core_c/scene.c"]
    planted = {"grader/a.txt": common + given}
    assert [*leaks.find(planted, ROOT / "reference", ROOT / "core_c")] == []


@pytest.mark.parametrize(
    ("path", "content", "key"),
    [
        ("reference/main.c", b"", "forbidden"),
        ("grader/mistake.patch", b"", "forbidden"),
        ("grader/authoring/release.py", b"", "forbidden"),
        ("core_c/main.c", b"int main(void) {}\n", "not_skeleton"),
        ("grader/intake/originals.zip", b"", "not_skeleton"),
        ("core_c/AUTEURS.txt", b"Nom : Lovelace, Ada, 21905678", "named"),
        ("grader/course/course.toml", COURSE + b'excused = ["21905678"]', "people"),
        (
            "grader/course/course.toml",
            COURSE + b'extensions = { "A" = 2026-03-09T23:59:00 }',
            "people",
        ),
        ("reference/expected/unseen.npz", b"", "unknown_data"),
        ("reference/expected/manifest.json", b'{"seed": 7, "files": {}}', "other_seed"),
        ("reference/expected/7/manifest.json", b'{"seed": 7, "files": {}}', "other_seed"),
        ("notebooks/fr/a.ipynb", b'{"cells": [{"outputs": [{}]}]}', "outputs"),
        ("notebooks/fr/a.ipynb", b"<<<<<<<", "missing"),
    ],
)
def test_what_must_not_be_handed_out(files: Files, path: str, content: bytes, key: str) -> None:
    """One sentence names the file."""
    assert refused({**files, path: content}, key)["path"] == path


# ---- From the command line ----------------------------------------------------------------------


@pytest.fixture(scope="module")
def place() -> Iterator[Path]:
    """Make the release of a copy that is littered, and unpack it where every user may work."""
    top = Path(tempfile.mkdtemp(prefix="mrt-release-"))
    copy = top / "le projet"
    for name in FOLDERS:
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in (*release.WHOLE_FILES, "Makefile", "README.md"):
        (copy / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, copy / name)
    litter = (".main.c.swp", "main.c~", "mrt", "essai.c")
    for path in (*(f"core_c/{name}" for name in litter), "grader/.cache/a.py", "grader/b.py~"):
        (copy / path).parent.mkdir(exist_ok=True)
        (copy / path).write_text("litter", encoding="utf-8")
    done = run("make", "release", f"OUT={top}/sujet.zip", cwd=copy, MRT_ENV=sys.prefix)
    assert (done.returncode, done.stderr) == (0, "")
    english = run(
        "make", "release", "COMMENTS=en", f"OUT={top}/en.zip", cwd=copy, MRT_ENV=sys.prefix
    )
    assert (english.returncode, english.stderr) == (0, "")
    shutil.rmtree(copy)
    place = top / "l'été au labo"
    with zipfile.ZipFile(top / "sujet.zip") as archive:
        archive.extractall(place)
        assert not [name for name in archive.namelist() if archive.read(name) == b"litter"]
    if os.geteuid() == 0:
        for each in (place, *place.rglob("*")):
            os.chown(each, NOBODY, NOBODY)
    top.chmod(0o755)
    yield place / "miniraytracer"
    shutil.rmtree(top)


def make(place: Path, *words: str) -> str:
    """Run make as an ordinary user in the student's folder; return what it printed."""
    # The tests' own environment, where that user can read it; else a new one in the folder.
    shared = sys.prefix if reachable(Path(sys.prefix, "bin", "python")) else ""
    done = run("make", *words, cwd=place, ordinary=True, MRT_ENV=shared)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def score(place: Path) -> tuple[float, float, set[str]]:
    """Return points, bonus and outcomes of the last full run."""
    content = json.loads((place / "build" / "grade" / "results.json").read_text(encoding="utf-8"))
    return content["score"], content["bonus"], {each["outcome"] for each in content["checks"]}


@pytest.mark.long
def test_comments_are_in_the_courses_language(place: Path) -> None:
    """French without a word of it, ours when asked for; the rest of both archives is the same."""
    contents = []
    for name in ("sujet.zip", "en.zip"):
        with zipfile.ZipFile(place.parents[1] / name) as archive:
            contents.append({each: archive.read(each) for each in archive.namelist()})
    french, english = contents
    for name in originals.names():
        path = f"miniraytracer/core_c/{name}"
        assert english[path] == (ROOT / "core_c" / name).read_bytes()
        assert french[path] != english[path]
    assert "Vérification : make grade" in french["miniraytracer/core_c/exercises.h"].decode()
    own = (release_record.ORIGINALS, release_record.RECORD)
    changed = {path for path in english if french[path] != english[path]}
    read = {f"miniraytracer/{path}" for path in own}
    read |= {path for path in english if translation.is_read(path.removeprefix("miniraytracer/"))}
    assert changed == read


@pytest.mark.long
def test_the_students_first_day(place: Path) -> None:
    """Unpacked, `make` lists the student's targets, and `make grade` gives 0 and a to-do list."""
    assert {row.split()[1] for row in make(place).splitlines()} == {*release.TARGETS}
    said = make(place, "grade")
    points, bonus, outcomes = score(place)
    assert (points, bonus) == (0, 0)
    assert "todo" in outcomes <= {"todo", "blocked"}
    assert "Tout est encore à écrire" in said
    assert "fill_red" in said


@pytest.mark.long
def test_the_solution_has_every_point_without_the_reference(place: Path) -> None:
    """With the reference's files in core_c/, and no reference beside: 100 and 20."""
    for name in exercises.load().student:
        shutil.copyfile(ROOT / "reference" / name, place / "core_c" / name)
    make(place, "grade")
    assert score(place) == (100, 20, {"passed"})
    authors = place / "core_c" / "AUTEURS.txt"
    authors.write_text("Nom : Lovelace, Ada, 21905678\nGroupe : B2\n", encoding="utf-8")
    said = make(place, "submit")
    assert "Total provisoire de ces fichiers : 100 / 100." in said
    make(place, "grade", "SUBMISSION=rendu-Lovelace.zip", "K=fill_red")
    results = place / "build" / "grade" / "partial" / "results.json"
    assert json.loads(results.read_text(encoding="utf-8"))["score"] == 2


def half_done(name: str) -> str:
    """Return a student's file in the middle of TP3: the solution of TP1, TP2 and `shade`."""
    path = ROOT / "reference" / name
    lines = path.read_text(encoding="utf-8").rstrip("\n").split("\n")
    regions = skeleton.find_regions(path, lines, {each.id for each in exercises.load().exercises})
    for region in reversed(regions):
        done = region.exercise[:3] in ("TP1", "TP2") or region.exercise == "TP3.1"
        own = lines[region.begin + 1 : region.end]
        lines[region.begin : region.end + 1] = own if done else skeleton.stub_lines(region, set())
    return "\n".join([*lines, ""])


def next_release(path: Path) -> Files:
    """Return a later release: a given file, a starting file, a notebook and a text have changed."""
    with zipfile.ZipFile(path) as archive:
        names = [name for name in archive.namelist() if not name.endswith(release_record.RECORD)]
        files = {name.removeprefix("miniraytracer/"): archive.read(name) for name in names}
        record = release_record.parse(archive.read(f"miniraytracer/{release_record.RECORD}"))
    for name, more in (("scene.h", b"/* later */\n"), ("raytracer.c", b"void later(void) {\n}\n")):
        files[f"core_c/{name}"] += more
    core = {name: files[f"core_c/{name}"] for name in originals.names()}
    files["grader/intake/originals.zip"] = originals.packed(core)
    files["README.md"] += b"Later.\n"
    del files["LICENSE"]
    sums = {name: release_record.digest(content) for name, content in files.items()}
    files[release_record.RECORD] = replace(record, version="9.0.0", files=sums).as_json()
    return files


@pytest.mark.long
def test_an_update_in_the_middle_of_tp3(place: Path) -> None:
    """Own code, own files and changes are there afterwards, and the same points."""
    theirs = {
        **{f"core_c/{name}": half_done(name) for name in exercises.load().student},
        "core_c/bvh.c": '#include "raytracer.h"\n',
        "core_c/AUTEURS.txt": "Nom : Lovelace, Ada, 21905678\n",
        "core_c/mes notes.txt": "à revoir",
        "notebooks/fr/essai.ipynb": "{}",
    }
    changed = {"grader/course/course.toml": "broken", "core_c/scene.h": "/* mine */\n"}
    for name, text in theirs.items():
        (place / name).write_text(text, encoding="utf-8")
    make(place, "grade", "TP=3")
    partial = place / "build" / "grade" / "partial" / "results.json"
    before = json.loads(partial.read_text(encoding="utf-8"))["checks"]
    for name, text in changed.items():
        (place / name).write_text(text, encoding="utf-8")
    later = next_release(place.parents[1] / "sujet.zip")
    (place.parent / "suite.zip").write_bytes(release.packed(later))

    said = make(place, "update", "ARCHIVE=../suite.zip")

    (copies,) = place.glob("sauvegarde-*")
    for name, content in later.items():
        assert name in theirs or (place / name).read_bytes() == content
    assert {name: (place / name).read_text(encoding="utf-8") for name in theirs} == theirs
    assert {name: (copies / name).read_text(encoding="utf-8") for name in changed} == changed
    assert "+void later(void)" in (copies / "core_c" / "raytracer.c.diff").read_text("utf-8")
    assert not (place / "LICENSE").exists()
    assert "core_c/raytracer.c : le fichier de départ a changé, le vôtre non." in said
    make(place, "grade", "TP=3")
    after = json.loads(partial.read_text(encoding="utf-8"))["checks"]
    assert [(each["id"], each["outcome"]) for each in after] == [
        (each["id"], each["outcome"]) for each in before
    ]
    assert {"passed", "todo"} <= {each["outcome"] for each in after}


def test_release_is_not_in_a_students_copy(place: Path) -> None:
    """The instructor's command says that it is not here."""
    words = ("-m", "grader", "release")
    done = run(sys.executable, *words, cwd=place, MRT_LANG="en")
    assert done.returncode == 2
    assert done.stderr.startswith("The command release is for instructors")


def test_files_that_git_does_not_know_are_refused(tmp_path: Path) -> None:
    """A trial beside the committed files stops the release; committed, it is part of it."""
    git = ("git", "-c", "user.name=a", "-c", "user.email=a@b")
    for words in (("init", "-q"), ("add", "."), ("commit", "-q", "--allow-empty", "-m", "a")):
        assert run(*git, *words, cwd=tmp_path).returncode == 0
    (tmp_path / "grader").mkdir()
    (tmp_path / "grader" / "trial.py").touch()
    with pytest.raises(ReleaseError) as caught:
        release.verify_history({"grader/trial.py": b""}, tmp_path)
    assert caught.value.values == {"path": "grader/trial.py"}
    assert run(*git, "add", ".", cwd=tmp_path).returncode == 0
    release.verify_history({"grader/trial.py": b""}, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("out", ["/proc/no/a.zip", "{here}"])
def test_an_archive_that_cannot_be_written(
    out: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line names the place and the cure, and no half of an archive stays."""
    monkeypatch.setattr(release, "verify_history", lambda *_: None)
    monkeypatch.setenv("MRT_LANG", "en")
    assert release.main(["--out", out.format(here=tmp_path)]) == 1
    said = capsys.readouterr().err
    assert "cannot be written" in said
    assert said.count("\n") == 1
    assert [*tmp_path.iterdir()] == []
    assert not [path for path in tmp_path.parent.iterdir() if path.name.endswith(".part")]

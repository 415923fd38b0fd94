"""`make release`: the archive that students start from, without the solution.

Only what is listed below goes in, and every file is then searched for the solution. The bytes of
the archive depend on those of the files alone: same order, date and permissions everywhere.
Run it as ``python -m grader release [--out ZIP]``.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any
from zipfile import ZIP_STORED

import grader
from grader.authoring.expected.command import SEED
from grader.authoring.skeleton import leaks, skeleton
from grader.authoring.translation import SOURCE, translated
from grader.console.run import complain
from grader.course import exercises, settings
from grader.course.exercises import ROOT
from grader.course.message import GraderError, UserError
from grader.course.texts import LANGUAGES, Texts, preferred
from grader.files import write_whole, zipped
from grader.intake import authors, originals
from grader.setup import release_record
from grader.setup.release_record import ORIGINALS, RECORD, TOP, Release, digest

# Beside the files that exercises.toml names.
CORE_FILES = (authors.NAME, "texture.ppm", "Makefile", "compile_flags.txt")
# By folder, the kinds of files that go in; sources of the notebooks stay behind.
FOLDERS = {
    "grader": (
        *(".py", ".sh", ".c", ".toml", ".json", ".zip", ".in", ".txt"),
        *(".html", ".j2", ".css", ".js", ".svg"),
    ),
    "notebooks": (".ipynb", ".png", ".svg", ".c"),
    "reference/expected": (".npz", ".png", ".json"),
}
LEFT_OUT = ("grader/batch/", "grader/authoring/", "grader/tests/")
EDITOR_FILES = ("c_cpp_properties", "extensions", "launch", "tasks")
WHOLE_FILES = (
    *("LICENSE", "pyproject.toml", ".editorconfig"),
    *(f".vscode/{name}.json" for name in EDITOR_FILES),
    *(f".devcontainer/{name}" for name in ("Dockerfile", "devcontainer.json", "workbook.pth")),
    ".dockerignore",
)
TARGETS = (
    *("help", "grade", "report", "watch", "mrt", "try", "debug", "restore"),
    *("lab", "submit", "update", "doctor", "clean"),
)
SECTIONS = ("Les cinq premières minutes", "The first five minutes", "Commands")
GIT_SECONDS = 30
FIRST_DATE = 315532800  # 1980: no .zip can hold an earlier one


class ReleaseError(UserError):
    """The archive cannot be made: a sentence of [release] in messages/."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, or 1 after one line on stderr."""
    texts = Texts(preferred())
    parser = argparse.ArgumentParser(prog="python -m grader release", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--out", type=Path, default=ROOT / "build" / f"{TOP}.zip", metavar="ZIP")
    parser.add_argument("--comments", choices=LANGUAGES, help="their language, if not the course's")
    options = parser.parse_args(arguments)
    try:
        language = options.comments or settings.load().language
        files = handed_out(ROOT, language)
        content = packed(files)
        write(options.out, content)
    except GraderError as error:
        return complain(error.sentence(texts), 1)
    size = texts.number(round(len(content) / 1e6, 1))
    print(texts.say("release.done", path=options.out, count=len(files), mb=size))
    return 0


# ---- What goes in -------------------------------------------------------------------------------


def handed_out(root: Path, language: str = SOURCE) -> dict[str, bytes]:
    """Return the files of the archive, once they are seen to be fit for it. Raises ReleaseError."""
    files = collect(root, language)
    verify(files, root, language)
    verify_history(files, root)
    return files


def collect(root: Path, language: str = SOURCE) -> dict[str, bytes]:
    """Return the files of the archive by path, the record too. Raises ReleaseError.

    `language` is that of the comments: the files are handed out as they are in that of the sources.
    """
    rules = exercises.load()
    core = [f"core_c/{name}" for name in (*originals.names(), *rules.ungraded, *CORE_FILES)]
    paths = [*core, *WHOLE_FILES, *_listed(root)]
    files = {path: read(root, path) for path in paths}
    files["Makefile"] = student_makefile(read(root, "Makefile").decode()).encode()
    files["README.md"] = student_readme(read(root, "README.md").decode()).encode()
    if language != SOURCE:
        files = translated(files, language)
        files[ORIGINALS] = originals.packed(_handed_out(files))
    own = [f"core_c/{name}" for name in (*rules.student, *rules.ungraded, authors.NAME)]
    own += [path for path in files if path.startswith("notebooks/") and path.endswith(".c")]
    sums = {path: digest(content) for path, content in files.items()}
    record = Release(grader.__version__, _date(root), tuple(own), sums)
    return {**files, RECORD: record.as_json()}


def packed(files: Mapping[str, bytes]) -> bytes:
    """Return the archive: the same bytes on every machine, hence stored, with the sources' date.

    Another date each time, or Python would take its compiled files for those of the last release.
    """
    date = time.gmtime(max(release_record.parse(files[RECORD]).date, FIRST_DATE))[:6]
    return zipped({f"{TOP}/{path}": each for path, each in files.items()}, date, ZIP_STORED)


def student_makefile(text: str) -> str:
    """Return the Makefile with the student's targets; a paragraph holds one. Raises ReleaseError.

    A target that is new here reaches students when it is listed, not before.
    """
    kept, found = [], set()
    for paragraph in text.split("\n\n"):
        rules = set(re.findall(r"^([a-z][\w-]*):", paragraph, re.MULTILINE))
        if rules <= {*TARGETS}:
            kept.append(paragraph)
            found |= rules
    if missing := sorted({*TARGETS} - found):
        raise ReleaseError("release.no_target", names=", ".join(missing))
    phony = f".PHONY: {' '.join(TARGETS)}"
    return re.sub(r"^\.PHONY:.*(?:\\\n.*)*", phony, "\n\n".join(kept), flags=re.M).rstrip() + "\n"


def student_readme(text: str) -> str:
    """Return the README's beginning and the student's sections. Raises ReleaseError."""
    top, *sections = re.split(r"^(?=## )", text, flags=re.MULTILINE)
    titled = {section.split("\n", 1)[0][3:].strip(): section for section in sections}
    if missing := [name for name in SECTIONS if name not in titled]:
        raise ReleaseError("release.no_section", names=", ".join(missing))
    return (top + "".join(titled[name] for name in SECTIONS)).rstrip() + "\n"


def _listed(root: Path) -> Iterator[str]:
    for folder, suffixes in FOLDERS.items():
        for path in sorted((root / folder).rglob("*")):
            name = path.relative_to(root).as_posix()
            hidden = any(part[0] == "." or part == "__pycache__" for part in name.split("/"))
            out = hidden or name == RECORD or name.startswith(LEFT_OUT)
            if path.is_file() and path.suffix in suffixes and not out:
                yield name


def read(root: Path, path: str) -> bytes:
    """Return the content of a file of the project. Raises ReleaseError."""
    try:
        return (root / path).read_bytes()
    except OSError as error:
        raise ReleaseError("release.missing", path=path, error=error.strerror) from error


def git(root: Path, *words: str) -> str:
    """Return what git says; "" where there is no git, or no history of it here."""
    try:
        done = subprocess.run(
            ["git", "-C", str(root), *words],
            capture_output=True,
            text=True,
            timeout=GIT_SECONDS,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout


def _date(root: Path) -> int:
    """Return when the sources were last committed: never today's date, which changes the bytes."""
    given = os.environ.get("SOURCE_DATE_EPOCH", "")
    known = given or (git(root, "log", "-1", "--format=%ct") if (root / ".git").exists() else "")
    return int(known) if known.strip().isdigit() else 0


# ---- What must not be in it ---------------------------------------------------------------------


def verify_history(files: Mapping[str, bytes], root: Path) -> None:
    """Raise ReleaseError for a file that git does not know: a trial, or not committed yet."""
    if (root / ".git").exists():
        unknown = git(root, "ls-files", "-z", "--others", "--", ".").split("\0")
        for path in sorted({*files} & {*unknown}):
            raise ReleaseError("release.untracked", path=path)


def verify(files: Mapping[str, bytes], root: Path, language: str = SOURCE) -> None:
    """Raise ReleaseError, or SkeletonError, unless the files may be handed out."""
    _verify_core(files, root, language)
    _verify_names(files)
    _verify_expected(files)
    _verify_notebooks(files)
    _verify_course(files)
    for leak in leaks.find(files, root / "reference", root / "core_c"):
        raise ReleaseError("release.leak", place=leak.place, what=leak.what)


def _verify_core(files: Mapping[str, bytes], root: Path, language: str) -> None:
    """Raise ReleaseError unless students start from the skeleton, with nobody's names in it."""
    made = skeleton.make_all(root / "reference", exercises.load())
    skeletons = {f"core_c/{name}": text.encode() for name, text in made.items()}
    for path, content in translated(skeletons, language).items():
        if files[path] != content:
            raise ReleaseError("release.not_skeleton", path=path)
    if files[ORIGINALS] != originals.packed(_handed_out(files)):
        raise ReleaseError("release.not_skeleton", path=ORIGINALS)
    if authors.parse(files[f"core_c/{authors.NAME}"]).people:
        raise ReleaseError("release.named", path=f"core_c/{authors.NAME}")


def _handed_out(files: Mapping[str, bytes]) -> dict[str, bytes]:
    return {name: files[f"core_c/{name}"] for name in originals.names()}


def _verify_names(files: Mapping[str, bytes]) -> None:
    for path in files:
        folder = path.split("/")[0]
        if folder == "reference" and not path.startswith("reference/expected/"):
            raise ReleaseError("release.forbidden", path=path)
        if PurePosixPath(path).suffix == ".patch" or path.startswith(LEFT_OUT):
            raise ReleaseError("release.forbidden", path=path)


def _verify_expected(files: Mapping[str, bytes]) -> None:
    """Raise ReleaseError unless the data is that of the public seed: unseen data stays behind."""
    folder = {path: files[path] for path in files if path.startswith("reference/expected/")}
    sums: set[str] = set()
    for path, content in folder.items():
        if path.endswith("/manifest.json"):
            sums |= set(re.findall(r"\b[0-9a-f]{64}\b", content.decode()))
            seed = _json(path, content).get("seed", SEED)
            if seed != SEED:
                raise ReleaseError("release.other_seed", path=path, seed=seed)
    for path, content in folder.items():
        known = path.endswith("/manifest.json") or hashlib.sha256(content).hexdigest() in sums
        if not known:
            raise ReleaseError("release.unknown_data", path=path)


def _verify_notebooks(files: Mapping[str, bytes]) -> None:
    """Raise ReleaseError for a notebook that somebody has run: it shows what they wrote."""
    for path, content in files.items():
        if path.endswith(".ipynb"):
            cells = _json(path, content).get("cells", [])
            if any(each.get("outputs") for each in cells):
                raise ReleaseError("release.outputs", path=path)


def _verify_course(files: Mapping[str, bytes]) -> None:
    """Raise ReleaseError for settings that name persons; ManifestError when they are wrong."""
    path = settings.COURSE.relative_to(ROOT).as_posix()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, settings.COURSE.name)
        place.write_bytes(files[path])
        people = settings.load(place).people
    if people.excused or people.extensions:
        raise ReleaseError("release.people", path=path)


def _json(path: str, content: bytes) -> dict[str, Any]:
    try:
        table: dict[str, Any] = json.loads(content)
    except ValueError as error:
        raise ReleaseError("release.missing", path=path, error=error) from error
    return table


def write(path: Path, content: bytes) -> None:
    """Write an archive whole. Raises ReleaseError."""
    try:
        write_whole(path, content)
    except OSError as error:
        raise ReleaseError("release.cannot_write", path=path, error=error.strerror) from error

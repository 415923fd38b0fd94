"""`make submit`: the archive that a student hands in, after saying what is in it.

    python -m grader submit [--source core_c] [--out DIR] [--force]

The archive holds the files that are judged, and AUTEURS.txt, as they are on the disk; it is read
back as the grader will read it before it takes its name.
"""

from __future__ import annotations

import argparse
import io
import json
import time
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from grader.build import diagnostics
from grader.build.builder import build
from grader.build.records import BuildResult, BuildStatus, Target
from grader.build.room import require_room
from grader.console.run import ExitCode, run
from grader.course import exercises
from grader.course.message import UserError
from grader.course.texts import Texts, preferred
from grader.evaluation import remarks
from grader.intake import archives, authors
from grader.intake.authors import Authors
from grader.intake.records import Submission
from grader.intake.submission import read_submission

TARGET = Target(320, 180)


class HandinError(UserError):
    """Nothing was written: a sentence of [submit] in messages/."""

    code = 2


@dataclass(frozen=True)
class Parcel:
    """What is sent: the files as they are on the disk, and when they were last written."""

    submission: Submission
    authors: Authors
    files: Mapping[str, bytes]
    modified: Mapping[str, float]  # seconds since the epoch


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, 2 for wrong use, 3 when the machine is at fault."""
    texts = Texts(preferred())
    options = _parser(texts).parse_args(arguments)

    def act() -> int:
        parcel = read(options.source)
        for line in submit(parcel, options.out, options.build, texts, force=options.force):
            print(line)
        return ExitCode.DONE

    return run(act, texts)


def read(source: Path) -> Parcel:
    """Read what a folder hands in. Raises SubmissionError, HandinError."""
    submission = read_submission(source)
    if not source.is_dir():
        raise HandinError("submit.not_a_folder", path=source)
    place = next(iter({Path(each.path).parent for each in submission.sources}), source)
    files, modified = {}, {}
    for name in (*submission.files, authors.NAME):
        content, problem = archives.read_file(place / name)
        if not problem:
            files[name], modified[name] = content, (place / name).stat().st_mtime
        elif name in submission.files:
            raise HandinError("submit.unreadable", path=place / name)
    known = authors.parse(files.get(authors.NAME, b""))
    return Parcel(submission, known, files, modified)


def submit(
    parcel: Parcel, out: Path, folder: Path, texts: Texts, *, force: bool = False
) -> Iterator[str]:
    """Yield what is told, and write the archive in `out`. Raises HandinError.

    `folder` is that of builds and results.
    """
    yield from _content(parcel, texts)
    yield from _authors(parcel.authors, texts)
    if not parcel.authors.people and not force:
        raise HandinError("submit.nobody", name=authors.NAME)
    yield from _compiles(parcel.submission, folder, texts)
    yield from _mark(parcel, folder, texts)
    label = parcel.authors.label or texts.say("submit.neutral")
    path = out / f"submission-{label}.zip"
    content = packed(parcel)
    try:
        older = _place(path, content)
    except OSError as error:
        raise HandinError("submit.cannot_write", path=path, error=error.strerror) from error
    if older:
        yield texts.say("submit.older", older=older.name)
    yield texts.say("submit.done", path=path)


def packed(parcel: Parcel) -> bytes:
    """Return the archive: the same bytes for the same files."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for name, content in parcel.files.items():
            entry = zipfile.ZipInfo(name, _date(parcel.modified[name]))
            entry.create_system, entry.external_attr = 3, 0o100644 << 16
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return out.getvalue()


def _date(modified: float) -> tuple[int, int, int, int, int, int]:
    """Return a date that a .zip can hold: from 1980 to 2107."""
    moment = time.localtime(modified)
    return moment[:6] if 1980 <= moment.tm_year <= 2107 else (1980, 1, 1, 0, 0, 0)


def _place(path: Path, content: bytes) -> Path | None:
    """Write the archive under its name; return where an older one of that name was put."""
    part, older = path.with_name(f".{path.name}.part"), None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(content)
        _read_back(part)
        if path.exists() and path.read_bytes() != content:
            number = 1
            while path.with_suffix(f".{number}.zip").exists():
                number += 1
            older = path.rename(path.with_suffix(f".{number}.zip"))
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
    return older


def _read_back(path: Path) -> None:
    """Read the archive as the grader will. Raises SubmissionError, OSError."""
    with zipfile.ZipFile(path) as archive:
        if damaged := archive.testzip():
            raise OSError(0, damaged, str(path))
    read_submission(path)


# ---- What is told -------------------------------------------------------------------------------


def _content(parcel: Parcel, texts: Texts) -> Iterator[str]:
    yield texts.say("submit.content")
    width = max(map(len, parcel.files))
    for name, content in parcel.files.items():
        size = texts.say("submit.size", bytes=len(content))
        written = parcel.modified[name]
        date = time.strftime("%Y-%m-%d", time.localtime(written))
        yield f"  {name:{width}}  {size:>14}  {texts.age(int(time.time() - written), date)}"


def _authors(known: Authors, texts: Texts) -> Iterator[str]:
    for each in known.people:
        name = f"{each.first_name} {each.surname}".strip()
        yield texts.say("submit.author", name=name, number=each.number or "?")
    if known.group:
        yield texts.say("submit.group", group=known.group)
    for problem in known.problems:
        if problem.key != "authors.nobody":
            said = texts.say(problem.key, **problem.values)
            yield texts.say("submit.mend", file=authors.NAME, problem=said)


def _compiles(submission: Submission, folder: Path, texts: Texts) -> Iterator[str]:
    """Say whether the files compile: what does not is sent all the same."""
    try:
        require_room(folder)
        (result,) = build(submission, [TARGET], folder / "cache")
    except UserError as error:  # no compiler here, no room for its files
        yield error.sentence(texts)
        return
    yield from remarks.notes(submission, [result], True, texts)
    if result.status is BuildStatus.BUILT and not (result.rejected or result.linker):
        yield texts.say("submit.compiles")
    for name, words in _errors(result):
        yield texts.say("submit.not_compiled", name=name, error=words)


def _errors(result: BuildResult) -> Iterator[tuple[str, str]]:
    logs = dict(result.rejected)
    if result.log and not logs:
        logs[exercises.load().student[0]] = result.log
    for name, log in logs.items():
        errors = diagnostics.errors(log)
        first = f"{errors[0].place}: {errors[0].message}" if errors else log.strip()[:200]
        yield name, first


def _mark(parcel: Parcel, folder: Path, texts: Texts) -> Iterator[str]:
    """Recall the mark of the last full run, when it judged these very files."""
    try:
        content = json.loads((folder / "grade" / "results.json").read_text(encoding="utf-8"))
        judged = content["submission"]["files"]
        points = texts.number(content["score"]), texts.number(content["max_score"])
    except (OSError, ValueError, KeyError, TypeError):
        yield texts.say("submit.not_graded")
        return
    ours = {name: sha256(each).hexdigest() for name, each in parcel.submission.files.items()}
    if judged == ours:
        yield texts.say("submit.graded", score=points[0], most=points[1])
    else:
        yield texts.say("submit.not_graded")


def _parser(texts: Texts) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m grader submit", description=texts.say("submit.description")
    )

    def add(name: str, default: Path, key: str) -> None:
        parser.add_argument(
            f"--{name}", type=Path, default=default, metavar="DIR", help=texts.say(key)
        )

    add("source", exercises.CORE, "submit.source")
    add("out", Path(), "submit.out")
    add("build", exercises.ROOT / "build", "usage.build")
    parser.add_argument("--force", action="store_true", help=texts.say("submit.force"))
    return parser

"""`make submit`: the archive that a student hands in, after saying what is in it.

    python -m grader submit [--source core_c] [--out DIR] [--force]

The archive holds the files that are judged, and AUTEURS.txt, as they are on the disk; it is read
back as the grader will read it before it takes its name.
"""

from __future__ import annotations

import io
import json
import re
import sys
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
from grader.console.parser import Parser
from grader.console.run import ExitCode, run
from grader.course import exercises, settings
from grader.course.message import UserError
from grader.course.texts import Texts, preferred
from grader.evaluation import remarks
from grader.intake import archives, authors
from grader.intake.authors import Authors
from grader.intake.records import Submission
from grader.intake.submission import read_submission
from grader.setup import c_text
from grader.setup.folding import put

TARGET = Target(320, 180)
MAX_NAMED = 4  # functions that are not there
# Comments and strings.


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
            put(line, sys.stdout)
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
    result = _built(parcel.submission, folder)
    yield from _compiles(parcel.submission, result, texts)
    yield from _mark(parcel, folder, texts)
    label = parcel.authors.label or texts.say("submit.neutral")
    path = out / texts.say("submit.name", label=label)
    older = path.with_suffix(f".{texts.say('submit.before')}.zip")
    try:
        is_kept = _place(path, packed(parcel), older)
    except OSError as error:
        raise HandinError("submit.cannot_write", path=path, error=error.strerror) from error
    if is_kept:
        yield texts.say("submit.older", older=older.name)
    lacks = texts.say("submit.and").join(_lacks(parcel.submission, result, texts))
    yield texts.say("submit.done_but" if lacks else "submit.done", path=path, lacks=lacks)


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


def _place(path: Path, content: bytes, older: Path) -> bool:
    """Write the archive under its name; say whether another one of that name was put aside."""
    part = path.with_name(f".{path.name}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(content)
        _read_back(part)
        is_other = path.exists() and path.read_bytes() != content
        if is_other:
            path.replace(older)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
    return is_other


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


def _built(submission: Submission, folder: Path) -> BuildResult | UserError:
    """Build the files; without a compiler here, or room for what it makes, return that error."""
    try:
        require_room(folder)
        (result,) = build(submission, [TARGET], folder / "cache")
    except UserError as error:
        return error
    return result


def _compiles(
    submission: Submission, result: BuildResult | UserError, texts: Texts
) -> Iterator[str]:
    """Say whether the files compile: what does not is sent all the same."""
    if isinstance(result, UserError):
        yield result.sentence(texts)
        return
    yield from map(texts.told, remarks.notes(submission, [result], True))
    if result.status is BuildStatus.BUILT and not (result.rejected or result.linker):
        yield texts.say("submit.compiles")
    for name, words in _errors(result):
        yield texts.say("submit.not_compiled", name=name, error=words)


def _lacks(submission: Submission, result: BuildResult | UserError, texts: Texts) -> Iterator[str]:
    """Say in a few words each what keeps the files from being judged whole."""
    if submission.missing:
        yield texts.say("submit.no_file", names=", ".join(submission.missing))
    if isinstance(result, BuildResult) and (broken := [name for name, _ in _errors(result)]):
        yield texts.say("submit.no_build", names=", ".join(broken))
    if functions := missing_functions(submission):
        named = ", ".join(functions[:MAX_NAMED])
        key = "submit.no_function" if len(functions) <= MAX_NAMED else "submit.no_functions"
        yield texts.say(key, names=named, count=len(functions) - MAX_NAMED)


def missing_functions(submission: Submission) -> list[str]:
    """Return the functions of open TPs that no file defines any more: renamed, or deleted."""
    text = "\n".join(each.decode(errors="replace") for each in submission.files.values())
    code = c_text.blanked(text)
    opened = settings.load().opened
    names = [
        name
        for each in exercises.load().exercises
        if each.tp in opened and each.file not in submission.missing
        for name in each.functions
    ]
    wanted = ("main", *dict.fromkeys(names))
    return [
        name for name in wanted if not re.search(rf"\b{name}\s*\([^;{{}}]{{0,300}}\)\s*{{", code)
    ]


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


def _parser(texts: Texts) -> Parser:
    description = texts.say("submit.description")
    parser = Parser(texts=texts, prog="python -m grader submit", description=description)

    def add(name: str, default: Path, key: str) -> None:
        parser.add_argument(
            f"--{name}", type=Path, default=default, metavar="DIR", help=texts.say(key)
        )

    add("source", exercises.CORE, "submit.source")
    add("out", Path(), "submit.out")
    add("build", exercises.ROOT / "build", "usage.build")
    parser.add_argument("--force", action="store_true", help=texts.say("submit.force"))
    return parser

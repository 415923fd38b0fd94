"""What of a candidate can be judged, and what is to be known of the rest of its files.

A file of the student's that cannot be read is no mark: it must not be one for want of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath

from grader.batch import moodle_archive
from grader.batch.records import Candidate
from grader.course import exercises
from grader.course.message import Message
from grader.intake import archives
from grader.intake.file_names import original
from grader.intake.records import Refusal, Submission
from grader.intake.submission import SubmissionError, read_submission

MAX_LISTED = 6
MOST = archives.MAX_ARCHIVE_BYTES


def read(candidate: Candidate, work: Path) -> tuple[Candidate, Submission | None]:
    """Return a candidate with what is to be known of it, and its submission when it has one.

    An archive in an archive is put in `work`.
    """
    if candidate.problem:
        return candidate, None
    try:
        candidate, submission = _opened(candidate, work)
    except SubmissionError as error:
        # The person's name, not a place in this machine; an archive within has its own.
        inside = PurePosixPath(str(error.values.get("path", "")))
        shown = candidate.label if inside.is_absolute() else inside
        problem = Message(error.key, {**error.values, "path": shown})
        return replace(candidate, problem=problem), None
    remarks = (*candidate.remarks, *_remarks(submission))
    candidate = replace(candidate, remarks=remarks)
    if unreadable := _unreadable(submission):
        problem = Message("batch.unreadable", {"names": ", ".join(unreadable)})
        return replace(candidate, problem=problem), None
    return candidate, submission


def _opened(candidate: Candidate, work: Path) -> tuple[Candidate, Submission]:
    """Read a submission, or the only archive in it when it holds nothing else to judge."""
    try:
        return candidate, read_submission(candidate.path)
    except SubmissionError as error:
        if error.key != "submission.nothing" or not candidate.path.is_file():
            raise
        inside = [
            each.path
            for each in archives.entries(candidate.path)
            if not each.problem and moodle_archive.is_archive(each.path)
        ]
        if len(inside) > 1:
            places = some([str(each) for each in inside])
            raise SubmissionError("batch.several", places=places) from error
        if not inside:
            raise
        content, problem = archives.contents(candidate.path, inside, MOST)[inside[0]]
        if problem:
            raise SubmissionError("submission.broken", path=inside[0], error=problem) from error
    work.mkdir(parents=True, exist_ok=True)
    path = work / f"inside-{candidate.name}{''.join(inside[0].suffixes[-2:])}"
    path.write_bytes(content)
    remark = Message("batch.opened", {"path": str(inside[0])})
    opened = replace(candidate, path=path, remarks=(*candidate.remarks, remark))
    try:
        return opened, read_submission(path)
    except SubmissionError as error:
        raise SubmissionError(error.key, **{**error.values, "path": inside[0]}) from error


def _unreadable(submission: Submission) -> list[str]:
    """Return the student's files that are there and were not read."""
    student = exercises.load().student
    found = []
    for each in submission.refused:
        path = PurePosixPath(original(PurePosixPath(each.path).name).lower())
        name = path.with_suffix(".c").name if each.reason == "cxx" else path.name
        if name in student and (each.reason == "twice" or name not in submission.files):
            found.append(name)
        elif each.reason in archives.ENDS:  # there may be more than was looked at
            found += submission.missing
    return list(dict.fromkeys(found))


def _remarks(submission: Submission) -> Iterator[Message]:
    for renaming in submission.renamed:
        yield Message("batch.renamed", {"path": renaming.path, "name": renaming.name})
    yield from refusals(submission.refused)
    if submission.missing:
        yield Message("batch.missing", {"names": ", ".join(submission.missing)})
    if submission.changed:
        yield Message("batch.given", {"names": ", ".join(submission.changed)})
    if submission.files and not _is_ours(submission):
        yield Message("batch.foreign")
    if submission.unread:
        yield Message("batch.unread", {"names": some(submission.unread)})


def refusals(refused: Sequence[Refusal]) -> Iterator[Message]:
    """Yield what is to be known of files that were not taken, by the reason."""
    for reason in dict.fromkeys(each.reason for each in refused):
        paths = some([each.path for each in refused if each.reason == reason])
        yield Message("batch.refused", {"path": paths, "reason": Message(f"refused.{reason}")})


def _is_ours(submission: Submission) -> bool:
    """Whether a function of the course is named anywhere: or it is another course's work."""
    functions = {name for each in exercises.load().exercises for name in each.functions}
    text = b"\n".join(submission.files.values()).decode(errors="replace")
    return not functions.isdisjoint(re.findall(r"\w+", text))


def some(names: Sequence[str]) -> str:
    """Return some of many names, and how many more there are."""
    listed = ", ".join(names[:MAX_LISTED])
    return listed if len(names) <= MAX_LISTED else f"{listed} (+{len(names) - MAX_LISTED})"

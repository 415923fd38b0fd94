"""Sentences about a submission as a whole: what was left out, replaced, converted, and why."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from grader.build import diagnostics
from grader.build.records import BuildResult
from grader.course.message import Message
from grader.intake.records import Refusal, Submission

MAX_REFUSED = 5


def notes(
    submission: Submission, builds: Sequence[BuildResult], sanitized: bool
) -> Iterator[Message]:
    """Yield the sentences, in the order in which they matter."""
    yield from _files(submission)
    yield from _build(builds[0])
    if not sanitized:
        yield Message("note.no_sanitizer")


def _files(submission: Submission) -> Iterator[Message]:
    if submission.missing:
        yield Message("note.skeleton_file", {"names": ", ".join(submission.missing)})
    if submission.changed:
        key = "note.given_file" if submission.in_place else "note.changed_file"
        yield Message(key, {"names": ", ".join(submission.changed)})
    if submission.converted:
        yield Message("note.converted_file", {"names": ", ".join(submission.converted)})
    yield from (_refused(each) for each in submission.refused[:MAX_REFUSED])
    if len(submission.refused) > MAX_REFUSED:
        yield Message("note.more_refused", {"count": len(submission.refused) - MAX_REFUSED})


def _refused(refusal: Refusal) -> Message:
    reason = Message(f"refused.{refusal.reason}")
    return Message("note.refused_file", {"name": refusal.path, "reason": reason})


def _build(result: BuildResult) -> Iterator[Message]:
    if result.cxx:
        yield Message("note.cxx", {"names": ", ".join(result.cxx)})
    twice = diagnostics.duplicates(result.linker)
    if twice:
        yield Message("note.twice", {"names": ", ".join(twice)})
    if "`main'" in result.linker and "main" not in twice:
        yield Message("note.no_main")

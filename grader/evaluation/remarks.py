"""Sentences about a submission as a whole: what was left out, replaced, converted, and why."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from grader.build import diagnostics
from grader.build.records import BuildResult
from grader.course.texts import Texts
from grader.intake.records import Refusal, Submission

MAX_REFUSED = 5


def notes(
    submission: Submission, builds: Sequence[BuildResult], sanitized: bool, texts: Texts
) -> list[str]:
    """Return the sentences, in the order in which they matter."""
    found = [*_files(submission, texts), *_build(builds[0], texts)]
    if not sanitized:
        found.append(texts.say("note.no_sanitizer"))
    return found


def _files(submission: Submission, texts: Texts) -> Iterator[str]:
    if submission.missing:
        yield texts.say("note.skeleton_file", names=", ".join(submission.missing))
    if submission.changed:
        key = "note.given_file" if submission.in_place else "note.changed_file"
        yield texts.say(key, names=", ".join(submission.changed))
    if submission.converted:
        yield texts.say("note.converted_file", names=", ".join(submission.converted))
    yield from (_refused(each, texts) for each in submission.refused[:MAX_REFUSED])
    if len(submission.refused) > MAX_REFUSED:
        yield texts.say("note.more_refused", count=len(submission.refused) - MAX_REFUSED)


def _refused(refusal: Refusal, texts: Texts) -> str:
    reason = texts.say(f"refused.{refusal.reason}")
    return texts.say("note.refused_file", name=refusal.path, reason=reason)


def _build(result: BuildResult, texts: Texts) -> Iterator[str]:
    if result.cxx:
        yield texts.say("note.cxx", names=", ".join(result.cxx))
    twice = diagnostics.duplicates(result.linker)
    if twice:
        yield texts.say("note.twice", names=", ".join(twice))
    if "`main'" in result.linker and "main" not in twice:
        yield texts.say("note.no_main")

"""From a candidate to a task: its files are read when they are needed, and not kept."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from grader.batch import contents
from grader.batch.dependencies import parts_of
from grader.batch.identity import SubmittedWork
from grader.batch.records import Candidate, Settings, Task
from grader.batch.roster import read
from grader.files import content_key
from grader.intake.records import Source, Submission
from grader.intake.submission import read_submission


@dataclass(frozen=True)
class TaskReader:
    """A candidate, who made it, and the hashes of what its result depends on ({}: no result)."""

    handed: SubmittedWork
    parts: Mapping[str, str]

    @property
    def candidate(self) -> Candidate:
        """The candidate, with what keeps it from being graded."""
        return self.handed.candidate


def read_candidate(candidate: Candidate, settings: Settings, work: Path) -> TaskReader:
    """Read a candidate; what makes it no submission becomes its problem.

    `work` is a folder for what must be unpacked.
    """
    candidate, submission = contents.read(candidate, work)
    if submission is None:
        return TaskReader(SubmittedWork(candidate, None, candidate.name), {})
    content = content_key(sorted(submission.files.items()))
    work_of = SubmittedWork(candidate, read(submission.authors), content)
    return TaskReader(work_of, parts_of(_task(candidate, submission, settings)))


def task_of(candidate: Candidate, settings: Settings) -> Task:
    """Return the task of a candidate that can be read. Raises SubmissionError."""
    return _task(candidate, read_submission(candidate.path), settings)


def _task(candidate: Candidate, submission: Submission, settings: Settings) -> Task:
    around = {
        "missing": submission.missing,
        "refused": submission.refused,
        "sources": tuple(_shown(each, candidate.path) for each in submission.sources),
        "changed": submission.changed,
        "converted": submission.converted,
    }
    return Task(candidate.name, candidate.label, submission.files, around, settings)


def _shown(source: Source, path: Path) -> Source:
    """Return a source whose place is told from the submission on, not from the machine's root."""
    inside = source.path.removeprefix(f"{path} : ").removeprefix(os.path.normpath(path))
    return replace(source, path=inside.lstrip("/"))

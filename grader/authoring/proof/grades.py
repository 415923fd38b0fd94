"""Whole grades of programs made here, kept by their content, so that a long run goes on.

A kept grade is one of the same files, built in the same way, judged by the same checks and data.
How the code is run (builds, workers, isolation) decides nothing and is not looked at: `--again`
forgets all that is kept.
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from grader.authoring.specimens import patches
from grader.authoring.specimens.grading import results
from grader.checking.expected_data import FOLDER
from grader.course.exercises import CORE, MANIFEST, PACKAGE, load
from grader.course.message import GraderError
from grader.course.settings import COURSE
from grader.files import content_key
from grader.intake.originals import REFERENCE
from grader.report.results import write

# What decides on a mark, beside the data and the course's own C.
_JUDGES = ("checking", "checks", "evaluation")  # the packages that decide of points


class ProofError(GraderError):
    """A grade could not be made, by the machine's or the grader's fault: what, in one line."""


@dataclass(frozen=True)
class Program:
    """What is graded: the student's files by name, how they are built, and on which inputs."""

    id: str
    files: Mapping[str, str]
    flags: tuple[str, ...] = ()
    compiler: str = ""
    with_reference: bool = True  # without: as in a student's copy
    inputs: Path = FOLDER  # of expected data

    @cached_property
    def key(self) -> str:
        """What stands for its content, and for what judges it."""
        built = (self.flags, self.compiler, self.with_reference)
        fresh = [] if self.inputs == FOLDER else [manifest_of(self.inputs)]
        return content_key(sorted(self.files.items()), *built, judged_by(), *fresh)

    def results(self, cache: Path) -> dict[str, Any]:
        """Grade it; return the content of results.json. Raises ProofError."""
        submission = patches.submission(self.id, self.files)
        found = results(
            submission,
            cache,
            flags=self.flags,
            compiler=self.compiler,
            with_reference=self.with_reference,
            inputs=self.inputs,
        )
        if found["incomplete"]:
            errors = [each for each in found["checks"] if each["outcome"] == "error"]
            raise ProofError(f"{self.id}: {errors[0]['id']}: {errors[0]['message']}")
        return found


@dataclass(frozen=True)
class Grade:
    """What a program got: the content of results.json."""

    content: Mapping[str, Any]

    @property
    def score(self) -> float:
        """Points of the exercises that count and of the bonuses."""
        return float(self.content["score"] + self.content["bonus"])

    @property
    def missing(self) -> float:
        """What is missing of all the points that there are."""
        return sum(load().total(bonus=each) for each in (False, True)) - self.score

    @property
    def points(self) -> dict[str, float]:
        """Points by exercise."""
        return {each["id"]: each["points"] for each in self.content["exercises"]}

    @property
    def losing(self) -> frozenset[str]:
        """The exercises that did not get all their points."""
        rows = self.content["exercises"]
        return frozenset(each["id"] for each in rows if each["points"] < each["max_points"])

    @property
    def shares(self) -> dict[str, float]:
        """The share of its points that each exercise lost, by exercise; those that lost some."""
        rows = self.content["exercises"]
        return {
            each["id"]: 1 - each["points"] / each["max_points"]
            for each in rows
            if each["points"] < each["max_points"]
        }

    @property
    def named(self) -> dict[str, tuple[str, ...]]:
        """The mistakes recognised, by check."""
        rows = self.content["checks"]
        return {each["id"]: tuple(each["mistakes"]) for each in rows if each["mistakes"]}

    def lost(self) -> list[str]:
        """Return what each check that lost points says, in a line."""
        return [
            f"{each['id']} ({each['outcome']}): {each['message']}"
            for each in self.content["checks"]
            if each["points"] < each["max_points"]
        ]


@dataclass(frozen=True)
class GradeCache:
    """Where programs are graded: a folder for builds and for what is kept, and how many at once."""

    folder: Path
    jobs: int = 1

    def graded(self, programs: Iterable[Program]) -> Iterator[tuple[Program, Grade]]:
        """Yield each program with its grade, as they come. Raises ProofError."""
        waiting = []
        for each in programs:
            if (path := self.path(each)).is_file():
                yield each, Grade(json.loads(path.read_text(encoding="utf-8")))
            else:
                waiting.append(each)
        for program, content in self.each(waiting, self._builds):
            write(self.path(program), content)
            yield program, Grade(content)

    def each(
        self, programs: Sequence[Program], builds: Path
    ) -> Iterator[tuple[Program, dict[str, Any]]]:
        """Grade programs, in processes of their own when there are several at once."""
        if self.jobs == 1 or len(programs) < 2:
            yield from ((each, each.results(builds)) for each in programs)
            return
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(min(self.jobs, len(programs)), context) as pool:
            runs = {pool.submit(each.results, builds): each for each in programs}
            try:
                for done in as_completed(runs):
                    yield runs[done], done.result()
            finally:
                pool.shutdown(cancel_futures=True)

    def clean(self) -> None:
        """Remove the builds: six megabytes a program, whose grades are kept."""
        shutil.rmtree(self._builds, ignore_errors=True)

    @property
    def _builds(self) -> Path:
        return self.folder / "cache"

    def path(self, program: Program) -> Path:
        """Return where a program's grade is kept."""
        return self.folder / "grades" / f"{program.key}.json"


def manifest_of(inputs: Path) -> str:
    """Return what stands for a folder of expected data. Raises ProofError."""
    try:
        return (inputs / "manifest.json").read_text(encoding="utf-8")
    except OSError as error:
        raise ProofError(f"{error.filename}: {error.strerror}; run make prove again") from error


@lru_cache(maxsize=1)
def judged_by() -> str:
    """Return what stands for the checks and for the data that they compare with."""
    files = [FOLDER / "manifest.json", MANIFEST, COURSE]
    for package in _JUDGES:
        files += sorted((PACKAGE / package).rglob("*.py"))
    files += sorted((*CORE.glob("*.[ch]"), *REFERENCE.glob("*.[ch]")))
    digest = hashlib.sha256()
    for path in files:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()

"""The submissions of a class, graded: each once, and what the machine has failed at once more."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from rich.console import Console

from grader.batch.dependencies import WORDING
from grader.batch.progress import Meter
from grader.batch.records import Graded, GradedFiles, Settings, Task
from grader.batch.results_folder import ResultsFolder, StoredResult
from grader.batch.tasks import TaskReader, task_of
from grader.course.message import Message
from grader.course.texts import Texts

Run = Callable[[Iterable[Task]], Iterator[GradedFiles]]  # pool.run, cluster.run


@dataclass(frozen=True)
class ClassGrading:
    """Grades a class with `run`; `again`: what is known of it too.

    `settles`: what a machine fails at twice, although it grades others, has the mark of what was
    judged.
    """

    results: ResultsFolder
    run: Run
    settings: Settings
    again: bool = False
    settles: bool = True

    def grade(self, readings: Sequence[TaskReader], texts: Texts) -> dict[str, Graded]:
        """Return what is known of each candidate, by its name. Raises BatchError."""
        found = {each.candidate.name: self._known(each) for each in readings}
        todo = {
            each.candidate.name: each
            for each in readings
            if each.parts and found[each.candidate.name].results is None
        }
        meter = Meter(texts, len(todo), Console(file=sys.stderr))
        unsure: dict[str, TaskReader] = {}
        with self.results.writing(self.results.work), meter:
            for bundle in self.run(self._tasks(todo.values())):
                if bundle.incomplete:
                    unsure[bundle.name] = todo[bundle.name]
                    continue
                found[bundle.name] = own = self._kept(bundle, todo[bundle.name])
                meter.step(_has_failed(own))
            settled = bool(unsure) and self.settles and self._works(found.values(), readings)
            for bundle in self.run(self._tasks(unsure.values())) if unsure else ():
                found[bundle.name] = own = self._kept(bundle, unsure[bundle.name], settled)
                meter.step(_has_failed(own))
        return found | _suspicious([found[name] for name in todo])

    def _tasks(self, readings: Iterable[TaskReader]) -> Iterator[Task]:
        return (task_of(each.candidate, self.settings) for each in readings)

    def _known(self, reading: TaskReader) -> Graded:
        """Return what is kept of a submission, if it is still so; in today's words."""
        known = self.results.known(reading.candidate.name) if reading.parts else None
        if not known or not known.fresh or self.again:
            return Graded(reading.candidate)
        changed = {each for each in reading.parts if reading.parts[each] != known.parts.get(each)}
        if changed == {WORDING}:
            name = reading.candidate.name
            known = self.results.tell_again(name, known, reading.parts, self.settings)
        elif changed:
            return Graded(reading.candidate)
        return _graded(reading, known)

    def _kept(self, bundle: GradedFiles, reading: TaskReader, settled: bool = False) -> Graded:
        """Keep what grading gave; `settled`: the machine's failures count as the submission's."""
        if bundle.failure:
            self.results.verify()  # or all the others would fail too
            return Graded(reading.candidate, failure=bundle.failure, parts=reading.parts)
        kept = self.results.save(bundle, reading.parts, bundle.incomplete and settled)
        return _graded(reading, kept)

    def _works(self, found: Iterable[Graded], readings: Iterable[TaskReader]) -> bool:
        """Whether the machine can grade, now, a submission that it has graded; the quickest."""
        whole = [each for each in found if each.results and not each.results["incomplete"]]
        if not whole:
            return False
        name = min(whole, key=lambda each: each.seconds).candidate.name
        own = [each for each in readings if each.candidate.name == name]
        return not any(each.failure or each.incomplete for each in self.run(self._tasks(own)))


def _has_failed(graded: Graded) -> bool:
    if graded.results is None:
        return bool(graded.failure)
    return bool(graded.results["incomplete"]) and not graded.settled


def _suspicious(graded: Sequence[Graded]) -> dict[str, Graded]:
    """Return those at which the machine fails each time, while it grades most others, told so."""
    failed = [each for each in graded if _has_failed(each)]
    others = len(graded) - len(failed)
    if others <= len(failed):
        return {}
    remark = Message("batch.suspicious", {"count": others})
    return {
        each.candidate.name: replace(
            each, candidate=replace(each.candidate, remarks=(*each.candidate.remarks, remark))
        )
        for each in failed
    }


def _graded(reading: TaskReader, known: StoredResult) -> Graded:
    return Graded(
        reading.candidate,
        known.summary,
        parts=known.parts,
        seconds=known.seconds,
        cpu=known.cpu,
        settled=known.settled,
    )

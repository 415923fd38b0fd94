"""Judging later stages fairly: what failed is judged again among the reference's functions.

A check that did not pass may have failed because of another exercise, on which its own depends.
Where the reference is present it is run again with the reference's versions of those in the place
of the submission's. When it passes then, and one of them has failed a check of its own, the points
are earned and the finding says through what. Otherwise the fault is its own, or nobody else's: it
costs its points, and the finding says which function, replaced alone, mends it.

What runs beside the reference's code says only whether it is right: that code lies in the memory of
the submission's process, which may read it, print it and draw it. So nothing of such a run is kept
but its outcome; what is told and shown is always what the submission alone has answered and drawn.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from grader.build import substitution
from grader.checking.records import Evidence
from grader.checking.student import Student
from grader.course.exercises import Check, Manifest
from grader.course.message import Message
from grader.evaluation.records import Finding, Outcome
from grader.evaluation.rules import DONE_WRONG, at_fault, is_judged, settle
from grader.execution.libraries import Libraries
from grader.execution.library_set import NOT_LINKED

Again = Callable[[str, Student], Finding]  # runs a check, by its id, on another build


def attribute(
    findings: Sequence[Finding], rules: Manifest, libraries: Libraries, folder: Path, again: Again
) -> list[Finding]:
    """Return the findings, with what running them again says of those that failed.

    `folder` holds the expected data.
    """
    if not substitution.is_possible():
        return list(findings)
    with _Court(findings, rules, libraries, folder, again) as court:
        return court.hear()


class _Court:
    """The findings of a submission while they are judged again; a context manager."""

    def __init__(
        self,
        findings: Sequence[Finding],
        rules: Manifest,
        libraries: Libraries,
        folder: Path,
        again: Again,
    ) -> None:
        self._found = {each.check: each for each in findings}
        self._rules, self._libraries, self._folder, self._again = rules, libraries, folder, again
        self._unwritten = settle(findings, rules).unwritten
        self._stack = contextlib.ExitStack()
        self._lent: frozenset[str] = frozenset()  # functions of the libraries that stand ready
        self._looping: set[str] = set()  # exercises that do so among the reference's functions too

    def __enter__(self) -> _Court:
        return self

    def __exit__(self, *error: object) -> None:
        self._stack.close()

    def hear(self) -> list[Finding]:
        """Return the findings, in their order."""
        rules = self._rules
        # What needs fewer exercises first, and last what judges others' functions besides: whether
        # these are right is known when it is asked.
        order = sorted(
            (rules.checks()[name] for name in self._found),
            key=lambda check: (bool(check.judges), len(rules.needed(check)), check.exercise),
        )
        waiting = [check for check in order if self._is_open(check)]
        open_still = []
        for check in waiting:
            if self._libraries.budget.spent:  # what would run now would only be out of time
                break
            if guilty := self._guilty(check):
                self._retry(check, guilty)
            else:
                open_still.append(check)
        for check in open_still:
            self._look_for_another(check)
        return [self._blamed(each) for each in self._found.values()]

    def _is_open(self, check: Check) -> bool:
        finding = self._found[check.id]
        return check.exercise not in self._unwritten and is_judged(finding, check)

    def _guilty(self, check: Check) -> frozenset[str]:
        """Return the exercises that a check needs, if they are wrong by themselves so far."""
        settled = settle([*self._found.values()], self._rules).findings
        wrong = (each for each in settled if each.outcome in (*DONE_WRONG, Outcome.TODO))
        return self._rules.needed(check) & {self._exercise(each) for each in wrong}

    def _exercise(self, finding: Finding) -> str:
        return self._rules.checks()[finding.check].exercise

    def _retry(self, check: Check, guilty: frozenset[str]) -> None:
        """Run a check with the reference's versions of what is wrong, and settle it."""
        first = self._found[check.id]
        if not (names := self._replaced(check, guilty)):
            return
        if self._loops(first):
            self._found[check.id] = replace(first, alone=True)
            return
        second = self._run(check, names)
        if second.outcome is Outcome.PASSED:
            self._found[check.id] = _forgiven(first, second, guilty)
        else:
            self._found[check.id] = self._failed_again(check, second)

    def _look_for_another(self, check: Check) -> None:
        """Settle a failure for which no other exercise has failed a check of its own so far."""
        first, needed = self._found[check.id], self._rules.needed(check)
        names = self._replaced(check, needed)
        self._found[check.id] = replace(first, alone=True)
        if not names or self._loops(first):
            return
        second = self._run(check, names)
        if second.outcome is not Outcome.PASSED:
            self._found[check.id] = self._failed_again(check, second)
            return
        order = [each.id for each in self._rules.exercises if each.id in needed]
        for exercise in order:
            names = self._replaced(check, frozenset({exercise}))
            if names and self._run(check, names).outcome is Outcome.PASSED:
                if exercise in at_fault(self._found.values(), self._rules):
                    self._found[check.id] = _forgiven(first, second, frozenset({exercise}))
                else:
                    functions = ", ".join(sorted(names))
                    self._remark(check, Message("note.mended", {"functions": functions}))
                return
        self._remark(check, Message("note.mended_by_several"))

    def _remark(self, check: Check, remark: Message) -> None:
        finding = self._found[check.id]
        self._found[check.id] = replace(finding, remarks=(*finding.remarks, remark))

    def _run(self, check: Check, names: frozenset[str]) -> Finding:
        """Run a check again, with the reference's versions of these functions."""
        if names != self._lent:
            self._stack.close()
            self._mixed = self._stack.enter_context(self._libraries.mixed(names))
            self._lent = names
        own = self._rules.exercise(check.exercise).functions
        second = _sealed(self._again(check.id, Student(self._mixed, self._folder, own)))
        if second.outcome is Outcome.TIMEOUT:
            self._looping.add(check.exercise)
        return second

    def _replaced(self, check: Check, exercises: frozenset[str]) -> frozenset[str]:
        """Return the functions for which the reference's stand in when a check is run again.

        What the check judges beside its own exercise stays, unless that is wrong by itself. An
        exercise of which another one's function is judged besides, and is wrong, is wrong there.
        """
        wrong = at_fault(self._found.values(), self._rules)
        besides = {name for each in exercises for name in self._wrong_besides(each)}
        chosen = (exercises | besides) - (set(check.judges) - wrong)
        names = {name for each in chosen for name in self._rules.exercise(each).functions}
        return frozenset(names - judged(check, self._found, self._rules))

    def _wrong_besides(self, exercise: str) -> Iterator[str]:
        """Yield the exercises in whose functions one is used wrongly: its checks judge them too."""
        for each in self._rules.exercise(exercise).checks:
            found = self._found.get(each.id)
            if found and found.outcome is not Outcome.PASSED:
                yield from each.judges

    def _loops(self, finding: Finding) -> bool:
        """Say whether it would take as long again.

        The loop is in the exercise's own function, or in what the code does when loaded.
        """
        if finding.outcome is not Outcome.TIMEOUT:
            return False
        exercise = self._exercise(finding)
        values = finding.message.values if finding.message else {}
        own = self._rules.exercise(exercise).functions
        in_own = values.get("function") in own or values.get("call") == ""
        return in_own or exercise in self._looping

    def _failed_again(self, check: Check, second: Finding) -> Finding:
        """Return what a check has found that fails among the reference's functions too."""
        first, rules = self._found[check.id], self._rules
        if second.outcome is Outcome.ERROR:
            return second  # the machine's fault never becomes a mark
        if check.exercise in second.todo:
            return replace(first, todo=second.todo)
        guilty = rules.needed(check) & at_fault(self._found.values(), rules)
        own = judged(check, self._found, rules)
        shared = any(own & set(rules.exercise(each).functions) for each in guilty)
        if shared or (second.message and second.message.key == NOT_LINKED):
            return first  # what is at fault could not be replaced
        # What of a picture is right may now be the reference's own, or been so by chance before.
        share = min(first.evidence.share, second.evidence.share)
        evidence = replace(first.evidence, share=share)
        unseen = first.unseen or second.unseen
        return replace(
            first, alone=True, observations=second.observations, evidence=evidence, unseen=unseen
        )

    def _blamed(self, finding: Finding) -> Finding:
        """Return a finding that passed among the reference's functions with whose fault it is.

        Only now is it known which of the exercises that it needs are wrong in the end.
        """
        if not finding.through:
            return finding
        wrong = at_fault(self._found.values(), self._rules)
        needed = self._rules.needed(self._rules.checks()[finding.check])
        return replace(finding, through=tuple(sorted(needed & wrong or finding.through)))


def _sealed(second: Finding) -> Finding:
    """Return what may be known of a run beside the reference's code: no word, value or picture.

    What was wrong in its answers goes no further than to recognising a known mistake.
    """
    message = second.message
    if message and message.key != NOT_LINKED:
        kind = str(message.values.get("detail", "")).partition(":")[0]
        message = Message("failure.error", {"detail": kind})
    return replace(
        second,
        message=message,
        location="",
        output="",
        evidence=Evidence(second.evidence.share),
        remarks=(),
        pictures=(),
        candidates=(),
    )


def _forgiven(first: Finding, second: Finding, guilty: frozenset[str]) -> Finding:
    """Return a finding that passes once what is wrong is replaced; its own picture stays."""
    evidence = Evidence(images=first.evidence.images, places=first.evidence.places)
    through = tuple(sorted(guilty))
    return replace(second, through=through, seconds=first.seconds, evidence=evidence)


def judged(check: Check, found: Mapping[str, Finding], rules: Manifest) -> frozenset[str]:
    """Return the functions of its own exercise that a check judges, one of them at least.

    One that is wrong in another exercise need not be, once a check of its own has passed.
    """
    wrong = rules.needed(check) & at_fault(found.values(), rules)
    faulty = {name for each in wrong for name in rules.exercise(each).functions}
    own = frozenset(rules.exercise(check.exercise).functions)

    def is_proven(name: str) -> bool:
        proof = found.get(check.proven.get(name, ""))
        return proof is not None and proof.outcome is Outcome.PASSED

    kept = frozenset(name for name in own if name not in faulty or not is_proven(name))
    return kept or own

"""Whose fault a failure is: what is judged, what is still to be written, and what waits for what.

A check waits only for an exercise that right code calls in it, that comes before its own or in the
same TP, on the way from the first exercise to the last: what comes later, and the bonuses, are
switched off in it. Who crashes, loops or writes where nothing is to be written is never told to
wait, unless it happens inside a function that is already known to be wrong.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace

from grader.course.exercises import Check, Manifest
from grader.evaluation.records import Finding, Outcome

DONE_WRONG = (Outcome.FAILED, Outcome.CRASHED, Outcome.TIMEOUT)
_ENDED = (Outcome.CRASHED, Outcome.TIMEOUT)
# The function was never judged: its question would lead astray.
_BESIDE = (
    *("failure.missing", "failure.not_built", "failure.not_linked", "failure.unreadable"),
    *("failure.error", "failure.expected", "death.missing_symbol"),
)


@dataclass(frozen=True)
class Settled:
    """What the findings mean beside one another.

    `findings` have the outcome that they have in the end, in their order; `waits` has, by check,
    the exercises that a blocked one waits for, in the order of the course; `unwritten` are those
    whose own marker was met.
    """

    findings: tuple[Finding, ...]
    waits: dict[str, tuple[str, ...]]
    unwritten: frozenset[str]


def settle(findings: Sequence[Finding], rules: Manifest) -> Settled:
    """Say of each failure whether it is to be done, to be looked at, or waits for another.

    The checks of functions convict first, those that call the fewest others before the rest; then
    the pictures, in the order of the course. So of exercises that might blame each other the first
    one on the way of a ray is at fault, and only what is wrong by itself is ever waited for.
    """
    judge = _Judge(findings, rules)
    for each in sorted(findings, key=judge.turn):
        judge.hear(each)
    return Settled(
        tuple(replace(each, outcome=judge.outcomes[each.check]) for each in findings),
        judge.waits,
        judge.unwritten,
    )


def is_learnt(finding: Finding) -> bool:
    """Whether a check passes on the inputs of the archive, and not on others."""
    return finding.unseen and finding.outcome in DONE_WRONG


def at_fault(findings: Iterable[Finding], rules: Manifest) -> frozenset[str]:
    """Return the exercises of which a check did not pass."""
    checks = rules.checks()
    wrong = (each for each in findings if each.outcome is not Outcome.PASSED)
    return frozenset(checks[each.check].exercise for each in wrong)


def unwritten(findings: Iterable[Finding], rules: Manifest) -> frozenset[str]:
    """Return the exercises whose own marker was met where a check did not pass."""
    checks = rules.checks()
    wrong = (each for each in findings if each.outcome is not Outcome.PASSED)
    return frozenset(
        checks[each.check].exercise for each in wrong if checks[each.check].exercise in each.todo
    )


def is_judged(finding: Finding, check: Check) -> bool:
    """Say whether a check failed of which the exercise is written, and could be called."""
    failed = finding.outcome in DONE_WRONG
    return failed and check.exercise not in finding.todo and not is_beside(finding)


def is_beside(finding: Finding) -> bool:
    """Whether what is wrong has nothing to do with what the check's question is about."""
    return finding.message is not None and finding.message.key in _BESIDE


class _Judge:
    """Hears the findings one after the other, and convicts exercises."""

    def __init__(self, findings: Sequence[Finding], rules: Manifest) -> None:
        self.outcomes: dict[str, Outcome] = {}
        self.waits: dict[str, tuple[str, ...]] = {}
        self.unwritten = unwritten(findings, rules)
        self._rules = rules
        self._order = [each.id for each in rules.exercises]
        # Of two that write in one function, the first.
        self._by_function = {
            name: each.id for each in reversed(rules.exercises) for name in each.functions
        }
        self._asked = {rules.checks()[each.check].exercise for each in findings}
        self._deadly = frozenset(filter(None, map(self._dies_by_itself, findings)))
        self._wrong: dict[str, set[Outcome]] = {}  # exercises that are wrong by themselves

    def turn(self, finding: Finding) -> tuple[bool, bool, bool, int, int]:
        """Return the place of a finding among those to hear."""
        check = self._rules.checks()[finding.check]
        return (
            not finding.alone,
            check.is_picture,
            bool(check.judges),
            0 if check.is_picture else len(self._rules.waited_for(check) | {*check.blames}),
            self._order.index(check.exercise),
        )

    def hear(self, finding: Finding) -> None:
        """Settle a finding."""
        check = self._rules.checks()[finding.check]
        outcome = finding.outcome
        if outcome not in (Outcome.PASSED, Outcome.ERROR):
            if check.exercise in finding.todo or self._shows_nothing_yet(finding, check):
                outcome = Outcome.TODO
            elif suspects := self._suspects(finding, check):
                is_todo = check.exercise in self.unwritten
                outcome = Outcome.TODO if is_todo else Outcome.BLOCKED
                self.waits[check.id] = tuple(sorted(suspects, key=self._order.index))
            else:
                self._wrong.setdefault(check.exercise, set()).add(outcome)
        self.outcomes[check.id] = outcome

    def _shows_nothing_yet(self, finding: Finding, check: Check) -> bool:
        """Say whether a picture does without a function, still to be written, that it is to show.

        As when trace_ray returns the kd of what is hit, and never asks for a light.
        """
        unwritten = check.is_picture and check.exercise in self.unwritten
        return unwritten and finding.outcome is Outcome.FAILED

    def _suspects(self, finding: Finding, check: Check) -> set[str]:
        """Return the exercises that may be the cause of a failure."""
        if finding.alone or is_beside(finding):
            return set()
        allowed = self._rules.waited_for(check)
        wrong = (allowed | {*check.blames}) & self._wrong.keys()
        if finding.outcome in _ENDED:
            return self._enders(finding, check, wrong)
        # A marker counts that was met here, of an exercise that is not right all the same.
        missing = {each for each in finding.todo if each not in self._asked - self.unwritten}
        return set(allowed & missing | wrong)

    def _enders(self, finding: Finding, check: Check, wrong: Collection[str]) -> set[str]:
        """Return the exercises, of those that are wrong, in which code did not come back.

        Of a crash, the function of an exercise that is nearest to it; a loop, and calls without
        end, go through others, so there any of the calls. Where no call is known, exercises that
        end so themselves. A function that crashes when it is judged by itself is to be looked at
        first wherever it is called: also one that comes later, as octree_free, which every change
        of scene calls.
        """
        if (nearest := self._nearest(finding)) in self._deadly - {check.exercise}:
            return {nearest}
        names = _calls(finding)
        own = self._rules.exercise(check.exercise).functions
        callers = {
            name: {each for each in wrong if name in self._rules.exercise(each).functions}
            for name in names
        }
        if finding.outcome is Outcome.TIMEOUT or _is_recursion(finding):
            found = set[str]().union(*callers.values())
        else:
            found = next((callers[each] for each in names if callers[each] or each in own), set())
        if found or any(each in own for each in names):
            return found
        return {each for each in wrong if self._wrong[each] & {*_ENDED}}

    def _dies_by_itself(self, finding: Finding) -> str:
        """Return the exercise of a check of functions that crashed in one of its own, or ""."""
        check = self._rules.checks()[finding.check]
        died = finding.outcome is Outcome.CRASHED and not check.is_picture
        return check.exercise if died and self._nearest(finding) == check.exercise else ""

    def _nearest(self, finding: Finding) -> str:
        """Return the exercise of the function that is nearest to a crash; "" when none is.

        Of calls that go round through several exercises without end, none is nearer.
        """
        if finding.outcome is not Outcome.CRASHED:
            return ""
        names = [each for each in _calls(finding) if each in self._by_function]
        found = list(dict.fromkeys(self._by_function[each] for each in names))
        return found[0] if found and not (len(found) > 1 and _is_recursion(finding)) else ""


def _calls(finding: Finding) -> list[str]:
    """Return the functions that were being called when code did not come back, the last first."""
    calls = finding.message.values.get("calls") if finding.message else None
    return [name for name, _ in calls] if isinstance(calls, Sequence) else []


def _is_recursion(finding: Finding) -> bool:
    return finding.message is not None and finding.message.key == "death.recursion"

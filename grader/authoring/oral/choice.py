"""Which questions are asked: the same ones for the same code, spread over the exercises."""

from __future__ import annotations

import hashlib
import random
from collections.abc import Collection, Iterator, Mapping, Sequence

from grader.authoring.oral import matching, tracing
from grader.authoring.oral.records import Change, Question, Swapped, Traced
from grader.authoring.oral.trials import ENOUGH, Laboratory, is_begun
from grader.authoring.specimens import mistakes
from grader.course import exercises as manifest
from grader.course.exercises import Exercise
from grader.evaluation.records import CheckResult, Outcome
from grader.intake.records import Submission

MOST_TRIALS = 16  # changes that are put in, at most, for one set of questions
MOST_UNSEEN = 1  # questions whose change is seen in no picture, while there are others

Results = Mapping[str, CheckResult]


def choose(laboratory: Laboratory, count: int, tp: int | None = None) -> list[Question]:
    """Return so many questions, or fewer: on lines that change, then on values.

    They are of one TP, or of all. Empty when no exercise is written.
    """
    rng = random.Random(seed(laboratory.submission))
    # The pictures of a later TP depend on what is written of the others.
    results = laboratory.program.checks(1 if tp == 1 else None)
    exercises = _begun(laboratory, results)
    begun = {each.id for each in exercises}
    asked = _in_turn([each for each in exercises if tp in (None, each.tp)], results, rng)
    lines = _on_lines(laboratory, asked, begun, results, count, rng)
    done = {each.change.mistake.exercise for each in lines}
    asked.sort(key=lambda each: each.id in done)  # what is not asked about yet comes first
    return [*lines, *_on_values(laboratory, asked, count - len(lines), rng)]


def seed(submission: Submission) -> int:
    """Return the number that the choice depends on: that of the code itself."""
    digest = hashlib.sha256()
    for name, content in sorted(submission.files.items()):
        digest.update(b"%s %d " % (name.encode("utf-8", "surrogateescape"), len(content)) + content)
    return int.from_bytes(digest.digest()[:8], "big")


# ---- Exercises ----------------------------------------------------------------------------------


def _begun(laboratory: Laboratory, results: Results) -> list[Exercise]:
    """Return the exercises that are written, compile, and come back from their calls."""
    rejected = laboratory.libraries.rejected
    return [
        each
        for each in manifest.load().exercises
        if (own := _own(each, results)) and is_begun(own) and each.file not in rejected
    ]


def _own(exercise: Exercise, results: Results) -> list[CheckResult]:
    return [results[each.id] for each in exercise.checks if each.id in results]


def _in_turn(exercises: Sequence[Exercise], results: Results, rng: random.Random) -> list[Exercise]:
    """Return the exercises in the order in which they are asked about: one of each TP in turn.

    Within a TP what is finished comes first, then the bonuses, then what has no known mistake.
    """
    known = {each.exercise for each in mistakes.load()}
    by_tp: dict[int, list[Exercise]] = {}
    for each in rng.sample(exercises, len(exercises)):
        by_tp.setdefault(each.tp, []).append(each)
    for row in by_tp.values():
        row.sort(
            key=lambda each: (each.id not in known, each.bonus, not _is_finished(each, results))
        )
    longest = max(map(len, by_tp.values()), default=0)
    return [row[k] for k in range(longest) for row in by_tp.values() if k < len(row)]


def _is_finished(exercise: Exercise, results: Results) -> bool:
    return all(each.outcome is Outcome.PASSED for each in _own(exercise, results))


# ---- Questions ----------------------------------------------------------------------------------


def _on_lines(
    laboratory: Laboratory,
    exercises: Sequence[Exercise],
    begun: Collection[str],
    results: Results,
    count: int,
    rng: random.Random,
) -> list[Swapped]:
    """Return questions on changed lines, each of another line; what is seen comes first."""
    waiting = [_changes(each, laboratory.submission, results, rng) for each in exercises]
    found: list[Swapped] = []
    spare: list[Swapped] = []
    trials = unseen = 0
    while waiting and len(found) < count and trials < MOST_TRIALS:
        changes = waiting.pop(0)
        asked = {name for each in (*found, *spare) for name in _subject(each.change)}
        change = next((each for each in changes if not asked & _subject(each)), None)
        if change is None:
            continue
        waiting.append(changes)
        trials += 1
        question = laboratory.tried(change, results, begun)
        if question is not None:
            unseen += not _is_seen(question)
            (found if _is_seen(question) or unseen <= MOST_UNSEEN else spare).append(question)
    return [*found, *spare][:count]


def _subject(change: Change) -> set[str]:
    """Return what no other question is about: its line, and its kind of mistake.

    The mistakes of one kind have names that differ by their first word only.
    """
    return {change.place.at, change.mistake.id.partition("_")[2]}


def _is_seen(question: Swapped) -> bool:
    return question.sight is not None and question.sight.changed >= ENOUGH


def _changes(
    exercise: Exercise, submission: Submission, results: Results, rng: random.Random
) -> Iterator[Change]:
    """Yield the changes of an exercise's lines, those of a single line first.

    What the code has wrong already, and what no check that passes would see, is left out.
    """
    named = {name for each in _own(exercise, results) for name in each.mistakes}
    found: list[Change] = []
    for mistake in mistakes.load():
        right = [results[name] for name in mistake.shows if name in results]
        if mistake.exercise != exercise.id or mistake.id in named:
            continue
        if any(each.outcome is Outcome.PASSED for each in right):
            found += matching.changes(submission, mistake)[:1]
    rng.shuffle(found)
    found.sort(key=lambda each: each.place.text.count("\n") + each.new.count("\n"))
    yield from found


def _on_values(
    laboratory: Laboratory, exercises: Sequence[Exercise], count: int, rng: random.Random
) -> list[Traced]:
    """Return questions on values, one for each exercise that has some."""
    found: list[Traced] = []
    for each in exercises:
        if len(found) >= count:
            break
        traced = tracing.traced(each.id, laboratory.submission, laboratory.libraries, rng)
        found += [traced] if traced else []
    return found

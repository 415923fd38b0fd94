"""Two hundred classes at random against the truth: no wrong mark, no wrong person, no silence.

For every person of the worksheet: a mark that is their own work's; no submission, when nothing was
handed in; or no mark, and the reason. Nothing is compiled: the desk alone is tried.
"""

from __future__ import annotations

import json
import zipfile

import pytest

from grader.batch import csv_table
from grader.batch.names import letters_of
from grader.console.run import ExitCode
from grader.tests.batch import generated
from grader.tests.batch.desk_class import Desk, Laid
from grader.tests.batch.generated import HARMLESS, SCALE, Drawn, Student
from grader.tests.support.sampling import sampled

CLASSES = 200


@pytest.mark.parametrize("seed", sampled(range(CLASSES), range(0, CLASSES, 10)))
def test_no_wrong_mark_no_wrong_person_no_silence(a_class: Laid, seed: int) -> None:
    """Of each class, each person: by the truth that made the class."""
    drawn = generated.draw(seed)
    top = generated.lay(drawn, a_class.folder)
    done = a_class.run(archive="" if top.is_dir() else top.name)
    assert done.status == ExitCode.DONE, done.said
    sent, told = done.sent(), remarks(done)
    wrong = [
        f"{each.name} ({each.participant}): {fault}"
        for each in drawn.students
        if (fault := judged(drawn, each, sent[str(each.participant)], told[str(each.participant)]))
    ]
    wrong += [
        f"not told: {word}" for work in drawn.works for word in work.told if not said(done, word)
    ]
    wrong += pages(drawn, done)
    assert wrong == []


def judged(drawn: Drawn, student: Student, sent: str, told: str) -> str:
    """Return what is wrong with the outcome of a person; "" when nothing is."""
    right = drawn.expected(student)
    if not sent:
        if not told:
            return "no mark, and no reason"
        clean = student.works and not student.perils - HARMLESS and not _entangled(drawn, student)
        return f"no mark ({told}), and nothing is amiss" if clean else ""
    mark = (csv_table.number(sent) or 0.0) * SCALE / drawn.maximum
    if not any(each is not None and abs(each - mark) < 0.04 for each in right):
        return f"{mark} instead of {right} ({told})"
    return "" if mark or told else "0, and no reason"


def _entangled(drawn: Drawn, student: Student) -> bool:
    """Whether the facts of somebody else may keep a person from their mark.

    A twin, a name like theirs, a number that another has written, or a partner's slip.
    """
    names = [each.name for each in drawn.students]
    others = {author for work in student.works for author in work.authors} - {student}
    twin = names.count(student.name) > 1
    likeness = any(word in student.name for word in ("Dupon", "Wei"))
    partner = len({id(work.sender) for work in student.works} - {id(student)}) > 0
    slips = {"name", "nobody", "other", "none", "twice", "unwritable"}
    borrowed = any("other" in each.perils for each in drawn.students)
    return bool(
        twin
        or likeness
        or borrowed
        or (partner and not drawn.numbered)
        or any(each.perils & slips for each in others)
    )


def remarks(done: Desk) -> dict[str, str]:
    """Return the remarks of grades.csv by participant."""
    sheet = csv_table.read(done.out / "grades.csv")
    at = {name: k for k, name in enumerate(sheet.header)}
    return {row[at["participant"]]: row[at["remarks"]] for row in sheet.rows}


def said(done: Desk, word: str) -> bool:
    """Say whether a word is told, in the terminal or in grades.csv."""
    return word in done.said or word in (done.out / "grades.csv").read_text(encoding="utf-8-sig")


def pages(drawn: Drawn, done: Desk) -> list[str]:
    """Return whose feedback is not of a work of theirs."""
    wrong = []
    people = {str(each.participant): each for each in drawn.students}
    with zipfile.ZipFile(done.out / "moodle" / "feedback.zip") as archive:
        for path in archive.namelist():
            number = path.split("_")[1]
            names = {*map(sorted_letters, json.loads(archive.read(path))[0].split(", "))}
            if drawn.team:
                theirs = [each for each in drawn.works if each.number == number]
            else:
                theirs = people[number].works
            own = [[author.name for author in each.authors] for each in theirs]
            if not any(names <= {*map(sorted_letters, _parts(each))} for each in own):
                wrong.append(f"page of {sorted(names)} for {number}")
    return wrong


def sorted_letters(name: str) -> str:
    """Return what a name and a slip of the pen in it share."""
    return "".join(sorted(letters_of(name)))


def _parts(names: list[str]) -> list[str]:
    """Return names, and the parts of those that hold a comma."""
    return [*names, *(part for name in names for part in name.split(", "))]

"""Classes drawn at random that know the truth: who has handed in what, and what it is worth.

Twins, slips of the pen, groups, renamed files, encodings, maxima, extensions, in every mixture.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path
from zoneinfo import ZoneInfo

from grader.tests.batch.desk_class import deflated_64, locked, packed, submission
from grader.tests.batch.moodle_site import HEADERS, HIDDEN, ZONE, Site

SIZE = 20
DUE = datetime(2026, 3, 2, 23, 59)
EXTENDED = datetime(2026, 3, 9, 23, 59)
SCALE = 20.0
NAMES = (
    *("Ada Lovelace", "Grace Hopper", "Alan Turing", "Marie Dupont", "Marie Dupond", "Wei Li"),
    *("Li Wei", "Zoé Lefèvre-D'Aubigné", "Jean-Baptiste O’Connor", 'Marie "Mimi" Dupont'),
    *("José María García Pérez", "Łukasz Żółć", "Çağla Öztürk", "Thị Minh Anh Nguyễn"),
    *("John, Jr. Smith", "Éloïse Dupuis", "X Æ A-12 Musk", "محمد أحمد", "=HYPERLINK(A1) Test"),
    *("Emmy Noether", "Sofia Kovalevskaïa", "Srinivasa Ramanujan", "Évariste Galois"),
    *("Hypatie d'Alexandrie", "Leonhard Euler", "Carl Gauß", "Jean Martin_Test", "Luc Vide"),
)
HARMLESS = frozenset(("nested", "renamed", "extra", "turned", "late", "extension", "override"))


@dataclass(eq=False)
class Student:
    """A person of the class, and the truth about them."""

    participant: int
    name: str
    number: str
    group: str = ""
    handed: datetime | None = None  # as the worksheet has it
    extension: bool = False
    override: bool = False
    online: bool = False
    works: list[Work] = field(default_factory=list)  # theirs
    perils: set[str] = field(default_factory=set)  # what may keep them from a mark


@dataclass(eq=False)
class Work:
    """A submission: whose it is, what it is worth, and how it lies in the archive."""

    sender: Student
    worth: float
    files: dict[str, str | bytes]
    authors: list[Student]
    label: str = ""
    number: str = ""
    handed: datetime = DUE
    lies: Callable[[dict[str, str | bytes]], dict[str, str | bytes]] = dict
    readable: bool = True
    told: list[str] = field(default_factory=list)  # words that must be said of it


@dataclass
class Drawn:
    """A class: its people, its submissions, and what stands beside them."""

    seed: int
    random: random.Random
    students: list[Student]
    works: list[Work] = field(default_factory=list)
    language: str = "en"
    maximum: float = SCALE
    layout: str = "folders"  # of Moodle; "flat", or "plain": folders of any name
    team: bool = False
    numbered: bool = True  # the worksheet has the students' numbers
    absent: float | None = None
    encoding: str = "utf-8"
    delimiter: str = ","

    def expected(self, student: Student) -> set[float | None]:
        """Return the marks that are right: none is among them only where nothing is."""
        if not student.works and not student.handed and not student.online:
            return {self.absent}
        return {self._mark(student, work) for work in student.works if work.readable}

    def _mark(self, student: Student, work: Work) -> float:
        due = EXTENDED if student.extension or student.override else DUE
        days = max(0, -((due + timedelta(minutes=15) - work.handed) // timedelta(days=1)))
        return max(0.0, SCALE * work.worth - days)


def draw(seed: int) -> Drawn:
    """Return the class of that number."""
    dice = random.Random(seed)
    names = dice.sample(NAMES, SIZE - 2)
    names += dice.sample(names, 2) if dice.random() < 0.6 else ["Solo Un", "Solo Deux"]  # twins
    numbers = [str(21_900_000 + each) for each in dice.sample(range(10_000), SIZE)]
    participants = dice.sample(range(100, 130), SIZE)
    drawn = Drawn(
        *(seed, dice),
        [Student(*each) for each in zip(participants, names, numbers, strict=True)],
        language=dice.choice(("fr", "en")),
        maximum=dice.choice((20.0, 20.0, 100.0, 10.0, 7.0)),
        layout=dice.choice(("folders", "folders", "flat", "plain")),
        numbered=dice.random() < 0.85,
        absent=dice.choice((None, 0.0)),
    )
    drawn.team = drawn.layout != "plain" and dice.random() < 0.2
    drawn.encoding, drawn.delimiter = dice.choice(
        (("utf-8", ","), ("utf-8-sig", ","), ("utf-16", "\t"), ("utf-8", ";"), ("sep", ";"))
    )
    (_in_groups if drawn.team else _alone_or_in_pairs)(drawn)
    for student in drawn.students:
        if not student.works and dice.random() < 0.2:
            student.online, student.handed = True, DUE - timedelta(days=1)
    return drawn


def _in_groups(drawn: Drawn) -> None:
    dice, left, group = drawn.random, list(drawn.students), 100
    while left:
        people = [left.pop() for _ in range(min(len(left), dice.randint(1, 3)))]
        group += 1
        if dice.random() < 0.15:
            for each in people:  # nobody has handed in
                each.group = f"Binôme {group}"
            continue
        work = _work(drawn, people[0], people)
        work.label, work.number = f"Binôme {group}", str(group)
        for each in people:
            each.group, each.handed = work.label, work.handed
        _name_authors(drawn, work)


def _alone_or_in_pairs(drawn: Drawn) -> None:
    dice, left = drawn.random, list(drawn.students)
    while left:
        sender = left.pop()
        if dice.random() < 0.15:
            continue
        partners = [left.pop()] if left and dice.random() < 0.3 else []
        work = _work(drawn, sender, [sender, *partners])
        work.label, work.number = sender.name, str(sender.participant)
        sender.handed = work.handed
        _name_authors(drawn, work)
        if partners and dice.random() < 0.2:
            _again(drawn, partners[0], work)


def _again(drawn: Drawn, partner: Student, work: Work) -> None:
    """Have the partner hand in too: the same work, or another one."""
    same = drawn.random.random() < 0.5
    files = dict(work.files) if same else submission(0.35, also=f"again {partner.number}")
    second = Work(partner, work.worth if same else 0.35, dict(files), [partner])
    second.label, second.number = partner.name, str(partner.participant)
    second.handed, second.lies = work.handed, work.lies if same else dict
    second.readable = work.readable if same else True
    if not same:
        second.files.pop("AUTEURS.txt", None)
    partner.handed = second.handed
    partner.works.append(second)
    partner.perils.add("twice")
    work.sender.perils.add("twice")
    drawn.works.append(second)


def _work(drawn: Drawn, sender: Student, people: list[Student]) -> Work:
    dice = drawn.random
    worth = dice.choice([0.0, *(k / 20 for k in range(1, 21))])
    work = Work(sender, worth, dict(submission(worth, also=sender.number)), people)
    late = dice.choice((0, 0, 0, 0, 1, 4))
    work.handed = DUE - timedelta(hours=2) + timedelta(days=late)
    for each in people:
        each.works.append(work)
        if dice.random() < 0.15:
            setattr(each, dice.choice(("extension", "override")), True)
    drawn.works.append(work)
    _files(drawn, work)
    return work


# How the files of a submission lie in the archive, by what has become of them.
LIES: dict[str, Callable[[dict[str, str | bytes]], dict[str, str | bytes]]] = {
    "packed": lambda files: {"r.zip": packed(files)},
    "nested": lambda files: {"r.zip": packed({"deep/core.zip": packed(files)})},
    "locked": lambda files: {"r.zip": locked(packed(files))},
    "d64": lambda files: {"r.zip": deflated_64(packed(files))},
    "rar": lambda files: {"rendu.rar": b"Rar!"},
}
UNREADABLE = ("locked", "d64", "rar")
RENAMED = ("main (1).c", "main - Copie.c", "main 2.c", "main.c.txt")


def _files(drawn: Drawn, work: Work) -> None:
    """Change the files of a submission, as browsers, systems and persons do."""
    dice = drawn.random
    kind = dice.choice(("", "", "", "", "", "packed", "renamed", "extra", *LIES))
    work.lies = LIES.get(kind, dict)
    if kind == "renamed":
        name = dice.choice(RENAMED)
        work.files[name] = work.files.pop("main.c")
        work.told.append(name)
    elif kind == "extra":
        name = f"notes-{work.sender.number}.pdf"
        work.files[name] = "%PDF"
        work.told.append(name)
    elif kind in UNREADABLE:
        work.readable = False
        for each in work.authors:
            each.perils.add(kind)


def _name_authors(drawn: Drawn, work: Work) -> None:
    """Write AUTEURS.txt: right, with a slip of the pen, with a number of somebody else, or none."""
    dice = drawn.random
    if dice.random() < 0.25 and (len(work.authors) == 1 or drawn.team) and drawn.layout != "plain":
        return
    lines = [_author(drawn, work, each) for each in work.authors]
    work.files["AUTEURS.txt"] = "".join(f"Nom, Prénom, numéro : {line}\n" for line in lines)


def _author(drawn: Drawn, work: Work, student: Student) -> str:
    surname, first = student.name.split()[-1], " ".join(student.name.split()[:-1])
    number = student.number
    slip = drawn.random.choice(("", "", "", "", "", "turned", "name", "nobody", "other", "none"))
    if slip == "turned":
        surname, first = first, surname
    elif slip == "name" and len(surname) > 4:
        surname = surname[0] + surname[2] + surname[1] + surname[3:]
    elif slip == "nobody":
        number = f"99{number[2:]}"
    elif slip == "other":
        number = _borrowed(drawn, student, work)
    elif slip == "none":
        number = ""
    student.perils |= {slip} - {"", "turned"}
    if re.search(r"\d|,", student.name):
        student.perils.add("unwritable")  # no name that AUTEURS.txt can hold
    return f"{surname}, {first}, {number}".replace('"', "")


def _borrowed(drawn: Drawn, student: Student, work: Work) -> str:
    """Return the number of somebody else; of a twin only where the folder says who it is."""
    twins = [each for each in drawn.students if each.name == student.name and each is not student]
    if twins and drawn.layout != "plain" and student is work.sender:
        return twins[0].number
    return drawn.random.choice([each for each in drawn.students if each not in twins]).number


# ---- What the desk gets -------------------------------------------------------------------------


def lay(drawn: Drawn, folder: Path) -> Path:
    """Write a class; return what to give as its submissions."""
    entries = dict(_entries(drawn))
    top = folder / "all.zip"
    if drawn.layout == "plain":
        top = folder
        for name, content in entries.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    else:
        top.write_bytes(packed({**entries, "__MACOSX/._x": "", ".DS_Store": ""}))
    (folder / "w.csv").write_bytes(_worksheet(drawn))
    absent = "" if drawn.absent is None else f"[people]\nabsent = {drawn.absent:g}\n"
    rules = "[deadlines]\nTP5 = 2026-03-02T23:59:00\n[late]\nper_day = 1\nmost = 20\n"
    (folder / "course.toml").write_text(f"{rules}grace_minutes = 15\n{absent}", encoding="utf-8")
    return top


def _entries(drawn: Drawn) -> Iterator[tuple[str, str | bytes]]:
    for k, work in enumerate(drawn.works):
        clean = "".join(each for each in work.label if each not in "\"'&<>|`:\\/").replace("_", " ")
        place = f"{clean}_{work.number}_assignsubmission_file"
        if drawn.layout == "plain":
            place = f"rendu {k}" if drawn.random.random() < 0.5 else f"{clean} ({k})"
        for name, content in work.lies(work.files).items():
            yield f"{place}{'_' if drawn.layout == 'flat' else '/'}{name}", content


def _worksheet(drawn: Drawn) -> bytes:
    site = Site(drawn.language, drawn.maximum, drawn.team)
    header = [
        each for each in HEADERS[drawn.language] if drawn.team or each not in ("Group", "Groupe")
    ]
    header.insert(5, "Date limite" if drawn.language == "fr" else "Due date")
    at = header.index("Numéro d’identification" if drawn.language == "fr" else "ID number")
    rows = [header, *(_row(drawn, site, each) for each in drawn.students)]
    if not drawn.numbered:
        rows = [row[:at] + row[at + 1 :] for row in rows]
    quoted = [['"' + cell.replace('"', '""') + '"' for cell in row] for row in rows]
    text = "".join(drawn.delimiter.join(row) + "\r\n" for row in quoted)
    if drawn.encoding == "sep":
        return f"\ufeffsep={drawn.delimiter}\r\n{text}".encode()
    return text.encode(drawn.encoding)


def _row(drawn: Drawn, site: Site, student: Student) -> list[str]:
    def date(moment: datetime | None) -> str:
        return site.date(moment.replace(tzinfo=ZoneInfo(ZONE)).timestamp() if moment else None)

    french = drawn.language == "fr"
    status = "Remis pour évaluation" if french else "Submitted for grading"
    if student.extension:
        granted = "Prolongation accordée jusqu’au : " if french else "Extension granted until: "
        status += f" - {granted}{date(EXTENDED)}"
    cells = [
        *(f"{HIDDEN[drawn.language]}{student.participant}", student.name, "a@example.invalid"),
        *(student.number, status, date(EXTENDED if student.override else DUE)),
        *([student.group] if drawn.team else []),
        *(
            "",
            f"{drawn.maximum:.2f}".replace(".", "," if french else "."),
            "Oui" if french else "Yes",
        ),
    ]
    return [*cells, date(student.handed), "un texte" if student.online else "", "-", ""]

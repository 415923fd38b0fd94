"""A Moodle site in small: the worksheets that it gives, and its importers (moodle_site.php)."""

from __future__ import annotations

import base64
import csv
import io
import json
import os
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any
from zipfile import ZipFile
from zoneinfo import ZoneInfo

import pytest

from grader.batch import csv_table

SCRIPT = Path(__file__).with_suffix(".php")
ZONE = "Europe/Paris"
HEADERS = {
    "en": [
        *("Identifier", "Full name", "Email address", "ID number", "Status", "Group", "Grade"),
        *("Maximum grade", "Grade can be changed", "Last modified (submission)", "Online text"),
        *("Last modified (grade)", "Feedback comments"),
    ],
    "fr": [
        *("Identifiant", "Nom complet", "Adresse de courriel", "Numéro d’identification"),
        *("Statut", "Groupe", "Note", "Note maximale", "La note peut être modifiée"),
        *("Dernière modification (travail remis)", "Texte en ligne"),
        *("Dernière modification (note)", "Feedback par commentaires"),
    ],
}
HIDDEN = {"en": "Participant ", "fr": "Participant"}
DAYS = {
    "en": ("Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday"),
    "fr": ("lundi", "mardi", "mercredi", "jeudi", "vendredi", "samedi", "dimanche"),
}
MONTHS = {
    "en": (
        *("January", "February", "March", "April", "May", "June", "July", "August"),
        *("September", "October", "November", "December"),
    ),
    "fr": (
        *("janvier", "février", "mars", "avril", "mai", "juin", "juillet", "août"),
        *("septembre", "octobre", "novembre", "décembre"),
    ),
}


@dataclass
class Person:
    """A participant, as the site knows them; dates are seconds since the epoch."""

    name: str
    number: str = ""
    submitted: float | None = None
    group: int | None = None  # its id
    group_name: str = ""
    status: str = ""
    online: str = ""
    grade: float | None = None
    modified: float | None = None
    locked: bool = False
    comment: str = ""


@dataclass
class Site:
    """An assignment of a site: participants by their number."""

    language: str = "fr"
    maximum: float = 20.0
    team: bool = False
    now: float = 1_780_000_000.0
    people: dict[str, Person] = field(default_factory=dict)

    def worksheet(self, delimiter: str = ",") -> str:
        """Return the grading worksheet, as it is downloaded now."""
        out = io.StringIO(newline="")
        writer = csv.writer(out, delimiter=delimiter, lineterminator="\n")
        header = HEADERS[self.language]
        skipped = () if self.team else (header.index("Groupe" if "Groupe" in header else "Group"),)
        writer.writerow([each for at, each in enumerate(header) if at not in skipped])
        for number, person in self.people.items():
            row = self._row(number, person)
            writer.writerow([each for at, each in enumerate(row) if at not in skipped])
        return out.getvalue()

    def _row(self, number: str, person: Person) -> list[str]:
        yes, no = ("Oui", "Non") if self.language == "fr" else ("Yes", "No")
        grade = "" if person.grade is None else self._number(person.grade)
        return [
            *(f"{HIDDEN[self.language]}{number}", person.name, "a@example.invalid", person.number),
            *(person.status, person.group_name, grade, self._number(self.maximum)),
            *(no if person.locked else yes, self.date(person.submitted), person.online),
            *(self.date(person.modified), person.comment),
        ]

    def _number(self, value: float) -> str:
        text = f"{value:.2f}"
        return text.replace(".", ",") if self.language == "fr" else text

    def date(self, seconds: float | None) -> str:
        """Return a date as the site writes it for a person."""
        if seconds is None:
            return "-"
        moment = datetime.fromtimestamp(seconds, ZoneInfo(ZONE))
        day, month = DAYS[self.language][moment.weekday()], MONTHS[self.language][moment.month - 1]
        if self.language == "fr":
            return f"{day} {moment.day} {month} {moment.year}, {moment:%H:%M}"
        half = "AM" if moment.hour < 12 else "PM"
        clock = f"{moment.hour % 12 or 12}:{moment.minute:02d} {half}"
        return f"{day}, {moment.day} {month} {moment.year}, {clock}"

    def upload(self, *uploads: dict[str, Any]) -> list[dict[str, Any]]:
        """Import files in order; return what became of each of their rows or paths."""
        asked = {
            "site": {
                **{"language": self.language, "maximum": self.maximum, "timezone": ZONE},
                **{"team": self.team, "now": self.now},
            },
            "people": {number: vars(each) for number, each in self.people.items()},
            "uploads": uploads,
        }
        done = subprocess.run(
            [php(), str(SCRIPT)],
            input=json.dumps(asked),
            capture_output=True,
            text=True,
            timeout=60,
            check=True,
        )
        answer = json.loads(done.stdout)
        self.people = {number: Person(**each) for number, each in answer["people"].items()}
        self.now += 60 * len(uploads)
        outcomes: list[dict[str, Any]] = answer["outcomes"]
        return outcomes


def php() -> str:
    """Return the interpreter; skips the test where there is none."""
    found = shutil.which("php")
    if not found:
        assert not os.environ.get("MRT_CI"), "CI must have php"
        pytest.skip("php is missing (Debian's package php-cli)")
    return found


def sheet(content: bytes, separator: str = ",") -> dict[str, Any]:
    """Return the upload of a worksheet, in the form's own encoding."""
    return {
        **{"kind": "worksheet", "content": base64.b64encode(content).decode()},
        "separator": separator,
    }


def files(archive: Path) -> dict[str, Any]:
    """Return the upload of feedback.zip."""
    with ZipFile(archive) as opened:
        return {"kind": "feedback", "paths": opened.namelist()}


def taken(outcome: dict[str, Any]) -> Sequence[str]:
    """Return whose grades an upload of a worksheet has changed."""
    return [number for number, what in outcome.items() if what == "taken"]


def assert_arrives(path: Path) -> None:
    """Upload a filled worksheet to a site that has its people: each mark in it must be taken.

    Nothing is asked where there is no PHP, or of a language that the importer does not play.
    """
    lines = csv_table.read(path)
    language = next((each for each, names in HEADERS.items() if names[0] == lines.header[0]), "")
    if not shutil.which("php") or not language:
        return
    names = dict(zip(HEADERS["en"], HEADERS[language], strict=True))
    at = {key: lines.header.index(name) for key, name in names.items() if name in lines.header}
    site, marks = Site(language), {}
    for cells in lines.rows:
        number = cells[at["Identifier"]].removeprefix(HIDDEN[language])
        site.people[number] = Person(number)
        site.maximum = csv_table.number(cells[at["Maximum grade"]]) or site.maximum
        if (mark := csv_table.number(cells[at["Grade"]])) is not None:
            marks[number] = mark
    (outcome,) = site.upload(sheet(path.read_bytes(), lines.delimiter))
    assert {*taken(outcome)} == {*marks}
    assert {name: site.people[name].grade for name in marks} == marks

"""Moodle's grading worksheet and feedback archive, read back by rules written from its importer's.

The importer takes commas or what the teacher says, finds its columns by their headers in the site's
language, reads the number behind "Participant", and passes over what is out of range.
"""

from __future__ import annotations

import csv
import io
import zipfile
from datetime import datetime
from pathlib import Path

import pytest

from grader.batch import moodle_worksheet
from grader.batch.records import BatchError, Mark, Member

HEADERS = {
    "en": [
        *("Identifier", "Full name", "ID number", "Email address", "Status", "Grade"),
        *("Maximum grade", "Grade can be changed", "Last modified (submission)"),
        *("Last modified (grade)", "Feedback comments"),
    ],
    "fr": [
        *("Identifiant", "Nom complet", "Numéro d'identification", "Adresse de courriel", "Statut"),
        *("Note", "Note maximale", "La note peut être modifiée"),
        *("Dernière modification (travail remis)", "Dernière modification (note)"),
        *("Feedback par commentaires",),
    ],
}
HANDED = {"en": "Monday, 2 March 2026, 11:47 PM", "fr": "lundi 2 mars 2026, 23:47"}
YES = {"en": "Yes", "fr": "Oui"}
DECIMAL = {"en": ".", "fr": ","}


def worksheet(
    path: Path, language: str, delimiter: str = ",", bom: bool = False, most: str = "20"
) -> Path:
    """Write a worksheet of three people, the third of whom has a grade."""
    out = io.StringIO(newline="")
    writer = csv.writer(out, delimiter=delimiter, lineterminator="\r\n")
    writer.writerow([*HEADERS[language], "Autre, inconnue"])
    for number, name, grade in (("101", "Ada", ""), ("102", 'Zoë "Z" Noël', ""), ("103", "B", "7")):
        graded = HANDED[language] if grade else "-"
        cells = [f"Participant {number}", name, f"2190{number}", "a@b.fr", "=état", grade, most]
        cells += [YES[language], HANDED[language], graded, "<p>ancien</p>" if grade else "", "à, b"]
        writer.writerow(cells)
    path.write_bytes((b"\xef\xbb\xbf" if bom else b"") + out.getvalue().encode())
    return path


def imported(content: bytes, language: str, delimiter: str) -> dict[int, tuple[float, str]]:
    """Read a worksheet as the importer does; return grade and feedback by participant."""
    text = content.decode("utf-8-sig")
    header, *rows = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    names = HEADERS[language]
    at = {name: header.index(name) for name in (names[0], names[5], names[9], names[10])}
    found = {}
    for row in rows:
        participant = int(row[at[names[0]]][len("Participant ") :])
        grade = row[at[names[5]]].replace(DECIMAL[language], ".")
        if grade == "" or not 0 <= float(grade) <= float(row[6].replace(",", ".")):
            continue
        found[participant] = (float(grade), row[at[names[10]]])
    return found


MARKS = [
    Mark(Member("Ada", moodle="101", submission="ada"), 18.25, comment="=1+1 <b>bien</b>"),
    Mark(Member("Zoë", moodle="102", submission="zoe"), None),
    Mark(Member("B", moodle="103", submission="b"), 9.5),
    Mark(Member("Sans", submission="x"), 20.0),
]


@pytest.mark.parametrize("language", ["fr", "en"])
@pytest.mark.parametrize(("delimiter", "bom"), [(",", False), (";", True)])
def test_a_worksheet_is_filled_in_place(
    tmp_path: Path, language: str, delimiter: str, bom: bool
) -> None:
    """Marks where they belong, in the site's decimals; every other cell as it was."""
    path = worksheet(tmp_path / "notes.csv", language, delimiter, bom)
    before = path.read_bytes()
    content, told = moodle_worksheet.filled(moodle_worksheet.read(path), MARKS)
    assert imported(content, language, delimiter) == {
        101: (18.25, "'=1+1 &lt;b&gt;bien&lt;/b&gt;"),
        103: (9.5, "<p>ancien</p>"),
    }
    assert content.startswith(b"\xef\xbb\xbf") is bom
    old, new = before.decode("utf-8-sig"), content.decode("utf-8-sig")
    assert old.count("\r\n") == new.count("\r\n")
    rows = [list(csv.reader(io.StringIO(each), delimiter=delimiter)) for each in (old, new)]
    changed = {
        (line, column)
        for line, (a, b) in enumerate(zip(*rows, strict=True))
        for column, (x, y) in enumerate(zip(a, b, strict=True))
        if x != y
    }
    assert changed == {(1, 5), (1, 10), (3, 5)}
    assert [each.key for each in told] == ["batch.row_changed"]
    assert path.read_bytes() == before


def test_marks_are_cut_at_the_maximum_and_told(tmp_path: Path) -> None:
    """A worksheet out of 10: what Moodle would pass over is cut, and listed with its line."""
    path = worksheet(tmp_path / "notes.csv", "fr", most="10,00")
    content, told = moodle_worksheet.filled(moodle_worksheet.read(path), MARKS)
    assert imported(content, "fr", ",")[101][0] == 10.0
    assert [(each.key, each.values["line"]) for each in told] == [
        ("batch.row_cut", 2),
        ("batch.row_changed", 4),
    ]
    assert b'"10,00"' in content


def test_a_locked_row_is_told(tmp_path: Path) -> None:
    """Moodle says itself which grades can no longer be changed."""
    path = worksheet(tmp_path / "notes.csv", "fr")
    path.write_text(path.read_text(encoding="utf-8").replace("Oui", "Non"), encoding="utf-8")
    _, told = moodle_worksheet.filled(moodle_worksheet.read(path), MARKS)
    assert [each.key for each in told] == ["batch.row_locked", "batch.row_locked"]


@pytest.mark.parametrize(
    ("text", "moment"),
    [
        ("lundi 2 mars 2026, 23:47", datetime(2026, 3, 2, 23, 47)),
        ("dimanche 1er février 2026, 08:05", datetime(2026, 2, 1, 8, 5)),
        ("Monday, 2 March 2026, 11:47 PM", datetime(2026, 3, 2, 23, 47)),
        ("Monday, 2 March 2026, 12:05 AM", datetime(2026, 3, 2, 0, 5)),
        ("Monday, March 2, 2026, 9:05 AM", datetime(2026, 3, 2, 9, 5)),
        ("Montag, 2. März 2026, 23:47", None),
        ("31 février 2026, 08:05", None),
    ],
)
def test_dates_in_both_languages(text: str, moment: datetime | None) -> None:
    """As Moodle writes them; others are no date."""
    assert moodle_worksheet.read_moment(text) == moment


def test_who_handed_in_when_and_who_is_enrolled(tmp_path: Path) -> None:
    """By Moodle's number."""
    read = moodle_worksheet.read(worksheet(tmp_path / "notes.csv", "en"))
    assert set(read.handed.items()) == {
        (number, datetime(2026, 3, 2, 23, 47)) for number in ("101", "102", "103")
    }
    assert next((each.moodle, each.number) for each in read.enrolled) == ("101", "2190101")


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("a,b\n1,2\n", "batch.not_a_worksheet"),
        ("Identifier,Grade\nParticipant 1,\nParticipant 1,\n", "batch.worksheet_twice"),
    ],
)
def test_a_wrong_worksheet_is_named(tmp_path: Path, text: str, key: str) -> None:
    """With the cure; a date that is not understood too, since lateness hangs on it."""
    path = tmp_path / "notes.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BatchError) as caught:
        moodle_worksheet.read(path)
    assert caught.value.key == key
    worksheet(path, "fr")
    path.write_text(path.read_text(encoding="utf-8").replace("mars", "März"), encoding="utf-8")
    with pytest.raises(BatchError) as caught:
        assert moodle_worksheet.read(path).handed
    assert (caught.value.key, caught.value.values["line"]) == ("batch.worksheet_date", 2)


def test_feedback_goes_to_whom_its_folder_says(tmp_path: Path) -> None:
    """Name, number, plugin: split at underscores, of which a name has none left."""
    (tmp_path / "report.html").write_text("<p>", encoding="utf-8")
    name = moodle_worksheet.folder_name("Éloïse_d'Été", "101")
    moodle_worksheet.write_feedback(tmp_path / "feedback.zip", {name: tmp_path})
    with zipfile.ZipFile(tmp_path / "feedback.zip") as archive:
        (path,) = archive.namelist()
    part, rest = path.split("/")
    info = part.split("_", 4)
    assert (info[1:], rest) == (["101", "assignsubmission", "file", ""], "report.html")
    assert not (tmp_path / "feedback.part").exists()

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

from grader.batch import csv_table, moodle_files, moodle_worksheet
from grader.batch.moodle_dates import read_moment
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
    filled = moodle_files.filled(moodle_worksheet.read(path), MARKS, 20)
    content = filled.content
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
    # The grade, its date, the comment; the date is one that every site reads.
    assert changed == {(1, 5), (1, 9), (1, 10), (3, 5), (3, 9)}
    assert (rows[1][1][9], rows[1][2][9], rows[1][3][9]) == (
        "2026-03-02 23:47",
        "-",
        "2026-03-02 23:47",
    )
    assert [each.key for each in filled.told] == ["batch.row_changed"]
    assert filled.told[0].values["before"] == "7"
    assert path.read_bytes() == before


@pytest.mark.parametrize(("most", "expected"), [("100,00", 91.25), ("10,00", 9.13), ("20", 18.25)])
def test_marks_are_converted_to_the_worksheets_maximum(
    tmp_path: Path, most: str, expected: float
) -> None:
    """Moodle's default is 100: 18.25 of 20 is 91.25 there; one line says so."""
    path = worksheet(tmp_path / "notes.csv", "fr", most=most)
    filled = moodle_files.filled(moodle_worksheet.read(path), MARKS, 20)
    assert imported(filled.content, "fr", ",")[101][0] == expected
    told = [each for each in filled.told if each.key == "batch.converted"]
    assert [each.values for each in told] == (
        [] if most == "20" else [{"scale": 20, "most": most[:-3]}]
    )
    assert filled.grades["101"] == f"{expected:.2f}".replace(".", ",")


def test_a_locked_row_is_told(tmp_path: Path) -> None:
    """Moodle says itself which grades can no longer be changed."""
    path = worksheet(tmp_path / "notes.csv", "fr")
    path.write_text(path.read_text(encoding="utf-8").replace("Oui", "Non"), encoding="utf-8")
    filled = moodle_files.filled(moodle_worksheet.read(path), MARKS, 20)
    assert [each.key for each in filled.told] == ["batch.row_locked", "batch.row_locked"]


def test_a_comment_of_ours_goes_when_there_is_none_any_more(tmp_path: Path) -> None:
    """Lateness that an extension has excused; what somebody has written in Moodle stays."""
    path = worksheet(tmp_path / "notes.csv", "fr")
    read = moodle_worksheet.read(path)
    for before, after in (({"103": "<p>ancien</p>"}, ""), ({"103": "autre"}, "<p>ancien</p>")):
        filled = moodle_files.filled(read, MARKS, 20, before)
        assert imported(filled.content, "fr", ",")[103] == (9.5, after)


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
        ("2026-03-02 23:47", datetime(2026, 3, 2, 23, 47)),
        ("-", None),
    ],
)
def test_dates_in_both_languages(text: str, moment: datetime | None) -> None:
    """As Moodle writes them; others are no date."""
    assert read_moment(text) == moment


def test_who_handed_in_when_and_who_is_enrolled(tmp_path: Path) -> None:
    """In the worksheet's order, by Moodle's number."""
    read = moodle_worksheet.read(worksheet(tmp_path / "notes.csv", "en"))
    assert [(each.moodle, each.number, each.handed, each.row) for each in read.enrolled] == [
        (number, f"2190{number}", datetime(2026, 3, 2, 23, 47), row)
        for row, number in enumerate(("101", "102", "103"))
    ]
    assert [(each.key, each.values) for each in read.unused()] == [
        ("batch.unused_columns", {"names": "Email address, Autre, inconnue"})
    ]


STATUSES = {
    "Remis pour évaluation - En retard de 10 min - Noté -  - ": (None, True, False),
    "Pas de travail remis - Le devoir est en retard de 272 jours -  - ": (None, False, False),
    "Brouillon (non remis) -  - ": (None, False, True),
    "Submitted for grading - 1 day 2 hours late -  - ": (None, True, False),
    "No submission - Assignment is overdue by: 272 days -  - ": (None, False, False),
    "Draft (not submitted) -  - ": (None, False, True),
    "Remis pour évaluation - Prolongation accordée jusqu’au : lundi 9 mars 2026, 23:59 -  - ": (
        *(datetime(2026, 3, 9, 23, 59), False, False),
    ),
    "Submitted for grading - Extension granted until: Monday, 9 March 2026, 11:59 PM - ": (
        *(datetime(2026, 3, 9, 23, 59), False, False),
    ),
}


@pytest.mark.parametrize(("status", "facts"), STATUSES.items())
def test_what_the_status_says(
    tmp_path: Path, status: str, facts: tuple[datetime | None, bool, bool]
) -> None:
    """An extension, lateness, a draft; what is overdue is not late."""
    path = worksheet(tmp_path / "notes.csv", "fr")
    text = path.read_text(encoding="utf-8").replace("=état", f'"{status}"')
    path.write_text(text, encoding="utf-8")
    person = moodle_worksheet.read(path).enrolled[0]
    assert (person.extended, person.late, person.draft) == facts


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("a,b\n1,2\n", "batch.not_a_worksheet"),
        ("Identifier,Grade\nParticipant 1,\nParticipant 1,\n", "batch.worksheet_twice"),
        ("Identifier,Grade\nNobody,\n", "batch.worksheet_nobody"),
        ("Identifier,Grade,Scale\nParticipant 1,,Bien\n", "batch.scale_of_words"),
        ("Identifier,Grade,Maximum grade\nParticipant 1,,A  B  C\n", "batch.scale_of_words"),
        (
            "Identificador,Nombre,Estado,Calificación,Máxima,Fecha\nParticipante7,A,x,,20,-\n",
            "batch.worksheet_language",
        ),
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
        assert moodle_worksheet.read(path).enrolled
    assert (caught.value.key, caught.value.values["line"]) == ("batch.worksheet_date", 2)


def test_feedback_goes_to_whom_its_folder_says(tmp_path: Path) -> None:
    """Name, number, plugin: split at underscores, of which a name has none left."""
    name = moodle_files.folder_name("Éloïse_d'Été", "101")
    moodle_files.write_feedback(tmp_path / "feedback.zip", {name: b"<p>"})
    with zipfile.ZipFile(tmp_path / "feedback.zip") as archive:
        (path,) = archive.namelist()
    part, rest = path.split("/")
    info = part.split("_", 4)
    assert (info[1:], rest) == (["101", "assignsubmission", "file", ""], "report.html")
    assert not (tmp_path / "feedback.part").exists()


@pytest.mark.parametrize(
    ("content", "delimiter", "line"),
    [
        ("\ufeff{}".encode(), ",", 2),
        ("\ufeff{}".encode("utf-16-le"), "\t", 2),
        ("\ufeff{}".encode("utf-16-be"), ";", 2),
        ("{}".encode("utf-16-le"), ";", 2),
        ("{}".encode("cp1252"), ";", 2),
        ("\ufeffsep=;\r\n{}".encode(), ";", 3),
        ("sep=\t\r\n{}".encode("cp1252"), "\t", 3),
        (b'"sep=;"\r\n{}', ";", 3),
    ],
)
def test_tables_of_every_spreadsheet_are_read(
    tmp_path: Path, content: bytes, delimiter: str, line: int
) -> None:
    """UTF-16 with tabs, the line sep=, Windows' letters; what is written back is UTF-8."""
    encoding = "utf-16-be" if b"\0{" in content else "utf-16-le" if b"{\0" in content else "cp1252"
    if content.startswith(b"\xef\xbb\xbf") or b'"sep' in content:
        encoding = "utf-8"
    table = "Identifiant;Note;Numéro d’identification\r\nParticipant1;;Zoé\r\n".replace(
        ";", delimiter
    )
    path = tmp_path / "notes.csv"
    path.write_bytes(content.replace("{}".encode(encoding), table.encode(encoding)))
    sheet = csv_table.read(path)
    assert sheet.header == ("Identifiant", "Note", "Numéro d’identification")
    assert (sheet.rows, sheet.lines, sheet.delimiter) == (
        *((("Participant1", "", "Zoé"),), (line,), delimiter),
    )
    assert csv_table.column(sheet.header, moodle_worksheet.COLUMNS["number"]) == 2
    back = csv_table.written(sheet)
    assert b"\0" not in back
    assert b"sep=" not in back
    assert back.decode("utf-8-sig") == table


def test_tables_beside_the_submissions(tmp_path: Path) -> None:
    """A worksheet in any language is one; another table is told; ours and manual.csv are known."""
    worksheet(tmp_path / "a.csv", "fr")
    foreign = "Identificador,Nombre,Estado,Nota,Fecha\nParticipante7,A,x,,-\n"
    (tmp_path / "b.csv").write_text(foreign, encoding="utf-8")
    (tmp_path / "oral.csv").write_text("nom;note\nAda;12\n", encoding="utf-8")
    (tmp_path / "empty.csv").touch()
    (tmp_path / "manual.csv").touch()
    found, others = moodle_worksheet.beside(tmp_path, ("manual.csv",))
    assert [each.name for each in found] == ["a.csv", "b.csv"]
    assert [each.name for each in others] == ["empty.csv", "oral.csv"]

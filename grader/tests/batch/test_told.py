"""What a class is given besides its marks: pages, comments, reasons, pseudonyms, one folder."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

from grader.batch import csv_table
from grader.batch.results_folder import ResultsFolder
from grader.console.run import ExitCode
from grader.tests.batch.desk_class import Laid, packed, row, submission, table

FILE = "assignsubmission_file"
LATE = {"Last modified (submission)": "Tuesday, 3 March 2026, 10:00 PM"}
RULES = "[deadlines]\nTP1 = 2026-03-02T23:59:00\n[late]\nper_day = 2\nmost = 20\n"


def test_lateness_stands_on_the_page_and_in_the_comment(a_class: Laid) -> None:
    """Under the authors' real names; of a pair each page has its own delay."""
    authors = "Lovelace, Ada, 21900001\nHopper, Grace, 21900002"
    a_class.archive({f"Ada Lovelace_1_{FILE}/r.zip": packed(submission(1, authors))})
    rows = [row(1, "Ada Lovelace", "21900001", **LATE)]
    rows.append(row(2, "Grace Hopper", "21900002", **{"Last modified (submission)": "-"}))
    a_class.write("w.csv", table(rows))
    extension = '[people]\nextensions = { "21900002" = 2026-03-09T12:00:00 }\n'
    a_class.write("course.toml", RULES + extension)
    done = a_class.run()
    assert done.sent() == {"1": "18.00", "2": "20.00"}
    pages = {}
    with zipfile.ZipFile(done.out / "moodle" / "feedback.zip") as archive:
        for name in archive.namelist():
            pages[name.split("_")[1]] = json.loads(archive.read(name))
    assert pages == {
        "1": ["Ada Lovelace, Grace Hopper", "Late: 1 d, -2."],
        "2": ["Ada Lovelace, Grace Hopper"],
    }
    own = done.out / "students" / "Ada Lovelace_1" / "report.html"
    assert json.loads(own.read_text(encoding="utf-8")) == [
        *("Ada Lovelace, Grace Hopper", "Ada Lovelace : Late: 1 d, -2."),
    ]
    sheet = csv_table.read(done.out / "moodle" / "w.csv")
    comments = [
        cells[csv_table.column(sheet.header, ("feedback comments",))] for cells in sheet.rows
    ]
    assert comments == ["Late: 1 d, -2.", ""]
    a_class.write("course.toml", RULES.replace("per_day = 2", "per_day = 3") + extension)
    again = a_class.run()
    assert "18 -> 17 (scale changed (course.toml), lateness changed)" in again.said
    assert "-3." in own.read_text(encoding="utf-8")


def test_the_reason_of_a_change_is_the_true_one(a_class: Laid) -> None:
    """A manual entry, a setting of the person, a date of the worksheet."""
    a_class.archive({f"Ada_1_{FILE}/r.zip": packed(submission(1))})
    a_class.write("w.csv", table([row(1, "Ada", "21900001")]))
    a_class.write("course.toml", RULES)
    assert a_class.run().marks() == {"Ada 1": 20}
    a_class.write("manual.csv", "who;override;reason\nAda;12;oral\n")
    assert "Ada : 20 -> 12 (manual entry changed (manual.csv))" in a_class.run().said
    (a_class.folder / "manual.csv").unlink()
    a_class.run()
    a_class.write("course.toml", f'{RULES}[people]\nexcused = ["Ada"]\n')
    assert "Ada : 20 -> - (the person's setting changed ([people]))" in a_class.run().said
    a_class.write("course.toml", RULES)
    a_class.run()
    a_class.write("w.csv", table([row(1, "Ada", "21900001", **LATE)]))
    assert "Ada : 20 -> 18 (lateness changed, grading worksheet changed)" in a_class.run().said


def test_one_class_for_each_folder_of_results(a_class: Laid) -> None:
    """Another class is refused and nothing changes; the same one may grow and shrink."""
    for name, people in (("one.zip", "ABC"), ("two.zip", "DEF"), ("more.zip", "ABCG")):
        entries = {f"{each}da_{ord(each)}_{FILE}/r.zip": packed(submission(1)) for each in people}
        a_class.archive(dict(entries), name)
    assert a_class.run(archive="one.zip").status == ExitCode.DONE
    before = (a_class.folder.parent / "out" / "grades.csv").read_bytes()
    other = a_class.run(archive="two.zip")
    assert other.status == ExitCode.FAILED
    assert "holds the results of another class (that of Ada)" in other.said
    assert (other.out / "grades.csv").read_bytes() == before
    assert sorted(path.name for path in (other.out / "students").iterdir()) == [
        *("Ada_65", "Bda_66", "Cda_67"),
    ]
    assert a_class.run(archive="more.zip").status == ExitCode.DONE


def test_pseudonyms_say_nothing(tmp_path: Path) -> None:
    """Their order is not that of the names; they stay, and are others in another folder."""
    names = [f"Élève {number:02d}" for number in range(40)]
    with ResultsFolder(tmp_path / "out") as results:
        first = results.pseudonyms(names)
        few = results.pseudonyms(names[5:9])
    with ResultsFolder(tmp_path / "out") as results:
        assert results.pseudonyms(names) == first
    with ResultsFolder(tmp_path / "other") as results:
        others = results.pseudonyms(names)
    assert sum(others[name] == first[name] for name in names) < 5  # of a million codes
    assert few == {name: first[name] for name in names[5:9]}
    assert len(set(first.values())) == 40
    assert sorted(first.values()) != [first[name] for name in names]


def test_namesakes_are_told_apart(a_class: Laid) -> None:
    """By their numbers, in the terminal and on the page; the page has titles, not ids."""
    a_class.archive({f"Marie Dupont_{k}_{FILE}/r.zip": packed(submission(0)) for k in (7, 8)})
    a_class.write("w.csv", table([row(k, "Marie Dupont", f"2190000{k}") for k in (7, 8)]))
    done = a_class.run("--names")
    page = (done.out / "index.html").read_text(encoding="utf-8")
    for number in ("21900007", "21900008"):
        assert f"Marie Dupont ({number}) : Mark 0." in done.said
        assert f"Marie Dupont ({number})" in page


def test_a_line_of_manual_csv_about_two_is_refused(a_class: Laid) -> None:
    """Two absent namesakes, or a number that is another's participant number."""
    rows = [row(k, "Marie Dupont", n) for k, n in ((11, "21900007"), (8, "11"))]
    a_class.archive({f"Ada_1_{FILE}/r.zip": packed(submission(1))})
    a_class.write("w.csv", table([*rows, row(1, "Ada", "21900001")]))
    for who in ("Marie Dupont", "11"):
        a_class.write("manual.csv", f"who;override;reason\n{who};12;oral\n")
        done = a_class.run()
        assert done.status == ExitCode.FAILED
        assert f'several people are called "{who}"' in done.said

"""Marks and pages go through Moodle's importers and back, as on a real site.

The importers are ours, in PHP, after the rules of grader/batch/MOODLE.md; without PHP these tests
are skipped.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from grader.batch import moodle_files, moodle_worksheet
from grader.batch.moodle_files import Filled
from grader.batch.records import Mark, Member
from grader.tests.batch.desk_class import Laid, packed, submission
from grader.tests.batch.moodle_site import Person, Site, files, php, sheet, taken

HANDED = 1_772_488_740.0 + 37  # 2 March 2026, 22:59:37 in Paris
NAMES = ("Ada Lovelace", "Zoé Lefèvre-D'Aubigné", 'Marie "Mimi" Dupont', "=HYPERLINK(A1)", "محمد")


@pytest.fixture(autouse=True)
def _php() -> None:
    php()


def site(language: str = "fr", people: int = 20, **settings: object) -> Site:
    """Return a site where all but the last have handed in."""
    made = Site(language, **settings)  # type: ignore[arg-type]
    for k in range(1, people + 1):
        submitted = HANDED + 1000 * k if k < people else None
        made.people[str(k)] = Person(f"{NAMES[k % len(NAMES)]} {k}", f"2190{k:04d}", submitted)
    return made


def given(to: Site, first: float = 1.0, comment: str = "") -> list[Mark]:
    """Return marks: each a quarter more than the one before."""
    return [
        Mark(Member(each.name, moodle=number), min(20, first + 0.25 * k), comment=comment)
        for k, (number, each) in enumerate(to.people.items())
    ]


def filled(folder: Path, to: Site, marks: list[Mark], delimiter: str = ",") -> Filled:
    """Return the site's worksheet, as it is now, with marks."""
    path = folder / "notes.csv"
    path.write_text(to.worksheet(delimiter), encoding="utf-8")
    return moodle_files.filled(moodle_worksheet.read(path), marks, 20)


@pytest.mark.parametrize("language", ["fr", "en"])
@pytest.mark.parametrize("maximum", [20.0, 100.0, 10.0])
def test_every_mark_arrives(tmp_path: Path, language: str, maximum: float) -> None:
    """With its comment, out of the site's own maximum."""
    to = site(language, maximum=maximum)
    marks = given(to, comment='=1+1 "été", <b>; bien')
    (outcome,) = to.upload(sheet(filled(tmp_path, to, marks).content))
    assert len(taken(outcome)) == 20
    assert [each.grade for each in to.people.values()] == pytest.approx(
        [(each.value or 0) * maximum / 20 for each in marks], abs=0.0051
    )
    assert {each.comment for each in to.people.values()} == {'\'=1+1 "été", &lt;b&gt;; bien'}


def paths(to: Site) -> dict[str, object]:
    """Return the upload of everybody's page."""
    names = [moodle_files.folder_name(each.name, number) for number, each in to.people.items()]
    return {"kind": "feedback", "paths": [f"{name}/report.html" for name in names]}


def test_the_order_of_the_two_uploads(tmp_path: Path) -> None:
    """The worksheet first: all arrives. The pages first: who has handed in nothing is skipped.

    Without the date in our copy it would be everybody.
    """
    first = site()
    copy = sheet(filled(tmp_path, first, given(first)).content)
    outcome, pages = first.upload(copy, paths(first))
    assert (len(taken(outcome)), sum(map(len, pages.values()))) == (20, 20)
    second = site()
    _, outcome = second.upload(paths(second), copy)
    assert [number for number, what in outcome.items() if what == "stale"] == ["20"]
    assert len(taken(outcome)) == 19
    third = site()
    bare = filled(tmp_path, third, given(third)).content.decode()
    undated = re.sub(r",2026-\d\d-\d\d \d\d:\d\d,", ",-,", bare)
    _, outcome = third.upload(paths(third), sheet(undated.encode()))
    assert taken(outcome) == []


@pytest.mark.parametrize("language", ["fr", "en"])
def test_a_second_time(tmp_path: Path, language: str) -> None:
    """Grades that were there are replaced; what was changed since the download is protected."""
    to = site(language)
    to.upload(sheet(filled(tmp_path, to, given(to)).content), paths(to))
    to.now += 3600
    again = filled(tmp_path, to, given(to, first=2.0))
    assert [each.key for each in again.told] == ["batch.row_changed"] * 20
    to.now += 3600
    to.people["5"] = replace(to.people["5"], grade=19.0, modified=to.now)
    (outcome,) = to.upload(sheet(again.content))
    assert outcome["5"] == "stale"
    assert len(taken(outcome)) == 19
    assert to.people["5"].grade == 19.0


def test_a_french_site_does_not_read_its_own_dates(tmp_path: Path) -> None:
    """What the worksheet has, left as it is, would skip every row that has a grade."""
    to = site("fr")
    to.upload(sheet(filled(tmp_path, to, given(to)).content))
    left = to.worksheet().replace('"1,', '"3,')
    (outcome,) = to.upload(sheet(left.encode()))
    assert {what for number, what in outcome.items() if what != "same"} == {"stale"}


@pytest.mark.parametrize(
    ("delimiter", "encoding"), [(",", "utf-8"), (";", "utf-8"), (";", "cp1252"), ("\t", "utf-16")]
)
def test_whatever_saved_the_worksheet(tmp_path: Path, delimiter: str, encoding: str) -> None:
    """With the separator that is told, and the form's own encoding: all goes back as UTF-8."""
    to = site()
    path = tmp_path / "notes.csv"
    text = (
        to.worksheet(delimiter).replace("محمد", "Mohamed")
        if encoding == "cp1252"
        else to.worksheet(delimiter)
    )
    path.write_bytes(text.encode(encoding))
    content = moodle_files.filled(moodle_worksheet.read(path), given(to), 20).content
    (outcome,) = to.upload(sheet(content, delimiter))
    assert len(taken(outcome)) == 20


def test_locked_rows_and_marks_that_are_none(tmp_path: Path) -> None:
    """A locked row is told and skipped; who has no mark keeps what is there."""
    to = site()
    to.people["3"].locked = True
    marks = [
        replace_value(each, None if each.member.moodle == "4" else each.value) for each in given(to)
    ]
    copy = filled(tmp_path, to, marks)
    (outcome,) = to.upload(sheet(copy.content))
    assert (outcome["3"], outcome["4"], len(taken(outcome))) == ("locked", "empty", 18)
    assert [each.key for each in copy.told] == ["batch.row_locked"]


def replace_value(mark: Mark, value: float | None) -> Mark:
    """Return a mark with another value."""
    return replace(mark, value=value)


@pytest.mark.parametrize("language", ["fr", "en"])
def test_groups_whole(a_class: Laid, language: str) -> None:
    """From the archive to the site: every member has the group's mark and page, nobody else's."""
    to = Site(language, team=True)
    for k, (number, group) in enumerate({"114": 109, "110": 109, "111": 110, "109": 110}.items()):
        name, own = f"P{k}", f"Binôme {'AB'[group - 109]}"
        to.people[number] = Person(name, f"2190000{k}", HANDED, group, own, "Submitted")
    default = "Groupe par défaut" if language == "fr" else "Default group"
    to.people["113"] = Person("Seul", "21900009", HANDED, None, default, "Submitted")
    kind = "assignsubmission_file"
    a_class.archive(
        {
            f"Binôme A_109_{kind}/r.zip": packed(submission(1)),
            f"Binôme B_110_{kind}/r.zip": packed(submission(0.5)),
            f"{default}_{kind}/r.zip": packed(submission(0.25)),
        }
    )
    a_class.write("w.csv", to.worksheet())
    done = a_class.run()
    content = (done.out / "moodle" / "w.csv").read_bytes()
    outcome, pages = to.upload(sheet(content), files(done.out / "moodle" / "feedback.zip"))
    assert len(taken(outcome)) == 5
    grades = {number: each.grade for number, each in to.people.items()}
    assert grades == {"114": 20, "110": 20, "111": 10, "109": 10, "113": 5}
    assert sorted(sorted(each) for each in pages.values()) == [["109", "111"], ["110", "114"]]


def whole(laid: Laid, to: Site, worth: dict[str, float]) -> Laid:
    """Lay what a site gives: its archive, its worksheet."""
    laid.archive(
        {
            f"{to.people[number].name}_{number}_assignsubmission_file/r.zip": packed(
                submission(share, also=number)
            )
            for number, share in worth.items()
        }
    )
    laid.write("w.csv", to.worksheet())
    return laid


def test_a_worksheet_older_than_marks_already_given_is_told(a_class: Laid) -> None:
    """The same download, filled again after an upload: its rows would be skipped."""
    to = site("en", people=3)
    for each in to.people.values():
        each.name = each.name.replace('"', "").replace("=", "")
    laid = whole(a_class, to, {"1": 1, "2": 0.5})
    first = laid.run()
    to.upload(sheet((first.out / "moodle" / "w.csv").read_bytes()))
    laid.write("manual.csv", "who;style\n21900002;2\n")
    stale = laid.run()
    assert "the worksheet does not know 1 grade(s) of the last time, which change" in stale.said
    (outcome,) = to.upload(sheet((stale.out / "moodle" / "w.csv").read_bytes()))
    assert outcome == {"1": "same", "2": "stale", "3": "empty"}
    laid.write("w.csv", to.worksheet())
    fresh = laid.run()
    assert "does not know" not in fresh.said
    (outcome,) = to.upload(sheet((fresh.out / "moodle" / "w.csv").read_bytes()))
    assert (outcome["2"], to.people["2"].grade) == ("taken", 12.0)

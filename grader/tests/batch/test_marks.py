"""From points to marks: the scale, lateness, manual.csv, and the files that are given back."""

from __future__ import annotations

import importlib
import io
import os
import zipfile
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from grader.batch import csv_table, grades_csv, last_run, manual_marks, marks, marks_xlsx, outputs
from grader.batch.lateness import Deadlines, Lateness
from grader.batch.records import BatchError, Candidate, Enrolled, Graded, ManualMark, Mark, Member
from grader.batch.results_folder import ResultsFolder
from grader.course import settings as course
from grader.course.exercises import ManifestError
from grader.course.message import Message
from grader.course.settings import Course, Late, Marks, People
from grader.course.texts import Texts

RULES = Course("fr", "c", (1, 2), count_closed=False)
ADA = Member("Ada Lovelace", "21900001", "1", "ada")
BOB = Member("Bob Noël", "21900002", "2", "bob")


def results(one: float, two: float, bonus: float = 0.0, incomplete: bool = False) -> dict[str, Any]:
    """Return a summary with these points in TP1 (of 15) and TP2 (of 30)."""
    tps = [
        {"tp": 1, "score": one, "max_score": 15.0},
        {"tp": 2, "score": two, "max_score": 30.0},
    ]
    exercises = {"TP1.1": ["passed", one, 15.0], "TP2.1": ["failed", two, 30.0]}
    return {
        **{"tps": tps, "bonus": bonus, "incomplete": incomplete, "exercises": exercises},
        **{"compiles": True, "rejected": [], "learnt": []},
    }


def graded(summary: dict[str, Any] | None, **changes: Any) -> Graded:
    """Return Ada's submission with that result."""
    return Graded(Candidate("ada", "ada", Path("ada")), summary, **changes)


def late(member: Member, handed: datetime | None, rules: Course) -> Lateness:
    """Return how late a person is who has handed in then."""
    return Deadlines(rules, []).of(replace(member, handed=handed))


def value(
    summary: dict[str, Any] | None,
    rules: Course = RULES,
    hand: ManualMark | None = None,
    handed: datetime | None = None,
) -> float | None:
    """Return Ada's mark."""
    return marks.mark(ADA, graded(summary), hand, late(ADA, handed, rules), rules).value


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({}, 11.0),  # 24.8 of 45, of 20: 11.02
        ({"step": 0.0}, 11.02),
        ({"step": 0.5}, 11.0),
        ({"scale": 10.0, "step": 0.0}, 5.51),
        ({"weights": {1: 1.0, 2: 1.0}, "step": 0.0}, 8.43),
        ({"weights": {2: 0.0}, "step": 0.0}, 0.67),
    ],
)
def test_points_become_a_mark(settings: dict[str, Any], expected: float) -> None:
    """By the weights of the TPs, on the scale, to the nearest step."""
    assert value(results(0.5, 24.3), replace(RULES, marks=Marks(**settings))) == expected


def test_a_half_goes_up_and_the_bonus_is_capped() -> None:
    """2.125 of steps of 0.25 is 2.25; the bonus adds 2 at most, and nothing exceeds the scale."""
    assert value(results(15 * 0.31875, 30 * 0.31875)) == 6.5
    assert value(results(7.5, 15, bonus=20)) == 12.0
    assert value(results(15, 30, bonus=20)) == 20.0


def test_lateness_is_a_persons_own() -> None:
    """Each day begun after the grace costs; an extension moves one person's deadline."""
    due = datetime(2026, 3, 2, 23, 59)
    rules = replace(
        RULES,
        deadlines={1: datetime(2026, 1, 1), 2: due},
        late=Late(per_day=1, most=3, grace_minutes=10, zero_after_days=5),
        people=People(extensions={"lovelace ADA": datetime(2026, 3, 4, 23, 59)}),
    )
    moments = [
        datetime(2026, 3, 5, 0, 8),
        datetime(2026, 3, 5, 0, 10),
        datetime(2026, 3, 8),
        datetime(2026, 3, 30),
    ]
    assert [value(results(15, 30), rules, handed=each) for each in moments] == [20, 19, 17, 0]
    bob = marks.mark(BOB, graded(results(15, 30)), None, late(BOB, moments[0], rules), rules)
    assert (bob.value, bob.late_days) == (18.0, 2)
    assert bob.late == Message("batch.late", {"days": 2, "penalty": 2})
    half = Message("batch.late", {"days": 1, "penalty": 1.5})
    assert Texts("fr").say(half.key, **half.values).endswith("-1,5.")
    assert Texts("en").say(half.key, **half.values).endswith("-1.5.")


def test_what_is_no_mark_is_none_and_says_why() -> None:
    """A fault of the grader is no zero; nothing is chosen; an excuse; an absence."""

    def told(member: Member, known: Graded | None, rules: Course = RULES) -> tuple[Any, list[str]]:
        mark = marks.mark(member, known, None, Lateness(), rules)
        return mark.value, [each.key for each in mark.why]

    assert told(ADA, graded(None, failure="x")) == (None, ["batch.failed"])
    assert told(ADA, graded(results(15, 30, incomplete=True))) == (None, ["batch.failed"])
    excused_absent = replace(RULES, people=People(absent=0.0))
    assert told(replace(ADA, unsettled=True), graded(results(15, 30))) == (None, [])
    assert told(replace(ADA, submission="", unsettled=True), None, excused_absent) == (None, [])
    excused = replace(RULES, people=People(excused=("21900001",), absent=0.0))
    assert told(ADA, None, excused) == (None, ["batch.excused"])
    assert told(BOB, None, excused) == (0.0, [])
    assert told(BOB, None) == (None, [])
    broken = Candidate("bob", "bob", Path("bob"), problem=Message("batch.nothing"))
    assert told(BOB, Graded(broken)) == (None, ["batch.nothing"])


def test_an_override_wins_and_the_rubric_adds() -> None:
    """Over everything else, with its reason; a rubric's points count like the others."""
    override = ManualMark(2, {}, override=14.1, reason="oral")
    mark = marks.mark(ADA, graded(None, failure="x"), override, Lateness(), RULES)
    assert (mark.value, mark.error) == (14.0, False)
    assert mark.why == (Message("batch.overridden", {"reason": "oral"}),)
    assert value(results(7.5, 15), hand=ManualMark(2, {"dessin": 1.5, "style": -0.5})) == 11.0


# ---- course.toml --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[marks]\nscale = 0", "course.toml, line 2: scale must be above 0"),
        ('[marks]\nstep = "x"', "line 2: step must be a number from 0 on"),
        ("[marks]\n\nsteps = 1", "line 3: steps is unknown here; known: scale"),
        ("[marks]\nweights = { TP9 = 1 }", "line 2: weights TP9 is no TP; there are TP1"),
        ("[late]\nper_day = -1", "line 2: per_day must be a number from 0 on"),
        ("[deadlines]\nTP1 = 3", "line 2: TP1 must be a date and time such as 2026-03-02T23:59:00"),
        ("[deadlines]\nTP7 = 2026-03-02T23:59:00", "line 2: TP7 TP7 is no TP"),
        ("[people]\nexcused = [1]", 'line 2: excused must be a list such as ["21905678"'),
        ('[people]\nabsent = "0"', "line 2: absent must be a mark such as 0"),
        ("[people.extensions]\nada = 1", "line 1: extensions must be a date and time"),
        ("\nopened = [1]", "line 2: opened belongs in grader/course/course.toml; move it there"),
        ("[nothing]", "nothing is unknown here"),
        ("marks = 1", "line 1: marks must be a table: write [marks]"),
    ],
)
def test_a_wrong_setting_names_its_line_and_the_cure(tmp_path: Path, text: str, said: str) -> None:
    """As a person can mend it without a manual."""
    path = tmp_path / "course.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ManifestError) as caught:
        course.beside(RULES, path)
    assert said in str(caught.value)


def test_settings_beside_the_submissions_replace_tables(tmp_path: Path) -> None:
    """Those that are there; a date with an offset is turned into local time."""
    path = tmp_path / "course.toml"
    path.write_text(
        "[people]\nabsent = 0\n[deadlines]\nTP2 = 2026-03-02T23:59:00Z\n"
        "[people.extensions]\n21900001 = 2026-03-09T12:00:00\n",
        encoding="utf-8",
    )
    given = course.beside(RULES, path)
    assert given.people == People((), {"21900001": datetime(2026, 3, 9, 12)}, 0.0)
    assert given.deadline is not None
    assert given.deadline.astimezone().timestamp() == 1772495940
    assert given.marks == RULES.marks


def test_a_setting_about_nobody_is_told() -> None:
    """A slip of the pen in a name must not cost a mark."""
    rules = replace(RULES, people=People(excused=("Ada Lovelaec",)))
    with pytest.raises(BatchError, match="Lovelaec"):
        marks.verify_people(rules, [ADA, BOB])


@pytest.mark.parametrize("name", ["Marie Dupont", "dupont MARIE", "Dupont Marie"])
def test_a_setting_about_several_is_refused(name: str) -> None:
    """As in manual.csv; their number says who is meant."""
    twins = [Member("Marie Dupont", "11111"), Member("Dupont Marie", "22222"), ADA]
    rules = replace(RULES, people=People(excused=(name,)))
    with pytest.raises(BatchError) as caught:
        marks.verify_people(rules, twins)
    assert (caught.value.key, caught.value.values) == ("batch.course_several", {"name": name})
    marks.verify_people(replace(RULES, people=People(extensions={"22222": MOMENT})), twins)
    both = replace(RULES, people=People(excused=("11111",), absent=0.0))
    given = [marks.mark(each, None, None, Lateness(), both) for each in twins[:2]]
    assert [each.value for each in given] == [None, 0.0]


# ---- Lateness, and what Moodle says of it -------------------------------------------------------

DUE = datetime(2026, 3, 2, 23, 59)
MOMENT = datetime(2026, 3, 9, 23, 59)
LATE_RULES = replace(RULES, deadlines={2: DUE}, late=Late(per_day=1, most=20))


def enrolled(**changes: Any) -> Enrolled:
    """Return a row of the worksheet."""
    return Enrolled("1", "Ada Lovelace", "21900001", **changes)


@pytest.mark.parametrize(
    ("own", "rules", "days", "told"),
    [
        ({}, LATE_RULES, 5, []),
        ({"extended": MOMENT}, LATE_RULES, 0, ["granted"]),
        ({"due": MOMENT}, LATE_RULES, 0, ["granted"]),
        ({"due": DUE}, LATE_RULES, 5, []),
        ({"due": datetime(2026, 3, 1)}, LATE_RULES, 5, ["other_extension"]),
        (
            {"extended": MOMENT},
            replace(LATE_RULES, people=People(extensions={"Ada Lovelace": datetime(2026, 3, 6)})),
            *(2, ["other_extension"]),
        ),
        ({"extended": MOMENT}, RULES, 0, []),
    ],
)
def test_what_moodle_grants_is_honoured_or_contradicted_aloud(
    own: dict[str, Any], rules: Course, days: int, told: list[str]
) -> None:
    """An extension in the status, an override in the column of dates; [people] goes first."""
    others = [Enrolled(f"{k}", f"P{k}", due=DUE) for k in range(2, 5)]
    person = enrolled(**own)
    member = replace(ADA, enrolled=person, handed=datetime(2026, 3, 7, 23, 0))
    found = Deadlines(rules, [person, *others]).of(member)
    assert (found.days, [each.key.removeprefix("batch.") for each in found.remarks]) == (days, told)


@pytest.mark.parametrize(
    ("people", "rules", "told"),
    [
        ([], LATE_RULES, ["no_dates"]),
        ([enrolled()], LATE_RULES, ["no_dates"]),
        ([enrolled(handed=DUE)], LATE_RULES, []),
        ([enrolled(handed=DUE, due=MOMENT)], LATE_RULES, ["other_deadline"]),
        ([enrolled(handed=DUE, due=DUE)], LATE_RULES, []),
        ([enrolled(handed=DUE, due=DUE)], RULES, ["no_deadline"]),
        ([enrolled(handed=DUE, late=True)], RULES, ["no_deadline"]),
        ([enrolled(handed=DUE)], RULES, []),
    ],
)
def test_deadlines_and_dates_that_do_not_meet_are_told(
    people: list[Enrolled], rules: Course, told: list[str]
) -> None:
    """Before anything is graded: a deadline without dates, two deadlines, dates without any."""
    found = Deadlines(rules, people).notices()
    assert [each.key.removeprefix("batch.") for each in found] == told


def test_one_date_that_is_missing_is_told() -> None:
    """Nobody is late without a date; the person's line says so. And where Moodle says late."""
    known = Deadlines(LATE_RULES, [enrolled(handed=DUE)])
    assert known.of(ADA) == Lateness(0, (Message("batch.no_date"),))
    late = replace(ADA, handed=DUE, enrolled=enrolled(late=True))
    assert [each.key for each in known.of(late).remarks] == ["batch.moodle_late"]


# ---- Why a mark is 0 ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("summary", "told"),
    [
        (results(0, 0), ["zero"]),
        ({**results(0, 0), "compiles": False, "rejected": ["main.c"]}, ["not_compiled", "zero"]),
        ({**results(0, 0), "compiles": False}, ["not_built", "zero"]),
        ({**results(15, 30), "compiles": False, "rejected": ["a.c"]}, ["not_compiled"]),
    ],
)
def test_a_mark_of_0_says_why(summary: dict[str, Any], told: list[str]) -> None:
    """And who does not compile has a remark, whatever the mark."""
    mark = marks.mark(ADA, graded(summary), None, Lateness(), RULES)
    assert [each.key.removeprefix("batch.") for each in mark.why] == told
    assert all(Texts(each).say(mark.why[-1].key, **mark.why[-1].values) for each in ("fr", "en"))


# ---- manual.csv ---------------------------------------------------------------------------------


def test_manual_marks_are_read_in_any_dialect(tmp_path: Path) -> None:
    """By number, by name, by submission; comma or point; French or English headers."""
    path = tmp_path / manual_marks.NAME
    path.write_text(
        "\ufeffqui;dessin;commentaire;override;raison\r\n"
        '21900001;1,5;"deux\r\nlignes";;\r\n\r\nnoel bob;;;14;oral\r\n',
        encoding="utf-8",
    )
    assert manual_marks.read(path, [ADA, BOB], 20) == {
        ADA: ManualMark(2, {"dessin": 1.5}, "deux\r\nlignes"),
        BOB: ManualMark(5, {}, "", 14.0, "oral"),
    }
    path.write_text("who,style\nada,0.5\n", encoding="utf-8")
    partner = replace(BOB, submission="ada")
    assert set(manual_marks.read(path, [ADA, partner], 20)) == {ADA, partner}


@pytest.mark.parametrize(
    ("text", "key", "line"),
    [
        ("name,style\nada,1\n", "manual_header", None),
        ("who,style\nada,1,2\n", "manual_cells", 2),
        ("who,style\nada,x\n", "manual_number", 2),
        ("who,style\nada,1\nAda Lovelace,2\n", "manual_twice", 3),
        ("who,override,reason\nada,21,x\n", "manual_range", 2),
        ("who,override,reason\nada,12,\n", "manual_reason", 2),
        ("who,style\n\nnobody,1\n", "manual_nobody", 3),
        ("", "not_a_table", None),
    ],
)
def test_a_wrong_line_of_manual_csv_is_named(
    tmp_path: Path, text: str, key: str, line: int | None
) -> None:
    """With its number and what to do, in both languages."""
    path = tmp_path / manual_marks.NAME
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BatchError) as caught:
        manual_marks.read(path, [ADA, BOB], 20)
    assert (caught.value.key, caught.value.values.get("line")) == (f"batch.{key}", line)
    assert all(Texts(each).say(caught.value.key, **caught.value.values) for each in ("fr", "en"))


# ---- grades.csv ---------------------------------------------------------------------------------


def test_grades_hold_no_formula_and_no_control(tmp_path: Path) -> None:
    """Whatever a student calls themselves; marks are numbers of the language."""
    names = ['=HYPERLINK("http://x")', "+1", "-x", "@a", "a\tb\x07\nc", 'quote"d;']
    given = [Mark(Member(each, f"0{k}"), 10.5) for k, each in enumerate(names)]
    path = tmp_path / "grades.csv"
    path.write_bytes(grades_csv.grades(given, {}, {}, Texts("fr")))
    sheet = csv_table.read(path)
    assert (sheet.delimiter, sheet.bom, sheet.header[0], sheet.header[5]) == (
        ";",
        True,
        "nom",
        "note",
    )
    assert [row[0] for row in sheet.rows] == [
        *('\'=HYPERLINK("http://x")', "'+1", "'-x", "'@a", "a b  c", 'quote"d;'),
    ]
    assert {row[5] for row in sheet.rows} == {"10,5"}


def test_marks_xlsx_has_the_rows_of_grades_csv() -> None:
    """Numbers are numbers, and what looks like a formula or a number is the text that it was."""
    if not marks_xlsx.is_possible():
        assert not os.environ.get("MRT_CI"), "CI must have openpyxl"
        pytest.skip("openpyxl is not installed")
    openpyxl = importlib.import_module("openpyxl")
    names = ['=HYPERLINK("http://x")', "+1", "-x", "@a", "a\tb\x07\nc", "Noël"]
    given = [
        Mark(Member(each, f"0{k}", "", "ada"), 10.5, bonus=1.25, points=80.0)
        for k, each in enumerate(names)
    ]
    known = {"ada": graded(results(15, 30))}
    content = marks_xlsx.marks_sheet(given, known, {"ada": "QX7A"}, Texts("fr"))
    sheet = openpyxl.load_workbook(io.BytesIO(content)).active
    header, rows = grades_csv.cells(given, known, {"ada": "QX7A"}, Texts("fr"))
    found = [[each.value for each in row] for row in sheet.iter_rows()]
    assert found[0] == header
    assert (found[0][0], found[0][5]) == ("nom", "note")
    assert [row[0] for row in found[1:]] == [*names[:4], "a b  c", "Noël"]
    told = [[None if each == "" else each for each in row[1:]] for row in rows]
    assert [row[1:] for row in found[1:]] == told
    assert [row[5:8] for row in found[1:]] == [[10.5, 80.0, 1.25]] * len(names)
    kinds = {each.data_type for row in sheet.iter_rows(max_col=5) for each in row if each.value}
    assert kinds == {"s"}
    assert b"<f>" not in zipfile.ZipFile(io.BytesIO(content)).read("xl/worksheets/sheet1.xml")


def test_an_older_marks_xlsx_goes_where_it_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would say other marks than grades.csv."""
    monkeypatch.setattr(marks_xlsx, "is_possible", lambda: False)
    with ResultsFolder(tmp_path / "out") as folder:
        (folder.out / marks_xlsx.NAME).write_bytes(b"old")
        outputs._write_sheet(folder, [], {}, {}, Texts("fr"))
        assert not (folder.out / marks_xlsx.NAME).exists()


def test_a_regrade_tells_old_mark_new_mark_and_why() -> None:
    """By what the mark depends on; a mark that stays is not listed."""
    known = {"ada": graded(results(15, 30), parts={"sources": "a", "grader": "1"})}
    before = last_run.kept([Mark(ADA, 12.0), Mark(BOB, 3.0)], known, {}, RULES)
    after = {"ada": graded(results(15, 30), parts={"sources": "b", "grader": "1"})}
    now = last_run.kept([Mark(ADA, 14.5, late_days=1), Mark(BOB, 3.0)], after, {}, RULES)
    assert last_run.changes(before, now, Texts("fr")) == [
        ["Ada Lovelace", "12", "14,5", "retard changé, fichiers différents"]
    ]


PARTS = {"sources": "a", "grader": "1"}


@pytest.mark.parametrize(
    ("member", "known", "hand", "rules", "why"),
    [
        (ADA, PARTS, None, RULES, "rien n'a changé : exécution différente"),
        (ADA, PARTS, ManualMark(2, {"dessin": 1.0}), RULES, "saisie manuelle changée (manual.csv)"),
        (
            ADA,
            PARTS,
            ManualMark(2, {}, override=3.0),
            RULES,
            "saisie manuelle changée (manual.csv)",
        ),
        (ADA, PARTS, ManualMark(2, {}, "bien"), RULES, "saisie manuelle changée (manual.csv)"),
        (replace(ADA, submission="bob"), PARTS, None, RULES, "rendu ou auteurs changés"),
        (replace(ADA, unsettled=True), PARTS, None, RULES, "rendu ou auteurs changés"),
        (ADA, {**PARTS, "grader": "2"}, None, RULES, "correcteur ou solution changés"),
        (
            *(replace(ADA, handed=datetime(2026, 3, 2)), PARTS, None, RULES),
            "feuille d'évaluation changée",
        ),
        (
            *(ADA, PARTS, None, replace(RULES, people=People(excused=("Ada Lovelace",)))),
            "réglage de la personne changé ([people])",
        ),
        (ADA, PARTS, None, replace(RULES, marks=Marks(scale=10)), "barème changé (course.toml)"),
        (
            ADA,
            PARTS,
            None,
            replace(RULES, people=People(excused=("Bob Noël",))),
            "rien n'a changé : exécution différente",
        ),
    ],
)
def test_the_reason_is_the_true_one(
    member: Member, known: dict[str, str], hand: ManualMark | None, rules: Course, why: str
) -> None:
    """Each of what a mark depends on has its own; "nothing has changed" when nothing has."""
    results_of = {name: graded(results(15, 30), parts=known) for name in ("ada", "bob")}
    old = {name: graded(results(15, 30), parts=PARTS) for name in ("ada", "bob")}
    before = last_run.kept([Mark(ADA, 12.0)], old, {}, RULES)
    hands = {member: hand} if hand else {}
    now = last_run.kept([Mark(member, 13.0)], results_of, hands, rules)
    assert last_run.changes(before, now, Texts("fr")) == [["Ada Lovelace", "12", "13", why]]


def test_who_can_be_read_or_not_and_who_is_gone() -> None:
    """A submission that cannot be read any more changes nothing else; who withdraws is told."""
    before = last_run.kept(
        [Mark(ADA, 12.0), Mark(BOB, 3.0)], {"ada": graded({}, parts=PARTS)}, {}, RULES
    )
    broken = Graded(Candidate("ada", "ada", Path("ada"), problem=Message("batch.nothing")))
    now = last_run.kept([Mark(ADA, None)], {"ada": broken}, {}, RULES)
    assert last_run.changes(before, now, Texts("fr")) == [
        ["Ada Lovelace", "12", "", "rendu lisible ou non, changé"],
        ["Bob Noël", "3", "", "n'est plus dans la classe"],
    ]


def test_a_person_is_known_again_by_what_both_runs_know() -> None:
    """Moodle's number, else the student's, else the name; two namesakes are two."""

    def same(one: Member, other: Member) -> bool:
        return last_run.is_same(last_run.person_of(one), last_run.person_of(other))

    assert same(ADA, replace(ADA, submission="x"))
    assert same(ADA, Member("LOVELACE Ada"))
    assert same(ADA, Member("A. Lovelace", "p21900001"))
    assert not same(ADA, replace(ADA, moodle="57"))
    assert not same(Member("Marie Dupont", "11111"), Member("Marie Dupont", "22222"))

"""Classes of a real platform that once went wrong without a word, laid again by code.

Each is a whole run of the command; only the judgement of the C code is taken as known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from grader.batch import pool
from grader.batch.records import GradedFiles
from grader.console.run import ExitCode
from grader.tests.batch import desk_class
from grader.tests.batch.desk_class import (
    Laid,
    deflated_64,
    locked,
    packed,
    row,
    submission,
    table,
)

FILE = "assignsubmission_file"
DEADLINE = "[deadlines]\nTP1 = 2026-03-02T23:59:00\n"


def test_the_worksheets_maximum_is_another(a_class: Laid) -> None:
    """Moodle's default is 100: 20 of 20 arrives as 100, one line says so; here it stays 20."""
    a_class.archive({f"Ada_57_{FILE}/r.zip": packed(submission(1))})
    rows = [row(57, "Ada", "Maximum grade"), row(60, "Paul", **{"Last modified (submission)": "-"})]
    a_class.write("w.csv", table([{**each, "Maximum grade": "100.00"} for each in rows]))
    done = a_class.run()
    assert (done.status, done.marks()) == (ExitCode.DONE, {"Ada 57": 20, "Paul 60": None})
    assert done.sent() == {"57": "100.00", "60": ""}
    assert "the marks out of 20 are written there out of 100" in done.said


@pytest.mark.parametrize("archived", [False, True])
def test_a_students_file_is_never_the_courses(a_class: Laid, archived: bool) -> None:
    """A worksheet, course.toml or manual.csv that is handed in counts for nothing, and is told.

    In the layout without folders each would lie beside the submissions, and would swap two marks.
    """
    swapped = table([row(1, "Eve"), row(3, "Ada")])
    late = "[deadlines]\nTP1 = 2016-03-02T23:59:00\n[marks]\nscale = 100\n"
    by_hand = "who;override;reason\nAda;0;none\nEve;20;mine\n"
    entries: dict[str, str | bytes] = {
        f"Ada_1_{FILE}_r.zip": packed(submission(1)),
        f"Eve_3_{FILE}_r.zip": packed(submission(0.1)),
        f"Eve_3_{FILE}_results.csv": swapped,
        f"Eve_3_{FILE}_course.toml": late,
        f"Eve_3_{FILE}_manual.csv": by_hand,
    }
    if archived:
        entries |= {"course.toml": late, "manual.csv": by_hand, "results.csv": swapped}
        a_class.archive(entries)
    else:
        for name, content in entries.items():
            a_class.write(name, content)
    done = a_class.run(archive="all.zip" if archived else "")
    assert (done.status, done.marks()) == (ExitCode.DONE, {"Ada 1": 20, "Eve 3": 2})
    assert not (done.out / "moodle").exists()
    (_, remarks) = done.lines()["Eve 3"]
    assert all(name in remarks for name in ("results.csv", "course.toml", "manual.csv"))


def test_a_scale_of_words_is_refused(a_class: Laid) -> None:
    """Before anything is graded, with what to do."""
    a_class.archive({f"Ada_57_{FILE}/r.zip": packed(submission(1))})
    header = [each.replace("Maximum grade", "Scale") for each in desk_class.HEADER]
    a_class.write("w.csv", table([row(57, "Ada", Scale="Poor    Fair    Good")], header))
    done = a_class.run()
    assert done.status == ExitCode.FAILED
    assert "graded in words (Scale)" in done.said
    assert not (done.out / "grades.csv").exists()


def test_the_number_of_a_folder_is_a_groups(a_class: Laid) -> None:
    """Every member gets the mark, nobody else; feedback bears the group's name."""
    archive = {
        f"Binome B_110_{FILE}/r.zip": packed(submission(0.5)),
        f"Binome A_109_{FILE}/r.zip": packed(submission(1)),
        f"Solo_111_{FILE}/r.zip": packed(submission(0.25, "Li, Wei, 21900012")),
    }
    header = [*desk_class.HEADER[:4], "Group", *desk_class.HEADER[4:]]
    rows = [
        row(114, "Ada", "21905678", Group="Binome A"),
        row(110, "Zoé", "21900002", Group="Binome A"),
        row(111, 'Marie "Mimi" Dupont', "21900007", Group="Binome B"),
        row(109, "Marie Dupont", "21900008", Group="Binome B"),
        row(112, "Wei Li", "21900012", Group="Solo"),
        row(113, "Paul", "21900017", Group="Default group", **{"Last modified (submission)": "-"}),
    ]
    a_class.archive(archive)
    a_class.write("w.csv", table(rows, header))
    done = a_class.run()
    assert done.status == ExitCode.DONE
    assert done.sent() == {
        **{"114": "20.00", "110": "20.00", "111": "10.00", "109": "10.00"},
        **{"112": "5.00", "113": ""},
    }
    assert done.feedback() == {
        f"Binome A_109_{FILE}_",
        f"Binome B_110_{FILE}_",
        f"Solo_111_{FILE}_",
    }


@pytest.mark.parametrize(
    ("authors", "expected"),
    [
        ("Lovelace, Ada, 21900031", {"7": "", "8": "", "9": "10.00"}),
        ("Lovelace, Ada, 21905678\nHopper, Grace, 21900032", {"7": "20.00", "8": "", "9": "10.00"}),
    ],
)
def test_a_number_is_another_persons(a_class: Laid, authors: str, expected: dict[str, str]) -> None:
    """Nobody is chosen and the line says why, even when who is absent has a 0."""
    a_class.archive(
        {
            f"Ada Lovelace_7_{FILE}/r.zip": packed(submission(1, authors)),
            f"Alan Turing_9_{FILE}/r.zip": packed(submission(0.5, "Turing, Alan, 21900032")),
        }
    )
    absent = {"Last modified (submission)": "-"}
    rows = [row(7, "Ada Lovelace", "21905678"), row(8, "Grace Hopper", "21900031", **absent)]
    a_class.write("w.csv", table([*rows, row(9, "Alan Turing", "21900032")]))
    a_class.write("course.toml", "[people]\nabsent = 0\n")
    done = a_class.run()
    assert (done.status, done.sent()) == (ExitCode.DONE, expected)
    for name in ("Ada Lovelace 7", "Grace Hopper 8"):
        mark, why = done.lines()[name]
        assert mark is not None or "Nobody is chosen" in why


def test_what_cannot_be_read_is_no_mark(a_class: Laid) -> None:
    """A password, unusual compression, renamed files, another course's: never a 0 without why."""
    whole = submission(1)
    renamed = {name: text for name, text in whole.items() if name != "main.c"}
    archive: dict[str, str | bytes] = {
        f"Pass Word_1_{FILE}/r.zip": locked(packed(whole)),
        f"Deflate_2_{FILE}/r.zip": deflated_64(packed(whole)),
        f"Other Course_5_{FILE}/r.zip": packed({"main.c": "int main(void) {}", "client.c": "x"}),
    }
    archive |= {f"Copy One_3_{FILE}/{name}": text for name, text in renamed.items()}
    archive |= {f"Txt Ext_4_{FILE}/{name}": text for name, text in renamed.items()}
    archive[f"Copy One_3_{FILE}/main (1).c"] = whole["main.c"]
    archive[f"Txt Ext_4_{FILE}/main.c.txt"] = whole["main.c"]
    a_class.archive(archive)
    names = ("Pass Word", "Deflate", "Copy One", "Txt Ext", "Other Course")
    a_class.write("w.csv", table([row(k, name) for k, name in enumerate(names, 1)]))
    done = a_class.run()
    assert done.status == ExitCode.DONE
    lines = done.lines()
    assert [lines[f"{name} {k}"][0] for k, name in enumerate(names, 1)] == [None, None, 20, 20, 0]
    assert "protected by a password" in lines["Pass Word 1"][1]
    assert "compressed in an unusual way" in lines["Deflate 2"][1]
    assert "main (1).c was read as main.c" in lines["Copy One 3"][1]
    assert "main.c.txt was read as main.c" in lines["Txt Ext 4"][1]
    assert "is it another assignment?" in lines["Other Course 5"][1]
    assert "Mark 0." in lines["Other Course 5"][1]


@pytest.mark.parametrize("between", ["_", "/"])
def test_absent_is_who_has_handed_in_nothing(a_class: Laid, between: str) -> None:
    """In both layouts: an archive of a kind that is not read is there, and no 0."""
    a_class.archive({f"Stu Rar_1_{FILE}{between}rendu.rar": b"Rar!\x1a\x07"})
    rows = [row(1, "Stu Rar"), row(2, "Bob", **{"Last modified (submission)": "-"}), row(3, "Carl")]
    a_class.write("w.csv", table(rows))
    a_class.write("course.toml", "[people]\nabsent = 0\n")
    done = a_class.run()
    assert (done.status, done.sent()) == (ExitCode.DONE, {"1": "", "2": "", "3": ""})
    assert "rendu.rar" in done.lines()["Stu Rar 1"][1]
    assert "perhaps one of them" in done.lines()["Bob 2"][1]  # a partner, in the archive
    assert "none of which is here" in done.lines()["Carl 3"][1]
    a_class.archive({f"Stu Rar_1_{FILE}{between}main.c": submission(1)["main.c"]})
    assert a_class.run(out="other").sent() == {"1": "20.00", "2": "0.00", "3": ""}


def test_a_deadline_without_dates_is_told_first(a_class: Laid) -> None:
    """Without a worksheet, with one in a language that is not read, with a table that is none."""
    a_class.archive({f"Ada_7_{FILE}/r.zip": packed(submission(1))})
    a_class.write("course.toml", DEADLINE)
    a_class.write("oral.csv", "name;mark\nAda;12\n")
    done = a_class.run()
    assert done.status == ExitCode.DONE
    assert done.said.index("nobody is late") < done.said.index("1/1")
    assert "not read: oral.csv" in done.said
    header = "Identificador,Nombre,Estado,Calificación,Máxima,Última modificación"
    a_class.write("Calificaciones.csv", f"{header}\nParticipante7,Ada,x,,20,-\n")
    done = a_class.run(out="other")
    assert (done.status, (done.out / "grades.csv").exists()) == (ExitCode.FAILED, False)
    assert "Set Moodle to French or English" in done.said


@pytest.mark.parametrize("name", ["Marie Dupont", "Dupont Marie"])
def test_a_name_of_several_in_the_settings_is_refused(a_class: Laid, name: str) -> None:
    """As in manual.csv, before anything is graded."""
    a_class.archive({f"Marie Dupont_{k}_{FILE}/r.zip": packed(submission(1)) for k in (7, 8)})
    a_class.write("w.csv", table([row(k, "Marie Dupont", f"2190000{k}") for k in (7, 8)]))
    a_class.write("course.toml", f'[people]\nexcused = ["{name}"]\n')
    done = a_class.run()
    assert (done.status, (done.out / "grades.csv").exists()) == (ExitCode.FAILED, False)
    assert f"[people] names {name}, and several people are called so" in done.said
    a_class.write("course.toml", '[people]\nexcused = ["21900007"]\n')
    assert a_class.run().sent() == {"7": "", "8": "20.00"}


def test_extensions_of_moodle_are_honoured(a_class: Laid) -> None:
    """In the status and in the column of dates; [people] contradicts them aloud."""
    late = "Saturday, 7 March 2026, 11:00 PM"
    until = "Monday, 9 March 2026, 11:59 PM"
    names = {1: "Ada", 2: "Bob", 3: "Eve", 4: "Zoé"}
    a_class.archive(
        {f"{name}_{k}_{FILE}/r.zip": packed(submission(1)) for k, name in names.items()}
    )
    header = [*desk_class.HEADER[:4], "Due date", *desk_class.HEADER[4:]]
    cells = {"Last modified (submission)": late, "Due date": "Monday, 2 March 2026, 11:59 PM"}
    rows = [row(k, name, **cells) for k, name in names.items()]
    rows[1]["Due date"] = until
    rows[2]["Status"] = f"Submitted for grading - Extension granted until: {until} - "
    rows[3]["Status"] = rows[2]["Status"]
    a_class.write("w.csv", table(rows, header))
    own = '[people]\nextensions = { "Zoé" = 2026-03-06T12:00:00 }\n[late]\nper_day = 1\nmost = 20\n'
    a_class.write("course.toml", DEADLINE + own)
    done = a_class.run()
    assert done.sent() == {"1": "15.00", "2": "20.00", "3": "20.00", "4": "18.00"}
    lines = done.lines()
    assert "Deadline granted in Moodle: 2026-03-09 23:59" in lines["Bob 2"][1]
    assert "Deadline granted in Moodle: 2026-03-09 23:59" in lines["Eve 3"][1]
    assert "course.toml 2026-03-06 12:00: course.toml counts" in lines["Zoé 4"][1]


def test_an_archive_in_an_archive_and_what_systems_leave(a_class: Laid) -> None:
    """One level is opened, and told; __MACOSX and .DS_Store are nobody."""
    a_class.archive(
        {
            f"Stu Zip_1_{FILE}/r.zip": packed({"rendu/core.zip": packed(submission(1))}),
            f"__MACOSX/Stu Zip_1_{FILE}/._r.zip": "x",
            ".DS_Store": "x",
        }
    )
    a_class.write("w.csv", table([row(1, "Stu Zip")]))
    done = a_class.run()
    assert done.lines() == {"Stu Zip 1": (20.0, "Archive in the archive, opened: rendu/core.zip.")}


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("manual.csv", "who;style\nAda Lovelcae;1\n", 'line 2: "Ada Lovelcae" is nobody'),
        ("course.toml", '[people]\nexcused = ["Ada Lovelcae"]\n', "names Ada Lovelcae, who is not"),
        (
            "w.csv",
            table([row(1, "Ada", **{"Last modified (submission)": "hier"})]),
            "not understood",
        ),
    ],
)
def test_errors_beside_the_submissions_come_first(
    a_class: Laid, monkeypatch: pytest.MonkeyPatch, name: str, content: str, said: str
) -> None:
    """Nothing is graded before manual.csv, [people] and the worksheet have been read."""
    a_class.archive({f"Ada_1_{FILE}/r.zip": packed(submission(1))})
    a_class.write("w.csv", table([row(1, "Ada")]))
    a_class.write(name, content)
    graded: list[str] = []

    def grading(*_: object) -> Iterator[GradedFiles]:
        graded.append("begun")
        return iter(())

    monkeypatch.setattr(pool, "run", grading)
    done = a_class.run()
    assert (done.status, graded) == (ExitCode.FAILED, [])
    assert said in done.said


FRENCH = (
    "Identifiant;Nom complet;Numéro d’identification;Statut;Note;Note maximale;"
    "La note peut être modifiée;Dernière modification (travail remis);"
    "Dernière modification (note);Feedback par commentaires\r\n"
    "Participant1;Zoé L’Été;21900001;Remis;;20,00;Oui;mardi 3 mars 2026, 22:59;-;\r\n"
)


@pytest.mark.parametrize(
    "content",
    [
        FRENCH.encode(),
        FRENCH.encode("cp1252"),
        f"\ufeffsep=;\r\n{FRENCH}".encode(),
        ("\ufeff" + FRENCH.replace(";", "\t")).encode("utf-16-le"),
        FRENCH.encode("utf-16-be"),
    ],
    ids=["utf-8", "ansi", "sep", "utf-16 tab", "utf-16-be"],
)
def test_worksheets_of_every_spreadsheet(a_class: Laid, content: bytes) -> None:
    """The dates are read and the marks written, whatever saved the file."""
    a_class.archive({f"Zoé LÉté_1_{FILE}/r.zip": packed(submission(1))})
    a_class.write("w.csv", content)
    a_class.write("course.toml", f"{DEADLINE}[late]\nper_day = 3\n")
    done = a_class.run()
    assert (done.status, done.sent()) == (ExitCode.DONE, {"1": "17,00"})
    assert done.lines()["Zoé L’Été 1"][1] == "Late: 1 d, -3."


ODD = (
    *('=HYPERLINK("http://x")', "+1 Ada", "@cmd", "O'Neil, Rémi", 'Marie "Mimi" Dupont'),
    *("محمد أحمد", "Jean Martin_Test", "Éloïse d’Été", "Thị Minh Anh Nguyễn", "李 小龙"),
)


@pytest.mark.parametrize(
    "clean", [lambda name: name, lambda name: name.replace("’", "").replace('"', "")]
)
def test_odd_names_keep_their_marks(a_class: Laid, clean: Callable[[str], str]) -> None:
    """Formulas, quotes, right to left, accents: each their own mark, and no formula in a cell."""
    label = [clean(name).replace("_", " ").replace("/", "") for name in ODD]
    a_class.archive(
        {
            f"{name}_{k}_{FILE}/r.zip": packed(submission(k / 20, also=str(k)))
            for k, name in enumerate(label, 1)
        }
    )
    a_class.write("w.csv", table([row(k, name) for k, name in enumerate(ODD, 1)]))
    done = a_class.run("--names")
    assert done.sent() == {str(k): f"{k}.00" for k in range(1, len(ODD) + 1)}
    assert not any(name[0] in "=+@-" for name in done.lines())

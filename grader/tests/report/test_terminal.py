"""The report as text, from the content of results.json alone."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import pytest

from grader.course import exercises as manifest
from grader.course.texts import Texts
from grader.report import terminal
from grader.report.summary import Summary

PATH = Path("build/grade/report.html")
FILES = {"main.c": "", "octree.c": ""}


def exercise(number: int, outcome: str, points: float, **other: Any) -> dict[str, Any]:
    """Return an exercise of 4 points, as results.json has it."""
    names = {"id": f"TP1.{number}", "tp": 1, "function": f"f{number}", "file": "main.c"}
    rest = {"title": f"titre {number}", "bonus": False, "outcome": outcome}
    return {**names, **rest, "points": points, "max_points": 4, **other}


def check(number: int, outcome: str, name: str = "a", **other: Any) -> dict[str, Any]:
    """Return a check of an exercise, as results.json has it."""
    names = {"id": f"tp1.f{number}.{name}", "exercise": f"TP1.{number}", "function": f"f{number}"}
    rest = {"title": f"ligne {name}", "outcome": outcome, "message": f"message {name}", "note": ""}
    rest |= {"output": "", "reproducer": ""}
    return {**names, **rest, "hint": "Question ?", "waits_for": [], **other}


def content(*rows: tuple[dict[str, Any], list[dict[str, Any]]], **other: Any) -> dict[str, Any]:
    """Return the content of results.json with these exercises and checks."""
    exercises = [row for row, _ in rows]
    counted = [each for each in exercises if not each["bonus"]]
    return {
        "graded_at": "2026-03-02T08:00:00+01:00",
        "submission": {"name": "rendu", "files": FILES, "sources": [], "nearby": []},
        "isolation": "strong",
        "notes": [],
        "build": {"ok": True, "warnings": [], "log": "", "errors": [], "rejected": {}},
        "score": sum(each["points"] for each in exercises if not each["bonus"]),
        "max_score": sum(each["max_points"] for each in exercises if not each["bonus"]),
        "bonus": sum(each["points"] for each in exercises if each["bonus"]),
        "max_bonus": sum(each["max_points"] for each in exercises if each["bonus"]),
        "incomplete": False,
        "partial": False,
        "opened_tps": [1, 2, 3],
        "unjudged_tps": [5],
        "tps": [
            {
                "tp": tp,
                "score": sum(each["points"] for each in counted if each["tp"] == tp),
                "max_score": sum(each["max_points"] for each in counted if each["tp"] == tp),
            }
            for tp in sorted({each["tp"] for each in counted})
        ],
        "changes": [],
        "same_files_as": "",
        "history": [],
        "exercises": exercises,
        "checks": [each for _, checks in rows for each in checks],
        **other,
    }


def source(name: str, moment: str, folder: str = "core_c") -> dict[str, str]:
    """Return a file of the submission, as results.json has it."""
    return {"name": name, "path": f"{folder}/{name}", "modified": f"2026-{moment}:00+01:00"}


class Terminal(io.StringIO):
    """A file that is a terminal."""

    def isatty(self) -> bool:
        """Say so."""
        return True


def shown(report: dict[str, Any], language: str = "fr") -> list[str]:
    """Return the lines that are printed to a pipe."""
    out = io.StringIO()
    terminal.show(report, PATH, Texts(language), out)
    return out.getvalue().splitlines()


def on_screen(
    report: dict[str, Any], monkeypatch: pytest.MonkeyPatch, columns: int = 120
) -> list[str]:
    """Return the lines that are printed to a terminal, with their colours."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", str(columns))
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    out = Terminal()
    terminal.show(report, PATH, Texts("fr"), out)
    return out.getvalue().splitlines()


def plain(lines: list[str]) -> list[str]:
    """Return lines without their colours."""
    return [re.sub(r"\x1b\[[\d;]*m", "", line) for line in lines]


THREE = (
    (exercise(1, "passed", 4), [check(1, "passed")]),
    (exercise(2, "failed", 2.5), [check(2, "failed")]),
    (exercise(3, "todo", 0, bonus=True), [check(3, "todo")]),
)


def test_one_line_per_exercise_and_totals() -> None:
    """Columns are aligned, decimals are French, bonuses stand apart; piped, nothing is drawn."""
    lines = shown(content(*THREE))
    assert lines[2:6] == [
        "TP1 - Images",
        "  juste     TP1.1  titre 1  f1  4 / 4",
        "  à revoir  TP1.2  titre 2  f2  2,5 / 4",
        "  à faire   TP1.3  titre 3  f3  0 / 4 bonus",
    ]
    assert "Total provisoire : 6,5 / 8" in lines
    assert "TP5 : pas encore jugé par cette version du correcteur." in lines
    with_bonus = shown(content((exercise(1, "passed", 4, bonus=True), [check(1, "passed")])))
    assert "Bonus : 4 / 4" in with_bonus


def test_a_part_of_an_exercise_has_no_points_to_tell(monkeypatch: pytest.MonkeyPatch) -> None:
    """How many checks were run, and how to run the others; nothing is added up."""
    row = exercise(1, "passed", 1, part={"run": 2, "of": 7})
    report = content((row, [check(1, "passed")]), partial=True)
    for lines in (shown(report), plain(on_screen(report, monkeypatch))):
        assert "  juste  TP1.1  titre 1  f1  vérifications faites : 2 sur 7" in lines
        left = "TP1.1 : vérifications qui n'ont pas été faites : 5"
        assert any(line.startswith(left) and "make grade K=TP1.1" in line for line in lines)
        assert not any(line.startswith(("Total", "Bonus")) for line in lines)


def test_a_bonus_alone_has_no_total_of_nothing() -> None:
    """Never "0 / 0"; its own points are told even when there are none."""
    row = exercise(1, "failed", 0, bonus=True)
    lines = shown(content((row, [check(1, "failed")]), partial=True))
    assert "Bonus : 0 / 4" in lines
    assert not any("0 / 0" in line for line in lines)


def test_a_terminal_has_bars_and_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    """The words are the same; what is to do has no colour."""
    lines = on_screen(content(*THREE), monkeypatch)
    assert plain(lines)[3:6] == [
        "  juste     TP1.1  titre 1  f1  ██████████  4 / 4",
        "  à revoir  TP1.2  titre 2  f2  ██████····  2,5 / 4",
        "  à faire   TP1.3  titre 3  f3  ··········  0 / 4 bonus",
    ]
    assert "\x1b[" in lines[3]
    assert lines[5] == plain(lines)[5]


def test_a_narrow_terminal_cuts_titles_and_folds_sentences(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nothing is longer than the terminal is wide; the points are always there."""
    row = exercise(1, "failed", 2, title="Un titre qui est vraiment bien long pour un terminal")
    report = content((row, [check(1, "failed", message="mot " * 40)]))
    lines = plain(on_screen(report, monkeypatch, columns=60))
    assert max(map(len, lines)) <= 60
    assert lines[3].startswith("  à revoir  TP1.1  Un titre")
    assert "…" in lines[3]
    assert lines[3].endswith("  2 / 4")
    folded = [line for line in lines if line.startswith("  mot mot")]
    assert len(folded) == 3


def test_what_gives_way_in_a_narrow_table(monkeypatch: pytest.MonkeyPatch) -> None:
    """First the bars, then some letters of the titles, then the functions; never the points."""
    row = exercise(1, "failed", 2, title="Un titre de vingt-six l.", function="horizontal_gradient")
    report = content((row, [check(1, "failed")]))
    start = "  à revoir  TP1.1  Un titre de vingt"
    for columns, wanted in (
        (90, f"{start}-six l.  horizontal_gradient  █████·····  2 / 4"),
        (80, f"{start}-six l.  horizontal_gradient  ██···  2 / 4"),
        (75, f"{start}-six l.  horizontal_gradient  2 / 4"),
        (66, f"{start}-…  horizontal_gradient  2 / 4"),
        (60, f"{start}-six l.  2 / 4"),
    ):
        lines = plain(on_screen(report, monkeypatch, columns))
        assert lines[3] == wanted


def test_commands_and_points_are_not_torn(monkeypatch: pytest.MonkeyPatch) -> None:
    """At any width, what one copies stands on one line, and no line begins with a colon."""
    report = content((exercise(1, "failed", 2), [check(1, "failed")]))
    for columns in range(40, 90):
        lines = [line.strip() for line in plain(on_screen(report, monkeypatch, columns))]
        assert any("make grade K=f1" in line for line in lines)
        assert any("2 / 4" in line for line in lines)
        assert not any(line.startswith((":", ";", "!", "?", "»")) for line in lines)


def test_what_changed_stands_between_the_total_and_the_next_step() -> None:
    """Since the last full run, and whether the files are the same as then."""
    change = {"exercise": "TP1.1", "kind": "fixed", "points": 4, "was": 0}
    lines = shown(
        content(*THREE, changes=[change], same_files_as="2026-03-02T07:30:00+01:00"), "en"
    )
    at = lines.index("Provisional total: 6.5 / 8")
    assert lines[at + 1 : at + 4] == [
        "TP1.1 is right now.",
        "Your files are exactly those of the last time (07:30). Have you saved them?",
        "",
    ]
    assert lines[-2].startswith("Next step: TP1.2")
    assert lines[-1] == "Report: build/grade/report.html"


def test_each_file_comes_with_its_age() -> None:
    """Counted from the grading; a version nearby is named, more so when it is newer."""
    files = [source("main.c", "03-02T07:57"), source("raytracer.c", "02-27T08:00")]
    files += [source("raytracer.h", "03-01T08:00"), source("octree.c", "01-30T12:00")]
    nearby = [source("main.c", "03-02T07:59", "vieux"), source("octree.c", "01-30T11:00", "old")]
    submission = {"name": "rendu", "sources": files, "nearby": nearby}
    assert shown(content(submission=submission))[1:7] == [
        "  core_c/main.c       modifié il y a 3 min",
        "  core_c/raytracer.c  modifié il y a 3 j",
        "  core_c/raytracer.h  modifié il y a 24 h",
        "  core_c/octree.c     modifié le 2026-01-30",
        "Autre version, plus récente : vieux/main.c, modifié il y a 1 min. "
        "Est-ce celle que vous vouliez faire juger ?",
        "Autre version : old/octree.c, modifié le 2026-01-30.",
    ]


def test_a_file_that_nobody_has_changed_has_no_age() -> None:
    """Its date is that of the archive."""
    files = [{**source("main.c", "02-27T08:00"), "untouched": True}]
    lines = shown(content(submission={"name": "rendu", "sources": files, "nearby": []}))
    assert lines[1] == "  core_c/main.c  tel que distribué"


def test_only_a_weak_isolation_is_told() -> None:
    """Of the strongest nothing need be said."""
    said = {
        level: [line for line in shown(content(*THREE, isolation=level)) if "solation" in line]
        for level in ("strong", "medium", "portable")
    }
    assert said["strong"] == []
    assert len(said["medium"]) == len(said["portable"]) == 1


def test_the_points_of_each_tp_stand_in_one_line() -> None:
    """Where there are several and some points; of a part of the exercises, nothing."""
    rows = [
        (exercise(1, "passed", 4), [check(1, "passed")]),
        (exercise(2, "failed", 1.5, tp=2), [check(2, "failed")]),
    ]
    assert "Par TP : TP1 4 / 4, TP2 1,5 / 4" in shown(content(*rows))
    assert not any(line.startswith("Par TP") for line in shown(content(rows[0])))


TP1 = [
    (exercise(k, "passed", points, max_points=points), [check(k, "passed")])
    for k, points in enumerate((2, 2, 3, 4, 4), start=1)
]
BRAVO = "TP1 terminé, 15 / 15. Bravo !"


def test_a_whole_tp_is_praised_when_it_has_become_right() -> None:
    """The first time, or when it was asked for; not again at each run, nor for a part of it."""
    fixed = {"exercise": "TP1.3", "kind": "fixed", "points": 3, "was": 0}
    other = (exercise(9, "failed", 0, tp=2), [check(9, "failed")])
    runs: list[dict[str, Any]] = [{}, {}]
    assert BRAVO in shown(content(*TP1, other))
    assert BRAVO in shown(content(*TP1, partial=True))
    assert BRAVO in shown(content(*TP1, other, history=runs, changes=[fixed]))
    assert BRAVO not in shown(content(*TP1, other, history=runs))
    assert not any("Bravo" in line for line in shown(content(*TP1[:3], partial=True)))


def test_everything_right_is_praised() -> None:
    """With the whole of the points."""
    rows = [
        (exercise(k, "passed", points, tp=k, max_points=points), [check(k, "passed")])
        for k, points in enumerate((15, 30, 20, 20, 15), start=1)
    ]
    assert "100 / 100 : tous les TP sont justes. Bravo !" in shown(content(*rows))


def step(**other: Any) -> list[str]:
    """Return what is said to do after TP1.2 alone is right."""
    row = (exercise(2, "passed", 2, max_points=2), [check(2, "passed")])
    lines = shown(content(row, partial=True, opened_tps=[1, 2], **other))
    return lines[lines.index("Tout ce qui a été vérifié est juste.") + 1 : -1]


def test_after_a_success_comes_the_next_exercise() -> None:
    """With its command: onwards first, then what was left behind, bonuses last."""
    following = "Prochaine étape : TP1.3, la fonction horizontal_gradient dans main.c."
    assert step() == [f"{following} Puis : make grade K=horizontal_gradient"]
    known = {each.id: "passed" for each in manifest.load().exercises}
    behind = step(earlier={**known, "TP1.1": "failed", "TP2.B1": "todo"})
    assert behind[0].startswith("Prochaine étape : TP1.1, la fonction fill_red")
    bonus = step(earlier={**known, "TP2.B1": "todo"})
    assert bonus[0].startswith("Prochaine étape : TP2.B1, la fonction intersect_cylinder")
    assert "Pour tout juger : make grade" in step(earlier=known)[0]


def test_the_function_to_go_on_with_is_the_one_that_is_wrong() -> None:
    """Of an exercise of several functions, not always the first; in the details too."""
    row = exercise(1, "failed", 2, id="TP5.1", tp=5, function="reflectance")
    names = {"exercise": "TP5.1"}
    right = check(1, "passed", **names, function="reflectance")
    wrong = check(1, "failed", "angle", **names, function="fresnel_schlick")
    lines = shown(content((row, [right, wrong])))
    assert any(line.startswith("TP5.1 fresnel_schlick - ligne angle") for line in lines)
    assert any(
        line.startswith("Prochaine étape : TP5.1, la fonction fresnel_schlick") for line in lines
    )


def test_the_next_hint_is_offered() -> None:
    """After a failure, the command that asks for it; nothing when there is none."""
    more = [{"level": 2, "text": "Deux."}, {"level": 3, "text": "Trois."}]
    asked = shown(content((exercise(1, "failed", 2), [{**check(1, "failed"), "hints": more}])))
    at = asked.index("  Question ?")
    assert asked[at + 1] == "  Pour une indication plus précise : make grade K=TP1.1 HINT=2"
    told = shown(content((exercise(1, "failed", 2), [{**check(1, "failed"), "hints": more[1:]}])))
    assert told[at + 1].endswith("HINT=3")
    last = shown(content((exercise(1, "failed", 2), [check(1, "failed")])))
    assert not any("HINT" in line for line in last)


def test_the_call_can_be_made_again() -> None:
    """The command that does, of one's own files; other people's are in another folder."""
    wrong = (exercise(1, "failed", 2), [check(1, "failed", reproducer="int main(void) {}")])
    own, other = (
        {"name": "x", "sources": [source("main.c", "03-02T07:57", place)], "nearby": []}
        for place in ("core_c", "rendus/ada")
    )
    said = "  Pour refaire cet appel : make try CASE=TP1.1 ; pas à pas, dans gdb :"
    said += " make debug K=TP1.1"
    assert said in shown(content(wrong, submission=own))
    assert said not in shown(content(wrong, submission=other))
    without = (exercise(1, "failed", 2), [check(1, "failed")])
    assert said not in shown(content(without, submission=own))


def test_what_a_broken_file_holds_is_not_said_to_be_wrong() -> None:
    """Its exercises are not built; those of later TPs stay folded, as those to come do."""
    build = {
        **{"ok": False, "errors": [], "log": "", "warnings": []},
        "rejected": {"main.c": "main.c ne compile pas"},
    }
    rows = [
        (exercise(1, "failed", 0), [check(1, "failed")]),
        (exercise(2, "failed", 0, tp=2), [check(2, "failed")]),
        (exercise(3, "failed", 1, tp=3, file="octree.c"), [check(3, "failed")]),
    ]
    lines = shown(content(*rows, build=build))
    assert "  non compilé  TP1.1  titre 1  f1  0 / 4" in lines
    assert "TP2 - Rayons lumineux et objets : à venir, 4 points" in lines
    assert "  à revoir  TP1.3  titre 3  f3  1 / 4" in lines


def test_later_and_closed_tps_fold_into_a_line() -> None:
    """The current TP is shown whole; those to come, and those not open, in a line."""
    rows = [
        (exercise(number, outcome, 0, tp=tp), [check(number, outcome)])
        for number, (tp, outcome) in enumerate(
            [(1, "failed"), (2, "todo"), (2, "blocked"), (3, "crashed"), (4, "todo"), (5, "todo")]
        )
    ]
    lines = shown(content(*rows))
    titles = [line for line in lines if line.startswith(("TP1 -", "TP2 -", "TP3 -", "Pas encore"))]
    assert titles == [
        "TP1 - Images",
        "TP3 - Lumière et matière",
        "TP2 - Rayons lumineux et objets : à venir, 8 points",
        "Pas encore ouverts : TP4, TP5.",
    ]
    every = shown(content(*rows, partial=True))
    assert sum(line.startswith("TP") and " - " in line for line in every) >= 5


def test_the_first_failure_of_each_exercise_is_explained() -> None:
    """With message and question, and how to see the others; a part that is asked for, whole."""
    rows = [check(1, "crashed", "a"), check(1, "crashed", "b"), check(1, "failed", "c")]
    lines = shown(content((exercise(1, "crashed", 0), rows)))
    at = lines.index("TP1.1 f1 - ligne a")
    more = "  (autres vérifications à revoir : 2 ; pour les voir : make grade K=f1)"
    assert lines[at + 1 :][:3] == ["  message a", "  Question ?", more]
    assert "TP1.1 f1 - ligne c" not in lines
    lines = shown(content((exercise(1, "crashed", 0), rows), partial=True))
    assert "TP1.1 f1 - ligne b" not in lines
    assert lines[lines.index("TP1.1 f1 - ligne c") + 1 :][:2] == ["  message c", "  Question ?"]


def test_what_was_printed_is_shown() -> None:
    """Its first lines, as text and never as orders to the terminal."""
    printed = "".join(f"ligne {k}\x07\n" for k in range(9))
    lines = shown(content((exercise(1, "failed", 0), [check(1, "failed", output=printed)])))
    at = lines.index("  Ce que votre programme a affiché :")
    assert lines[at + 1 :][:6] == [*(f"    ligne {k}\ufffd" for k in range(5)), ""]


def test_no_wall_of_failures() -> None:
    """Beyond a screenful, exercises are named only."""
    rows = [(exercise(k, "failed", 0), [check(k, "failed")]) for k in range(10)]
    lines = shown(content(*rows))
    assert sum(line == "  message a" for line in lines) == 8
    assert "À revoir aussi : TP1.8, TP1.9." in lines


def test_the_next_step_is_the_first_that_can_be_done() -> None:
    """What is right or waits for something else is not the next step."""
    waiting = check(2, "blocked", note="Attendre.", waits_for=["TP1.3"])
    lines = shown(
        content(
            (exercise(1, "passed", 4), [check(1, "passed")]),
            (exercise(2, "blocked", 0), [waiting]),
            (exercise(3, "todo", 0), [check(3, "todo")]),
        )
    )
    assert "Prochaine étape : TP1.3, la fonction f3 dans main.c. Puis : make grade K=f3" in lines
    assert lines[lines.index("TP1.2 f2 - ligne a") + 1] == "  Attendre."
    assert "  message a" in lines  # what is seen meanwhile
    assert "  Question ?" not in lines
    assert "Tout est encore à écrire : c'est le point de départ." not in lines


def test_a_file_that_does_not_compile_shows_its_first_errors() -> None:
    """Three of them, with the source line; its checks have nothing to add, nor to be done next."""
    error = {"file": "main.c", "line": 1, "meaning": "Un point-virgule ?"}
    errors = [{**error, "lines": [f"main.c:{k}: error", f"  {k} | x"]} for k in range(5)]
    build = {"ok": False, "errors": errors, "rejected": {"main.c": "-"}, "log": "", "warnings": []}
    lines = shown(content((exercise(1, "failed", 0), [check(1, "failed")]), build=build))
    assert lines[2:6] == [
        "main.c ne compile pas encore ; les autres fichiers sont jugés sans lui.",
        "  main.c:0: error",
        "    0 | x",
        "  Un point-virgule ?",
    ]
    assert "  ... et 2 de plus dans build/grade/report.html" in lines
    assert "  message a" not in lines
    assert "Prochaine étape : faire compiler main.c. Puis : make grade" in lines


def test_only_warnings_that_have_a_meaning_are_listed() -> None:
    """A handful of them; of the others, which are in the compiler's English, their number."""
    warnings = [f"main.c:{k}: warning: w\n  {k} | x" for k in range(13)]
    advice = [f"main.c:{k} : la variable x ne sert jamais (f)." for k in range(10)]
    build = {"ok": True, "errors": [], "rejected": {}, "log": "", "warnings": warnings}
    build |= {"advice": advice}
    lines = shown(content((exercise(1, "passed", 4), [check(1, "passed")]), build=build))
    first = lines.index("Le compilateur signale (sans effet sur les points) :") + 1
    assert lines[first : first + 11] == [
        *(f"  {each}" for each in advice[:8]),
        "  ... et 2 de plus dans build/grade/report.html",
        "  (autres messages du compilateur : 3, dans build/grade/report.html)",
        "",
    ]
    assert not any("warning: w" in line for line in lines)


def test_what_a_warning_means_stands_in_its_place() -> None:
    """The sentence instead of the compiler's line; one without stands on the page alone."""
    warnings = [f"main.c:{k}: warning: w\n  {k} | x" for k in range(2)]
    advice = ["main.c:1 : la variable x ne sert jamais (f)."]
    build = {"ok": True, "errors": [], "rejected": {}, "log": "", "warnings": warnings}
    build |= {"advice": advice}
    lines = shown(content((exercise(1, "passed", 4), [check(1, "passed")]), build=build))
    first = lines.index("Le compilateur signale (sans effet sur les points) :") + 1
    assert lines[first : first + 3] == [
        f"  {advice[0]}",
        "  (autres messages du compilateur : 1, dans build/grade/report.html)",
        "",
    ]


def test_warnings_without_a_meaning_are_one_line() -> None:
    """No title above nothing."""
    warnings = ["main.c:1: warning: w"]
    build = {"ok": True, "errors": [], "rejected": {}, "log": "", "warnings": warnings}
    build |= {"advice": []}
    lines = shown(content((exercise(1, "passed", 4), [check(1, "passed")]), build=build))
    (told,) = [k for k, line in enumerate(lines) if "compilateur" in line]
    assert lines[told - 1 : told + 2] == [
        "",
        "(messages du compilateur, sans effet sur les points : 1, dans build/grade/report.html)",
        "",
    ]


def test_what_waits_makes_the_total_a_lower_bound() -> None:
    """Provisional, and "at least"."""
    rows = [check(1, "blocked", note="Il faut d'abord écrire TP1.2.")]
    lines = shown(content((exercise(1, "blocked", 0), rows)), "en")
    assert any(line.startswith("Provisional total: at least 0 / 4") for line in lines)


def test_an_incomplete_or_partial_report_says_so() -> None:
    """Nobody takes it for a mark."""
    lines = shown(
        content((exercise(1, "error", 0), [check(1, "error")]), incomplete=True, partial=True), "en"
    )
    assert any(line.startswith("Incomplete report") for line in lines)
    assert any(line.startswith("Partial run") for line in lines)


def test_control_characters_of_a_submission_are_not_obeyed() -> None:
    """A file's name or a message cannot clear the screen or colour it."""
    submission = {"name": "a\x1b[2Jb\rc", "sources": [], "nearby": []}
    lines = shown(content(submission=submission))
    assert lines[0] == "Rendu : a�[2Jb�c"


def test_what_is_wrong_comes_before_what_is_to_do() -> None:
    """A bonus too, when it is there and wrong; of what is to do, and of what is wrong, the core."""
    rows = [("TP2.B1", "failed", True), ("TP3.1", "todo", False), ("TP3.B1", "todo", True)]
    exercises = [{"id": name, "outcome": what, "bonus": bonus} for name, what, bonus in rows]

    def following(*left: int) -> str:
        chosen = [exercises[k] for k in left]
        found = Summary({"exercises": chosen}, Texts("fr")).next_exercise()
        return found["id"] if found else ""

    assert [following(0, 1, 2), following(1, 2), following(2), following()] == [
        *("TP2.B1", "TP3.1", "TP3.B1", ""),
    ]

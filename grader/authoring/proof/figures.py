"""The figures of the proof: results.json, what the last whole runs gave, and the README's table.

reference/mistakes/proof.json keeps what each part gave when it was last run whole; the table of
README.md is made from it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from string import Formatter

from grader.authoring.specimens.wrong import FOLDER
from grader.course.exercises import ROOT
from grader.course.message import GraderError
from grader.files import write_whole
from grader.report.results import write

KEYS = (
    *("known_mistakes", "caught", "named_right", "named_wrong", "named_none"),
    *("half_written", "half_written_shown", "half_right", "half_right_calm"),
    *("mutants", "equivalent", "mutation_score", "mutation_score_worst_function"),
    *("variants", "variants_full", "runs", "flaky"),
    *("sentences", "sentences_broken", "breaches", "breaches_caught", "cases", "cases_fair"),
    *("slips", "slips_caught", "fresh", "fresh_full"),
)
PROOF = FOLDER / "proof.json"
README = ROOT / "README.md"
BEGIN, END = "<!-- BEGIN PROOF: written by make prove -->", "<!-- END PROOF -->"

Figures = Mapping[str, float]


class FiguresError(GraderError):
    """A file that figures are kept in cannot be used: the file and the cure in one line."""


def results(figures: Figures) -> dict[str, float | None]:
    """Return the content of results.json; what was not measured is null."""
    return {key: figures.get(key) for key in KEYS}


def keep(figures: Figures, path: Path = PROOF) -> None:
    """Put the figures of a part that was run whole to those of the others.

    Raises FiguresError, OSError.
    """
    write(path, {**(kept(path) if path.exists() else {}), **figures})


def kept(path: Path = PROOF) -> dict[str, float]:
    """Read the figures of the last whole runs. Raises FiguresError."""
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        raise FiguresError(f"{path.name}: {error}; make it again: make prove") from error


def table(figures: Figures) -> str:
    """Return the README's table: a line for each part that was run."""
    lines = [each for each in _LINES if all(name in figures for name in _names(each))]
    rows = [f"| {what} | {how} |".format_map(figures) for what, how in lines]
    return "\n".join(["| what was tried | what came out |", "|---|---|", *rows])


def _names(line: Sequence[str]) -> list[str]:
    """Return the figures that a line of the table tells."""
    parsed = Formatter().parse(" ".join(line))
    return [name for _, name, _, _ in parsed if name is not None]


_LINES = (
    (
        "{known_mistakes:.0f} known mistakes",
        "{caught:.0f} lose points in their own exercise, {elsewhere:.0f} in another;"
        " {named_right:.0f} named right, {named_wrong:.0f} wrong",
    ),
    (
        "{half_written:.0f} half-written programs with one, without the reference",
        "in {half_written_shown:.0f} it is shown at its exercise, and nothing else is red;"
        " {half_right_calm:.0f} of {half_right:.0f} right ones have nothing red",
    ),
    (
        "{sentences:.0f} sentences of the contracts",
        "{sentences_broken:.0f} can be broken: {breaches_caught:.0f} of {breaches:.0f} programs"
        " that break one, and nothing else, lose points there",
    ),
    (
        "{slips:.0f} mistakes that students may well make",
        "{slips_caught:.0f} lose points in their own exercise",
    ),
    (
        "{cases:.0f} programs from outside",
        "{cases_fair:.0f} lose what a teacher takes off, where they are wrong, and no more",
    ),
    (
        "{pairs:.0f} pairs of mistakes",
        "{pairs_caught:.0f} lose points for both; in {pairs_third_named:.0f} a third is named;"
        " {mendings_lowered:.0f} mendings of one cost points",
    ),
    (
        "{mutants:.0f} small changes of the solution",
        "{mutation_score:.1%} caught, {mutation_score_worst_function:.1%} in the worst function;"
        " {equivalent:.0f} change nothing",
    ),
    ("{variants:.0f} right solutions written differently", "{variants_full:.0f} have every point"),
    ("{fresh:.0f} of them on inputs that nobody has seen", "{fresh_full:.0f} have every point"),
    ("{thoughtless:.0f} that are no work", "{thoughtless_earning:.0f} earn points"),
    ("{runs:.0f} grades of the same submissions", "{flaky:.0f} differ"),
)


def in_readme(text: str, figures: Figures) -> str:
    """Return the README's text with the table of these figures. Raises FiguresError."""
    if text.count(BEGIN) != 1 or text.count(END) != 1 or text.index(BEGIN) > text.index(END):
        raise FiguresError(f"{README.name}: put back its lines {BEGIN} and {END}")
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{table(figures)}\n{END}{after}"


def write_readme(path: Path = README, proof: Path = PROOF) -> None:
    """Put the table of the last whole runs into the README. Raises FiguresError, OSError."""
    text = in_readme(path.read_text(encoding="utf-8"), kept(proof))
    write_whole(path, text)

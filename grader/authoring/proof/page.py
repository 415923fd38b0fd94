"""The page of the proof: figures, faults, and a table for each part."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from grader.authoring.proof.figures import results
from grader.authoring.proof.parts import Part

NAMES = {
    "known_mistakes": "known mistakes",
    "caught": "that lose points in their own exercise",
    "elsewhere": "that lose points in another",
    "named_right": "named right",
    "named_wrong": "named wrong",
    "named_none": "not named",
    "half_written": "half-written programs with one, without the reference",
    "half_written_shown": "in which it is shown at its exercise, and nothing else is red",
    "half_right": "half-written programs that are right so far",
    "half_right_calm": "in which nothing is red",
    "sentences": "sentences of the contracts",
    "sentences_broken": "that a program can break",
    "breaches": "programs that break one",
    "breaches_caught": "that lose points there",
    "slips": "mistakes that students may well make",
    "slips_caught": "that lose points in their own exercise",
    "cases": "programs from outside",
    "cases_fair": "that lose what they deserve to lose",
    "pairs": "pairs of mistakes",
    "pairs_caught": "that lose points for both",
    "pairs_third_named": "in which a third is named",
    "mendings": "mendings of one of a pair",
    "mendings_lowered": "exercises in which one costs points",
    "mutants": "small changes of the solution",
    "equivalent": "that change nothing",
    "mutation_score": "share of the others that is caught",
    "mutation_score_worst_function": "in the worst function",
    "variants": "right solutions written differently",
    "variants_full": "that have every point",
    "variant_builds": "builds of them, by gcc and by clang",
    "variant_builds_full": "that have every point",
    "fresh": "right solutions on inputs that nobody has seen",
    "fresh_full": "that have every point",
    "thoughtless": "submissions that are no work",
    "thoughtless_earning": "that earn points",
    "runs": "grades of the same submissions",
    "flaky": "that differ",
}
_SHARES = ("mutation_score", "mutation_score_worst_function")


def render(parts: Sequence[Part]) -> str:
    """Return the page of the parts."""
    made = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    figures = {key: value for each in parts for key, value in each.figures.items()}
    missing = [key for key, value in results(figures).items() if value is None]
    return made.get_template("page.html").render(
        parts=[(each, _lines(each)) for each in parts], missing=[NAMES[key] for key in missing]
    )


def _lines(part: Part) -> list[tuple[str, str]]:
    """Return the names and values of a part's figures, as text."""
    return [(NAMES[key], _text(key, value)) for key, value in part.figures.items()]


def _text(key: str, value: float) -> str:
    return f"{value:.2%}" if key in _SHARES else f"{value:.0f}"

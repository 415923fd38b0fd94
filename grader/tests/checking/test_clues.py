"""What all the wrong answers have in common, and the question that follows what is wrong."""

from __future__ import annotations

import numpy as np
import pytest

from grader.checking import clues, describe
from grader.checking.clues import Array
from grader.course import exercises
from grader.course.message import Message
from grader.course.texts import LANGUAGES, Texts, sentences

RIGHT = np.random.default_rng(3).uniform(0.2, 3, (40, 3)).astype(np.float32)
UNIT = RIGHT / np.linalg.norm(RIGHT, axis=1, keepdims=True)
ONE = np.float32(1)
COLUMN = RIGHT[:, 0]


def clue(got: Array, right: Array = RIGHT) -> Message | None:
    """Return the clue of answers, wrong where they differ from the right ones."""
    differs = np.abs(got.astype(float) - right).reshape(len(right), -1).max(axis=1)
    return clues.of(got, right, ~(differs <= 1e-4), 1e-4)


@pytest.mark.parametrize(
    ("factor", "text"),
    [
        (np.pi, "pi"),
        (1 / np.pi, "1 / pi"),
        (np.pi**2, "pi²"),
        (8.0, "8"),
        (1 / 8, "1 / 8"),
        (255.0, "255"),
        (2.0, "2"),
        (-2.0, "-2"),
        (np.pi / 180, "pi / 180"),
        (1.7, "1.7"),
    ],
)
def test_a_constant_factor_is_told_by_its_name(factor: float, text: str) -> None:
    """Of colours, of vectors, of numbers."""
    for right in (RIGHT, COLUMN):
        assert clue(right * np.float32(factor), right) == Message("clue.factor", {"factor": text})


def test_a_variable_without_a_first_value_is_told() -> None:
    """Its answers are what the stack was filled with, and what has been added to that."""
    paint = np.frombuffer(b"\xfe" * 4 * RIGHT.size, "f4").reshape(RIGHT.shape)
    assert clue(paint + RIGHT) == clue(paint) == Message("clue.unset")
    assert clue(np.where(np.arange(40)[:, None] > 20, paint, RIGHT)) == Message("clue.unset")
    whole = np.arange(40, dtype=np.int32)
    assert clue(np.full(40, -16843010, np.int32), whole) == Message("clue.unset")
    seeds = whole.astype(np.uint32)
    assert clue(np.full(40, 0xFEFEFEFE, np.uint32), seeds) == Message("clue.unset")
    assert clue(seeds + np.uint32(1), seeds) != Message("clue.unset")


@pytest.mark.parametrize("pi", [3.14, 3.1, 3.0])
def test_a_pi_with_few_decimals_is_told(pi: float) -> None:
    """Be it above the bar or below; of 3.1416 nothing is wrong."""
    for factor in (pi / np.pi, np.pi / pi):
        assert clue(RIGHT * np.float32(factor)) == Message("clue.pi", {"pi": f"{pi:g}"})


PATTERNS: dict[str, tuple[Array, dict[str, object]]] = {
    "opposite": (-RIGHT, {}),
    "constants": (RIGHT * np.float32(1.02), {"factor": "1.02"}),
    "exchanged": (RIGHT[:, [2, 1, 0]], {"names": "(z, y, x)"}),
    "sign": (RIGHT * np.array([1, -1, 1], np.float32), {"names": "y"}),
    "dropped": (RIGHT * np.array([1, 1, 0], np.float32), {"names": "z"}),
    "zero": (np.vstack([RIGHT[:20] * 0, RIGHT[20:]]), {}),
    "limited": (np.clip(RIGHT, 0, 1), {}),
    "offset": (RIGHT + np.array([0, 0, 1], np.float32), {"offset": "(0, 0, 1)"}),
    "grey": (np.repeat(RIGHT.mean(axis=1, keepdims=True), 3, axis=1), {}),
    "varying": (RIGHT * np.linspace(0.1, 0.5, 40, dtype=np.float32)[:, None], {}),
    "constant": (np.full_like(RIGHT, 0.5), {"value": "(0.5, 0.5, 0.5)"}),
    "nan": (np.full_like(RIGHT, np.nan), {}),
}


@pytest.mark.parametrize("name", PATTERNS)
def test_a_pattern_is_told(name: str) -> None:
    """With what it needs to be said, and a question of its own, in both languages."""
    got, values = PATTERNS[name]
    found = clue(got)
    assert found == Message(f"clue.{name}", values)
    for language in LANGUAGES:
        texts = Texts(language)
        assert texts.say(found.key, **found.values)
        wrong = Message("failure.result", then=(found,))
        asked = clues.question(wrong, "tp3.shade.both", texts)
        assert asked
        assert "{" not in asked


def test_a_direction_of_another_length_is_told() -> None:
    """Where unit vectors are expected."""
    got = UNIT * np.linspace(0.5, 2, 40, dtype=np.float32)[:, None]
    assert clue(got, UNIT) == Message("clue.length")


@pytest.mark.parametrize(
    "got",
    [
        RIGHT + np.random.default_rng(4).normal(0, 0.1, RIGHT.shape).astype(np.float32),
        np.vstack([RIGHT[:1] * 2, RIGHT[1:2] * 2, RIGHT[2:]]),  # too few to tell
        np.vstack([RIGHT[:20] * 2, RIGHT[20:] * 3]) + ONE,
        RIGHT * np.float32(1.0001),
    ],
)
def test_what_has_nothing_in_common_has_no_clue(got: Array) -> None:
    """Nothing is guessed."""
    assert clue(got) is None


def test_wrong_answers_from_a_depth_on_are_told() -> None:
    """When all up to it are right, and only then."""
    depths = np.arange(12)
    found = Message("clue.depth", {"depth": 6})
    assert clues.deeper(depths, depths >= 6) == found
    assert clues.deeper(depths, (depths >= 6) & (depths < 11)) is None
    assert clues.deeper(depths, depths >= 0) is None


@pytest.mark.parametrize(
    ("got", "right", "texts"),
    [
        (1.035, 1.0345, ("1.035", "1.0345")),
        ([1.0351, 1, 0], [1.0352, 1, 0], ("(1.0351, 1, 0)", "(1.0352, 1, 0)")),
        ([0.5, 2, 0], [0.25, 2, 0], ("(0.5, 2, 0)", "(0.25, 2, 0)")),
        (np.uint32(1), np.uint32(4009123456), ("1", "4009123456")),
        (np.int32(3), np.int32(4), ("3", "4")),
        (False, True, ("false", "true")),
    ],
)
def test_two_numbers_that_differ_are_told_apart(
    got: object, right: object, texts: tuple[str, str]
) -> None:
    """With as many digits as it takes, and a whole number with all of them."""
    sides = [
        np.array(each, np.float32) if isinstance(each, float | list) else each
        for each in (got, right)
    ]
    assert describe.pair(*sides) == dict(zip(("got", "expected"), texts, strict=True))


def test_every_question_on_a_part_has_its_check() -> None:
    """The names that stand before a part are those of checks."""
    checks = exercises.load().checks()
    names = {each.partition(".")[2] for each in checks} | {
        each.rpartition(".")[2] for each in checks
    }
    asked = [each.split(".")[1:] for each in sentences("en") if each.startswith("ask.")]
    parts = [each for each in asked if len(each) > 1 and each[0] not in ("clue", "more")]
    assert parts
    assert all(".".join(each[:-1]) in names for each in parts)

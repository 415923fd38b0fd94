"""Suites that are lines of the manifest: what is drawn, and what a wrong line is told."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grader.authoring.expected.vectors import lines
from grader.authoring.expected.vectors.maker import Maker
from grader.checking.expected_data import SIZE, Array
from grader.course.exercises import ROOT, ManifestError
from grader.execution.session import Limits, open_core

SUITE = "intersect_plane.far"
PLANE: dict[str, Any] = {
    "r": {"dir": {"first": [[0, -2, 0]], "low": -1, "high": [1, -0.5, 1], "unit": True}},
    "obj": {"type": "PLANE", "normal": [0, 1, 0], "dist": {"low": 1, "high": 9}},
}


@pytest.fixture(scope="module")
def maker(cache: Path) -> Iterator[Maker]:
    """Return a maker of inputs."""
    with (
        open_core(ROOT / "reference", *SIZE, cache=cache) as core,
        core.session(Limits(cpu=60)) as session,
    ):
        yield Maker(core, session, 7)


def made(maker: Maker, suite: str, inputs: object, drawn: int = 5) -> Mapping[str, Array]:
    """Return the arguments of the calls of a line."""
    line = {"within": 1e-4, "why": "x", "drawn": drawn, "inputs": inputs}
    (question,) = lines._recipe(suite, line).make(maker)
    return question.batch.args


def test_first_numbers_come_before_drawn_ones(maker: Maker) -> None:
    """In the range of each component; what is one value is the same in every call."""
    args = made(maker, SUITE, PLANE)
    way, plane = args["r"]["dir"], args["obj"]
    assert len(way) == 6
    assert way[0].tolist() == [0, -1, 0]
    assert np.allclose(np.linalg.norm(way, axis=1), 1)
    assert (way[:, 1] < 0).all()
    assert (plane["type"] == maker.core.constants["PLANE"]).all()
    assert (plane["normal"] == [0, 1, 0]).all()
    assert len(set(plane["dist"].tolist())) == 6
    assert ((plane["dist"] >= 1) & (plane["dist"] <= 9)).all()


def test_what_is_not_said_is_ordinary(maker: Maker) -> None:
    """A ray's range, an object's material; what is only written holds no number of an answer."""
    args = made(maker, SUITE, PLANE)
    assert (args["r"]["tmax"] == 1000).all()
    assert (args["obj"]["mat"]["kd"] > 0).all()
    assert (args["it"]["position"] == -77).all()


def test_ints_are_whole(maker: Maker) -> None:
    """The ends of the range are among them."""
    where = {name: {"first": [3], "low": 0, "high": 2} for name in ("i", "j")}
    args = made(maker, "pixel_color.some", where, drawn=60)
    assert (args["i"].dtype.kind, int(args["i"][0])) == ("i", 3)
    assert set(args["i"][1:].tolist()) == {0, 1, 2}


@pytest.mark.parametrize(
    ("inputs", "told"),
    [
        ({"x": 1}, "intersect_plane has no parameter x"),
        ({"obj": {"size": 1}}, "its inputs: no field of name size"),
        ({"obj": {"type": "PLAIN"}}, "its inputs: 'PLAIN'"),
        ({"obj": {"dist": {"from": 1}}}, "its inputs: from is none of first, high, low, unit"),
        ({"obj": {"dist": {"low": 1}}}, "its inputs: 'high'"),
        ({"obj": 1}, "its inputs: of a struct its fields are said, such as type"),
        ({"r": {"dir": {"first": [[0, 1]], "low": 0, "high": 1}}}, "its inputs: could not broad"),
    ],
)
def test_a_wrong_line_is_told(maker: Maker, inputs: object, told: str) -> None:
    """In one line, with the file and the suite."""
    with pytest.raises(ManifestError, match=rf"^exercises\.toml: {SUITE}: {told}") as error:
        made(maker, SUITE, inputs)
    assert "\n" not in str(error.value)


def test_a_line_without_its_tolerance_is_told() -> None:
    """Before anything is built."""
    with pytest.raises(ManifestError, match=r"odd: missing or malformed key: 'within'"):
        lines._recipe("reflectance.odd", {"why": "x"})


def test_what_nothing_is_said_of_is_told(maker: Maker) -> None:
    """A number has no ordinary value."""
    with pytest.raises(ManifestError, match=r"odd: its inputs: nothing is said of n2"):
        made(maker, "reflectance.odd", {"n1": 1})

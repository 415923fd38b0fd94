"""What a reproducer prints after its call: a part of the answers, beside what is expected there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grader.checking import c_literals
from grader.checking.describe import value
from grader.checking.expected_data import Batch


@dataclass(frozen=True)
class Look:
    """What is printed after the call: a part of the answers, such as "result" or "it.normal".

    `expected` is its right value, None when it cannot be said in a number. What was left in an
    output parameter is set `before` the call where the student's function writes nothing there.
    """

    pick: str
    expected: Any = None
    before: Any = None
    unit: bool = False  # only the direction counts


def setting_before(looks: Sequence[Look]) -> Iterator[str]:
    """Yield what sets the output parameters where a function may write nothing."""
    for each in looks:
        if each.before is not None:
            yield f"{each.pick} = {c_literals.literal(each.before)};"


def sample_of(batch: Batch, pick: str) -> Any:
    """Return an item of the type that a part of the answers has."""
    name, *fields = pick.split(".")
    if name == "result":
        assert batch.answers[0].result is not None
        return batch.answers[0].result[0]
    item: Any = batch.args[name][0]
    for field in fields:
        item = item[field]
    return item


def printing_of(look: Look, sample: Any) -> str:
    """Return the statement that prints what is looked at."""
    pick = "direction" if look.unit else look.pick
    return printing(pick, pick, sample)


def printing(name: str, expression: str, sample: Any) -> str:
    """Return the statement that prints an expression of the sample's type."""
    array = np.asarray(sample)
    if array.ndim:
        marks = ", ".join(["%g"] * array.size)
        if expression.endswith("user"):
            parts = ", ".join(f"{expression}[{k}]" for k in range(array.size))
        else:
            parts = ", ".join(f"{expression}.{each}" for each in "xyz")
        return f'printf("{name} = ({marks})\\n", {parts});'
    if array.dtype.kind == "b":
        return f'printf("{name} = %s\\n", {expression} ? "true" : "false");'
    mark = {"i": "%d", "u": "%u"}.get(array.dtype.kind, "%g")
    return f'printf("{name} = {mark}\\n", {expression});'


def aligned(rows: Sequence[tuple[str, Any]]) -> Iterator[str]:
    """Yield statements with what is expected behind them, in one column."""
    width = max((len(statement) for statement, expected in rows if expected is not None), default=0)
    for statement, expected in rows:
        comment = "" if expected is None else f" /* $expected {value(expected)} */"
        yield f"{statement.ljust(width)}{comment}" if comment else statement

"""Tests with many parameters: some quick, a sample for `make test-all`, the others exhaustive."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def sampled(
    everything: Iterable[Any], sample: Collection[Any], quick: Collection[Any] | None = None
) -> list[Any]:
    """Return the parameters of a test, those outside the sample marked `exhaustive`.

    Of the sample, those outside `quick` are marked `long`. Several values of one test are a tuple.
    """
    return [_parameter(each, sample, sample if quick is None else quick) for each in everything]


def _parameter(each: Any, sample: Collection[Any], quick: Collection[Any]) -> Any:
    values = each if isinstance(each, tuple) else (each,)
    if each not in sample:
        return pytest.param(*values, marks=pytest.mark.exhaustive)
    return pytest.param(*values, marks=() if each in quick else pytest.mark.long)

"""Tests with many parameters: `make test` runs a sample, `make test-all` the others too."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def sampled(everything: Iterable[Any], sample: Collection[Any]) -> list[Any]:
    """Return the parameters of a test, those outside the sample marked `exhaustive`.

    Several values of one test are a tuple.
    """
    return [_parameter(each, each in sample) for each in everything]


def _parameter(each: Any, in_sample: bool) -> Any:
    values = each if isinstance(each, tuple) else (each,)
    return pytest.param(*values, marks=() if in_sample else pytest.mark.exhaustive)

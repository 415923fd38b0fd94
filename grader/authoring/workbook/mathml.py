"""The workbook's formulas as MathML, so that an exported page shows them without a network."""

from __future__ import annotations

import re

from latex2mathml.converter import convert

# Formulas in a Markdown text; what is code is the first group.
FORMULA = re.compile(r"(```.*?```|`[^`]*`)|\$\$(.+?)\$\$|\$([^$]+)\$", re.DOTALL)
# What TeX sets a little apart, and the converter does not: a function's name, if no bracket does.
_FUNCTION = re.compile(r"(\\(?:cos|tan|arccos)) +(?=[\w\\])")
# The comma of a French number, which would be set as one between two things.
_COMMA = re.compile(r"<mrow><mo>&#x0002C;</mo></mrow>")


class MathError(ValueError):
    """A formula that is not read to its end."""


def formulas(text: str) -> str:
    """Return a Markdown text with MathML in place of its formulas; code stays as it is."""

    def written(match: re.Match[str]) -> str:
        code, block, inline = match.groups()
        return code or (mathml(block, "block") if block else mathml(inline))

    return FORMULA.sub(written, text)


def mathml(formula: str, display: str = "inline") -> str:
    """Return a formula as one `<math>` element. Raises MathError."""
    try:
        made = convert(_FUNCTION.sub(r"\1\\,", formula), display=display)
    except Exception as error:  # the converter's own, or an IndexError of its parser
        raise MathError(f"{formula}: {type(error).__name__}") from error
    if "\\" in made or formula.count("{") != formula.count("}"):
        raise MathError(f"{formula}: it holds what is not known, or a brace is missing")
    return _COMMA.sub('<mo lspace="0" rspace="0">,</mo>', made)

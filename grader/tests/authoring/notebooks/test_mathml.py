"""Formulas as MathML: what the notebooks use is known, anything else is refused."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from grader.authoring.workbook.mathml import FORMULA, MathError, formulas, mathml
from grader.authoring.workbook.notebooks import LANGUAGES, NOTEBOOKS


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_formula_of_the_workbook_is_known(language: str) -> None:
    """Each becomes one well-formed element that holds no TeX."""
    texts = "\n\n".join(path.read_text("utf-8") for path in (NOTEBOOKS / language).glob("*.md"))
    wanted = sum(1 for match in FORMULA.finditer(texts) if not match[1])
    assert wanted > 200
    found = re.findall(r"<math .*?</math>", formulas(texts))
    assert len(found) == wanted
    for each in found:
        ElementTree.fromstring(each)
        assert "\\" not in each


@pytest.mark.parametrize(
    ("formula", "shown"),
    [
        ("j \\times w", "j×w"),
        ("-1{,}7", "−1,7"),
        ("88\\,573", "88573"),
        ("\\cos 60°", "cos60°"),
        ("\\left( \\frac{a}{2} \\right)^2", "(a2)2"),
        ("\\operatorname{atan2}(d_x)", "atan2(dx)"),
        ("a < b", "a<b"),
        ("I'[x]", "I′[x]"),
    ],
)
def test_what_a_formula_shows(formula: str, shown: str) -> None:
    """Numbers keep their marks, a minus is a minus, functions are words."""
    assert "".join(ElementTree.fromstring(mathml(formula)).itertext()) == shown


def test_scripts_belong_to_what_stands_before_them() -> None:
    """One base, with what is lowered and what is raised."""
    assert "<msubsup><mi>k</mi><mi>d</mi><mn>2</mn></msubsup>" in mathml("k_d^2")
    assert "<msub><mover" in mathml("\\vec{z}_r")
    assert "<msup><mi>r</mi><mn>2</mn></msup>" in mathml("- r^2")


def test_what_stands_apart_and_what_does_not() -> None:
    """A function's name is followed by a space, unless a bracket is; a decimal comma by none."""
    assert "<mspace" in mathml("\\cos 60°")
    assert "<mspace" not in mathml("\\arccos(x)")
    assert '<mo lspace="0" rspace="0">,</mo>' in mathml("1{,}7")


def test_code_is_no_formula() -> None:
    """Dollars in code stay."""
    assert formulas("`$x$` and\n```sh\necho $HOME $x\n```\n") == (
        "`$x$` and\n```sh\necho $HOME $x\n```\n"
    )


@pytest.mark.parametrize("formula", ["\\nothing x", "\\frac", "{a", "\\begin{matrix}"])
def test_what_is_not_known_is_refused(formula: str) -> None:
    """The error holds the formula."""
    with pytest.raises(MathError, match=re.escape(formula)):
        mathml(formula)

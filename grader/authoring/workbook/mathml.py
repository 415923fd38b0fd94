"""The workbook's formulas as MathML, so that an exported page shows them without a network.

Only what the notebooks use of TeX is known; anything else raises `MathError`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from html import escape

TOKEN = re.compile(r"\\[A-Za-z]+|\\.|\d+(?:(?:\.|\{,\}|\\,)\d+)*|\S|\\\\")
# Formulas in a Markdown text; what is code is the first group.
FORMULA = re.compile(r"(```.*?```|`[^`]*`)|\$\$(.+?)\$\$|\$([^$]+)\$", re.DOTALL)
NUMBER_MARKS = {"{,}": ",", "\\,": "\N{NARROW NO-BREAK SPACE}"}
LETTERS = {"pi": "π", "varepsilon": "ε"}
OPERATORS = {
    **{"cdot": "⋅", "times": "×", "wedge": "∧", "pm": "±", "le": "≤", "approx": "≈", "in": "∈"},
    **{"dots": "…", "lfloor": "⌊", "rfloor": "⌋", "lVert": "‖", "rVert": "‖"},
}
SCRIPTS = ("^", "_")
FUNCTIONS = ("cos", "tan", "arccos")
SPACES = {"\\,": "0.17em", "\\;": "0.28em", "\\ ": "0.33em", "\\qquad": "2em"}


class MathError(ValueError):
    """A formula with something that is not known here."""


def formulas(text: str) -> str:
    """Return a Markdown text with MathML in place of its formulas; code stays as it is."""

    def written(match: re.Match[str]) -> str:
        code, block, inline = match.groups()
        return code or (mathml(block, "block") if block else mathml(inline))

    return FORMULA.sub(written, text)


def mathml(formula: str, display: str = "inline") -> str:
    """Return a formula as one `<math>` element. Raises MathError."""
    reader = _Reader(formula)
    inside = reader.row(())
    return f'<math display="{display}">{inside}</math>'


class _Reader:
    """The tokens of a formula, and how far they are read."""

    def __init__(self, formula: str) -> None:
        self.formula = formula
        self.tokens = TOKEN.findall(formula)
        self.at = 0

    def row(self, ends: tuple[str, ...]) -> str:
        """Return what stands before one of these tokens, or before the end."""
        parts: list[str] = []
        while self.at < len(self.tokens) and self.tokens[self.at] not in ends:
            if self.tokens[self.at] in SCRIPTS:
                parts.append(self.scripts(parts.pop() if parts else "<mrow></mrow>"))
            else:
                parts.append(self.atom())
        if ends and self.at == len(self.tokens):
            raise MathError(f"{self.formula}: {' or '.join(ends)} is missing")
        return f"<mrow>{''.join(parts)}</mrow>"

    def next(self, wanted: str = "") -> str:
        """Return the next token, which must be the one that is wanted, if any."""
        found = self.tokens[self.at] if self.at < len(self.tokens) else "the end"
        if found == "the end" or (wanted and found != wanted):
            raise MathError(f"{self.formula}: {found} in place of {wanted or 'something'}")
        self.at += 1
        return found

    def scripts(self, base: str) -> str:
        """Return a base with what is raised and lowered behind it."""
        found = {}
        while self.at < len(self.tokens) and self.tokens[self.at] in SCRIPTS:
            mark = self.next()
            found[mark] = self.atom()
        if len(found) == 2:
            return f"<msubsup>{base}{found['_']}{found['^']}</msubsup>"
        if "^" in found:
            return f"<msup>{base}{found['^']}</msup>"
        # Browsers lower too little where the machine has no font for formulas.
        return f'<msub>{base}<mpadded voffset="-0.2em">{found["_"]}</mpadded></msub>'

    def atom(self) -> str:
        """Return the next element."""
        token = self.next()
        if token == "{":
            inside = self.row(("}",))
            self.next("}")
            return inside
        if token in SPACES:
            return f'<mspace width="{SPACES[token]}"></mspace>'
        if token.startswith("\\"):
            return self.command(token[1:])
        if token[0].isdigit():
            for mark, shown in NUMBER_MARKS.items():
                token = token.replace(mark, shown)
            return f"<mn>{token}</mn>"
        if token.isalpha() or token in "°'":
            return f"<mi>{token.replace(chr(39), '′')}</mi>"
        # Brackets are as large as they are unless \left and \right say otherwise.
        return f'<mo stretchy="false">{escape("−" if token == "-" else token)}</mo>'

    def command(self, name: str) -> str:
        """Return what a command stands for."""
        if name in LETTERS:
            return f"<mi>{LETTERS[name]}</mi>"
        if name in OPERATORS:
            return f'<mo stretchy="false">{OPERATORS[name]}</mo>'
        if name in FUNCTIONS:
            return f"<mi>{name}</mi>{self.gap()}"
        known: dict[str, Callable[[], str]] = {
            "frac": lambda: f"<mfrac>{self.atom()}{self.atom()}</mfrac>",
            "sqrt": lambda: f"<msqrt>{self.atom()}</msqrt>",
            "vec": lambda: f'<mover accent="true">{self.atom()}<mo stretchy="false">→</mo></mover>',
            "mathit": lambda: f'<mi style="font-style:italic">{self.word()}</mi>',
            "operatorname": lambda: f"<mi>{self.word()}</mi>",
            "text": lambda: f"<mtext>{self.word()}&#160;</mtext>",
            "left": self.fenced,
            "begin": self.cases,
        }
        if name not in known:
            raise MathError(
                f"{self.formula}: \\{name} is not known to grader/authoring/workbook/mathml.py"
            )
        return known[name]()

    def gap(self) -> str:
        """Return the space between a function's name and what it is of, if no bracket does."""
        bracket = self.at < len(self.tokens) and self.tokens[self.at] == "("
        return "" if bracket else f'<mspace width="{SPACES[chr(92) + ","]}"></mspace>'

    def word(self) -> str:
        """Return the letters between braces."""
        self.next("{")
        letters = []
        while (token := self.next()) != "}":
            letters.append(token)
        return "".join(letters)

    def fenced(self) -> str:
        """Return what stands between brackets as high as it is."""
        first = self.next()
        inside = self.row(("\\right",))
        self.next("\\right")
        return f"<mrow><mo>{first}</mo>{inside}<mo>{self.next()}</mo></mrow>"

    def cases(self) -> str:
        """Return the rows of a case distinction, behind a brace."""
        if self.word() != "cases":
            raise MathError(f"{self.formula}: only cases can begin")
        rows = ""
        while True:
            cells = [self.row(("&", "\\\\", "\\end"))]
            while (end := self.next()) == "&":
                cells.append(self.row(("&", "\\\\", "\\end")))
            made = "".join(f'<mtd style="text-align:left">{each}</mtd>' for each in cells)
            rows += f"<mtr>{made}</mtr>"
            if end == "\\end":
                break
        self.word()
        return f"<mrow><mo>{{</mo><mtable>{rows}</mtable></mrow>"

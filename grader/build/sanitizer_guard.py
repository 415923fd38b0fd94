"""What would switch the sanitizers off in a submission: refused, with the place.

An attribute, or a function or variable by which their runtime is set. The attribute is looked for
in the text: who hides it behind pasted tokens loses a help, and gains nothing, for answers are
compared elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from grader.setup import c_text

_ATTRIBUTE = r"no_sanitize\w*|no_address_safety_analysis|disable_sanitizer_instrumentation"
_ATTRIBUTE += r"|no_instrument_function"
_SYMBOL = r"__(?:a|ub|l)san_\w+|__sanitizer_\w+|__cyg_profile_\w+"
_WORD = re.compile(rf"\b_*(?:{_ATTRIBUTE})\b|\b(?:{_SYMBOL})\b", re.ASCII)
_DEFINED = re.compile(_SYMBOL, re.ASCII)


def in_text(files: Mapping[str, bytes]) -> str:
    """Return the errors, as a compiler writes them, for what the files name; "" for nothing."""
    return "".join(_errors(name, content) for name, content in files.items())


def in_symbols(name: str, defined: Iterable[str]) -> str:
    """Return the errors for what an object defines; `name` is its source's. "" for nothing."""
    return "".join(_error(name, 1, word) for word in sorted(defined) if _DEFINED.fullmatch(word))


def _errors(name: str, content: bytes) -> str:
    code = c_text.blanked(content.decode("latin-1"))
    return "".join(
        _error(name, code.count("\n", 0, found.start()) + 1, found[0])
        for found in _WORD.finditer(code)
    )


def _error(name: str, line: int, word: str) -> str:
    return f"{name}:{line}:1: error: '{word}' switches the sanitizers off\n"

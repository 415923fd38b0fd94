"""What would switch the sanitizers off in a submission: refused, with the place.

An attribute, or a function or variable by which their runtime is set. The attribute is looked for
in the text: who hides it behind pasted tokens loses a help, and gains nothing, for answers are
compared elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

_ATTRIBUTE = rb"no_sanitize\w*|no_address_safety_analysis|disable_sanitizer_instrumentation"
_ATTRIBUTE += rb"|no_instrument_function"
_SYMBOL = rb"__(?:a|ub|l)san_\w+|__sanitizer_\w+|__cyg_profile_\w+"
_WORD = re.compile(rb"\b_*(?:" + _ATTRIBUTE + rb")\b|\b(?:" + _SYMBOL + rb")\b")
_DEFINED = re.compile(_SYMBOL.decode())
# Comments, strings and characters, where anything may stand; but a string in an attribute is no
# such thing. What is begun always ends, at the end of the line or of the file: one pass is enough.
_SILENT = re.compile(
    rb"//[^\n]*|/\*.*?(?:\*/|\Z)|\"(?:\\.|[^\"\\\n])*\"?|'(?:\\.|[^'\\\n])*'?", re.DOTALL
)


def in_text(files: Mapping[str, bytes]) -> str:
    """Return the errors, as a compiler writes them, for what the files name; "" for nothing."""
    return "".join(_errors(name, content) for name, content in files.items())


def in_symbols(name: str, defined: Iterable[str]) -> str:
    """Return the errors for what an object defines; `name` is its source's. "" for nothing."""
    return "".join(_error(name, 1, word) for word in sorted(defined) if _DEFINED.fullmatch(word))


def _errors(name: str, content: bytes) -> str:
    # Lines keep their numbers, and a comment its place.
    code = _SILENT.sub(lambda found: b"\n" * found[0].count(b"\n") or b" ", content)
    return "".join(
        _error(name, code.count(b"\n", 0, found.start()) + 1, found[0].decode())
        for found in _WORD.finditer(code)
    )


def _error(name: str, line: int, word: str) -> str:
    return f"{name}:{line}:1: error: '{word}' switches the sanitizers off\n"

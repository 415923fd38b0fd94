"""What compilers' messages mean in plain words: keys of [build] and [advice] in messages/.

A message is recognised by its words, gcc's or clang's; a warning by its option, -W..., first.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from grader.course.message import Message

_QUOTED = re.compile(r"[‘'`]([^‘’'`]+)[’']")
_NAMED = re.compile(r"[\w./>\[\]-]+")
# The usual errors. The name they tell is the pattern's group, or else the first word in quotes.
_ERRORS = (
    ("build.changed_signature", r"conflicting types for"),
    ("build.semicolon", r"expected (?:(?! before ).)*;"),
    ("build.bracket", r"expected [‘']\)[’']"),
    ("build.brace", r"at end of input|expected '}'|function definition is not allowed here"),
    ("build.undeclared", r"undeclared|implicit declaration of function"),
    ("build.unknown_type", r"unknown type name"),
    ("build.no_member", r"no member named [‘'](\w+)"),
    ("build.no_file", r"([\w./]+): No such file|file not found"),
    ("build.taken", r"as different kind of symbol"),
    ("build.twice", r"redefinition of"),
    ("build.arguments", r"too (?:few|many) arguments to function"),
    ("build.operands", r"invalid operands to binary"),
    ("build.arrow", r"is a pointer; did you mean to use [‘']->[’']"),
    ("build.dot", r"invalid type argument of ‘->’|is not a pointer; did you mean to use '\.'"),
    ("build.off_switch", r"switches the sanitizers off"),
    ("build.slow", r"^compiling takes too long"),
    ("build.huge", r"^what is made of it takes more than"),
    ("build.gives_up", r"^the compiler gives up"),
)
# A structure where its address is wanted, or the other way round: gcc tells the type that is wanted
# and the one that is given, clang the cure.
_TYPES = re.compile(r"expected ‘([^’]+)’(?: {aka [^}]*})? but argument is of type ‘([^’]+)’")
_CURES = {
    **dict.fromkeys(("; dereference with *", "; remove &"), "build.value"),
    **dict.fromkeys(("; take the address", "; remove *"), "build.address"),
}
_STORAGE = re.compile(r"invalid storage class for function")
# A character that C does not know; the compilers write it as its number.
_STRAY = re.compile(r"stray [‘']|unexpected character|not allowed in an identifier|extended char")
_POINT = re.compile(r"<U\+([0-9A-F]{4,6})>")
_BLANKS = frozenset("\u00a0\u2007\u2009\u200b\u202f\u3000\ufeff")
_MACRO = re.compile(r"#\s*define\s+(\w+)\b.*;\s*(?:/[/*].*)?$")
# What makes the rest of a line incomprehensible, and what may be the effect of any other error.
SPOILS = frozenset(
    ("build.stray", "build.blank", "build.semicolon", "build.bracket", "build.unknown_type")
)
BRACES = frozenset(("build.brace", "build.brace_in"))

_OPTION = re.compile(r"\[-W([\w-]+)(?:=[\w-]*)?(?:,-W[\w-]+)*\]$")
# The usual warnings that are an answer, by their option.
_WARNINGS = {
    **dict.fromkeys(
        ("uninitialized", "maybe-uninitialized", "sometimes-uninitialized"), "advice.unset"
    ),
    "conditional-uninitialized": "advice.unset",
    "return-type": "advice.no_return",
    "unused-variable": "advice.unused_variable",
    "unused-but-set-variable": "advice.set_only",
    "unused-function": "advice.unused_function",
    **dict.fromkeys(("unused-value", "unused-comparison"), "advice.no_effect"),
    "unused-result": "advice.unused_result",
    "shadow": "advice.shadow",
    "empty-body": "advice.empty_body",
    "misleading-indentation": "advice.indentation",
    "absolute-value": "advice.absolute",
    "implicit-function-declaration": "advice.implicit",
    "logical-not-parentheses": "advice.not",
    "array-bounds": "advice.bounds",
    **dict.fromkeys(("div-by-zero", "division-by-zero"), "advice.zero"),
    **dict.fromkeys(("return-local-addr", "return-stack-address"), "advice.local_address"),
    **dict.fromkeys(
        ("discarded-qualifiers", "incompatible-pointer-types-discards-qualifiers"), "advice.const"
    ),
    **dict.fromkeys(("incompatible-pointer-types", "int-conversion"), "advice.wrong_type"),
    **dict.fromkeys(("sequence-point", "unsequenced"), "advice.sequence"),
    **dict.fromkeys(("overflow", "constant-conversion"), "advice.overflow"),
    "dangling-else": "advice.dangling_else",
    "infinite-recursion": "advice.endless",
    "format": "advice.format",
    "use-after-free": "advice.freed",
    "implicit-fallthrough": "advice.fallthrough",
}
# Those whose option says too little, by their words.
_WORDS = (
    ("advice.assignment", r"assignment (?:used as truth value|as a condition)"),
    ("advice.chained", r"do not have their mathematical meaning"),
    ("advice.precedence", r"comparison in operand of|lower precedence than"),
    ("advice.always", r"always(?: evaluates? to)? [‘']?(true|false)"),
    ("advice.always", r"will (?:always|never) evaluate as [‘'](true|false)"),
)


def of_error(message: str, lines: Sequence[str], function: str) -> Message | None:
    """Return what an error means: its message, all its lines, and the function that it is in."""
    if _STRAY.search(message) and (character := _character(message, lines)):
        blank = character in _BLANKS
        return Message("build.blank" if blank else "build.stray", {"name": character})
    macro = next((found for line in lines[1:] if (found := _MACRO.search(line))), None)
    if macro:
        return Message("build.macro_semicolon", {"name": macro[1]})
    if _STORAGE.search(message):
        key = "build.brace_in" if function else "build.brace"
        return Message(key, {"name": function})
    if way := _address_or_value(message, lines):
        return Message(way, {"name": ""})
    for key, pattern in _ERRORS:
        if found := re.search(pattern, message):
            quoted = _QUOTED.search(message)
            name = (found.re.groups and found[1]) or (quoted[1] if quoted else "")
            return Message(key, {"name": name})
    return None


def _address_or_value(message: str, lines: Sequence[str]) -> str:
    """Return the key of what a parameter wants that was given the other; "" when it is neither."""
    for cure, way in _CURES.items():
        if cure in message:
            return way
    if found := next(filter(None, map(_TYPES.search, lines)), None):
        wanted, given = (each.removeprefix("const ") for each in found.groups())
        if given == f"{wanted} *":
            return "build.value"
        if wanted == f"{given} *":
            return "build.address"
    return ""


def of_warning(message: str, word: str, function: str) -> Message | None:
    """Return what a warning means; `word` is the name that stands there."""
    option = _OPTION.search(message)
    key = _WARNINGS.get(option[1], "") if option else ""
    value = ""
    for other, pattern in () if key else _WORDS:
        if found := re.search(pattern, message):
            key, value = other, found[1] if found.re.groups else ""
            break
    if not key:
        return None
    quoted = [each for each in _QUOTED.findall(message) if each != "warn_unused_result"]
    named = key != "advice.shadow" and next(filter(_NAMED.fullmatch, quoted), "")
    where = f" ({function})" if function else ""
    return Message(key, {"name": named or word, "value": value, "where": where})


def _character(message: str, lines: Sequence[str]) -> str:
    """Return the character that C does not know; "" when it is none of another alphabet."""
    text = "\n".join((*lines[1:], message))
    if point := _POINT.search(text):
        return chr(int(point[1], 16))
    return next((each for line in lines[1:] for each in line if ord(each) > 126), "")

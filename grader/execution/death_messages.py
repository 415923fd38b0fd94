"""How a call ended that did not come back: a verdict, and its sentence."""

from __future__ import annotations

import re

from grader.course.message import Message
from grader.course.texts import Texts, sentences
from grader.execution.records import Cause, Death

_UNDEFINED = re.compile(r"undefined symbol: (\w+)")
_RUNTIME = "runtime error: "
# What UndefinedBehaviorSanitizer says most often, and our sentence for it.
_PLAIN = {
    "death.null": re.compile(r"null pointer"),
    "death.index": re.compile(r"index (?P<index>-?\d+) out of bounds"),
    "death.zero": re.compile(r"^division by zero"),
    "death.integer": re.compile(r"signed integer overflow|negation of"),
}


def message(death: Death, call: str) -> Message:
    """Return what happened in a call; "" as the call: while the code was loaded."""
    # A variable is looked for when the code is loaded, a function when it is called.
    missing = _UNDEFINED.search(death.text)
    if missing and death.cause in (Cause.LOAD, Cause.EXIT):
        return Message("death.missing_symbol", {"name": missing[1]})
    values = {
        "call": call,
        "location": death.location,
        "function": death.function,
        "code": death.code,
        "seconds": f"{death.seconds:g}",
        "detail": death.text.strip()[:300],
        "word": death.word.removeprefix(_RUNTIME),
    }
    for key, pattern in _PLAIN.items():
        found = pattern.search(str(values["word"])) if death.word.startswith(_RUNTIME) else None
        if found:
            return Message(key, {**values, **found.groupdict()})
    return Message(_key(death), values)


def told(what: Message, location: str, texts: Texts) -> str:
    """Return the sentence of a verdict, with the place ("file:line" or "") where code has died."""
    values = {"place": _place(what, location, texts), **what.values}
    if values.get("call") == "":
        values["call"] = texts.say("death.loading")
    return texts.say(what.key, **values)


def _key(death: Death) -> str:
    if death.cause is not Cause.SIGNAL:
        return f"death.{death.cause.value}"
    if death.word.startswith(_RUNTIME):
        return "death.runtime"
    key = f"death.{death.word}"
    return key if key in sentences("fr") else "death.other"


def _place(what: Message, location: str, texts: Texts) -> str:
    """Return where the code was, as the end of a sentence; "" when not known."""
    if not location:
        return ""
    function = what.values.get("function")
    key = "death.place_in" if function else "death.place"
    return texts.say(key, location=location, function=function)

"""How a call ended that did not come back: its sentence, and the question that goes with it."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from grader.course.message import Message
from grader.course.settings import COMPLETE
from grader.course.texts import LANGUAGES, Texts, sentences
from grader.execution.crash_location import ENDLESS
from grader.execution.records import Cause, Death

MAX_CALLERS = 4  # that are named
_NAMED = re.compile(r"{(\w+)}")  # a value of a sentence
_UNDEFINED = re.compile(r"undefined symbol: (\w+)")
_RUNTIME = "runtime error: "
# What UndefinedBehaviorSanitizer says most often, and our sentence for it; the first that fits.
# Memory that nothing has been written in holds one byte again and again: 0xbe where malloc has
# given it, 0xfe in a local variable (build/shim/paint.c, and gcc's own fill; clang's is 0xaa).
_PLAIN = {
    "death.unwritten": re.compile(r"0xbebebe|value 190, .*bool|index -1094795586 "),
    "death.unset": re.compile(
        r"0xfefefe|0xaaaaaa|value (?:254|170), .*bool|index -(?:16843010|1431655766) "
    ),
    "death.null": re.compile(r"null pointer"),
    "death.index": re.compile(r"index (?P<index>-?\d+) out of bounds"),
    "death.zero": re.compile(r"^division by zero"),
    "death.integer": re.compile(r"signed integer overflow|negation of"),
}
_REFUSED = re.compile(r"AddressSanitizer failed to allocate (0x[0-9a-f]+) bytes")
_FREED = re.compile(r"double free|free\(\): invalid|munmap_chunk")  # the C library's own words
# The question of a kind of death, [ask] in messages/, by what its sentences have in common.
_KINDS = {
    **dict.fromkeys(("SIGSEGV", "SEGV", "SIGBUS", "index", "stray_write"), "bounds"),
    **dict.fromkeys(("SIGFPE", "FPE", "SIGILL", "zero"), "zero"),
    **dict.fromkeys(("heap-use-after-free", "freed"), "freed"),
}
_BOUNDS = re.compile(r"-buffer-(?:over|under)flow$")


def message(death: Death, call: str) -> Message:
    """Return what happened in a call; "" as the call: while the code was loaded."""
    # A variable is looked for when the code is loaded, a function when it is called.
    missing = _UNDEFINED.search(death.text)
    if missing and death.cause in (Cause.LOAD, Cause.EXIT):
        return Message("death.missing_symbol", {"name": missing[1]})
    refused = _REFUSED.search(death.text)
    values: dict[str, object] = {
        "call": call,
        "calls": ((death.function, death.location), *death.callers),
        "function": death.function,
        "code": death.code,
        "seconds": death.seconds,
        "detail": death.text.strip()[:300],
        "word": death.word.removeprefix(_RUNTIME),
        "bytes": int(refused[1], 16) if refused else 0,
        "again": _again(death),
    }
    for key, pattern in _PLAIN.items():
        found = pattern.search(str(values["word"])) if death.word.startswith(_RUNTIME) else None
        if found:
            return Message(_nearer(key, death), {**values, **found.groupdict()})
    return Message(_nearer(_key(death), death), values)


def told(what: Message, location: str, texts: Texts) -> str:
    """Return the sentence of a verdict, with the place ("file:line" or "") where code has died."""
    return texts.told(placed(what, location))


def placed(what: Message, location: str) -> Message:
    """Return a verdict that says the place ("file:line" or "") where code has died.

    Of a death only what its sentence tells is kept: the rest, an address or a number of seconds,
    may be another one each time.
    """
    values = {"place": tuple(_place(what, location)), **what.values}
    if values.get("call") == "":
        values["call"] = Message("death.loading")
    if what.key.startswith("death."):
        named = _NAMED.findall(sentences(LANGUAGES[0]).get(what.key, ""))
        values = {name: values[name] for name in named if name in values}
    return replace(what, values=values)


def question(what: Message | None, texts: Texts, level: int = 1) -> str:
    """Return what to ask of code that did not come back, or the help of a higher level.

    "" for what is no such thing.
    """
    group, _, name = what.key.partition(".") if what else ("", "", "")
    if group != "death":
        return ""
    kind = "bounds" if _BOUNDS.search(name) else _KINDS.get(name, name)
    asked = texts.get(f"ask.{kind}", texts.get("ask.other"))
    return asked if level == 1 else texts.get(f"ask.more.{kind}", asked)


def shown(death: Death, own: Collection[str], others: Collection[str]) -> str:
    """Return the line to show of code that has died: one of the functions that are judged.

    `own` are these, `others` the functions of other exercises: a right one that was called badly is
    not to be looked at. The helpers that a judged function calls are its own.
    """
    calls = [(death.function, death.location), *death.callers]
    judged = next((k for k, (name, _) in enumerate(calls) if name in own), -1)
    if judged < 0:
        return death.location
    while judged > 0 and calls[judged - 1][0] not in others:
        judged -= 1
    return calls[judged][1]


def _key(death: Death) -> str:
    if death.cause is Cause.SPENT:
        return f"death.spent_{death.word}"
    if death.cause is not Cause.SIGNAL:
        return f"death.{death.cause.value}"
    if death.word.startswith(_RUNTIME):
        return "death.runtime"
    if death.word in ("double-free", "free") or (
        death.word == "SIGABRT" and _FREED.search(death.text)
    ):
        return "death.freed"
    if death.word == "null-pointer":
        return "death.null"
    key = f"death.{death.word}"
    return key if key in sentences(COMPLETE[-1]) else "death.other"


def _nearer(key: str, death: Death) -> str:
    """Return the key of a sentence that says more, where more is known."""
    if key == "death.null" and _REFUSED.search(death.text):
        return "death.no_memory"
    if key == "death.stack-overflow" and _again(death):
        return "death.recursion"
    return key


def _again(death: Death) -> str:
    """Return the function that is called again and again, maybe through others; "" for none."""
    often = 1 + sum(name == death.function for name, _ in death.callers)
    return death.function if often >= ENDLESS else ""


def _place(what: Message, location: str) -> Iterator[Message]:
    """Yield where the code was, the parts of the end of a sentence; none when not known."""
    if not location:
        return
    calls = what.values.get("calls", ((what.values.get("function"), location),))
    assert isinstance(calls, Sequence)
    (function, where), *callers = calls
    key = "death.place_in" if function else "death.place"
    yield Message(key, {"location": where, "function": function})
    # One that calls itself is named once.
    others = [each for each, (last, _) in zip(callers, calls, strict=False) if each[0] != last]
    for name, line in others[:MAX_CALLERS]:
        same = line.removeprefix(f"{where.partition(':')[0]}:")
        yield Message("death.called_by", {"function": name, "line": same})

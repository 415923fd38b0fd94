"""How a call ended that did not come back, as a sentence."""

from __future__ import annotations

import re

from grader.records import Cause, Death
from grader.texts import Texts, sentences

_UNDEFINED = re.compile(r"undefined symbol: (\w+)")


def tell(death: Death, call: str, seconds: float, texts: Texts) -> str:
    """Return what happened, in which call, and where; "" as the call: while the code was loaded."""
    missing = _UNDEFINED.search(death.text)
    # A variable is looked for when the code is loaded, a function when it is called.
    if missing and death.cause in (Cause.LOAD, Cause.EXIT):
        return texts.say("death.missing_symbol", name=missing[1])
    place = ""
    if death.location:
        key = "death.place_in" if death.function else "death.place"
        place = texts.say(key, location=death.location, function=death.function)
    return texts.say(
        _key(death),
        call=call or texts.say("death.loading"),
        place=place,
        seconds=f"{seconds:g}",
        code=death.code,
        detail=death.text.strip()[:300],
        word=death.word.removeprefix("runtime error: "),
    )


def _key(death: Death) -> str:
    if death.cause is not Cause.SIGNAL:
        return f"death.{death.cause.value}"
    if death.word.startswith("runtime error: "):
        return "death.runtime"
    key = f"death.{death.word}"
    return key if key in sentences("fr") else "death.other"

"""What a student reads of a call that did not come back: words of their language, and a question.

Not the sanitizers' words, nor a question about what the function computes.
"""

from __future__ import annotations

import json
import re
from dataclasses import replace

import pytest

from grader.course.message import Message
from grader.course.texts import Texts, sentences
from grader.execution import death_messages
from grader.execution.crash_location import CrashLocation, from_endless
from grader.execution.records import Cause, Death

BAD_POINTER = "address {} for type 'struct object', which requires 4 byte alignment"
BAD_BOOL = "load of value {}, which is not a valid value for type 'bool'"
UNWRITTEN = "shade() utilise de la mémoire donnée par malloc, où rien n'a encore été écrit"
UNSET = "shade() utilise une variable locale qui n'a reçu aucune valeur"
# As gcc and clang write them.
SAID = {
    "store to null pointer of type 'int'": "shade() utilise un pointeur nul (NULL)",
    "load of null pointer of type 'object'": "shade() utilise un pointeur nul (NULL)",
    "index -1 out of bounds for type 'object [70000]'": (
        "shade() utilise l'indice -1, qui est hors du tableau"
    ),
    "division by zero": "shade() divise un entier par zéro",
    "signed integer overflow: 2147483647 + 1 cannot be represented in type 'int'": (
        "shade() obtient un entier trop grand pour son type"
    ),
    "shift exponent 40": (
        "shade() fait une opération que le langage C ne définit pas (shift exponent 40)"
    ),
    f"member access within misaligned {BAD_POINTER.format('0xbebebebebebebebe')}": UNWRITTEN,
    BAD_BOOL.format(190): UNWRITTEN,
    "index -1094795586 out of bounds for type 'light [16]'": UNWRITTEN,
    f"load of misaligned {BAD_POINTER.format('0xfefefefefefefefe')}": UNSET,
    BAD_BOOL.format(254): UNSET,
    BAD_BOOL.format(170): UNSET,
    "index -16843010 out of bounds for type 'light [16]'": UNSET,
}


@pytest.mark.parametrize("word", SAID)
def test_undefined_behaviour_is_told_in_plain_words(word: str) -> None:
    """The frequent ones have a sentence; the others keep the sanitizer's word."""
    death = Death(Cause.SIGNAL, f"runtime error: {word}", location="main.c:3")
    sentence = death_messages.told(
        death_messages.message(death, "shade()"), death.location, Texts("fr")
    )
    assert sentence == f"{SAID[word]}, dans main.c:3."


def test_other_ends_are_not_taken_for_it() -> None:
    """An exit whose text speaks of a null pointer is an exit."""
    death = Death(Cause.EXIT, code=3, text="division by zero, null pointer")
    assert death_messages.message(death, "shade()").key == "death.exit"


def test_a_null_that_malloc_returned_is_told_as_such() -> None:
    """With the bytes that were asked for."""
    said = "==1==WARNING: AddressSanitizer failed to allocate 0x1000000000 bytes\n"
    death = Death(Cause.SIGNAL, "runtime error: store to null pointer of type 'int'", text=said)
    sentence = death_messages.told(death_messages.message(death, "f()"), "", Texts("en"))
    assert sentence == "f() uses the NULL that malloc returned: it cannot give 68719476736 bytes."


INNER = ("intersect_sphere", "raytracer.c:62")
CALLERS = (("intersect_scene", "raytracer.c:76"), ("trace_ray", "raytracer.c:81"))


def _death(*callers: tuple[str, str], word: str = "SEGV") -> Death:
    return Death(Cause.SIGNAL, word, location=INNER[1], function=INNER[0], callers=callers)


def test_the_calls_that_led_there_are_told() -> None:
    """From the inside out; a file is named again when it is another one."""
    death = _death(*CALLERS, ("raytrace", "main.c:9"))
    sentence = death_messages.told(
        death_messages.message(death, "f()"), death.location, Texts("en")
    )
    assert sentence.endswith(
        ", in intersect_sphere (raytracer.c:62), called by intersect_scene (76)"
        ", called by trace_ray (81), called by raytrace (main.c:9)."
    )


LOOP = (("trace_ray", "raytracer.c:81"), ("mirror_color", "raytracer.c:99"))


@pytest.mark.parametrize("leaves", [(), CALLERS[:1]], ids=["itself", "what it called"])
@pytest.mark.parametrize("turn", [0, 1])
def test_endless_calls_are_told_alike_wherever_the_stack_ended(
    turn: int, leaves: tuple[tuple[str, str], ...]
) -> None:
    """At the line that calls on; each function once in a row; a large local table is another."""
    calls = [CrashLocation(*each) for each in (*leaves, *(LOOP * 9)[turn:])]
    first, *callers = ((each.function, each.location) for each in from_endless(calls))
    death = Death(
        Cause.SIGNAL,
        "stack-overflow",
        location=first[1],
        function=first[0],
        callers=tuple(callers),
    )
    told = death_messages.told(death_messages.message(death, "f()"), death.location, Texts("en"))
    start = "f() runs out of stack: trace_ray calls itself again and again, without end, in "
    assert told.startswith(f"{start}trace_ray (raytracer.c:81), called by mirror_color (99)")
    assert told.count("called by") == death_messages.MAX_CALLERS


def test_a_large_local_table_is_no_endless_call() -> None:
    """Where no function is called again and again, it is the table that takes the stack."""
    large = _death(*CALLERS, word="stack-overflow")
    assert "a local table is too large" in death_messages.told(
        death_messages.message(large, "f()"), large.location, Texts("en")
    )
    calls = [CrashLocation(*INNER), *(CrashLocation(*each) for each in CALLERS)]
    assert from_endless(calls) == calls


@pytest.mark.parametrize(
    ("own", "line"),
    [
        ("trace_ray", "raytracer.c:81"),  # not that of the right function that it calls badly
        ("intersect_scene", "raytracer.c:76"),
        ("intersect_sphere", "raytracer.c:50"),  # its own helper is its own
        ("shade", "raytracer.c:50"),  # it is not among the calls
    ],
)
def test_the_line_shown_is_the_judged_functions(own: str, line: str) -> None:
    """A right function that a wrong one called badly is not the one to look at."""
    death = Death(
        Cause.SIGNAL, "SEGV", 0, 0, "raytracer.c:50", "", "solve", callers=(INNER, *CALLERS)
    )
    others = {"intersect_sphere", "intersect_scene", "trace_ray", "shade"} - {own}
    assert death_messages.shown(death, {own}, others) == line


def test_each_end_has_a_question_of_its_own_kind() -> None:
    """Whatever ends a call is asked about, with more help at the next level; nothing else is."""
    texts = Texts("fr")
    calls = [key for key in sentences("fr") if re.fullmatch(r"death\.[\w-]+", key)]
    beside = {"killed", "load", "loading", "missing_symbol", "place", "place_in", "called_by"}
    for key in calls:
        death = Message(key)
        if key.removeprefix("death.") in beside:
            continue
        assert death_messages.question(death, texts).endswith(("?", "."))
        bounds = "indice" in death_messages.question(death, texts)
        assert bounds == bool(re.search(r"overflow$|underflow$|SEGV|SIGBUS|index|stray", key)) or (
            key == "death.stack-overflow"
        )
    assert death_messages.question(Message("death.null"), texts, 2).startswith("Affichez")
    assert death_messages.question(Message("failure.result"), texts) == ""
    assert death_messages.question(None, texts) == ""


def test_what_is_kept_of_a_death_is_what_its_sentence_tells() -> None:
    """No address, and no number of a process, that another run of the same code would not have."""
    word = "runtime error: store to null pointer of type 'int'"
    death = replace(_death(*CALLERS, word=word), text="==36==WARNING: 0x7ffd01", seconds=0.17)
    placed = death_messages.placed(death_messages.message(death, "f()"), death.location)
    assert set(placed.values) == {"call", "place"}
    row = json.dumps(placed.as_row())
    assert "trace_ray" in row
    assert "36" not in row

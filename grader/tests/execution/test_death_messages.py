"""What a student reads of undefined behaviour: words of their language, not the sanitizer's."""

from __future__ import annotations

import pytest

from grader.course.texts import Texts
from grader.execution import death_messages
from grader.execution.records import Cause, Death

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

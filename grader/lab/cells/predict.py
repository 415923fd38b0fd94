"""Predictions: a choice made before the code runs, kept, and shown beside the result."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from grader.lab.display import store
from grader.lab.display.card import Shown, escape, note
from grader.lab.display.controls import beside
from grader.lab.display.error_cards import sentence
from grader.lab.display.stopped import Stopped
from grader.lab.display.words import say

FILE = "predictions.json"


class Prediction:
    """The choices of a question, as buttons; with their text where there are no buttons."""

    def __init__(self, name: str, options: Sequence[str]) -> None:
        self.name, self.options = name, tuple(options)

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return buttons, and beside them what a page without a kernel shows."""
        plain = _told(self.name, self.options)
        bundle = dict(beside(_buttons(self.name, self.options))._repr_mimebundle_())
        return {**bundle, "text/html": plain.html, "text/plain": plain.text}

    def __repr__(self) -> str:
        return _told(self.name, self.options).text


def predict(name: str, options: Sequence[str], answer: str | None = None) -> Prediction | Shown:
    """Ask for a choice, such as predict("tp1.first_pixel", "ABC"); it is kept, for no points.

    Where there are no buttons to click, `answer="B"` gives the choice. Raises Stopped.
    """
    if answer is None:
        return Prediction(name, options)
    if answer not in tuple(options):
        raise Stopped(sentence("lab.no_option", answer=answer, options=", ".join(options)))
    _keep(name, answer)
    return predicted(name)


def predicted(name: str) -> Shown:
    """Return what was chosen, to stand beside the result."""
    choice = _choice(name)
    return note(say("chosen", choice=choice) if choice else say("not_chosen"))


def _choice(name: str) -> str:
    return str(store.read(FILE).get(name, ""))


def _keep(name: str, choice: str) -> None:
    try:
        store.write(FILE, {**store.read(FILE), name: choice})
    except OSError as error:
        raise Stopped(
            sentence("machine.cannot_write", path=error.filename or FILE, error=error.strerror)
        ) from error


def _told(name: str, options: Sequence[str]) -> Shown:
    choice = _choice(name)
    how = say("how_to_choose", name=name, options="".join(options), first=options[0])
    text = say("chosen", choice=choice) if choice else how
    return Shown(f"<p>{escape(text)}</p>", text)


def _buttons(name: str, options: Sequence[str]) -> Any:
    import ipywidgets  # type: ignore[import-untyped]

    kept = _choice(name)
    buttons = ipywidgets.ToggleButtons(
        options=list(options),
        value=kept if kept in tuple(options) else None,
        description=say("your_choice"),
        style={"button_width": "4em"},
    )

    def choose(change: Any) -> None:
        _keep(name, change["new"])

    buttons.observe(choose, names="value")
    return buttons

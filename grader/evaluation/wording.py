"""What is told of a check, in a language, from words that are kept in none.

What a run writes, and what a report that is made again says, are the same few functions of a
check's id, of the mistakes that were recognised, and of its Words.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from grader.checking import clues
from grader.course.texts import Texts
from grader.evaluation.records import Words
from grader.execution import death_messages

MOST_DIRECT = 3  # the last level of help


@dataclass(frozen=True)
class Wording:
    """The sentences of one check. Each raises KeyError when messages/ has a key no more."""

    check: str
    mistakes: Sequence[str]
    words: Words
    texts: Texts

    def title(self) -> str:
        """Return what the check is about."""
        return self.texts.get(f"title.{self.check}", self.words.title)

    def message(self) -> str:
        """Return what is wrong."""
        return self.texts.told(self.words.message) if self.words.message else ""

    def hint(self) -> str:
        """Return a question, or the hint of the level, the last that there is; "": none is asked.

        They are those of the mistake that is recognised, which the last level names; then those of
        how the code ended, if it did not come back, or of what is wrong and how; of the check
        otherwise.
        """
        wrong, level = self.words.message, self.words.level
        if not level:
            return ""
        if known := self._mistakes(level):
            return known
        if asked := death_messages.question(wrong, self.texts, level):
            return asked
        if asked := clues.question(wrong, self.check, self.texts, level):
            return asked
        found = self.texts.get(f"question.{self.check}")
        for each in range(2, level + 1):
            found = self.texts.get(f"hint.{self.check}.{each}", found)
        return found

    def hints(self) -> dict[int, str]:
        """Return what the next levels of help say, by level, where they say something more."""
        told, found = self.hint(), {}
        for level in range(self.words.level + 1, MOST_DIRECT + 1) if self.words.level else ():
            more = replace(self, words=replace(self.words, level=level)).hint()
            if more != told:
                found[level] = told = more
        return found

    def _mistakes(self, level: int) -> str:
        """Return what is told of mistakes that no check tells apart; each sentence once."""
        parts = (("question",), ("hint",), ("title", "hint"))[level - 1]
        told = (
            " ".join(filter(None, (self.texts.get(f"mistake.{name}.{part}") for part in parts)))
            for name in self.mistakes
        )
        return self.texts.say("note.or").join(dict.fromkeys(filter(None, told)))

    def note(self) -> str:
        """Return what to know besides."""
        return " ".join(map(self.texts.told, self.words.notes))

    def places(self) -> str:
        """Return where a picture is wrong."""
        return self.texts.told(self.words.places) if self.words.places else ""

    def pixel(self) -> str:
        """Return what is told of the pixel to look at."""
        return self.texts.told(self.words.pixel) if self.words.pixel else ""

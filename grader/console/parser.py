"""The command line's own words: argparse speaks English, students need not."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import Any, NoReturn

from grader.course.message import UserError
from grader.course.texts import Texts, preferred

# What argparse says of a wrong command line, and our sentence for it.
_COMPLAINTS = (
    (r"the following arguments are required: (?P<names>.*)", "usage.required"),
    (r"unrecognized arguments: (?P<names>.*)", "usage.unrecognized"),
    (
        r"argument (?P<name>.*): invalid choice: (?P<got>.*) \(choose from (?P<choices>.*)\)",
        "usage.bad_choice",
    ),
    (r"argument (?P<name>.*): invalid \w+ value: (?P<got>.*)", "usage.bad_value"),
    (r"argument (?P<name>.*): expected one argument", "usage.no_value"),
)
MOST_JOBS = 256
# The settings of make that reach an option.
_SETTINGS = {
    **{f"--{name}": name.upper() for name in ("tp", "hint", "isolation", "expected", "build")},
    **{f"--{name}": name.upper() for name in ("out", "jobs", "scheduler", "worksheet")},
    "-k": "K",
}


class UsageError(UserError):
    """The command line asks for something that is not there."""

    code = 2


class Parser(argparse.ArgumentParser):
    """A parser whose help and complaints are in the language of its texts."""

    def __init__(self, *, texts: Texts, **settings: Any) -> None:
        super().__init__(**settings, add_help=False, allow_abbrev=False)
        self._texts = texts
        self._positionals.title = texts.say("usage.positionals")
        self._optionals.title = texts.say("usage.options")
        self.add_argument("-h", "--help", action="help", help=texts.say("usage.help"))

    def format_usage(self) -> str:
        """Return the line of usage, under our own heading."""
        return self._own(super().format_usage())

    def format_help(self) -> str:
        """Return the whole help, under our own heading."""
        return self._own(super().format_help())

    def error(self, message: str) -> NoReturn:
        """Say in one line what is wrong with the command line, and exit with 2."""
        self.exit(2, f"{complaint(message, self._texts)}\n")

    def _own(self, text: str) -> str:
        return re.sub("^usage:", self._texts.say("usage.usage"), text)


def complaint(message: str, texts: Texts) -> str:
    """Return our sentence for a complaint of argparse's; its own when we have none."""
    for pattern, key in _COMPLAINTS:
        if found := re.fullmatch(pattern, message, re.DOTALL):
            values = found.groupdict()
            if "name" in values:
                values["name"] = _typed(values["name"])
            return texts.say(key, **values)
    return message


def _typed(name: str) -> str:
    """Return an option as it is typed: those of make come first."""
    return f"{_SETTINGS[name]} ({name})" if name in _SETTINGS else name


def tp_number(text: str) -> int:
    """Read the number of a TP, written 2 or TP2. Raises ValueError."""
    return int(text.lower().removeprefix("tp"))


def jobs(text: str) -> int:
    """Read how much is to be done side by side. Raises ValueError."""
    number = int(text)
    if not 0 < number <= MOST_JOBS:
        raise ValueError(text)
    return number


def language(words: Sequence[str]) -> str:
    """Return the language of the help itself: what --lang asks for, before all else is read."""
    early = argparse.ArgumentParser(add_help=False)
    early.add_argument("--lang", default="")
    return preferred(early.parse_known_args(words)[0].lang)

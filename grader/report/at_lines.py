"""What is wrong, each at its line of the student's file, in the forms that other tools read.

The source is results.json, and the files themselves for the line where a function begins.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.intake import definitions
from grader.report.results import Row
from grader.setup.failing_call import WRONG

_ADVICE = re.compile(r"(?P<file>[^\s:]+):(?P<line>\d+) ?: (?P<text>.*)", re.DOTALL)


@dataclass(frozen=True)
class Annotation:
    """A sentence on a line of a file (from 1); `path` is as the person names it.

    `exercise` is "" when the compiler says it.
    """

    exercise: str
    path: str
    line: int
    is_error: bool
    title: str
    text: str

    def for_editor(self) -> str:
        """Return a line such as a compiler writes, which editors know."""
        kind = "error" if self.is_error else "warning"
        said = " - ".join(filter(None, (self.title, " ".join(self.text.split()))))
        return f"{self.path}:{self.line}: {kind}: {said}"

    def for_github(self) -> str:
        """Return a workflow command of GitHub Actions, which shows the sentence at the line.

        Its escapes are those of the documentation of workflow commands.
        """
        kind = "error" if self.is_error else "warning"
        place = f"file={_property(self.path)},line={self.line}"
        title = f",title={_property(self.title)}" if self.title else ""
        return f"::{kind} {place}{title}::{_escaped(self.text)}"


FORMS: Mapping[str, Callable[[Annotation], str]] = {
    "editor": Annotation.for_editor,
    "github": Annotation.for_github,
}


def lines(content: Row, form: str) -> list[str]:
    """Return what is wrong in one of the FORMS, a line each."""
    return [FORMS[form](each) for each in found_in(content)]


def found_in(content: Row) -> list[Annotation]:
    """Return what is wrong: the compiler's errors, each exercise's first failure, warnings."""
    paths = {each["name"]: each["path"] for each in content["submission"]["sources"]}
    return [
        *_errors(content, paths),
        *_failures(content, paths),
        *_warnings(content, paths),
    ]


def _errors(content: Row, paths: Mapping[str, str]) -> Iterator[Annotation]:
    for each in content["build"]["errors"]:
        if path := paths.get(each["file"]):
            said = each["meaning"] or next(iter(each["lines"]), "")
            yield Annotation("", path, max(each["line"], 1), True, "", said)


def _failures(content: Row, paths: Mapping[str, str]) -> Iterator[Annotation]:
    files = dict(_read(paths))
    shown: set[str] = set()
    for each in content["checks"]:
        if each["outcome"] in WRONG and each["exercise"] not in shown:
            shown.add(each["exercise"])
            title = f"{each['exercise']} {each['function']}"
            text = "\n".join(filter(None, (each["message"], each["hint"])))
            place = _place(each, files) or _own_file(each, content)
            if place and place[0] in paths:
                said = text or each["title"]
                yield Annotation(each["exercise"], paths[place[0]], place[1], True, title, said)


def _place(check: Row, files: Mapping[str, str]) -> tuple[str, int] | None:
    """Return the file and line of a crash, or else where the function begins."""
    name, _, line = check["location"].rpartition(":")
    if name in files and line.isdecimal():
        return name, int(line)
    found = definitions.find(check["function"], files)
    return (found.file, found.line) if found else None


def _own_file(check: Row, content: Row) -> tuple[str, int] | None:
    """Return the first line of the file that is to hold the function."""
    own = (each for each in content["exercises"] if each["id"] == check["exercise"])
    return next(((each["file"], 1) for each in own), None)


def _warnings(content: Row, paths: Mapping[str, str]) -> Iterator[Annotation]:
    for each in content["build"].get("advice", []):
        found = _ADVICE.fullmatch(each)
        if found and found["file"] in paths:
            yield Annotation("", paths[found["file"]], int(found["line"]), False, "", found["text"])


def _read(paths: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield the C files that can be read here: those of an archive cannot."""
    for name, path in paths.items():
        if name.endswith(".c") and Path(path).is_file():
            yield name, Path(path).read_text(encoding="utf-8", errors="replace")


def _escaped(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _escaped(text).replace(":", "%3A").replace(",", "%2C")

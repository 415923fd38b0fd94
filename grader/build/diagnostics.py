"""What a compiler said, gcc or clang: one record per error or warning, at the student's line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grader.build import meanings
from grader.course.message import Message

MAX_LINE = 1000  # characters: a source can make the compiler say anything, at any length
_HEAD = re.compile(r"([\w.-]+):(\d+)(?::(\d+))?: (fatal error|error|warning|note): (.*)")
_INCLUDED = re.compile(r"(In file included from|\s+from) ")
_INSIDE = re.compile(r"([\w.-]+): (?:In function [‘'`](\w+)|At top level|In file scope)")
_DUPLICATE = re.compile(r"multiple definition of [`'‘](\w+)['’]")
CHANGED = "build.changed_signature"
# A number, or an expression of some, with a semicolon too many.
_CONSTANT = re.compile(r"\s*#\s*define\s+(\w+)\s+[\w.+\-*/ ()]+;\s*(?:/[/*].*)?$")
_GUTTER = re.compile(r" *\d+ \| ?")
_CARET = re.compile(r" +(?:\| *)?[~^]")


@dataclass(frozen=True)
class Diagnostic:
    """An error or a warning with the lines that go with it: source, caret, notes."""

    file: str
    line: int
    is_error: bool
    message: str
    lines: tuple[str, ...]  # as the compiler wrote them, the first with place and message
    function: str = ""  # in which it is, where the compiler says so
    word: str = ""  # the name that stands there

    @property
    def place(self) -> str:
        """Return "main.c:12"."""
        return f"{self.file}:{self.line}"

    def meaning(self) -> Message | None:
        """Return what it means in plain words, when that is known."""
        if self.is_error:
            return meanings.of_error(self.message, self.lines, self.function)
        found = meanings.of_warning(self.message, self.word, self.function)
        return Message(found.key, {**found.values, "place": self.place}) if found else None


def read(text: str) -> list[Diagnostic]:
    """Return the errors and warnings of a compiler's output, in its order."""
    return [_diagnostic(lines, function) for lines, function in _groups(text)]


def with_macros(text: str, sources: Mapping[str, bytes]) -> str:
    """Return a compiler's output with a note where a line in error uses a constant that ends in ;.

    The compiler shows the definition only where the error is inside it. `sources` are files.
    """
    if not (found := _constants(sources)):
        return text
    told: list[str] = []
    waiting: list[str] = []
    is_error = False
    for line in text.splitlines(keepends=True):
        if not _CARET.match(line):
            told += waiting
            waiting = []
        told.append(line)
        if head := _HEAD.match(line[:MAX_LINE]):
            is_error = "error" in head[4]
        elif is_error:  # the line of the source
            words = re.findall(r"\w+", line[:MAX_LINE])
            waiting, is_error = [found[name] for name in found if name in words], False
    told += waiting
    return "".join(told)


def _constants(sources: Mapping[str, bytes]) -> dict[str, str]:
    """Return notes on the constants whose definition ends in a semicolon, by their names."""
    found = {}
    for name, content in sources.items():
        for number, line in enumerate(content.decode(errors="replace").splitlines(), 1):
            if define := _CONSTANT.match(line[:MAX_LINE]):
                note = f"{name}:{number}: note: in definition of macro ‘{define[1]}’"
                found[define[1]] = f"{note}\n{number:5} | {line[:MAX_LINE]}\n"
    return found


def errors(text: str) -> list[Diagnostic]:
    """Return the errors, without those that only follow from another one before them.

    The same error is told once, however many files include its line.
    """
    kept: list[Diagnostic] = []
    told: set[object] = set()
    for each in (each for each in read(text) if each.is_error):
        meaning = each.meaning()
        name = meaning.key if meaning else ""
        # Braces are counted up to the end of a file: whatever else is wrong may have lost one.
        once = each.file if name in meanings.BRACES else (each.place, name or each.message)
        if {once, each.place} & told:
            continue
        kept.append(each)
        told |= {once, each.file}
        # After what it does not know at all, a compiler understands the line no more.
        told |= {each.place} if name in meanings.SPOILS else set()
    return kept


def advice(text: str) -> list[Message]:
    """Return what the warnings mean, those that have a meaning, by their places."""
    found: dict[tuple[str, int, str], Message] = {}
    for each in read(text):
        if not each.is_error and (meaning := each.meaning()):
            found.setdefault((each.file, each.line, meaning.key), meaning)
    return [found[key] for key in sorted(found)]


def places(text: str) -> list[str]:
    """Return the files in which a compiler has found errors, each once."""
    return list(dict.fromkeys(each.file for each in read(text) if each.is_error))


def changed_signatures(rejected: Mapping[str, str]) -> dict[str, str]:
    """Return the functions that a header declares otherwise than exercises.h, and that header.

    `rejected` are the errors of files.
    """
    found = [
        (each.meaning(), name)
        for name, text in rejected.items()
        if name.endswith(".h")
        for each in errors(text)
    ]
    return {str(each.values["name"]): name for each, name in found if each and each.key == CHANGED}


def is_changed(each: Diagnostic) -> bool:
    """Say whether an error is a declaration that differs from that of exercises.h."""
    meaning = each.meaning()
    return meaning is not None and meaning.key == CHANGED


def duplicates(complaint: str) -> list[str]:
    """Return the names that a linker has found more than once."""
    return list(dict.fromkeys(_DUPLICATE.findall(complaint)))


def _groups(text: str) -> Iterator[tuple[list[str], str]]:
    """Split the output: a group begins at an error or a warning, and holds its notes.

    Yields its lines, and the function that it is in.
    """
    group: list[str] = []
    ours = False
    function = now = ""
    for line in (each[:MAX_LINE] for each in text.splitlines()):
        head = _HEAD.match(line)
        if inside := _INSIDE.match(line):
            now = inside[2] or ""
        # Notes about the system's headers, and how they came to be included, help nobody.
        ours = bool(head) or (ours and line.startswith(" ") and not _INCLUDED.match(line))
        if head and head[4] != "note":
            yield from [(group, function)] if group else []
            group, function = [line], now
        elif group and ours:
            group.append(line)
    yield from [(group, function)] if group else []


def _diagnostic(lines: list[str], function: str) -> Diagnostic:
    head = _HEAD.match(lines[0])
    assert head is not None
    source = _GUTTER.sub("", lines[1], count=1) if len(lines) > 1 else ""
    word = re.match(r"\w+", source[int(head[3] or 1) - 1 :])
    return Diagnostic(
        head[1],
        int(head[2]),
        "error" in head[4],
        head[5],
        tuple(lines),
        function,
        word[0] if word else "",
    )

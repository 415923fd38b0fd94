"""What a compiler said, gcc or clang: one record per error or warning, at the student's line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from grader.course.message import Message

_HEAD = re.compile(r"([\w.-]+):(\d+)(?::\d+)?: (fatal error|error|warning|note): (.*)")
_QUOTED = re.compile(r"[‘'`]([\w./]+)['’]")
# What the usual errors mean, in plain words: keys of [build] in messages/. The name they tell is
# the pattern's group, or else the first word in quotes.
_MEANINGS = (
    ("build.changed_signature", r"conflicting types for"),
    ("build.semicolon", r"expected .*[‘']?;['’]?"),
    ("build.brace", r"at end of input|expected '}'|function definition is not allowed here"),
    ("build.undeclared", r"undeclared"),
    ("build.no_member", r"no member named [‘'](\w+)"),
    ("build.no_file", r"([\w./]+): No such file|file not found"),
    ("build.taken", r"as different kind of symbol"),
    ("build.twice", r"redefinition of"),
    ("build.off_switch", r"switches the sanitizers off"),
    ("build.slow", r"^compiling takes too long"),
    ("build.huge", r"^what is made of it takes more than"),
    ("build.gives_up", r"^the compiler gives up"),
)
_INCLUDED = re.compile(r"(In file included from|\s+from) ")
_DUPLICATE = re.compile(r"multiple definition of [`'‘](\w+)['’]")


@dataclass(frozen=True)
class Diagnostic:
    """An error or a warning with the lines that go with it: source, caret, notes."""

    file: str
    line: int
    is_error: bool
    message: str
    lines: tuple[str, ...]  # as the compiler wrote them, the first with place and message

    @property
    def place(self) -> str:
        """Return "main.c:12"."""
        return f"{self.file}:{self.line}"

    def meaning(self) -> Message | None:
        """Return what it means in plain words, when that is known."""
        for key, pattern in _MEANINGS:
            found = re.search(pattern, self.message)
            if found and self.is_error:
                quoted = _QUOTED.search(self.message)
                name = (found.re.groups and found[1]) or (quoted[1] if quoted else "")
                return Message(key, {"name": name})
        return None


def read(text: str) -> list[Diagnostic]:
    """Return the errors and warnings of a compiler's output, in its order."""
    return [_diagnostic(lines) for lines in _groups(text)]


def places(errors: str) -> list[str]:
    """Return the files in which a compiler has found errors, each once."""
    return list(dict.fromkeys(each.file for each in read(errors) if each.is_error))


def duplicates(complaint: str) -> list[str]:
    """Return the names that a linker has found more than once."""
    return list(dict.fromkeys(_DUPLICATE.findall(complaint)))


def _groups(text: str) -> Iterator[list[str]]:
    """Split the output: a group begins at an error or a warning, and holds its notes."""
    group: list[str] = []
    ours = False
    for line in text.splitlines():
        head = _HEAD.match(line)
        # Notes about the system's headers, and how they came to be included, help nobody.
        ours = bool(head) or (ours and line.startswith(" ") and not _INCLUDED.match(line))
        if head and head[3] != "note":
            yield from [group] if group else []
            group = [line]
        elif group and ours:
            group.append(line)
    yield from [group] if group else []


def _diagnostic(lines: list[str]) -> Diagnostic:
    head = _HEAD.match(lines[0])
    assert head is not None
    return Diagnostic(head[1], int(head[2]), "error" in head[3], head[4], tuple(lines))

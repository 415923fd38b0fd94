"""AUTEURS.txt: who made a submission, read from whatever an editor made of the file.

The student completes the template's lines or writes over them:

    Nom, Prénom, numéro : Lovelace, Ada, 21905678
    Groupe : B2

Nothing is guessed in silence: a line that is not understood is a problem of the record.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

from grader.course.message import Message

NAME = "AUTEURS.txt"
MAX_BYTES = 10_000
MAX_LABEL = 60  # characters of a file's name

_GROUP = re.compile(r"groupe?\b(?:[^:]*:)?(?P<rest>.*)", re.IGNORECASE)
# The template's label, with or without its accents, in either language; or a part of it.
_LABEL = re.compile(
    r"(?:noms?|surname|last name|name|étudiant(?:e|s)?|student)\b[^:\d]*:(?P<rest>.*)",
    re.IGNORECASE,
)
# A number may carry letters around its digits: p1905678, 21905678T.
_NUMBER = re.compile(r"[A-Za-z]{0,3}\d{4,15}[A-Za-z]?")
_SEPARATOR = re.compile(r"\s*[,;\t|]\s*")
_INVISIBLE = re.compile("[\ufeff\u200b\u200e\u200f]")  # pasted with a name
# Letters without an accent to take off.
LETTERS = str.maketrans(
    {
        **{"œ": "oe", "Œ": "OE", "æ": "ae", "Æ": "AE", "ß": "ss", "ø": "o", "Ø": "O"},
        **{"ł": "l", "Ł": "L", "đ": "d", "Đ": "D", "ı": "i"},
    }
)


@dataclass(frozen=True)
class Person:
    """One author; `number` is "" when it is missing, `first_name` too when there is one name."""

    surname: str
    first_name: str
    number: str


@dataclass(frozen=True)
class Authors:
    """What AUTEURS.txt says. `problems` are sentences of [authors] in messages/."""

    people: tuple[Person, ...]
    group: str
    problems: tuple[Message, ...] = ()

    @property
    def label(self) -> str:
        """The surnames as a part of a file's name: ASCII, without spaces; "" without authors."""
        names = [_plain(each.surname) or _plain(each.number) for each in self.people]
        return "-".join(filter(None, names))[:MAX_LABEL].strip("-")


def parse(content: bytes) -> Authors:
    """Read the file's content, in any usual encoding and with any end of line."""
    people: list[Person] = []
    problems: list[Message] = []
    group = ""
    if len(content) > MAX_BYTES:
        problems.append(Message("authors.too_long", {"kb": MAX_BYTES // 1000}))
    for number, line in enumerate(_text(content[:MAX_BYTES]).splitlines(), 1):
        if line.startswith("#") or _is_blank(line):
            continue
        if found := _GROUP.fullmatch(line):
            group = found["rest"].strip() or group
        elif person := _person(line):
            problems += _remarks(person, people, number)
            people.append(person)
        else:
            problems.append(Message("authors.not_understood", {"line": number, "text": line}))
    if not people:
        problems.append(Message("authors.nobody"))
    return Authors(tuple(people), group, tuple(problems))


def _text(content: bytes) -> str:
    """Decode: UTF-8 or UTF-16 with its mark, else Windows' Latin letters; then plain lines."""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        text = content.decode("utf-16", errors="replace")
    elif content[1:2] == b"\0":
        text = content.decode("utf-16-le", errors="replace")
    else:
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = content.decode("cp1252", errors="replace")
    # macOS writes an accent apart from its letter.
    text = unicodedata.normalize("NFC", text)
    text = _INVISIBLE.sub("", text)
    lines = (re.sub(r"[^\S\t]+", " ", line).strip() for line in text.splitlines())
    return "\n".join("".join(c for c in line if c == "\t" or c.isprintable()) for line in lines)


def _rest(line: str) -> str:
    """Return a line without the template's label and without a colon left at its end."""
    found = _LABEL.fullmatch(line)
    rest = (found["rest"] if found else line).strip().rstrip(":").strip()
    return re.sub(r"(?<=\d) (?=\d)", "", rest)  # 21 90 56 78


def _is_blank(line: str) -> bool:
    return not _rest(line).strip(" ,;.-_…")


def _person(line: str) -> Person | None:
    """Return the person of a line: names, then a number, in this order or not; None otherwise."""
    rest = _rest(line)
    numbers = _NUMBER.findall(rest)
    if len(numbers) > 1:
        return None
    names = [each.strip(" .-:()") for each in _SEPARATOR.split(_NUMBER.sub(",", rest))]
    names = [each for each in names if any(map(str.isalnum, each))]
    if len(names) not in (1, 2) or re.search(r"[\d:@]", "".join(names)):
        return None
    return Person(names[0], names[1] if len(names) == 2 else "", "".join(numbers))


def _remarks(person: Person, before: list[Person], line: int) -> list[Message]:
    """Return what is to be mended about a person."""
    name = f"{person.first_name} {person.surname}".strip()
    found = []
    if not person.number:
        found.append(Message("authors.no_number", {"name": name, "line": line}))
    if any(person == each or person.number == each.number != "" for each in before):
        found.append(Message("authors.twice", {"name": name, "line": line}))
    return found


def _plain(name: str) -> str:
    """Return a name as letters and digits of ASCII: the base letter of an accented one."""
    apart = unicodedata.normalize("NFKD", name.translate(LETTERS))
    letters = apart.encode("ascii", "ignore").decode()
    return re.sub(r"[^A-Za-z0-9]+", "-", letters).strip("-")

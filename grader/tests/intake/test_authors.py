"""AUTEURS.txt, as students and their editors write it."""

from __future__ import annotations

import pytest

from grader.course import exercises
from grader.course.texts import LANGUAGES, Texts
from grader.intake.authors import NAME, Authors, Person, parse

TEMPLATE = (exercises.CORE / NAME).read_text(encoding="utf-8")
ADA = Person("Lovelace", "Ada", "21905678")
ELISE = Person("Lœuillet", "Élise", "p1905679")


def filled(*lines: str) -> str:
    """Return the template with what students wrote behind its labels."""
    text = TEMPLATE
    for line in lines:
        text = text.replace("numéro :\n", f"numéro : {line}\n", 1)
    return text.replace("Groupe :", "Groupe : B2")


TWO = filled("Lovelace, Ada, 21905678", "Lœuillet, Élise, p1905679")


def keys(authors: Authors) -> list[str]:
    """Return what is to be mended."""
    return [each.key.removeprefix("authors.") for each in authors.problems]


def test_the_template_names_nobody() -> None:
    """Blank, as it is handed out, and with dots left by someone who began."""
    for text in (TEMPLATE, TEMPLATE.replace("numéro :", "numéro : ..., ..."), ""):
        assert (parse(text.encode()).people, keys(parse(text.encode()))) == ((), ["nobody"])


@pytest.mark.parametrize(
    "content",
    [
        TWO.encode(),
        TWO.encode("utf-8-sig"),
        TWO.replace("\n", "\r\n").encode(),
        TWO.replace("\n", "\r").encode(),
        TWO.encode("cp1252"),
        TWO.encode("utf-16"),
        TWO.encode("utf-16-le"),
        TWO.replace("É", "E\u0301").encode(),  # as macOS writes it
        TWO.replace("Lovelace", "\u200bLovelace\u00a0").encode(),
    ],
    ids=["utf-8", "bom", "crlf", "cr", "cp1252", "utf-16", "utf-16-le", "nfd", "invisible"],
)
def test_encodings_and_ends_of_line(content: bytes) -> None:
    """The same two people and group, whatever the editor."""
    assert parse(content) == Authors((ADA, ELISE), "B2")


@pytest.mark.parametrize(
    ("line", "person"),
    [
        ("Lovelace, Ada, 21905678", ADA),
        ("Lovelace ; Ada ; 21905678", ADA),
        ("Lovelace, Ada, 21 90 56 78", ADA),
        ("Lovelace\tAda\t21905678", ADA),
        ("Lovelace, Ada, 21905678 :", ADA),
        ("Nom : Lovelace, Ada, 21905678", ADA),
        ("Nom, Prenom, numero : Lovelace, Ada (21905678)", ADA),
        ("Surname, first name, number: Lovelace, Ada, 21905678", ADA),
        ("Lovelace Ada 21905678", Person("Lovelace Ada", "", "21905678")),
        ("Le Gall-O'Brien, Zoé, 21905678T", Person("Le Gall-O'Brien", "Zoé", "21905678T")),
    ],
)
def test_ways_of_writing_a_person(line: str, person: Person) -> None:
    """Behind the label or over it, with any usual separator."""
    assert parse(line.encode()) == Authors((person,), "")


@pytest.mark.parametrize(
    ("text", "problems", "people"),
    [
        ("Lovelace, Ada", ["no_number"], 1),
        ("Lovelace, Ada, 21905678\nLovelace, Ada, 21905678", ["twice"], 2),
        ("Lovelace, Ada, 21905678\nByron, Ada, 21905678", ["twice"], 2),
        ("Lovelace, Ada, 21905678, Byron, George, 21905679", ["not_understood", "nobody"], 0),
        ("Lovelace, Ada, 219", ["not_understood", "nobody"], 0),
        ("Nom : Lovelace\nPrénom : Ada\n21905678", ["no_number", *["not_understood"] * 2], 1),
        ("x" * 20_000, ["too_long", "no_number"], 1),
    ],
)
def test_what_is_doubtful_is_told(text: str, problems: list[str], people: int) -> None:
    """Nothing is guessed in silence, and what is understood is kept."""
    found = parse(text.encode())
    assert (keys(found), len(found.people)) == (problems, people)
    for language in LANGUAGES:
        texts = Texts(language)
        assert all(texts.say(each.key, **each.values) for each in found.problems)


@pytest.mark.parametrize("text", ["Groupe : B2", "groupe B2", "Group: B2", "Groupe de TP : B2"])
def test_the_group(text: str) -> None:
    """With or without a colon, in both languages."""
    assert parse(text.encode()).group == "B2"


@pytest.mark.parametrize(
    ("lines", "label"),
    [
        (["Lovelace, Ada, 21905678", "Lœuillet, Élise, 21905679"], "Lovelace-Loeuillet"),
        (["Le Gall-O'Brien, Zoé, 21905678"], "Le-Gall-O-Brien"),
        (["../../etc, x, 21905678"], "etc"),
        (["王, 伟, 21905678"], "21905678"),
        ([], ""),
        (["x" * 200 + ", y, 21905678"], "x" * 60),
    ],
)
def test_the_label_is_safe_in_a_files_name(lines: list[str], label: str) -> None:
    """ASCII, no space, no path, not too long; the number where no letter is left."""
    assert parse("\n".join(lines).encode()).label == label

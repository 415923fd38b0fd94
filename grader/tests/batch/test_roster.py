"""Who made what: folder, AUTEURS.txt and worksheet, where they agree and where they do not."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime
from pathlib import Path

import pytest

from grader.batch.identity import SubmittedWork
from grader.batch.names import is_alike, is_folder_of, key_of
from grader.batch.records import Candidate, Enrolled, Member
from grader.batch.roster import members, read
from grader.course.exercises import CORE
from grader.course.message import Message
from grader.intake.authors import parse


def handed(name: str, said: str = "", number: str = "", sources: str = "") -> SubmittedWork:
    """Return a submission with that AUTEURS.txt."""
    label = name.partition("_")[0]
    candidate = Candidate(name, label, Path("x"), number, moodle="_" in name)
    return SubmittedWork(candidate, parse(said.encode()) if said else None, sources or name)


def told(
    submissions: list[SubmittedWork], enrolled: list[Enrolled]
) -> list[tuple[str, str, str, bool]]:
    """Return name, Moodle's number, submission and whether nothing is chosen, by line."""
    lines = members(submissions, enrolled)
    return [(each.name, each.moodle, each.submission, each.unsettled) for each in lines]


ADA, BOB = Enrolled("1", "Ada Lovelace", "21900001"), Enrolled("2", "Bob Noël", "21900002")


def test_a_pair_is_graded_once_and_has_two_lines() -> None:
    """By number or by name, whatever the accents and the order; who is absent has a line too."""
    pair = handed("Ada Lovelace_1", "Lovelace, Ada, 21900001\nNOEL, bob, \n", "1")
    lines = told([pair], [ADA, BOB, Enrolled("3", "Carl Gauß")])
    assert lines == [
        ("Ada Lovelace", "1", "Ada Lovelace_1", False),
        ("Bob Noël", "2", "Ada Lovelace_1", False),
        ("Carl Gauß", "3", "", False),
    ]


@pytest.mark.parametrize(("sources", "chosen"), [("same", True), ("other", False)])
def test_the_same_student_in_two_submissions(sources: str, chosen: bool) -> None:
    """The same work handed in by both partners counts once; of different work none is chosen."""
    first = handed("Ada Lovelace_1", "Lovelace, Ada, 21900001\nNoël, Bob, 21900002", "1", "same")
    second = handed("Bob Noël_2", "Noël, Bob, 21900002", "2", sources)
    lines = {line[0]: line[3] for line in told([first, second], [ADA, BOB])}
    assert lines == {"Ada Lovelace": False, "Bob Noël": not chosen}


def test_who_hands_in_without_being_an_author_is_told() -> None:
    """They get a line, with a remark; an untouched template names nobody."""
    sent = handed("Bob Noël_2", "Lovelace, Ada, 21900001", "2")
    lines = {
        each.name: [remark.key for remark in each.remarks] for each in members([sent], [ADA, BOB])
    }
    assert lines == {"Ada Lovelace": [], "Bob Noël": ["batch.sender_missing"]}
    assert read(b"") is None
    template = (CORE / "AUTEURS.txt").read_bytes()
    assert read(template) is None


def test_anonymous_marking_keeps_the_participant() -> None:
    """The worksheet has numbers and no names: the one author is the participant."""
    sent = handed("Participant 12_12", "Lovelace, Ada, 21900001", "12")
    lines = told([sent], [Enrolled("12", "Participant 12")])
    assert lines == [("Ada Lovelace", "12", "Participant 12_12", False)]


# ---- Where two facts about a person disagree ----------------------------------------------------

GRACE = Enrolled("8", "Grace Hopper", "21900031")
ALAN = Enrolled("9", "Alan Turing", "21900032")
OWN = Enrolled("7", "Ada Lovelace", "21905678")


def lines_of(submissions: list[SubmittedWork], *enrolled: Enrolled) -> dict[str, Member]:
    """Return the line of each person, by Moodle's number; by the name of who has none."""
    return {each.moodle or each.name: each for each in members(submissions, list(enrolled))}


def reasons(member: Member) -> list[str]:
    """Return what is to be known of a person."""
    return [each.key.removeprefix("batch.") for each in member.remarks]


def test_a_name_and_a_number_of_two_people() -> None:
    """Neither gets a mark by it, in their own folder either; a work of one's own stays."""
    typo = handed("Ada Lovelace_7", "Lovelace, Ada, 21900031", "7")
    other = handed("Alan Turing_9", "Turing, Alan, 21900032", "9")
    found = lines_of([typo, other], OWN, GRACE, ALAN)
    assert {name: (each.submission, each.unsettled) for name, each in found.items()} == {
        "7": ("Ada Lovelace_7", True),
        "8": ("Ada Lovelace_7", True),
        "9": ("Alan Turing_9", False),
    }
    assert reasons(found["7"]) == reasons(found["8"]) == ["two_people"]
    pair = handed("Ada Lovelace_7", "Lovelace, Ada, 21905678\nHopper, Grace, 21900032", "7")
    found = lines_of([pair], OWN, GRACE, ALAN)
    assert {name: each.unsettled for name, each in found.items()} == {
        **{"7": False, "8": True, "9": True}
    }
    both = lines_of([pair, other], OWN, GRACE, ALAN)
    assert (both["9"].unsettled, both["9"].submission) == (False, "Alan Turing_9")


@pytest.mark.parametrize(
    ("said", "unsettled", "told"),
    [
        ("Lovelace, Ada, 21905679", False, "number_differs"),  # nobody's: the folder decides
        ("Lovelace, Ada,", False, ""),
        ("Lovelcae, Ada, 21905678", False, ""),
        ("Byron, Augusta, 21905678", False, "name_differs"),
        ("Byron, Augusta,", False, "name_differs"),
        ("ADA, LOVELACE, 21905678", False, ""),
        ("Hopper, Grace, 21905678", True, "two_people"),
    ],
)
def test_the_folder_outweighs_a_likeness(said: str, unsettled: bool, told: str) -> None:
    """A slip of the pen in a name or a number is told; a number of somebody else is none."""
    found = lines_of([handed("Ada Lovelace_7", said, "7")], OWN, GRACE)
    assert (found["7"].unsettled, found["7"].submission) == (unsettled, "Ada Lovelace_7")
    assert (told in reasons(found["7"])) == bool(told)
    assert found["8"].unsettled == ("Hopper" in said)


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("Hopper, Grace, 21900099", "other_number"),
        ("Hoper, Grace,", "nearly"),
        ("Hoper, Grace, 21900099", "nearly"),
        ("Nobody, Known, 21900031", "other_name"),
    ],
)
def test_a_partner_is_not_guessed(said: str, told: str) -> None:
    """Nor absent: who may be meant gets no mark and the reason."""
    pair = handed("Ada Lovelace_7", f"Lovelace, Ada, 21905678\n{said}", "7")
    found = lines_of([pair], OWN, GRACE)
    assert (found["7"].unsettled, found["8"].unsettled) == (False, True)
    assert reasons(found["8"]) == [told]


def test_namesakes_are_told_apart_by_folder_or_number_only() -> None:
    """Of two with one name, the folder's; as a partner neither, and each keeps their own work."""
    twins = (Enrolled("1", "Marie Dupont", "11111"), Enrolled("2", "Marie Dupont", "22222"))
    alone = lines_of([handed("Marie Dupont_2", "Dupont, Marie,", "2")], *twins)
    assert (alone["2"].unsettled, reasons(alone["1"])) == (False, ["absent"])
    pair = handed("Ada Lovelace_7", "Lovelace, Ada, 21905678\nDupont, Marie,", "7")
    own = handed("Marie Dupont_1", "", "1")
    found = lines_of([pair, own], OWN, *twins)
    assert (found["1"].submission, found["1"].unsettled) == ("Marie Dupont_1", False)
    assert (found["2"].unsettled, reasons(found["2"])) == (True, ["namesakes"])
    turned = (Enrolled("1", "Wei Li", "11111"), Enrolled("2", "Li Wei", "22222"))
    found = lines_of([handed("Wei Li_1", "Li, Wei,", "1")], *turned)
    assert (found["1"].unsettled, reasons(found["2"])) == (False, ["absent"])


def test_a_group_is_whom_the_worksheet_says() -> None:
    """The number of its folder is the group's, whoever has it as a participant."""
    people = [
        *(Enrolled("114", "Ada", "11111", "Binôme A"), Enrolled("110", "Zoé", "22222", "Binôme A")),
        *(
            Enrolled("109", "Bob", "33333", "Binôme B"),
            Enrolled("113", "Paul", "4", "Default group"),
        ),
    ]
    works = [
        handed("Binôme A_109", "Ada, , 11111\nBob, , 33333", "109"),
        handed("Binôme B_110", "", "110"),
    ]
    found = lines_of(works, *people)
    assert {name: (each.submission, each.unsettled) for name, each in found.items()} == {
        "114": ("Binôme A_109", False),
        "110": ("Binôme A_109", False),
        "109": ("Binôme B_110", False),
        "113": ("", False),
    }
    assert reasons(found["110"]) == ["member_missing"]
    assert reasons(found["109"]) == ["not_in_group"]
    default = handed("Default group_", "", "")
    assert lines_of([default], *people)["113"].submission == "Default group_"
    older = handed("Binôme A-Ada_114", "", "114")
    assert lines_of([older], *people)["114"].submission == "Binôme A-Ada_114"


def test_a_worksheet_of_another_assignment_gives_nobody_a_mark() -> None:
    """Moodle numbers participants anew in each: a folder's name and number are two people's."""
    works = [
        handed("Ada Lovelace_8", "Lovelace, Ada, 21905678", "8"),
        handed("Grace Hopper_55", "Hopper, Grace, 21900031", "55"),
    ]
    found = lines_of(works, OWN, GRACE)
    assert all(each.unsettled for each in found.values())
    assert "folder_torn" in reasons(found["7"])
    assert "folder_other_number" in reasons(found["8"])
    assert reasons(found["55"]) == ["folder_other_number"]


def test_who_has_handed_in_something_that_is_not_here_is_not_absent() -> None:
    """By the worksheet's own date, or a text written online."""
    when = datetime(2026, 3, 2, 22, 0)
    people = [
        *(Enrolled("1", "Ada", handed=when), Enrolled("2", "Bob", online=True, handed=when)),
        Enrolled("3", "Carl"),
    ]
    found = lines_of([], *people)
    assert {name: (each.unsettled, reasons(each)) for name, each in found.items()} == {
        "1": (True, ["not_there"]),
        "2": (True, ["online"]),
        "3": (False, ["absent"]),
    }
    draft = Enrolled("1", "Ada", handed=when, draft=True)
    assert reasons(lines_of([handed("Ada_1", "", "1")], draft)["1"]) == ["draft"]


def test_dates_are_those_of_the_work() -> None:
    """A partner has that of who handed in; the same work twice has the first one."""
    first, second = datetime(2026, 3, 1), datetime(2026, 3, 5)
    ada, bob = (
        Enrolled("1", "Ada", "11111", handed=first),
        Enrolled("2", "Bob", "22222", handed=second),
    )
    pair = handed("Ada_1", "Ada, , 11111\nBob, , 22222", "1", "same")
    own = handed("Bob_2", "Bob, , 22222", "2", "same")
    assert lines_of([pair, own], ada, bob)["2"].handed == first
    alone = lines_of([pair], ada, bob)["2"]
    assert (alone.handed, reasons(alone)) == (first, ["other_date"])
    absent = Enrolled("2", "Bob", "22222")
    assert lines_of([pair], ada, absent)["2"].handed == first


def test_anonymous_partners_are_not_absent() -> None:
    """Which number is theirs cannot be known."""
    pair = handed("Participant_12", "Lovelace, Ada, 11111\nHopper, Grace, 22222", "12")
    people = [Enrolled("12", "Participant 12"), Enrolled("13", "Participant 13")]
    found = lines_of([pair], *people)
    assert (found["13"].unsettled, reasons(found["13"])) == (True, ["perhaps"])


def test_without_a_worksheet_folders_and_authors_say_who_it_is() -> None:
    """Partners are found by number among the folders; one number for two names is two people."""
    works = [
        handed("Ada Lovelace_7", "Lovelace, Ada, 11111\nTuring, Alan, 33333", "7"),
        handed("Alan Turing_9", "Turing, Alan, 33333", "9"),
        handed("Grace Hopper_8", "Hopper, Grace, 33333", "8"),
        handed("rendu", "Noether, Emmy, 44444"),
        handed("Carl Gauss"),
    ]
    found = lines_of(works)
    assert {name: (each.submission, each.unsettled) for name, each in found.items()} == {
        "7": ("Ada Lovelace_7", False),
        "9": ("Ada Lovelace_7", True),
        "8": ("Grace Hopper_8", False),
        "Emmy Noether": ("rendu", False),
        "Carl Gauss": ("Carl Gauss", False),
    }


def test_plain_folders_are_held_against_the_worksheet() -> None:
    """By name or number; a name of several, or one that AUTEURS.txt contradicts, is nobody's."""
    twins = (Enrolled("1", "Marie Dupont", "11111"), Enrolled("2", "Marie Dupont", "22222"))
    works = [
        *(handed("Ada Lovelace"), handed("21900031"), handed("Marie Dupont")),
        handed("Alan Turing", "Nobody, Known, 99999"),
    ]
    found = lines_of(works, OWN, GRACE, ALAN, *twins)
    assert {name: (each.submission, each.unsettled) for name, each in found.items()} == {
        "7": ("Ada Lovelace", False),
        "8": ("21900031", False),
        "9": ("Alan Turing", True),
        "1": ("Marie Dupont", True),
        "2": ("Marie Dupont", True),
        "Known Nobody": ("Alan Turing", False),
    }
    assert reasons(found["1"]) == ["folder_namesakes"]
    assert reasons(found["9"]) == ["folder_name"]


def test_the_order_is_the_worksheets() -> None:
    """Then the others, by their names."""
    works = [handed("Zoë_1", "", "1"), handed("Ångström_77", "", "77")]
    enrolled = [Enrolled("1", "Zoë", row=0), Enrolled("3", "Ada", row=1)]
    assert [each.name for each in members(works, enrolled)] == ["Zoë", "Ada", "Ångström"]


# ---- Names --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("label", "name", "same"),
    [
        ("Zoé Lefèvre-DAubigné", "Zoé Lefèvre-D'Aubigné", True),
        ("Marie Mimi Dupont", 'Marie "Mimi" Dupont', True),
        ("Jean Martin Test", "Jean Martin_Test", True),
        ("=HYPERLINK(A1) +Injection", "=HYPERLINK(A1) +Injection", True),
        ("Zo├® Lef├¿vre", "Zoé Lefèvre", True),  # an archive that lost its letters
        ("محمد أحمد", "محمد أحمد", True),
        ("محمد", "أحمد", False),
        ("Marie Dupont", 'Marie "Mimi" Dupont', False),
        ("Li Wei", "Wei Li", False),
        ("Ada Lovelace", "Alan Turing", False),
    ],
)
def test_a_folders_name_is_a_persons_as_moodle_cleans_it(label: str, name: str, same: bool) -> None:
    """Exactly, but for what Moodle drops and what archives lose."""
    assert is_folder_of(label, name) is same


@pytest.mark.parametrize(
    ("one", "other", "alike"),
    [
        ("Łukasz Żółć", "Lukasz ZOLC", True),
        ("Yıldız Öztürk", "yildiz ozturk", True),
        ("José García", "José María García Pérez", True),
        ("A. Lovelace", "Ada Lovelace", True),
        ("Ada Lovelcae", "Ada Lovelace", True),
        ("Jean-Baptiste O’Connor", "JeanBaptiste OConnor", True),
        ("Ada Lovelace", "Ada Byron", False),
        ("", "Ada", False),
    ],
)
def test_names_may_be_one_persons(one: str, other: str, alike: bool) -> None:
    """Whatever the accents, the order, initials and a slip of the pen."""
    assert is_alike(one, other) is is_alike(other, one) is alike
    if key_of(one) == key_of(other) != "":
        assert alike


@pytest.mark.parametrize(
    ("said", "sure"),
    [
        ("Lovelace, Ada, 21905678", True),
        ("Lovelace, Ada, 21905678\nNobody, Known, 99999", True),  # a number of another class
        ("Lovelace, Ada, 21905678\nNobody, Known,", False),
        ("Lovelace, Ada, 21905678\nbinôme: voir avec Grace, merci, bien", False),
        (None, False),
    ],
)
def test_who_seems_absent_may_be_an_author_who_is_not_known(said: str | None, sure: bool) -> None:
    """Of a submission that cannot be read, or that names somebody who may be anybody."""
    work = handed("Ada Lovelace_7", said or "", "7")
    if said is None:
        work = replace(work, candidate=replace(work.candidate, problem=Message("batch.nothing")))
    found = lines_of([work], OWN, GRACE)["8"]
    assert (found.unsettled, reasons(found)) == (not sure, ["absent" if sure else "perhaps"])

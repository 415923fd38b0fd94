"""Intake: what a folder or a Moodle archive holds, and who made it."""

from __future__ import annotations

import os
import stat
import zipfile
from pathlib import Path

import pytest

from grader.batch.discovery import discover
from grader.batch.records import BatchError, Candidate, Settings
from grader.batch.roster import Enrolled, SubmittedWork, members, read
from grader.batch.tasks import read_candidate
from grader.course.exercises import CORE
from grader.intake.authors import parse
from grader.tests.batch import classroom

SETTINGS = Settings("fr", "strong")


def found(path: Path, tmp_path: Path) -> dict[str, Candidate]:
    """Return the candidates of a place by name."""
    return {each.name: each for each in discover(path, tmp_path / "work", tmp_path / "out")}


def keys(candidate: Candidate) -> list[str]:
    """Return what is wrong with a candidate, and what is to be known."""
    problem = [candidate.problem.key] if candidate.problem else []
    return problem + [str(each.values["reason"].key) for each in candidate.remarks]  # type: ignore[attr-defined]


def moodle(path: Path, entries: dict[str, str | bytes]) -> Path:
    """Write an archive as Moodle makes it."""
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return path


def test_a_class_of_every_kind(tmp_path: Path) -> None:
    """Folders at any depth and archives are found; what is not one submission is told."""
    pupils = classroom.write(tmp_path / "in", 12)
    candidates = found(tmp_path / "in", tmp_path)
    assert sorted(candidates) == sorted(each.name for each in pupils)
    problems = {
        name: reading.candidate.problem.key
        for name, each in candidates.items()
        if (reading := read_candidate(each, SETTINGS)).candidate.problem
    }
    kinds = {each.name: each.kind for each in pupils}
    assert {kinds[name]: key for name, key in problems.items()} == {
        "broken archive": "submission.not_an_archive",
        "empty": "batch.nothing",
        "several": "submission.several",
    }


def test_moodle_names_with_accents_commas_and_apostrophes(tmp_path: Path) -> None:
    """The number is read behind any name; files beside each other belong together."""
    archive = moodle(
        tmp_path / "tous.zip",
        {
            "O'Neil, Rémi_101_assignsubmission_file_/main.c": "int x;",
            "Éloïse d'Été_102_assignsubmission_file/deep/er/main.c": "int x;",
            "Zoë_103_assignsubmission_file_main.c": "int x;",
            "Zoë_103_assignsubmission_file_octree.c": "int x;",
            "Anne_104_assignsubmission_file_/rapport.pdf": "%PDF",
            "Anne_104_assignsubmission_onlinetext_/onlinetext.html": "<p>",
        },
    )
    candidates = found(archive, tmp_path)
    assert {each.number: each.label for each in candidates.values()} == {
        "101": "O'Neil, Rémi",
        "102": "Éloïse d'Été",
        "103": "Zoë",
        "104": "Anne",
    }
    reading = read_candidate(candidates["Zoë_103"], SETTINGS)
    assert reading.candidate.problem is None
    assert sorted(each.name for each in candidates["Zoë_103"].path.iterdir()) == [
        "main.c",
        "octree.c",
    ]
    assert keys(candidates["Anne_104"]) == ["batch.nothing"]


def test_unsafe_entries_are_refused_one_by_one(tmp_path: Path) -> None:
    """Nothing is written outside; the rest of the class is there."""
    top = "A_1_assignsubmission_file_"
    archive = moodle(
        tmp_path / "tous.zip",
        {
            f"{top}/main.c": "int x;",
            f"{top}/../../evil.c": "int x;",
            f"{top}/{'n' * 240}.c": "int x;",
            f"{top}/a\x07.c": "int x;",
            "/absolute.c": "int x;",
        },
    )
    link = zipfile.ZipInfo(f"{top}/link.c")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    device = zipfile.ZipInfo(f"{top}/device.c")
    device.external_attr = (stat.S_IFCHR | 0o666) << 16
    with zipfile.ZipFile(archive, "a") as more:
        more.writestr(link, "/etc/passwd")
        more.writestr(device, "")
        with pytest.warns(UserWarning, match="Duplicate"):
            more.writestr(f"{top}/main.c", "int y;")
    candidates = found(archive, tmp_path)
    assert sorted(keys(candidates["A_1"])) == [
        *("refused.link", "refused.name", "refused.name"),
        *("refused.outside", "refused.special", "refused.twice"),
    ]
    written = [path.name for path in (tmp_path / "work").rglob("*") if path.is_file()]
    assert written == ["main.c"]


def test_too_large_a_submission_is_refused_unread(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In Moodle's archive, and as a file: told, and the others are there."""
    monkeypatch.setattr("grader.batch.moodle_archive.MAX_ARCHIVE_BYTES", 1000)
    archive = moodle(
        tmp_path / "tous.zip",
        {
            "A_1_assignsubmission_file_/big.zip": bytes(2000),
            "B_2_assignsubmission_file_/main.c": "int x;",
        },
    )
    candidates = found(archive, tmp_path)
    assert keys(candidates["A_1"]) == ["batch.nothing", "refused.huge"]
    assert candidates["B_2"].problem is None
    huge = tmp_path / "in" / "huge.zip"
    huge.parent.mkdir()
    huge.touch()
    os.truncate(huge, 500_000_000)
    problem = read_candidate(found(huge.parent, tmp_path)["huge"], SETTINGS).candidate.problem
    assert problem is not None
    assert problem.key == "submission.too_large"


def test_an_archive_beside_files_is_not_guessed(tmp_path: Path) -> None:
    """A folder with an archive in it is that archive; with files as well, both are named."""
    (tmp_path / "in" / "ada").mkdir(parents=True)
    moodle(tmp_path / "in" / "ada" / "rendu.zip", {"main.c": "int x;"})
    (tmp_path / "in" / "bob" / ".git").mkdir(parents=True)
    (tmp_path / "in" / "bob" / ".git" / "main.c").touch()
    (tmp_path / "in" / "bob" / "main.c").touch()
    moodle(tmp_path / "in" / "bob" / "rendu.zip", {"main.c": "int x;"})
    (tmp_path / "in" / "link").symlink_to(tmp_path / "in" / "ada")
    candidates = found(tmp_path / "in", tmp_path)
    assert {name: keys(each) for name, each in candidates.items()} == {
        "ada": [],
        "bob": ["batch.several"],
        "link": ["batch.link"],
    }


@pytest.mark.parametrize(
    ("content", "key"), [(None, "no_submissions"), (b"PK\5\6" + bytes(18), "not_moodle")]
)
def test_a_place_that_is_no_class(tmp_path: Path, content: bytes | None, key: str) -> None:
    """Neither a folder nor a Moodle archive: one sentence."""
    path = tmp_path / "x.zip"
    if content:
        path.write_bytes(content)
    with pytest.raises(BatchError) as caught:
        found(path, tmp_path)
    assert caught.value.key == f"batch.{key}"


# ---- Members ------------------------------------------------------------------------------------


def handed(name: str, said: str = "", number: str = "", sources: str = "") -> SubmittedWork:
    """Return a submission with that AUTEURS.txt."""
    label = name.partition("_")[0]
    candidate = Candidate(name, label, Path("x"), number)
    return SubmittedWork(candidate, parse(said.encode()) if said else None, sources or name)


def told(
    submissions: list[SubmittedWork], enrolled: list[Enrolled]
) -> list[tuple[str, str, str, bool]]:
    """Return name, Moodle's number, submission and whether nothing is chosen, by line."""
    lines = members(submissions, enrolled)
    return [(each.name, each.moodle, each.submission, each.doubled) for each in lines]


ADA, BOB = Enrolled("1", "Ada Lovelace", "21900001"), Enrolled("2", "Bob Noël", "21900002")


def test_a_pair_is_graded_once_and_has_two_lines() -> None:
    """By number or by name, whatever the accents and the order; who is absent has a line too."""
    pair = handed("Ada Lovelace_1", "Lovelace, Ada, 21900001\nNOEL, bob, \n", "1")
    lines = told([pair], [ADA, BOB, Enrolled("3", "Carl Gauß")])
    assert lines == [
        ("Ada Lovelace", "1", "Ada Lovelace_1", False),
        ("bob NOEL", "2", "Ada Lovelace_1", False),
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

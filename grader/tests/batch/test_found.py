"""What a folder or a Moodle archive holds: one candidate for each submission, and what is told."""

from __future__ import annotations

import os
import stat
import zipfile
from pathlib import Path

import pytest

from grader.authoring.specimens import classroom
from grader.batch.discovery import Found, discover
from grader.batch.records import BatchError, Candidate, Settings
from grader.batch.tasks import read_candidate
from grader.tests.batch.desk_class import locked, packed

SETTINGS = Settings("fr", "strong")


def search(path: Path, tmp_path: Path) -> Found:
    """Return what a place holds."""
    return discover(path, tmp_path / "work", tmp_path / "out")


def found(path: Path, tmp_path: Path) -> dict[str, Candidate]:
    """Return the candidates of a place by name."""
    return {each.name: each for each in search(path, tmp_path).candidates}


def keys(candidate: Candidate) -> list[str]:
    """Return what is wrong with a candidate, and what is to be known."""
    told = [candidate.problem] if candidate.problem else []
    told += candidate.remarks
    return [getattr(each.values.get("reason"), "key", each.key) for each in told]


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
        if (reading := read_candidate(each, SETTINGS, tmp_path / "work")).candidate.problem
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
    reading = read_candidate(candidates["Zoë_103"], SETTINGS, tmp_path)
    assert reading.candidate.problem is None
    assert sorted(each.name for each in candidates["Zoë_103"].path.iterdir()) == [
        "main.c",
        "octree.c",
    ]
    assert keys(candidates["Anne_104"]) == ["batch.nothing", "batch.unread"]
    (unread,) = candidates["Anne_104"].remarks
    assert unread.values["names"] == "rapport.pdf, onlinetext.html"


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
        *("batch.unreadable", "refused.link", "refused.name"),
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
    problem = read_candidate(
        found(huge.parent, tmp_path)["huge"], SETTINGS, tmp_path
    ).candidate.problem
    assert problem is not None
    assert problem.key == "submission.too_large"


@pytest.mark.parametrize("layout", ["{}_assignsubmission_file_/", "{}_assignsubmission_file_"])
def test_nobody_s_files_take_the_room_of_another_s(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, layout: str
) -> None:
    """Each participant has a budget of bytes and of files; whoever exceeds it is told of it."""
    monkeypatch.setattr("grader.batch.moodle_archive.MAX_ARCHIVE_BYTES", 5000)
    monkeypatch.setattr("grader.batch.moodle_archive.MAX_FILES", 20)
    eve, mallory = layout.format("Eve_1"), layout.format("Mallory_2")
    files: dict[str, str | bytes] = {f"{eve}a{k}.zip": bytes(900) for k in range(9)}
    files |= {f"{mallory}big.c": "/" * 1_000_001}
    files |= {f"{mallory}f{k}.c": "int x;" for k in range(25)}
    files |= {f"{layout.format('Zoe_3')}main.c": "int x;"}
    candidates = found(moodle(tmp_path / "tous.zip", files), tmp_path)
    assert "refused.huge" in keys(candidates["Eve_1"])
    assert {"refused.many", "refused.large"} <= {*keys(candidates["Mallory_2"])}
    assert candidates["Zoe_3"].problem is None
    written = [path.name for path in (tmp_path / "work").rglob("*.c") if "loose" not in str(path)]
    assert len(written) == 20 + 1


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


@pytest.mark.parametrize("flat", [False, True])
def test_both_layouts_follow_the_same_rules(tmp_path: Path, flat: bool) -> None:
    """What cannot be graded is there and is told; renamed files are read; systems are nobody."""
    between = "_" if flat else "/"
    entries: dict[str, str | bytes] = {
        f"A_1_assignsubmission_file{between}rendu.rar": "Rar!",
        f"B_2_assignsubmission_file{between}main (1).c": "void fill_red(void) {}",
        f"B_2_assignsubmission_file{between}AUTEURS.txt": "Lovelace, Ada, 21900001",
        f"C_3_assignsubmission_file{between}main.c.txt": "void fill_red(void) {}",
        f"C_3_assignsubmission_file{between}notes.txt": "",
        f"Default group_assignsubmission_file{between}main.c": "int x;",
        f"__MACOSX/A_1_assignsubmission_file{between}._rendu.rar": "",
        ".DS_Store": "",
    }
    candidates = found(moodle(tmp_path / "tous.zip", entries), tmp_path)
    assert sorted(candidates) == ["A_1", "B_2", "C_3", "Default group"]
    assert keys(candidates["A_1"]) == ["batch.nothing", "batch.unread"]
    assert candidates["A_1"].remarks[0].values == {"names": "rendu.rar"}
    assert (candidates["Default group"].number, candidates["Default group"].moodle) == ("", True)
    told = {}
    for name in ("B_2", "C_3"):
        read = read_candidate(candidates[name], SETTINGS, tmp_path)
        assert read.candidate.problem is None
        told[name] = {each.key: each.values for each in read.candidate.remarks}
    assert told["B_2"]["batch.renamed"] == {"path": "main (1).c", "name": "main.c"}
    assert told["C_3"]["batch.renamed"] == {"path": "main.c.txt", "name": "main.c"}
    assert told["C_3"]["batch.unread"] == {"names": "notes.txt"}
    assert read_candidate(candidates["B_2"], SETTINGS, tmp_path).handed.authors is not None


@pytest.mark.parametrize(
    ("files", "problem", "remarks"),
    [
        ({"deep/core.zip": packed({"main.c": "fill_red"})}, None, ["batch.opened"]),
        ({"a.zip": packed({"main.c": ""}), "b.zip": b""}, "batch.several", []),
        ({"a.zip": packed({"b.zip": packed({"main.c": ""})})}, "submission.nothing", []),
        ({"a.zip": b"PK"}, "submission.not_an_archive", []),
        ({"a.txt": ""}, "submission.nothing", []),
    ],
)
def test_one_level_of_archives_in_archives_is_opened(
    tmp_path: Path, files: dict[str, str | bytes], problem: str | None, remarks: list[str]
) -> None:
    """When it holds the only files to judge, and that is told; of several nothing is chosen."""
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "ada.zip").write_bytes(packed(files))
    candidate = found(tmp_path / "in", tmp_path)["ada"]
    read = read_candidate(candidate, SETTINGS, tmp_path / "work").candidate
    assert (read.problem.key if read.problem else None) == problem
    assert [each.key for each in read.remarks][: len(remarks)] == remarks


@pytest.mark.parametrize(
    ("content", "names"),
    [
        (locked(packed({"main.c": "int x;", "octree.c": "int y;"})), "main.c, octree.c"),
        (packed({"main.c": " " * 1_000_001, "octree.c": "int y;"}), "main.c"),
        (packed({"main.cpp": "int x;", "octree.c": "int y;"}), "main.c"),
        (packed({"main (1).c": "a", "main (2).c": "b", "octree.c": "c"}), "main.c"),
        (packed({"main.c": b"\0\0\0\0", "octree.c": "int y;"}), "main.c"),
    ],
)
def test_a_file_of_the_students_that_cannot_be_read_is_no_mark(
    tmp_path: Path, content: bytes, names: str
) -> None:
    """It would be a lower one for want of it: a remark says which file, and why."""
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "ada.zip").write_bytes(content)
    read = read_candidate(found(tmp_path / "in", tmp_path)["ada"], SETTINGS, tmp_path).candidate
    assert read.problem is not None
    assert (read.problem.key, read.problem.values) == ("batch.unreadable", {"names": names})
    assert "batch.refused" in [each.key for each in read.remarks]


def test_another_courses_files_are_told(tmp_path: Path) -> None:
    """No function of the course is named in them."""
    archive = moodle(
        tmp_path / "tous.zip",
        {
            "A_1_assignsubmission_file/r.zip": packed(
                {"main.c": "int main(void) {}", "client.c": ""}
            )
        },
    )
    read = read_candidate(found(archive, tmp_path)["A_1"], SETTINGS, tmp_path).candidate
    assert [each.key for each in read.remarks] == ["batch.missing", "batch.foreign"]


def test_files_that_are_no_submission_are_told(tmp_path: Path) -> None:
    """A lone file in the folder of submissions; not what is read by others."""
    for name in ("notes.txt", "main.c", "manual.csv", "course.toml", ".DS_Store", "Thumbs.db"):
        (tmp_path / "in").mkdir(exist_ok=True)
        (tmp_path / "in" / name).touch()
    assert search(tmp_path / "in", tmp_path).strays == ["main.c", "notes.txt"]

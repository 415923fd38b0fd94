"""What is taken of a folder or an archive, and what is refused: entry by entry, with the reason."""

from __future__ import annotations

import contextlib
import gzip
import io
import os
import stat
import struct
import tarfile
import tracemalloc
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from grader.authoring.skeleton import originals as packing
from grader.build.records import BuildResult, BuildStatus, Target
from grader.course import exercises
from grader.course.texts import Texts
from grader.evaluation.remarks import notes
from grader.intake import archives, originals, tar_stream
from grader.intake import submission as intake
from grader.intake.archives import SubmissionError
from grader.intake.originals import OriginalsError
from grader.intake.records import Refusal, Renaming, Submission
from grader.intake.submission import read_submission
from grader.report import results

Write = Callable[..., Path]
BUILT = BuildResult(BuildStatus.BUILT, Target(96, 64))
MAIN = b'#include "raytracer.h"\n'


def reasons(submission: Submission) -> dict[str, str]:
    """Return why each refused file was."""
    return {each.path: each.reason for each in submission.refused}


def zipped(path: Path, files: Mapping[str, bytes]) -> Path:
    """Write a .zip of files."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return path


def lay(folder: Path, files: Mapping[str, bytes]) -> Path:
    """Write a folder of files."""
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder


def tarred(path: Path, *members: tuple[tarfile.TarInfo, bytes]) -> Path:
    """Write a .tar.gz of members."""
    with tarfile.open(path, "w:gz") as archive:
        for member, content in members:
            member.size = len(content)
            archive.addfile(member, io.BytesIO(content))
    return path


def member(name: str, kind: bytes = tarfile.REGTYPE) -> tarfile.TarInfo:
    """Return an entry of a .tar.gz."""
    entry = tarfile.TarInfo(name)
    entry.type, entry.linkname = kind, "/etc/passwd"
    return entry


def test_the_students_folder_holds_nothing_foreign() -> None:
    """As it is handed out: its Makefile is neither judged nor refused."""
    found = read_submission(exercises.CORE)
    assert "Makefile" not in found.files
    assert (found.refused, found.changed, found.missing) == ((), (), ())


def test_files_are_found_at_any_depth(tmp_path: Path) -> None:
    """In a folder, a .zip (of Windows too) and a .tar.gz, the same files come out."""
    (tmp_path / "a b" / "core_c").mkdir(parents=True)
    (tmp_path / "a b" / "core_c" / "main.c").write_bytes(MAIN)
    one = zipped(tmp_path / "rendu.zip", {"a b/core_c/main.c": MAIN, "a b/readme.txt": b""})
    two = zipped(tmp_path / "windows.zip", {"a b\\core_c\\main.c": MAIN})
    three = tarred(tmp_path / "rendu.tar.gz", (member("a b/core_c/main.c"), MAIN))
    for path in (tmp_path / "a b", one, two, three):
        submission = read_submission(path)
        assert submission.files == {"main.c": MAIN}
        assert submission.missing == ("raytracer.c", "raytracer.h", "octree.c")
    assert [read_submission(each).name for each in (one, three)] == ["rendu", "rendu"]


def test_several_candidates_are_named(tmp_path: Path) -> None:
    """Two folders with students' files: neither is chosen; at the top, they are the ones."""
    for folder in ("tp", "tp-ancien"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "raytracer.c").write_bytes(MAIN)
    with pytest.raises(SubmissionError) as caught:
        read_submission(tmp_path)
    assert caught.value.key == "submission.several"
    assert caught.value.values["folders"] == "tp, tp-ancien"
    (tmp_path / "main.c").write_bytes(MAIN)
    assert set(read_submission(tmp_path).files) == {"main.c"}


def test_what_tools_leave_behind_is_not_looked_at(tmp_path: Path) -> None:
    """MacOS's second copy of each file, an editor's or a version manager's folders."""
    files = {"main.c": MAIN, "__MACOSX/._main.c": b"\0", ".git/x.c": b"", "build/main.c": b""}
    submission = read_submission(zipped(tmp_path / "rendu.zip", files))
    assert (submission.files, submission.refused) == ({"main.c": MAIN}, ())


def test_unsafe_entries_of_a_zip_are_refused_one_by_one(tmp_path: Path) -> None:
    """Paths out of the archive, links, devices, bombs, repetitions: the rest is read."""
    path = zipped(
        tmp_path / "rendu.zip",
        {
            "main.c": MAIN,
            "../up.c": MAIN,
            "/root.c": MAIN,
            "C:/drive.c": MAIN,
            "big.c": b" " * 10**7,
        },
    )
    link, device = zipfile.ZipInfo("link.c"), zipfile.ZipInfo("device.c")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    device.external_attr = (stat.S_IFBLK | 0o666) << 16
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(link, "/etc/passwd")
        archive.writestr(device, "")
        with pytest.warns(UserWarning, match="Duplicate"):
            archive.writestr("main.c", b"again")
    submission = read_submission(path)
    assert submission.files == {"main.c": MAIN}
    assert reasons(submission) == {
        "../up.c": "outside",
        "/root.c": "outside",
        "C:/drive.c": "outside",
        "big.c": "large",
        "link.c": "link",
        "device.c": "special",
        "main.c": "twice",
    }


def test_locked_and_damaged_entries_are_refused_one_by_one(tmp_path: Path) -> None:
    """A password, a wrong checksum: said of the entry, not of the archive."""
    path = tmp_path / "rendu.zip"
    with zipfile.ZipFile(path, "w") as archive:
        for name in ("main.c", "locked.c", "damaged.c"):
            archive.writestr(name, name.encode())
    content = bytearray(path.read_bytes())
    content[content.rfind(b"locked.c") - 46 + 8] |= 1
    content[content.find(b"damaged.c", content.find(b"damaged.c") + 1)] ^= 255
    path.write_bytes(content)
    submission = read_submission(path)
    assert submission.files == {"main.c": b"main.c"}
    assert reasons(submission) == {"locked.c": "locked", "damaged.c": "damaged"}


def test_unsafe_entries_of_a_tar_are_refused_one_by_one(tmp_path: Path) -> None:
    """The same of a .tar.gz, whose names need not be text at all."""
    path = tarred(
        tmp_path / "rendu.tar.gz",
        (member("rendu/main.c"), MAIN),
        (member("rendu/../../up.c"), MAIN),
        (member("/root.c"), MAIN),
        (member("rendu/link.c", tarfile.SYMTYPE), b""),
        (member("rendu/hard.c", tarfile.LNKTYPE), b""),
        (member("rendu/device.c", tarfile.CHRTYPE), b""),
        (member("rendu/\udcff.c"), MAIN),
    )
    submission = read_submission(path)
    assert submission.files == {"main.c": MAIN}
    assert reasons(submission) == {
        "rendu/../../up.c": "outside",
        "/root.c": "outside",
        "rendu/link.c": "link",
        "rendu/hard.c": "link",
        "rendu/device.c": "special",
        "rendu/\ufffd.c": "name",
    }


def test_a_bomb_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A .tar.gz that unpacks to far more than it is, in its files or in its headers."""
    monkeypatch.setattr(tar_stream, "MAX_UNPACKED_BYTES", 5_000_000)
    header = member("octree.c")
    header.pax_headers = {"comment": "x" * 10**6}
    bombs = {"unpacked": (member("x"), b"\0" * 10**7), "header": (header, MAIN)}
    for problem, bomb in bombs.items():
        path = tarred(tmp_path / "behind.tar.gz", (member("main.c"), MAIN), bomb)
        assert path.stat().st_size < 100_000
        read = read_submission(path)
        assert (read.files, reasons(read)) == ({"main.c": MAIN}, {path.name: problem})
        path = tarred(tmp_path / "before.tar.gz", bomb, (member("main.c"), MAIN))
        with pytest.raises(SubmissionError) as caught:
            read_submission(path)
        assert caught.value.key == f"submission.nothing_in_{problem}"


def test_many_large_files_never_meet_in_memory(tmp_path: Path) -> None:
    """60 files of 1 MB in an archive of 65 KB: elsewhere, none is read; beside, 10 MB are."""
    for folder in ("d/", ""):
        large = dict.fromkeys((f"{folder}x{k}.c" for k in range(60)), b"/" * 999_999)
        path = zipped(tmp_path / "rendu.zip", {"main.c": MAIN, **large})
        assert path.stat().st_size < 100_000
        tracemalloc.start()
        read = read_submission(path)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert read.files["main.c"] == MAIN
        assert peak < 30e6
        assert sum(map(len, read.files.values())) <= intake.MAX_BYTES
        assert set(reasons(read).values()) == (set() if folder else {"total"})


def test_what_a_name_or_a_folder_costs_is_bounded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Folders count among the entries, in archives too: each takes memory and time."""
    monkeypatch.setattr(archives, "MAX_ENTRIES", 20)
    for k in range(30):
        (tmp_path / "folder" / f"d{k}").mkdir(parents=True)
    many = [(member(f"d{k}", tarfile.DIRTYPE), b"") for k in range(30)]
    path = tarred(tmp_path / "rendu.tar.gz", *many, (member("main.c"), MAIN))
    for each in (tmp_path / "folder", path):
        with pytest.raises(SubmissionError) as caught:
            read_submission(each)
        assert caught.value.key == "submission.nothing_in_many"


def test_the_four_named_files_come_first(tmp_path: Path) -> None:
    """With 99 files of one's own, or 10 MB of them, before: the course's are read all the same."""
    names = exercises.load().student
    for around in (
        {f"a{k}.c": MAIN for k in range(99)},
        {f"a{k}.c": b" " * 10**6 for k in range(11)},
    ):
        path = zipped(tmp_path / "rendu.zip", {**around, **dict.fromkeys(names, MAIN)})
        read = read_submission(path)
        assert set(names) < set(read.files)
        assert set(reasons(read).values()) <= {"many", "total"}
        assert len(reasons(read)) + len(read.files) == len(around) + len(names)


def test_a_course_s_file_that_cannot_be_read_is_told_first(submission: Write) -> None:
    """Before all the others: a report shows but a few, and this one costs points."""
    folder = submission(files={f"@{k}.c": "" for k in range(9)})
    (folder / "main.c").write_bytes(b"\0\1\2")
    read = read_submission(folder)
    assert read.refused[0] == Refusal("main.c", "binary")
    assert "main.c" not in read.missing


DATES: list[object] = [1e15, -1, "nan", "inf", "-inf", "1e300", "x", ""]


@pytest.mark.parametrize("date", DATES)
def test_a_date_of_an_archive_is_one_that_can_be_shown(tmp_path: Path, date: object) -> None:
    """Whatever a .tar claims: what is no date is none, and results are written all the same."""
    entry = member("main.c")
    if isinstance(date, str):
        entry.pax_headers = {"mtime": date}
    else:
        entry.mtime = date  # type: ignore[assignment]
    (source,) = read_submission(tarred(tmp_path / "rendu.tar.gz", (entry, MAIN))).sources
    assert source.modified == 0
    assert results._moment(source.modified)


def test_a_date_of_a_folder_is_one_that_can_be_shown(submission: Write) -> None:
    """A file system keeps more years than a calendar."""
    folder = submission()
    os.utime(folder / "main.c", (10**12, 10**12))
    assert results._moment(read_submission(folder).sources[0].modified)


NAMES = [
    "",
    ".",
    "./",
    "/",
    "//",
    "a\0b/main.c",
    "\x1b[2J/main.c",
    "\u202e/main.c",
    "a/" * 9000 + "main.c",
]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_of_an_archive_is_never_a_traceback(tmp_path: Path, name: str) -> None:
    """Empty, without a part, endless, or made to be obeyed by a terminal."""
    path = tmp_path / "rendu.zip"
    with zipfile.ZipFile(path, "w") as archive:
        entry = zipfile.ZipInfo("x")
        entry.filename = name
        archive.writestr(entry, MAIN)
    entry_of_tar = member("x")
    entry_of_tar.pax_headers = {"path": name}
    for each in (path, tarred(tmp_path / "rendu.tar.gz", (entry_of_tar, MAIN))):
        with contextlib.suppress(SubmissionError):
            read = read_submission(each)
            assert read.files == {"main.c": MAIN}
            assert all(c.isprintable() for source in read.sources for c in source.path)


@pytest.mark.parametrize("size", ["-1", "-600", "9" * 30, "1e9", "600000000"])
def test_a_size_of_an_archive_is_never_a_traceback(tmp_path: Path, size: str) -> None:
    """What a .tar claims of a member's length; a stream never goes back."""
    entry = member("x.bin")
    entry.pax_headers = {"size": size}
    path = tarred(tmp_path / "rendu.tar.gz", (member("main.c"), MAIN), (entry, b""))
    with contextlib.suppress(SubmissionError):
        assert read_submission(path).files == {"main.c": MAIN}


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_other_compressions_are_refused(tmp_path: Path, method: int) -> None:
    """They may claim gigabytes to be unpacked with, and ordinary tools do not use them."""
    path = zipped(tmp_path / "rendu.zip", {"main.c": MAIN})
    with zipfile.ZipFile(path, "a", method) as archive:
        archive.writestr("octree.c", MAIN)
    read = read_submission(path)
    assert (read.files, reasons(read)) == ({"main.c": MAIN}, {"octree.c": "method"})


def test_a_zip_whose_list_is_a_bomb_is_not_opened(tmp_path: Path) -> None:
    """The size of the list is read before the list."""
    path = zipped(tmp_path / "rendu.zip", {"main.c": MAIN})
    content = bytearray(path.read_bytes())
    struct.pack_into("<L", content, len(content) - 22 + 12, 50_000_000)
    path.write_bytes(content)
    with pytest.raises(SubmissionError) as caught:
        read_submission(path)
    assert caught.value.key == "submission.too_many"


def test_many_entries_are_looked_at_up_to_a_bound(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What has been found so far is judged, and the report says that there is more."""
    monkeypatch.setattr(archives, "MAX_ENTRIES", 10)
    files = {"main.c": MAIN, **{f"{k}.txt": b"" for k in range(20)}}
    (tmp_path / "folder").mkdir()
    for name, content in files.items():
        (tmp_path / "folder" / name).write_bytes(content)
    for path in (zipped(tmp_path / "rendu.zip", files), tmp_path / "folder"):
        if path.is_file():
            assert set(read_submission(path).files) == {"main.c"}
        else:
            problems = [each.problem for each in archives.entries(path) if each.problem]
            assert problems == ["many"]


@pytest.mark.parametrize(
    ("content", "key"),
    [
        (b"int main;", "submission.not_an_archive"),
        (b"", "submission.not_an_archive"),
        (gzip.compress(b"int main;", mtime=0), "submission.not_an_archive"),
        (gzip.compress(b"\0" * 2000, mtime=0)[:-9], "submission.broken"),
        (b"PK\5\6" + b"\1" * 18, "submission.too_many"),
        (b"PK\5\6" + struct.pack("<4H2LH", 0, 0, 1, 1, 46, 0, 0), "submission.broken"),
    ],
)
def test_what_is_no_archive_says_so(tmp_path: Path, content: bytes, key: str) -> None:
    """A text, nothing, half an archive: one sentence each, no traceback."""
    path = tmp_path / "rendu.zip"
    path.write_bytes(content)
    with pytest.raises(SubmissionError) as caught:
        read_submission(path)
    assert caught.value.key == key


@pytest.mark.parametrize("cut", range(0, 400, 7))
def test_a_damaged_archive_is_never_a_traceback(tmp_path: Path, cut: int) -> None:
    """Bytes changed anywhere: a submission, or a SubmissionError."""
    one = zipped(tmp_path / "rendu.zip", {"main.c": MAIN, "octree.c": MAIN * 9})
    two = tarred(tmp_path / "rendu.tar.gz", (member("main.c"), MAIN), (member("x.c"), MAIN))
    for path in (one, two):
        content = bytearray(path.read_bytes())
        content[cut % len(content)] ^= 0x55
        path.write_bytes(content)
        with contextlib.suppress(SubmissionError):
            assert set(read_submission(path).files) <= {"main.c", "octree.c", "x.c"}


def test_an_archive_that_is_too_large_is_not_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sentence tells the bound and the cure."""
    monkeypatch.setattr(archives, "MAX_ARCHIVE_BYTES", 100)
    with pytest.raises(SubmissionError) as caught:
        read_submission(zipped(tmp_path / "rendu.zip", {"main.c": MAIN}))
    assert caught.value.key == "submission.too_large"


def test_links_odd_names_and_large_files_are_refused(submission: Write, tmp_path: Path) -> None:
    """Nothing is read through a link; `@x.c` would be an option file for the compiler."""
    secret = tmp_path / "secret"
    secret.write_text("int secret;", encoding="utf-8")
    folder = submission(files={"@x.c": "", "large.c": " " * 1_000_001, "mrt_shim.c": ""})
    (folder / "link.c").symlink_to(secret)
    os.mkfifo(folder / "pipe.c")
    (Path(os.fsdecode(os.fsencode(folder) + b"/\xff.c"))).touch()
    assert reasons(read_submission(folder)) == {
        "@x.c": "name",
        "large.c": "large",
        "link.c": "link",
        "pipe.c": "special",
        "\ufffd.c": "name",
    }


def test_wrong_paths_say_so(tmp_path: Path) -> None:
    """No folder, a pipe, an empty folder: each has its own sentence."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    for path, key in (
        (tmp_path / "absent", "submission.no_folder"),
        (tmp_path / "pipe", "submission.not_a_folder"),
        (tmp_path / "loop", "submission.not_a_folder"),
        (tmp_path, "submission.nothing"),
    ):
        with pytest.raises(SubmissionError) as caught:
            read_submission(path)
        assert caught.value.key == key


def test_given_files_are_compared_not_taken(submission: Write) -> None:
    """Changed ones are named; my_tests.c is the student's, never built."""
    folder = submission(files={"vector.h": "#error mine\n", "my_tests.c": "", "extra.c": ""})
    (folder / "ray.h").write_bytes((exercises.CORE / "ray.h").read_bytes())
    read = read_submission(folder)
    assert set(read.files) == {"main.c", "raytracer.c", "raytracer.h", "octree.c", "extra.c"}
    assert read.changed == ("vector.h",)


def test_every_file_comes_with_its_place_and_date(submission: Write, tmp_path: Path) -> None:
    """In the course's order; of an archive, the place is in it."""
    folder = submission()
    os.utime(folder / "octree.c", (1000, 2000))
    read = read_submission(folder)
    names = [each.name for each in read.sources]
    assert names == list(exercises.load().student)
    assert read.sources[-1].path == str(folder / "octree.c")
    assert read.sources[-1].modified == 2000
    (source,) = read_submission(zipped(tmp_path / "r.zip", {"tp/main.c": MAIN})).sources
    assert source.path == f"{tmp_path / 'r.zip'} : tp/main.c"


def test_other_versions_nearby_are_found(submission: Write, tmp_path: Path) -> None:
    """Above, beside and below, when they differ; never among other people's submissions."""
    folder = submission()
    (folder / "vieux").mkdir()
    (folder / "vieux" / "main.c").write_bytes(b"int old;")
    (tmp_path / "copie").mkdir()
    (tmp_path / "copie" / "octree.c").write_bytes(b"int copy;")
    (tmp_path / "main.c").write_bytes((folder / "main.c").read_bytes())
    found = read_submission(folder, look_around=True).nearby
    places = {
        str(tmp_path / "copie/octree.c"),
        str(folder / "vieux/main.c"),
    }
    assert {each.path for each in found} == places
    assert read_submission(folder).nearby == ()
    for k in range(6):
        (tmp_path / f"student{k}").mkdir()
        (tmp_path / f"student{k}" / "main.c").write_bytes(b"int other;")
    assert read_submission(folder, look_around=True).nearby == ()


def test_the_originals_are_those_of_core_c(capsys: pytest.CaptureFixture[str]) -> None:
    """What is packed in the grader is what core_c/ holds: make skeleton packs it again."""
    assert (packing.main(["--check"]), capsys.readouterr().out) == (0, "")


def test_core_c_itself_is_judged_with_the_packed_originals(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A given file edited in place is named, and the original is still at hand."""
    core = tmp_path / "core_c"
    core.mkdir()
    for name in originals.names():
        (core / name).write_bytes((exercises.CORE / name).read_bytes())
    monkeypatch.setattr(exercises, "CORE", core)
    monkeypatch.setattr(originals, "PACK", tmp_path / "originals.zip")
    assert packing.main([]) == 0
    (core / "scene.c").write_bytes(b"#error mine\n")
    read = read_submission(core)
    assert (read.in_place, read.changed) == (True, ("scene.c",))
    assert "make restore" in "".join(map(Texts("fr").told, notes(read, [BUILT], sanitized=True)))
    assert originals.read(in_place=True)["scene.c"] != b"#error mine\n"
    assert originals.read(in_place=False)["scene.c"] == b"#error mine\n"
    monkeypatch.setattr(originals, "REFERENCE", tmp_path / "absent")
    assert originals.read(in_place=False)["scene.c"] != b"#error mine\n"
    (core / "ray.h").unlink()
    assert read_submission(core).changed == ("ray.h", "scene.c")


def test_a_drift_and_a_missing_pack_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Another core_c, no archive, a damaged one: each has its line."""
    pack = tmp_path / "originals.zip"
    monkeypatch.setattr(originals, "PACK", pack)
    assert packing.main(["--check"]) == 1
    assert "run make skeleton" in capsys.readouterr().out
    with pytest.raises(OriginalsError) as caught:
        originals.read(in_place=True)
    assert caught.value.values["name"] == "grader/intake/originals.zip"
    assert (packing.main([]), packing.main(["--check"])) == (0, 0)


# ---- Renamed on the way -------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        *("main (1).c", "main(1).c", "main-1.c", "main 2.c", "main copy.c", "main copie 2.c"),
        *("main - Copie.c", "main - Copy (2).c", "Copie de main.c", "Copy (2) of main.c"),
        *("main (copy).c", "main (3rd copy).c", "main.c.txt", "main (1).c.txt", "MAIN.C", "Main.c"),
    ],
)
def test_names_that_browsers_and_systems_have_changed(tmp_path: Path, name: str) -> None:
    """The file is read under its own name, in a folder and in an archive, and that is told."""
    files = {name: b"int x;", "raytracer.c": b"int y;", "main_v2.c": b"int z;"}
    for path in (zipped(tmp_path / "rendu.zip", files), lay(tmp_path / "folder", files)):
        read = read_submission(path)
        assert read.files["main.c"] == b"int x;"
        assert read.renamed == (Renaming(name, "main.c"),)
        assert read.missing == ("raytracer.h", "octree.c")
        assert "main_v2.c" in read.files


def test_nothing_is_chosen_between_copies(tmp_path: Path) -> None:
    """The file under its own name is the one, whatever lies beside it."""
    both = read_submission(lay(tmp_path / "both", {"main.c": b"int x;", "main (1).c": b"int y;"}))
    assert (both.files, reasons(both)) == ({"main.c": b"int x;"}, {"main (1).c": "name"})
    copies = {"main (1).c": b"int x;", "main (2).c": b"int y;"}
    differ = read_submission(lay(tmp_path / "differ", copies))
    assert dict(differ.files) == {}
    assert reasons(differ) == {"main (1).c": "copies", "main (2).c": "name"}


def test_what_is_not_read_is_named(tmp_path: Path) -> None:
    """Whatever it is and wherever it lies, except what systems make for themselves."""
    files = {
        **{"main.c": b"int x;", "rapport.pdf": b"", "old/main.c": b"int y;", "mrt": b""},
        **{"__MACOSX/._main.c": b"", ".DS_Store": b"", "vector.c": b"int z;", "my_tests.c": b""},
    }
    for path in (zipped(tmp_path / "rendu.zip", files), lay(tmp_path / "folder", files)):
        assert set(read_submission(path).unread) == {"rapport.pdf", "old/main.c", "mrt"}

"""The skeleton generator: what it cuts, what it puts instead, what it refuses, what it writes."""

from __future__ import annotations

import errno
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from grader.authoring.skeleton import skeleton
from grader.course.exercises import CORE, ROOT, ManifestError, load

FILES = load().student
KNOWN = frozenset({"TP1.1", "TP2.4", "TP2.6", "TP3.1", "TP5.2", "TP4.B1"})
SOURCE = Path("reference/main.c")

PLAIN = "int zero(void)\n{\n    return 0;\n}\n"
SOLVED = """\
#include "raytracer.h"

bool hit(void) {
    /* BEGIN SOLUTION TP2.4 */
    return secret_root(2.0f);
    /* END SOLUTION */
    return false;
}
"""
STUBBED = """\
#include "raytracer.h"

bool hit(void) {
    MRT_TODO("TP2.4");
    return false;
}
"""


def make(text: str) -> str:
    """Return the skeleton of a text, with the ids of KNOWN."""
    return skeleton.make_skeleton(SOURCE, text, KNOWN)


def test_text_without_a_mark_is_unchanged() -> None:
    """A file without marks comes out as it went in."""
    assert make(PLAIN) == PLAIN


def test_region_in_a_function_becomes_a_marker() -> None:
    """The marker stands at the mark's indentation, in place of the region."""
    assert make(SOLVED) == STUBBED


def test_stub_text_follows_the_marker() -> None:
    """What stands after the colon is written below the marker, colons of its own included."""
    text = (
        "color f(void) {\n"
        "    if (on) {\n"
        "        /* BEGIN SOLUTION TP2.6: *out = a ? b : c; return sky_color(); */\n"
        "        work();\n"
        "        /* END SOLUTION */\n"
        "    }\n"
        "}\n"
    )
    assert make(text) == (
        "color f(void) {\n"
        "    if (on) {\n"
        '        MRT_TODO("TP2.6");\n'
        "        *out = a ? b : c; return sky_color();\n"
        "    }\n"
        "}\n"
    )


def test_marker_stands_once_per_function_and_id() -> None:
    """Later regions of an id give their stub only; another id or function has its own marker."""

    def region(exercise: str, stub: str = "") -> str:
        return f"    /* BEGIN SOLUTION {exercise}{stub} */\n    x();\n    /* END SOLUTION */\n"

    text = (
        f"void f(void) {{\n{region('TP3.1')}    keep();\n{region('TP5.2')}{region('TP3.1')}"
        f"    keep();\n{region('TP3.1', ': y = 0;')}}}\n\nvoid g(void) {{\n{region('TP5.2')}}}\n"
    )
    assert make(text) == (
        'void f(void) {\n    MRT_TODO("TP3.1");\n    keep();\n    MRT_TODO("TP5.2");\n'
        '    keep();\n    y = 0;\n}\n\nvoid g(void) {\n    MRT_TODO("TP5.2");\n}\n'
    )


def test_region_at_column_0_goes_without_a_trace() -> None:
    """Includes and helpers vanish with the blank lines around them, wherever they stand."""
    cut = "/* BEGIN SOLUTION TP4.B1 */\nint helper(void) {\n    return 1;\n}\n/* END SOLUTION */\n"
    assert make(f"#include <a.h>\n{cut}\nint x;\n") == "#include <a.h>\n\nint x;\n"
    assert make(f"int x;\n\n{cut}\nint y;\n") == "int x;\n\nint y;\n"
    assert make(f"int x;\n\n{cut}\n{cut}\nint y;\n") == "int x;\n\nint y;\n"
    assert make(f"{cut}\nint x;\n") == "int x;\n"
    assert make(f"int x;\n\n{cut}") == "int x;\n"
    assert make(f"int x;\n\n{cut}\n{cut}") == "int x;\n"


def test_cut_inside_a_function_leaves_no_blank_line_at_its_edges() -> None:
    """A later region without a stub takes the blank lines next to a brace with it."""
    region = "    /* BEGIN SOLUTION TP2.4 */\n    x();\n    /* END SOLUTION */\n"
    text = f"void f(void) {{\n{region}    do {{\n{region}\n    }} while (keep());\n\n{region}}}\n"
    assert make(text) == (
        'void f(void) {\n    MRT_TODO("TP2.4");\n    do {\n    } while (keep());\n}\n'
    )
    text = f"void f(void) {{\n{region}    {{\n{region}\n    keep();\n    }}\n}}\n"
    assert make(text) == 'void f(void) {\n    MRT_TODO("TP2.4");\n    {\n    keep();\n    }\n}\n'


def test_the_texts_own_blank_lines_stay() -> None:
    """Blank lines away from a region are the author's."""
    text = "int x;\n\n\nint y;\n\nint z;\n" + SOLVED
    assert make(text) == "int x;\n\n\nint y;\n\nint z;\n" + STUBBED


END = "    /* END SOLUTION */\n"
OPEN = "    /* BEGIN SOLUTION TP2.4 */\n"


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (OPEN, 1, "BEGIN SOLUTION without its END"),
        ("int x;\n" + OPEN + "int y;\n", 2, "BEGIN SOLUTION without its END"),
        ("int x;\n" + END, 2, "END SOLUTION without its BEGIN"),
        (OPEN + END + END, 3, "END SOLUTION without its BEGIN"),
        (OPEN + OPEN + END + END, 2, "inside another"),
        (OPEN + "/* END SOLUTION */\n", 2, "not indented as its BEGIN"),
        (OPEN + "}\n" + END, 2, "the function ends inside"),
        ("/* BEGIN SOLUTION TP9.9 */\n/* END SOLUTION */\n", 1, "unknown exercise TP9.9"),
        ("/* BEGIN SOLUTION tp2.4 */\n/* END SOLUTION */\n", 1, "unknown exercise tp2.4"),
        ("/* BEGIN SOLUTION */\n/* END SOLUTION */\n", 1, "malformed"),
        ("/* BEGIN SOLUTION  TP2.4 */\n/* END SOLUTION */\n", 1, "malformed"),
        ("/* BEGIN SOLUTION TP2.4 TP2.6 */\n/* END SOLUTION */\n", 1, "malformed"),
        ("    /* BEGIN SOLUTION TP2.4: */\n" + END, 1, "malformed"),
        ("    // BEGIN SOLUTION TP2.4\n    // END SOLUTION\n", 1, "malformed"),
        ("    int x; /* BEGIN SOLUTION TP2.4 */\n" + END, 1, "malformed"),
        ("    /* BEGIN SOLUTION TP2.4 */ int x;\n" + END, 1, "malformed"),
        (OPEN + "    /* END SOLUTION */ int x;\n", 2, "malformed"),
        (OPEN + "    /* END SOLUTION TP2.4 */\n", 2, "malformed"),
        ("    /* begin solution TP2.4 */\n", 1, "malformed"),
        ("    /* Begin-Solution TP2.4 */\n", 1, "malformed"),
        ("    /* the SOLUTION of TP2.4 */\n", 1, "malformed"),
        ("    /* BEGIN SOLUTION TP2.4: a; */ b(); /* c; */\n" + END, 1, "stands alone"),
        ("    /* BEGIN SOLUTION TP2.4: return 0 */\n" + END, 1, "whole C statements"),
        ("    /* BEGIN SOLUTION TP2.4: SOLUTION(); */\n" + END, 1, "whole C statements"),
        ("/* BEGIN SOLUTION TP2.4: return 0; */\n/* END SOLUTION */\n", 1, "column 0 has no stub"),
    ],
)
def test_wrong_mark_is_refused_at_its_line(text: str, line: int, words: str) -> None:
    """The message is one line: the file, the line's number and what is wrong."""
    with pytest.raises(skeleton.SkeletonError) as caught:
        make(text)
    message = str(caught.value)
    assert message.startswith(f"reference/main.c:{line}: ")
    assert words in message
    assert "\n" not in message


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    """Return a small reference and a folder that holds older files to be written over."""
    reference, out = tmp_path / "reference", tmp_path / "core été"
    for folder, text in ((reference, SOLVED), (out, "old\n")):
        folder.mkdir()
        for name in FILES:
            (folder / name).write_text(text, encoding="utf-8")
    return reference, out


def run(folders: tuple[Path, Path], *more: str) -> int:
    """Run the command line on the two folders and return its exit code."""
    return skeleton.main(["--reference", str(folders[0]), "--out", str(folders[1]), *more])


def contents(folder: Path) -> dict[str, str]:
    """Return every file of a folder, hidden ones too, as name: text."""
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}


OLD = dict.fromkeys(FILES, "old\n")


def test_command_writes_the_four_files(folders: tuple[Path, Path]) -> None:
    """The four files are replaced, readable as any new file, and nothing else is left there."""
    assert run(folders) == 0
    assert contents(folders[1]) == dict.fromkeys(FILES, STUBBED)
    beside = folders[1] / "new"
    beside.touch()
    assert (folders[1] / "main.c").stat().st_mode == beside.stat().st_mode


def test_check_is_silent_on_fresh_files(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """What was just generated passes --check without a word."""
    assert run(folders) == 0
    assert run(folders, "--check") == 0
    assert capsys.readouterr() == ("", "")


def test_check_shows_a_drift_and_writes_nothing(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """--check exits 1 with a diff and the command to run, and leaves the folder alone."""
    assert run(folders, "--check") == 1
    captured = capsys.readouterr()
    assert "-old\n" in captured.out
    assert '+    MRT_TODO("TP2.4");\n' in captured.out
    assert captured.err.endswith("run `make skeleton`\n")
    assert contents(folders[1]) == OLD


def test_check_keeps_the_diff_short(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """A diff of a thousand lines is cut, and says by how much."""
    (folders[1] / "main.c").write_text("int x;\n" * 1000, encoding="utf-8")
    assert run(folders, "--check") == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == skeleton.DIFF_LINES + 1
    assert re.fullmatch(r"\.\.\. and \d+ more lines", lines[-1])


def test_check_sees_a_missing_last_newline(folders: tuple[Path, Path]) -> None:
    """One byte of difference is a drift."""
    assert run(folders) == 0
    (folders[1] / "octree.c").write_text(STUBBED.rstrip("\n"), encoding="utf-8")
    assert run(folders, "--check") == 1


def refused(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str], words: str, *more: str
) -> None:
    """Run the command line; hold that it fails with one line that has these words."""
    assert run(folders, *more) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert words in captured.err


@pytest.mark.parametrize("name", FILES)
def test_error_in_any_file_writes_nothing(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str], name: str
) -> None:
    """A wrong mark in one file leaves all four as they were."""
    (folders[0] / name).write_text("int x;\n" + END, encoding="utf-8")
    refused(folders, capsys, f"{folders[0] / name}:2: END SOLUTION without")
    assert contents(folders[1]) == OLD


def test_missing_or_binary_reference_file(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """A reference file that is not text, then not there, is named; nothing is written."""
    (folders[0] / "octree.c").write_bytes(b"\xff\xfe\x00")
    refused(folders, capsys, f"{folders[0] / 'octree.c'}: not UTF-8")
    (folders[0] / "octree.c").unlink()
    refused(folders, capsys, f"{folders[0] / 'octree.c'}: cannot be read (No such file")
    assert contents(folders[1]) == OLD


def test_missing_output_file_is_a_drift(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """--check names the file that is not there."""
    assert run(folders) == 0
    (folders[1] / "raytracer.h").unlink()
    refused(folders, capsys, "raytracer.h: missing; run `make skeleton`", "--check")


def test_output_folder_that_cannot_be_written(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """A missing folder, and a file in its place, give one line each."""
    reference, out = folders
    refused((reference, out / "none"), capsys, "cannot be written (No such file")
    refused((reference, out / "main.c"), capsys, "cannot be written (Not a directory")
    assert contents(out) == OLD


def test_folder_in_the_place_of_a_file(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """A folder called octree.c stops the generator before it has replaced main.c."""
    (folders[1] / "octree.c").unlink()
    (folders[1] / "octree.c").mkdir()
    refused(folders, capsys, "octree.c: is a folder")
    assert (folders[1] / "main.c").read_text(encoding="utf-8") == "old\n"
    assert sorted(path.name for path in folders[1].iterdir()) == sorted(FILES)


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EACCES])
def test_failed_write_leaves_nothing_half_written(
    folders: tuple[Path, Path],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    number: int,
) -> None:
    """When the third file cannot be written whole, all four stay and no temporary file is left."""
    write = Path.write_text

    def fill_up(path: Path, text: str, **keywords: str) -> int:
        if "raytracer.h" in path.name:
            write(path, text[:5], **keywords)
            raise OSError(number, os.strerror(number))
        return write(path, text, **keywords)

    monkeypatch.setattr(Path, "write_text", fill_up)
    refused(folders, capsys, f"cannot be written ({os.strerror(number)})")
    assert contents(folders[1]) == OLD


def test_reference_is_never_written_over(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """--out may not be the reference, under whatever spelling."""
    reference = folders[0]
    refused((reference, reference / ".." / reference.name), capsys, "is the reference itself")
    assert contents(reference) == dict.fromkeys(FILES, SOLVED)


def test_wrong_manifest(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the manifest's reader refuses is said in one line, and nothing is written."""

    def refuse() -> None:
        raise ManifestError("exercises.toml: missing or malformed key: 'exercise'")

    monkeypatch.setattr(skeleton, "load", refuse)
    refused(folders, capsys, "exercises.toml: missing or malformed key")
    assert contents(folders[1]) == OLD


# ---- The project's own files ----------------------------------------------------------------


def real(folder: Path) -> str:
    """Return the text of the students' files in a folder, one after the other."""
    return "".join((folder / name).read_text(encoding="utf-8") for name in FILES)


def leaks(solved: str, given: str) -> set[str]:
    """Return the lines of the solution that can be read in the given text.

    Lines of 12 characters or less, and those that also stand outside the regions, tell nothing.
    Reads the marks in its own way, so that it does not share the generator's mistakes.
    """
    inside: list[str] = []
    outside: list[str] = []
    hidden = False
    for line in solved.splitlines():
        if "BEGIN SOLUTION" in line:
            hidden = True
            outside.append(line)
        elif "END SOLUTION" in line:
            hidden = False
        else:
            (inside if hidden else outside).append(line.strip())
    public = "\n".join(outside)
    return {line for line in inside if len(line) > 12 and line not in public and line in given}


def test_leaks_are_seen() -> None:
    """The test below can fail: it finds a solution's line, and not a public one."""
    assert leaks(SOLVED, "x\n  return secret_root(2.0f);\n") == {"return secret_root(2.0f);"}
    assert leaks(SOLVED + "return secret_root(2.0f);\n", "return secret_root(2.0f);") == set()
    assert leaks(SOLVED, STUBBED) == set()


def test_no_line_of_the_solution_is_given_to_students() -> None:
    """The committed skeleton holds no line of the reference's regions, and no mark."""
    given = real(CORE)
    assert leaks(real(ROOT / "reference"), given) == set()
    assert "SOLUTION" not in given


def test_committed_skeleton_is_up_to_date() -> None:
    """`make skeleton` would change nothing; run as people run it, from another folder."""
    done = subprocess.run(
        [sys.executable, "-m", "grader.authoring.skeleton.skeleton", "--check"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        cwd="/",
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_every_exercise_has_its_marker() -> None:
    """Each exercise of the manifest is cut out of the reference somewhere, and only those are."""
    markers = set(re.findall(r'MRT_TODO\("([^"]+)"\)', real(CORE)))
    assert markers == {exercise.id for exercise in load().exercises}

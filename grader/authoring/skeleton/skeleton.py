"""Make the student's skeleton in core_c/ from the solution in reference/.

The solution is written once, between marks that each stand alone on their line:

    /* BEGIN SOLUTION TP2.4 */                        the region ends with   /* END SOLUTION */
    /* BEGIN SOLUTION TP2.6: return sky_color(); */   the same, and what the stub does instead

A region whose marks are at column 0 (an include, a helper function) goes without a trace.
A region inside a function gives way to ``MRT_TODO("TP2.4");`` and to the stub's line, if it has
one; further regions of that exercise in the same function give way to their stub's line only.
A function ends with a ``}`` at column 0, as clang-format writes it.

The exercises' ids and the files that students write are those of exercises.toml. Nothing is written
unless all the files are right: an error names the file, the line and the cure.
Run it as ``python -m grader.authoring.skeleton.skeleton [--check] [--reference DIR] [--out DIR]``.
"""

from __future__ import annotations

import argparse
import difflib
import os
import re
import sys
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.course.exercises import CORE, ROOT, Manifest, load
from grader.course.message import GraderError

DIFF_LINES = 40  # enough to see what drifted without flooding a CI log

BEGIN = re.compile(
    r"(?P<indent>[ \t]*)/\* BEGIN SOLUTION (?P<exercise>[\w.]+)(?:: (?P<stub>\S.*?))? \*/[ \t]*"
)
END = re.compile(r"(?P<indent>[ \t]*)/\* END SOLUTION \*/[ \t]*")
# Whatever looks like a mark without being one is refused: a typing slip must not leak an answer.
SUSPECT = re.compile(r"SOLUTION|(?i:\b(?:begin|end)[\s_-]*solution)")


class SkeletonError(GraderError):
    """What stopped the generator: one line that names the file and the cure."""


@dataclass(frozen=True)
class MarkedRegion:
    """A part of the solution: the lines from index ``begin`` to ``end``, marks included."""

    exercise: str
    stub: str
    indent: str
    begin: int
    end: int


def shown(path: Path) -> str:
    """Return the path as a person reads it: from the repository's root when it is inside."""
    absolute = path.absolute()
    return str(absolute.relative_to(ROOT) if absolute.is_relative_to(ROOT) else path)


def read_text(path: Path) -> str:
    """Return the text of a UTF-8 file, or raise a SkeletonError that says why it cannot be read."""
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise SkeletonError(f"{shown(path)}: not UTF-8 text; save it as UTF-8") from None
    except OSError as error:
        raise SkeletonError(
            f"{shown(path)}: cannot be read ({error.strerror}); check the path and its permissions"
        ) from None


def check_begin(mark: re.Match[str], known: Collection[str]) -> str:
    """Return what is wrong with a BEGIN mark, or an empty string."""
    exercise, stub = mark["exercise"], mark["stub"]
    if exercise not in known:
        return f"unknown exercise {exercise}; the ids are in grader/course/exercises.toml"
    if stub is None:
        return ""
    if not mark["indent"]:
        return "a region at column 0 has no stub: it is removed whole"
    if "*/" in stub or "/*" in stub:
        return "a mark stands alone on its line, without another comment"
    if SUSPECT.search(stub) or not stub.endswith((";", "}")):
        return "the stub after the colon must be whole C statements"
    return ""


def check_line(line: str, begin: re.Match[str] | None, known: Collection[str]) -> str:
    """Return what is wrong with a line, given the region it is in (or None), or an empty string."""
    if mark := BEGIN.fullmatch(line):
        return check_begin(mark, known) if begin is None else "a region inside another one"
    if end := END.fullmatch(line):
        if begin is None:
            return "END SOLUTION without its BEGIN SOLUTION"
        same = end["indent"] == begin["indent"]
        return "" if same else "END SOLUTION is not indented as its BEGIN SOLUTION"
    if SUSPECT.search(line):
        return "malformed mark; write /* BEGIN SOLUTION TP2.4 */ or /* END SOLUTION */ on its line"
    if begin and begin["indent"] and line.startswith("}"):
        return "the function ends inside a region; put END SOLUTION before its closing brace"
    return ""


def find_regions(path: Path, lines: Sequence[str], known: Collection[str]) -> list[MarkedRegion]:
    """Return the solution's regions in a file, in order.

    Raises SkeletonError, as ``reference/main.c:41: ...``, at the first mark that is not right.
    """
    regions: list[MarkedRegion] = []
    begin: re.Match[str] | None = None
    start = 0
    for index, line in enumerate(lines):
        if problem := check_line(line, begin, known):
            raise SkeletonError(f"{shown(path)}:{index + 1}: {problem}")
        if mark := BEGIN.fullmatch(line):
            begin, start = mark, index
        elif begin and END.fullmatch(line):
            regions.append(
                MarkedRegion(begin["exercise"], begin["stub"] or "", begin["indent"], start, index)
            )
            begin = None
    if begin:
        raise SkeletonError(f"{shown(path)}:{start + 1}: BEGIN SOLUTION without its END SOLUTION")
    return regions


def join(out: list[str], following: Sequence[str]) -> None:
    """Append lines where a region was cut out, without the blank lines that it leaves behind."""
    first = 0
    if not out or not out[-1] or out[-1].endswith("{"):
        while first < len(following) and not following[first]:
            first += 1
    if first < len(following) and following[first].lstrip().startswith("}"):
        while out and not out[-1]:
            out.pop()
    out.extend(following[first:])


def stub_lines(region: MarkedRegion, noted: set[str]) -> list[str]:
    """Return a region's replacement; ``noted`` holds the ids that its function already names."""
    if not region.indent:
        return []
    lines = [region.stub] if region.stub else []
    if region.exercise not in noted:
        noted.add(region.exercise)
        lines.insert(0, f'MRT_TODO("{region.exercise}");')
    return [region.indent + line for line in lines]


def make_skeleton(path: Path, text: str, known: Collection[str]) -> str:
    """Return the student's text of a reference file; ``path`` only serves in errors."""
    lines = text.rstrip("\n").split("\n")
    out: list[str] = []
    noted: set[str] = set()
    position = 0
    for region in find_regions(path, lines, known):
        kept = lines[position : region.begin]
        if any(line.startswith("}") for line in kept):
            noted.clear()
        join(out, kept)
        out.extend(stub_lines(region, noted))
        position = region.end + 1
    join(out, lines[position:])
    result = "\n".join(out).rstrip("\n") + "\n"
    # find_regions already holds this; a leak is bad enough to be looked for twice.
    assert not SUSPECT.search(result), f"{shown(path)}: a mark is left in the skeleton"
    return result


def make_all(reference: Path, course: Manifest) -> dict[str, str]:
    """Return the student's text of each file that students write, by name."""
    known = {exercise.id for exercise in course.exercises}
    return {
        name: make_skeleton(reference / name, read_text(reference / name), known)
        for name in course.student
    }


def write_all(out: Path, texts: Mapping[str, str]) -> None:
    """Write every file of a folder or none: temporary files first, renamed once all are there."""
    temporary = {name: out / f".{name}.{os.getpid()}.new" for name in texts}
    try:
        for name, text in texts.items():
            if (out / name).is_dir():
                raise SkeletonError(f"{shown(out / name)}: is a folder; remove it")
            temporary[name].write_text(text, encoding="utf-8", newline="\n")
        for name, path in temporary.items():
            path.replace(out / name)
    except OSError as error:
        raise SkeletonError(
            f"{shown(out)}: cannot be written ({error.strerror}); give a writable --out folder"
        ) from None
    finally:
        if out.is_dir():
            for path in temporary.values():
                path.unlink(missing_ok=True)


def drift(out: Path, texts: Mapping[str, str]) -> list[str]:
    """Return a unified diff from the folder's files to the texts, line by line; empty if equal."""
    diff: list[str] = []
    for name, text in texts.items():
        path = out / name
        if not path.exists():
            raise SkeletonError(f"{shown(path)}: missing; run `make skeleton`")
        found = read_text(path).split("\n")
        generated = f"{shown(path)} (generated)"
        diff += difflib.unified_diff(found, text.split("\n"), shown(path), generated, lineterm="")
    return diff


def check(out: Path, texts: Mapping[str, str]) -> None:
    """Print a short diff and raise SkeletonError when the folder is not what would be written."""
    diff = drift(out, texts)
    if not diff:
        return
    print("\n".join(diff[:DIFF_LINES]))
    if len(diff) > DIFF_LINES:
        print(f"... and {len(diff) - DIFF_LINES} more lines")
    raise SkeletonError(f"{shown(out)}: not what reference/ gives; run `make skeleton`")


def parse_arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    """Return the command line's choices: reference, out and check."""
    parser = argparse.ArgumentParser(
        prog="python -m grader.authoring.skeleton.skeleton", description=__doc__
    )
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--reference", type=Path, default=ROOT / "reference", metavar="DIR")
    parser.add_argument("--out", type=Path, default=CORE, metavar="DIR")
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 on a drift")
    return parser.parse_args(argv)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, or 1 after one line on stderr."""
    arguments = parse_arguments(argv)
    try:
        if arguments.out.resolve() == arguments.reference.resolve():
            raise SkeletonError(
                f"{shown(arguments.out)}: is the reference itself; give another --out"
            )
        texts = make_all(arguments.reference, load())
        if arguments.check:
            check(arguments.out, texts)
        else:
            write_all(arguments.out, texts)
    except GraderError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

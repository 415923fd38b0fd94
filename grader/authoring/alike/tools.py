"""The tools that find what texts have in common: sim_c, or else copydetect.

sim_c is in Debian's similarity-tester; copydetect is a package of Python. Both are given items, one
a line or a character, never a submission's own text.
"""

from __future__ import annotations

import importlib.util
import io
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

from grader.course.message import UserError

LEAST = 12  # items of a run: shorter ones are anybody's
SECONDS = 900
_RUN = re.compile(r"^(\d+)\.c: line (\d+)-(\d+) *\|(\d+)\.c: line (\d+)-(\d+) *\[\d+\]$", re.M)
_ARGUMENTS = ("-e", "-F", "-n", "-T", "-w", "200", "-r", str(LEAST), "-i")
_FIRST_SIGN = 0x4E00  # as many signs as there are items, none of them special

Items = tuple[str, ...]


class AlikeError(UserError):
    """Nothing can be compared: a sentence of [alike] in messages/."""

    code = 2


class ToolError(AlikeError):
    """The tool has failed."""

    code = 3


@dataclass(frozen=True)
class Run:
    """What two texts have in common: their indices, and the items of each."""

    one: int
    other: int
    items: range
    other_items: range


Tool = Callable[[Sequence[Items], int], Iterator[Run]]


def found() -> tuple[str, Tool]:
    """Return the tool that is here, with its name. Raises AlikeError."""
    if shutil.which("sim_c"):
        return "sim_c", by_sim
    if importlib.util.find_spec("copydetect"):
        return "copydetect", by_copydetect
    raise AlikeError("alike.no_tool")


def by_sim(texts: Sequence[Items], new: int) -> Iterator[Run]:
    """Yield what the first `new` texts share with one another, and with those behind them."""
    with tempfile.TemporaryDirectory(prefix="mrt-alike-") as name:
        folder = Path(name)
        for k, items in enumerate(texts):
            (folder / f"{k}.c").write_text(
                "\n".join(items) + "\n", encoding="ascii", errors="replace"
            )
        names = [f"{k}.c" for k in range(len(texts))]
        listed = "\n".join([*names[:new], "/", *names[new:]]) + "\n"
        try:
            done = _sim(folder, listed)
        except (OSError, subprocess.SubprocessError) as error:
            raise ToolError("alike.tool_failed", tool="sim_c", error=error) from error
    for each in _RUN.finditer(done.stdout):
        one, first, last, other, other_first, other_last = map(int, each.groups())
        yield Run(one, other, range(first - 1, last), range(other_first - 1, other_last))


def _sim(folder: Path, names: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["sim_c", *_ARGUMENTS],
        cwd=folder,
        input=names,
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=True,
    )


def by_copydetect(texts: Sequence[Items], new: int) -> Iterator[Run]:
    """Do the same with copydetect, which compares all runs of that length."""
    from copydetect import CodeFingerprint, compare_files  # type: ignore[import-untyped]

    signs: dict[str, str] = {}
    prints = {}
    for k, items in enumerate(texts):
        text = "".join(signs.setdefault(each, chr(_FIRST_SIGN + len(signs))) for each in items)
        if len(text) >= LEAST:
            prints[k] = CodeFingerprint(str(k), LEAST, 1, filter=False, fp=io.StringIO(text))
    for one, other in combinations(prints, 2):
        if one >= new:
            break
        _, _, (mine, theirs) = compare_files(prints[one], prints[other])
        if len(mine):
            yield from _spans(one, other, mine.T.tolist(), theirs.T.tolist())


def _spans(one: int, other: int, mine: list[list[int]], theirs: list[list[int]]) -> Iterator[Run]:
    """Yield the stretches of two texts; which of the one is which of the other is not told."""
    for k in range(max(len(mine), len(theirs))):
        first = range(*map(int, mine[k])) if k < len(mine) else range(0)
        second = range(*map(int, theirs[k])) if k < len(theirs) else range(0)
        yield Run(one, other, first, second)

"""From addresses in a library to the calls that were running: their functions and their lines.

A process in a sandbox has no /proc, and names its calls by addresses only; addr2line, which reads
what the compiler noted in the library, is run here, shut in as well.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.course import exercises
from grader.execution.records import Act
from grader.sandbox.tools import OUT_OF_TIME, run_tool
from grader.worker import frames

ADDR2LINE_SECONDS = 3
MAX_ADDRESSES = 40
ENDLESS = 5  # so often, among the calls that are known, stands a function that calls itself
SHIM = "mrt_shim.c"
# The address of a field, or of an item, of what NULL points to; it is never anything else.
NULL_BYTES = 4096
STACK_BYTES = 1 << 24  # below the stack: what is used there has outgrown it

_REPORTED = re.compile(r"^ +#(\d+) .*?\(([^()\s]+)\+0x([0-9a-f]{1,16})\)", re.MULTILINE)
_PLACE = re.compile(r"(?:.*/)?([\w.]+\.(?:c|h|cpp)):(\d+)")


# Libraries in which a place is long to find, by what they hold: it would be so after each crash.
_slow: set[str] = set()


@dataclass(frozen=True)
class CrashLocation:
    """A function, and "file:line"."""

    function: str
    location: str


def from_page(library: str, page: bytes) -> list[CrashLocation]:
    """Return the calls that ran when a signal came, as watch.c noted them in the session's page."""
    base, pc, _, _, signal, count, *callers = frames.TRACE.unpack_from(page, frames.TRACE_OFFSET)
    if signal == 0:
        return []
    callers = callers[: min(count, frames.FRAMES)]
    if pc in callers:  # behind the calls that noted them
        callers = callers[callers.index(pc) + 1 :]
    # A caller's address is the one to which it will be returned: its line is just before.
    addresses = [pc, *(each - 1 for each in callers)]
    return locate(library, [each - base for each in addresses])


def acts(library: str, page: bytes) -> list[Act]:
    """Return what was tried that isolation may refuse: the first that it did, and did not."""
    base = frames.TRACE.unpack_from(page, frames.TRACE_OFFSET)[0]
    noted = frames.ACTS.unpack_from(page, frames.ACTS_OFFSET)
    found = []
    for kind, address, worked in ((noted[1], noted[0], False), (noted[4], noted[3], True)):
        if 0 < kind < len(frames.KINDS):
            place = next(iter(locate(library, [address - 1 - base])), CrashLocation("", ""))
            found.append(Act(frames.KINDS[kind], worked, place.function, place.location))
    return found


def fault(page: bytes) -> str:
    """Return what was wrong with the address that could not be used; "" when nothing is known."""
    _, _, stack, address, signal, *_ = frames.TRACE.unpack_from(page, frames.TRACE_OFFSET)
    if signal == 0:
        return ""
    if address < NULL_BYTES:
        return "null-pointer"
    return "stack-overflow" if -STACK_BYTES <= address - stack < NULL_BYTES else ""


def from_report(library: str, text: str) -> list[CrashLocation]:
    """Return the calls in the library that a sanitizer's report names by their addresses.

    They are those of its first stack; others say where memory was allocated, or given back.
    """
    name = os.path.basename(library)
    found: list[int] = []
    last = -1
    for number, path, address in _REPORTED.findall(text):
        if int(number) <= last:
            break
        last = int(number)
        if os.path.basename(path) == name:
            found.append(int(address, 16) - 1)
    return locate(library, found)


def from_endless(calls: list[CrashLocation]) -> list[CrashLocation]:
    """Return the calls from the first on that calls again what is called again and again, if any.

    The stack ends anywhere, often in a right function that such a one calls. Of several functions
    that call each other, the one that stands first in the file comes first, wherever it ended.
    """
    often = Counter(each.function for each in calls)
    again = {name for name, count in often.items() if count > ENDLESS}
    on = [k for k in range(1, len(calls)) if {calls[k].function, calls[k - 1].function} <= again]
    if not on:
        return calls
    name = calls[min(on, key=lambda k: _order(calls[k].location))].function
    return calls[next(k for k in on if calls[k].function == name) :]


def _order(location: str) -> tuple[str, int]:
    file, _, line = location.partition(":")
    return file, int(line)


def locate(library: str, offsets: Sequence[int]) -> list[CrashLocation]:
    """Return the calls of the submission's own code among these places, else those of ours.

    They go from the inside out.
    """
    size = Path(library).stat().st_size * 64  # a library's globals are not in its file
    sane = [f"{each:#x}" for each in offsets if 0 < each < size][:MAX_ADDRESSES]
    if not sane or library in _slow:
        return []
    command = ["addr2line", "-a", "-C", "-f", "-i", "-s", "-e", library, *sane]
    try:
        ran = run_tool(command, Path(library).parent, [Path(library)], seconds=ADDR2LINE_SECONDS)
    except OSError:
        return []  # no addr2line on this machine
    if ran.status == OUT_OF_TIME or ran.signals:
        _slow.add(library)
        return []
    places = [each for each in _places(ran.output) if not each.location.startswith(SHIM)]
    given = exercises.load().given
    own = [each for each in places if each.location.partition(":")[0] not in given]
    return own or places[:1]


def _places(output: str) -> list[CrashLocation]:
    """Return what addr2line found: after each address, pairs of lines, inlined calls first."""
    places = []
    function = ""
    for line in output.splitlines():
        if line.startswith("0x"):
            function = ""
        elif not function:
            function = line.partition(".")[0]  # of what the optimiser has made several
        else:
            if found := _PLACE.match(line):
                places.append(CrashLocation(function, f"{found[1]}:{found[2]}"))
            function = ""
    return places

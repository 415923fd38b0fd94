"""What a session left when it ended: what it printed, and what the sanitizers and the shim noted.

All of it may be the submission's own work, and may be made to be slow to read: patterns go through
a text once, and the text is bounded.
"""

from __future__ import annotations

import re
import signal

from grader.execution.crash_location import (
    CrashLocation,
    fault,
    from_endless,
    from_page,
    from_report,
)

MAX_TEXT = 20_000  # characters of output that are kept
MAX_WORD = 200  # characters of what a sanitizer says of an error
NO_STACK = "stack-overflow"  # the word of who has used it all
UBSAN_EXIT = 1

_SANITIZER = re.compile(
    r"ERROR: AddressSanitizer:? (?:attempting )?([\w-]+)|(?<=\S): runtime error: (.*)"
)
_NULL = "Hint: address points to the zero page"
_RUNTIME_ERROR = re.compile(r"^(?:\./)?([\w.]+\.[ch]):(\d+):\d+: runtime error", re.MULTILINE)
# What the sanitizers and the loader write themselves: from its error on, all is a sanitizer's;
# before, some lines are ASan's warnings and advice, the calls that it lists, and the loader's.
_REPORT = re.compile(
    r"^AddressSanitizer:DEADLYSIGNAL\n|^=+\n(?===\d{1,10}==ERROR: AddressSanitizer)"
    r"|==\d{1,10}==ERROR: AddressSanitizer(?s:.*)"
    r"|^[^\n]*: runtime error: (?s:.*)"
    r"|^[^\n]*: symbol lookup error: .*\n?"
    r"|^==\d{1,10}==.*\n?|^False positive error reports may follow\n?"
    r"|^For details see https://github\.com/google/sanitizers.*\n?"
    r"|^ +#\d+ 0x[0-9a-f]+ .*\n?",
    re.MULTILINE,
)


def printable(text: str) -> str:
    """Return a text without the control characters that could fool a terminal."""
    if text.replace("\n", "").replace("\t", "").isprintable():
        return text
    return "".join(each if each.isprintable() or each in "\n\t" else "\ufffd" for each in text)


def own_words(errors: str) -> str:
    """Return what the code itself wrote on stderr."""
    return _REPORT.sub("", errors)


def is_reported(code: int, text: str) -> bool:
    """Say whether a process that ended by exit did so because of a sanitizer's report."""
    # Where UBSan cannot read its settings it ends by exit instead of a signal.
    return code == UBSAN_EXIT and _SANITIZER.search(text) is not None


def word(code: int, page: bytes, text: str) -> str:
    """Return how the code ended: as a sanitizer reports it, else as the signal tells."""
    report = _SANITIZER.search(text)
    if report is not None:
        said = (report[1] or f"runtime error: {report[2]}")[:MAX_WORD]
        return "null-pointer" if said == "SEGV" and _NULL in text else said
    name = signal.Signals(-code).name if code < 0 else ""
    return (fault(page) if name == "SIGSEGV" else "") or name


def calls(library: str, page: bytes, text: str, said: str) -> list[CrashLocation]:
    """Return the calls that ran: as a sanitizer reports them, else as the shim noted them.

    `said` is the word of that end: of endless calls, those that come again.
    """
    found = from_report(library, text) or from_page(library, page)
    if said == NO_STACK:
        return from_endless(found)
    error = _RUNTIME_ERROR.search(text)
    if not error:
        return found
    # The line of the error is its own report's; the rest of the calls is in the page.
    place = CrashLocation(found[0].function if found else "", f"{error[1]}:{error[2]}")
    return [place, *found[1:]]

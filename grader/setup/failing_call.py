"""The program of a call that the last `make grade` showed to fail, for `make try` and `make debug`.

    python -m grader.setup.failing_call NAME BUILD

NAME is an exercise, a function or a check, or `last`: the first failure of the last grade. Writes
BUILD/try/call.c and prints, for program.sh, its path, the function that it calls, and the picture's
size (nothing: any). Standard library only.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from grader.setup.folding import put
from grader.setup.sentences import say

WRONG = ("failed", "crashed", "timeout")
LAST = "last"
_SIZE = re.compile(r"make try WIDTH=(\d+) HEIGHT=(\d+)")
Check = dict[str, Any]


class CaseError(Exception):
    """There is no such program: one line for the person."""


def main() -> int:
    """Run the command line; return the exit code."""
    name, build = sys.argv[1], Path(sys.argv[2])
    try:
        check = find(name, failing(build / "grade"))
        place = build / "try" / "call.c"
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(check["reproducer"], encoding="utf-8")
    except CaseError as error:
        put(str(error), sys.stderr)
        return 1
    except OSError as error:
        put(f"{error.filename}: {error.strerror}", sys.stderr)
        return 1
    for told in (f"{check['exercise']} {check['function']} - {check['title']}", check["message"]):
        put(told, sys.stderr)
    size = _SIZE.search(check["reproducer"])
    print(place, check["function"], *(size.groups() if size else ("", "")), sep="\n")
    return 0


def failing(folder: Path) -> list[Check]:
    """Return the checks that failed in the last runs, the newest run first. Raises CaseError."""
    paths = [folder / "results.json", folder / "partial" / "results.json"]
    found = sorted(
        (path for path in paths if path.is_file()), key=lambda each: each.stat().st_mtime
    )
    if not found:
        raise CaseError(say("setup.call_no_grade"))
    return [check for path in reversed(found) for check in _failing(path)]


def _failing(path: Path) -> Iterator[Check]:
    try:
        checks = json.loads(path.read_text(encoding="utf-8"))["checks"]
        yield from (each for each in checks if each["outcome"] in WRONG and each["reproducer"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise CaseError(say("setup.results_unread", path=path)) from error


def find(name: str, checks: Sequence[Check]) -> Check:
    """Return the first of the checks that a name means. Raises CaseError."""
    word = name.lower()
    if word == LAST and checks:
        return checks[0]
    for key in (_names, _parts):
        for each in checks:
            if word in key(each):
                return each
    ids = ", ".join(dict.fromkeys(each["exercise"] for each in checks))
    if not ids:
        raise CaseError(say("setup.call_none"))
    raise CaseError(say("setup.call_unknown", name=name, ids=ids))


def _names(check: Check) -> tuple[str, ...]:
    parts = check["id"].split(".")
    ends = (".".join(parts[k:]) for k in range(len(parts)))
    return (check["exercise"].lower(), check["function"].lower(), *ends)


def _parts(check: Check) -> str:
    return "\n".join(_names(check))


if __name__ == "__main__":
    sys.exit(main())

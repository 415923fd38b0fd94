"""`python -m grader.report.page FOLDER`: report.html again from a folder's results.json."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from grader.files import write_whole
from grader.report import page


def main() -> int:
    """Make the page; return the exit code."""
    if len(sys.argv) != 2:
        sys.stderr.write("usage: python -m grader.report.page FOLDER\n")
        return 2
    folder = Path(sys.argv[1])
    try:
        content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
        write_whole(folder / page.NAME, page.render(content, folder))
    except (OSError, ValueError) as error:
        sys.stderr.write(f"{folder / 'results.json'}: {error}; make it again: make grade\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())

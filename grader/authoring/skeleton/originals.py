"""Packs what is handed out, core_c/, into the grader.

Run it as ``python -m grader.authoring.skeleton.originals [--check]``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from grader.course.message import UserError
from grader.files import write_whole
from grader.intake import originals


def main(arguments: Sequence[str] | None = None) -> int:
    """Write grader/intake/originals.zip, or with --check compare it; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing: exit 1 on a drift")
    options = parser.parse_args(arguments)
    try:
        content = originals.packed(originals.from_core())
        if not options.check:
            write_whole(originals.PACK, content)
        elif not originals.PACK.exists() or originals.PACK.read_bytes() != content:
            print(f"{originals.PACK.name}: not core_c/; run make skeleton")
            return 1
    except (OSError, UserError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""make calibrate: python -m grader.dev.pictures."""

from __future__ import annotations

import sys

from grader.dev.pictures import calibrate
from grader.dev.pictures.make import make
from grader.expected import FOLDER
from grader.pictures import stored


def main() -> int:
    """Set the limits, write them beside the pictures, and try them; return the exit code."""
    status = calibrate.set_limits()
    make(FOLDER / stored.FOLDER)
    stored.forget()
    return calibrate.try_limits() or status


if __name__ == "__main__":
    sys.exit(main())

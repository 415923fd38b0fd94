"""make calibrate: python -m grader.authoring.expected.pictures."""

from __future__ import annotations

import sys

from grader.authoring.expected.pictures import calibrate


def main() -> int:
    """Set the limits, write them beside the pictures, and try them; return the exit code."""
    status = calibrate.set_limits()
    status |= calibrate.try_mixtures()
    status |= calibrate.try_wrongs()
    calibrate.try_mistakes()
    return status


if __name__ == "__main__":
    sys.exit(main())

"""`make bench`: how fast the reference draws, beside POV-Ray and Tachyon, and is graded.

It always prints its goals, met or missed, and fails only when it could not measure.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from grader.authoring.bench import (
    grading,
    inspector,
    lab,
    measure,
    pictures,
    report,
    slider,
    watching,
)
from grader.authoring.bench.programs import BenchError
from grader.build.toolchain import ToolchainError

NICE = 5  # the machine stays usable meanwhile


def main() -> int:
    """Run the command line; return 0, or 1 after one line on stderr."""
    parser = argparse.ArgumentParser(prog="python -m grader.authoring.bench", description=__doc__)
    parser.add_argument("--build", type=Path, default=Path("build"), metavar="DIR")
    folder: Path = parser.parse_args().build.absolute() / "bench"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Wall time, which a nice process would lose to its neighbours.
        graded = grading.measure(folder)
        print(watching.text(watching.measure(folder)))
        print(lab.text(lab.measure(folder)))
        print(slider.text(slider.measure(folder)))
        print(inspector.text(inspector.measure(folder)))
        print(pictures.text(pictures.measure()))
        os.nice(NICE)
        measured, octree_ratios = measure.measure_all(folder)
        print(report.text(measured, octree_ratios, graded))
        report.write_json(folder / "results.json", measured, octree_ratios, graded)
    except (BenchError, ToolchainError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

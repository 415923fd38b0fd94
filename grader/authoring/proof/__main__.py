"""`make prove`: proves the grader, all of it or some parts, on everything or on a sample.

What is graded is kept in build/prove/, by content: a run that was stopped goes on. A part that is
run whole goes to reference/mistakes/proof.json and to the table of README.md; a sample only has a
page, in build/prove/sample/.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import shutil
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from grader.authoring.proof import figures, page
from grader.authoring.proof.grades import GradeCache
from grader.authoring.proof.parts import Part
from grader.course.message import GraderError
from grader.files import write_whole
from grader.report.results import write
from grader.sandbox import cores

# The modules of the parts, each with run(shop, sample) -> Part; the quickest first.
PARTS = {
    "nothing": "nothing",
    "contracts": "contracts",
    "slips": "slips",
    "known": "known",
    "cases": "cases",
    "half_written": "half_written",
    "pairs": "pairs",
    "variants": "right",
    "fresh": "fresh",
    "flakiness": "flaky",
    "mutants": "changes",
}
# Where they keep what they find, but for grades.
KEPT = {"flakiness": "runs", "mutants": "mutants"}
NICE = 5  # the machine stays usable meanwhile


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, 1 when something is not as it should be, 2 on wrong use."""
    options = _parser().parse_args(arguments)
    os.nice(NICE)
    try:
        return prove(options)
    except (GraderError, OSError) as error:
        print(error, file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        return 130


def prove(options: argparse.Namespace) -> int:
    """Run the parts that are asked for. Raises ProofError, FiguresError, PatchError, OSError."""
    grade_cache = GradeCache(options.build.absolute() / "prove", options.jobs)
    folder = grade_cache.folder / ("sample" if options.sample else "")
    chosen = options.part or list(PARTS)
    for kept in {KEPT.get(name, "grades") for name in chosen if options.again}:
        shutil.rmtree(grade_cache.folder / kept, ignore_errors=True)
    faults: list[str] = []
    for name in chosen:
        started = time.monotonic()
        part = _run(name, grade_cache, options.sample)
        grade_cache.clean()
        write(folder / "parts" / f"{name}.json", asdict(part))
        publish(stored(folder), folder)
        if part.whole:
            figures.keep(part.figures)
            figures.write_readme()
        faults += part.faults
        _tell(part, time.monotonic() - started)
    print(f"{folder / 'index.html'}")
    return 1 if faults else 0


def _run(name: str, grade_cache: GradeCache, sample: int | None) -> Part:
    part: Part = importlib.import_module(f"grader.authoring.proof.{PARTS[name]}").run(
        grade_cache, sample
    )
    return part


def stored(folder: Path) -> list[Part]:
    """Return the parts that have been run in a folder, in order."""
    paths = [folder / "parts" / f"{name}.json" for name in PARTS]
    return [Part(**json.loads(p.read_text(encoding="utf-8"))) for p in paths if p.is_file()]


def publish(parts: Sequence[Part], folder: Path) -> None:
    """Write results.json and the page of the parts. Raises OSError."""
    measured = {key: value for each in parts for key, value in each.figures.items()}
    write(folder / "results.json", figures.results(measured))
    write_whole(folder / "index.html", page.render(parts))


def _tell(part: Part, seconds: float) -> None:
    told = ", ".join(f"{key} {value:g}" for key, value in part.figures.items())
    print(f"{part.name} ({seconds:.0f} s): {told}", flush=True)
    for fault in part.faults:
        print(f"    {fault}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m grader.authoring.proof", description=__doc__)
    parser.add_argument("--build", type=Path, default=Path("build"), metavar="DIR")
    parser.add_argument("--jobs", type=int, default=cores.usable(), help="how many at once")
    parser.add_argument("--part", action="append", choices=PARTS, help="this one (may be repeated)")
    parser.add_argument("--sample", type=int, metavar="N", help="only N of each part")
    parser.add_argument("--again", action="store_true", help="forget what is kept")
    return parser


if __name__ == "__main__":
    sys.exit(main())

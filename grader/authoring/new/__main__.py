"""make new: python -m grader.authoring.new, with --exercise, --check, --mistake or --scene."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from grader.authoring.new import check, exercise, mistake, scene
from grader.authoring.new.edits import MARK, Edit, NewError, write
from grader.authoring.specimens import mistakes
from grader.course import exercises
from grader.course.message import GraderError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    options = _parser().parse_args(arguments)
    try:
        made, then = _made(options)
        write(made)
    except GraderError as error:
        print(error, file=sys.stderr)
        return error.code
    except OSError as error:
        print(f"{error.filename}: {error.strerror}", file=sys.stderr)
        return 2
    print(_told(made, then))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m grader.authoring.new", description=__doc__)
    for name in ("exercise", "function", "check", "suite", "picture", "mistake", "scene"):
        parser.add_argument(f"--{name}", default="")
    parser.add_argument("--worth", default="idea", help="of a mistake (default: %(default)s)")
    return parser


def _made(options: argparse.Namespace) -> tuple[list[Edit], list[str]]:
    """Return the files of what is asked for, and the commands that come after. Raises NewError."""
    rules = exercises.load()
    if options.mistake:
        known = mistakes.load()
        made = mistake.edits(options.mistake, options.exercise, options.worth, rules, known)
        return made, [f"make expected MISTAKE={options.mistake}", "make prove PART=known"]
    if options.scene:
        return scene.edits(options.scene), scene.then(options.scene)
    if options.check:
        asked = f"make grade SUBMISSION=reference K={options.check}"
        if options.picture:
            made = check.picture_edits(options.check, options.picture, options.exercise, rules)
            return made, [f"make expected PICTURE={options.picture}", "make calibrate", asked]
        made = check.edits(options.check, options.suite, rules)
        return made, [f"make expected SUITE={options.suite}", asked]
    if options.exercise:
        made = exercise.edits(options.exercise, options.function, rules)
        function = options.function
        mistaken = f"make new MISTAKE=name EXERCISE={options.exercise}"
        asked = f"make grade SUBMISSION=reference K={function}"
        return made, [
            *("make skeleton", f"make expected SUITE={function}.any", asked, mistaken),
            *("make notebooks", "make test"),
        ]
    ways = "EXERCISE=TP3.B3 FUNCTION=fog_color, CHECK= SUITE=, MISTAKE=, SCENE="
    raise NewError(f"say what is new: {ways}")


def _told(made: Sequence[Edit], then: Sequence[str]) -> str:
    """Return the files in the order to write them, what to put there, and what to run."""
    lines = []
    for each in made:
        lines.append(each.path)
        lines += [f"    {note}" for note in each.notes()]
    paths = " ".join(each.path for each in made)
    lines += ["", f'What is left to write: grep -n "{MARK}" {paths}', "Then:"]
    return "\n".join([*lines, *(f"    {each}" for each in then)])


if __name__ == "__main__":
    sys.exit(main())

"""A report in which everything happens, for the tests of what reads results.json."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from PIL import Image

from grader.build.records import BuildResult, BuildStatus, Target
from grader.checking.records import Evidence, Pinned
from grader.course import exercises as manifest
from grader.course.message import Message
from grader.course.texts import Texts
from grader.evaluation.grading import grade
from grader.evaluation.records import Finding, Outcome, Report
from grader.intake.records import Refusal, Source, Submission
from grader.report import results

RULES = manifest.load()
# What a submission may try: to be obeyed by a terminal or a browser, or to be read backwards.
HOSTILE = "f(\x1b)<img src=x onerror=alert(1)></script>\u202e"
PROGRAM = '/* make try */\nint main(void) {\n    return 0; /* $expected "<1>" */\n}\n'
LOG = """\
In file included from main.c:1:
main.c:7:3: error: expected ‘;’ before ‘}’ token
    7 |   x
      |    ^
main.c:9:1: warning: unused variable ‘y’ [-Wunused-variable]
"""


def png(color: str) -> bytes:
    """Return a small picture of one colour."""
    memory = io.BytesIO()
    Image.new("RGB", (32, 18), color).save(memory, "PNG")
    return memory.getvalue()


PNG = png("navy")


PLACE = Message("place.counted", {"where": Message("place.top_left"), "count": 12})
VALUES: dict[str, object] = {"call": HOSTILE, "got": "1", "expected": "2"}


def told(outcome: Outcome) -> str:
    """Return the key of what is said of an outcome."""
    crashed = outcome in (Outcome.CRASHED, Outcome.TIMEOUT)
    return "death.SIGSEGV" if crashed else "failure.result"


def every_outcome(language: str = "fr", folder: Path | None = None) -> dict[str, Any]:
    """Return the content of results.json for a run in which everything happens.

    The pictures are written beside it when there is a folder.
    """
    texts = Texts(language)
    # What needs no other exercise waits for none.
    names = [check.id for check in RULES.checks().values() if not check.needs]
    findings = [
        Finding(
            *(name, "title", outcome, Message(told(outcome), VALUES), "main.c:3"),
            output=HOSTILE,
            evidence=Evidence(
                reproducer=PROGRAM,
                images={"expected": PNG, "got": PNG, "similarity": PNG},
                places=Message("places.1", {"first": PLACE}),
                pinned=Pinned("scene0.flat", 3, 4),
            ),
        )
        for name, outcome in zip(names, Outcome, strict=False)
    ]
    checks, exercises = grade(findings, RULES, texts)
    if folder:
        results.write_images(folder, checks)
    made = Report(
        submission=Submission(
            name="rendu",
            files={"main.c": f"int x;\n\n{HOSTILE}\n".encode()},
            missing=("octree.c",),
            refused=(Refusal("@x.c", "name"),),
            sources=(Source("main.c", "rendu/\udcff/main.c", 1e9),),
            nearby=(Source("main.c", "main.c", 0.0),),
        ),
        language=language,
        builds=(BuildResult(BuildStatus.BUILT, Target(96, 64), log=LOG, warnings=(LOG,)),),
        checks=tuple(checks),
        exercises=tuple(exercises),
        graded_at=1.5e9,
        notes=(Message("note.no_main"),),
        rejected={"main.c": Message("failure.unreadable", {"file": "main.c"})},
        opened=(1, 2),
        isolation="strong",
    )
    return results.as_json(made, texts)

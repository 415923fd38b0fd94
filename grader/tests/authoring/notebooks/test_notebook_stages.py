"""Each notebook as it is for who has just reached an exercise, right or with a known mistake.

In a student's copy, where there is no solution to judge among. No dead end: whatever a check cell
says is true of that program, and says what to do next.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from grader.authoring.specimens import mistakes
from grader.authoring.specimens.half_written import just_reached
from grader.authoring.workbook import pages
from grader.authoring.workbook.notebooks import LANGUAGES, NOTEBOOKS
from grader.course import exercises
from grader.course.exercises import CORE
from grader.tests.support.notebooks import checks, shown
from grader.tests.support.outputs import outputs
from grader.tests.support.sampling import sampled

ORDER = [each.id for each in exercises.load().exercises if each.checks]
MISTAKES = {each.id: each for each in mistakes.load()}
# The reference writes fill_red with fill: what is wrong, or missing, in one is so in the other.
WITH = {"TP1.1": "TP1.2"}
NO_SOLUTION = """\
from pathlib import Path
from grader.intake import originals
originals.REFERENCE = Path("none")"""
NEXT = re.compile(r"(?:Prochaine étape|Next step)\s*: (TP\d\.B?\d),")
ALL_RIGHT = re.compile("Tout est juste|All is right")
TO_WRITE = re.compile(r"encore à écrire, dans|still to be written, in")
RIGHT_SO_FAR = re.compile(r"juste jusqu'ici|right so far")
QUESTION = re.compile(r"\?$", re.MULTILINE)


def stages() -> list[tuple[str, str]]:
    """Return each exercise, right; then with one of its mistakes, another one in each TP."""
    found = []
    for number, name in enumerate(ORDER):
        own = [each.id for each in MISTAKES.values() if each.seen_from == each.exercise == name]
        found.append((name, ""))
        if own:
            found.append((name, own[number % len(own)]))
    return found


def written(folder: Path, name: str, mistake: str) -> Path:
    """Write the files of who has just reached an exercise; return their folder."""
    files = just_reached(name, MISTAKES[mistake].files() if mistake else None)
    shutil.copytree(CORE, folder)
    for file, text in files.items():
        (folder / file).write_text(text, encoding="utf-8")
    return folder


def faults(exercise: str, text: str, reached: str, mistake: str) -> list[str]:
    """Return what a check cell says that is not true, or does not lead on."""
    here = ORDER.index(reached)
    later = ORDER.index(exercise) > here
    through = mistake and reached == WITH.get(exercise)  # of what it calls
    wrong = mistake and reached == exercise
    missing = WITH.get(exercise, exercise) in ORDER[here + 1 :]
    led = NEXT.search(text)
    leads = {
        "to do": later and text.startswith("○") and TO_WRITE.search(text),
        "wrong": (wrong or through) and text.startswith("✗") and QUESTION.search(text),
        "waits": (missing or through) and text.startswith("○") and led,
        "right": text.startswith("✓") and (led or ALL_RIGHT.search(text)),
        "so far": text.startswith("○") and RIGHT_SO_FAR.search(text) and led,
    }
    told = [] if any(leads.values()) else [f"{exercise}: {text}"]
    if not later and wrong and not leads["wrong"]:
        told.append(f"{exercise} is wrong: {text}")
    # What comes later, and the TPs whose notebooks were not run, may be looked at.
    known = [each for each in ORDER[: ORDER.index(exercise)] if each[:3] == exercise[:3]]
    if led and led[1] in known and led[1] != reached:
        told.append(f"{exercise} leads back to {led[1]}")
    return told


@pytest.mark.long
@pytest.mark.parametrize(
    ("reached", "mistake"), sampled(stages(), [("TP1.4", "rect_axes_swapped")])
)
def test_no_check_cell_is_a_dead_end(
    reached: str, mistake: str, cache: Path, tmp_path: Path
) -> None:
    """What is to do, wrong, waiting or right is said so, with a question or the next step."""
    core = written(tmp_path / "core_c", reached, mistake)
    language = LANGUAGES[ORDER.index(reached) % 2]
    path = NOTEBOOKS / language / f"{reached.partition('.')[0]}.ipynb"
    notebook = pages.execute(path, core, outputs(tmp_path / "build", cache), NO_SOLUTION)
    assert [source for source, text in shown(notebook) if "ERROR" in text] == []
    told = checks(notebook)
    assert told
    found = [line for name, text in told.items() for line in faults(name, text, reached, mistake)]
    assert found == []

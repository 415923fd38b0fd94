"""What the result of a submission depends on, as hashes by what they stand for.

When the words alone have changed, nothing is graded: the result is told again.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from grader.batch.records import Settings, Task
from grader.build import toolchain
from grader.checking import expected_data
from grader.course import exercises as manifest
from grader.course import settings as course
from grader.course.texts import sentences
from grader.files import content_key
from grader.intake import originals

WORDING = "wording"  # the part of a result that is made again without grading
_TELLING = ("course/messages/", "report/", "evaluation/wording.py")
# Of the grader, what a result depends on.
_CODE = (".py", ".toml", ".c", ".html", ".css", ".js", ".zip")


def parts_of(task: Task) -> dict[str, str]:
    """Return the hashes of all that the result of a task depends on, by what they stand for."""
    # When files were last written changes nothing.
    around = [task.submission[key] for key in ("missing", "refused", "changed", "converted")]
    return {
        "sources": content_key(task.label, sorted(task.files.items()), around),
        **_common(task.settings),
    }


@cache
def _common(settings: Settings) -> dict[str, str]:
    folder = Path(settings.expected) if settings.expected else expected_data.FOLDER
    data = [*folder.rglob("*.json")]
    data += Path(settings.fresh).rglob("*.json") if settings.fresh else []
    own = [path for path in sorted(manifest.PACKAGE.rglob("*")) if path.suffix in _CODE]
    code = [each for each in own if not (_is_beside(each) or _only_tells(each))]
    code += sorted(originals.REFERENCE.glob("*.[ch]")) if originals.has_solution() else []
    rules, words = course.load(), sentences(settings.language)
    grading = (rules.dialect, rules.opened, rules.count_closed)
    asked = (settings.isolation, settings.gallery)
    # A death that has no sentence is told as another one.
    deaths = sorted(key for key in words if key.startswith("death."))
    telling = [each.read_bytes() for each in own if _only_tells(each)]
    return {
        "grader": content_key(
            [each.read_bytes() for each in code], deaths, toolchain.find_compiler()
        ),
        "expected": content_key([each.read_bytes() for each in sorted(data)]),
        "settings": content_key(grading, asked),
        WORDING: content_key(settings.language, settings.hint, sorted(words.items()), telling),
    }


def _only_tells(path: Path) -> bool:
    """Whether a file of the package only words a result: when it changes, nothing is graded."""
    place = path.relative_to(manifest.PACKAGE).as_posix()
    return place.startswith(_TELLING) and place != "report/results.py"


def _is_beside(path: Path) -> bool:
    """Whether a file of the package has no part in a result, or is counted as a setting."""
    first = path.relative_to(manifest.PACKAGE).parts[0]
    return first in ("tests", "authoring", "lab", "batch") or path == course.COURSE

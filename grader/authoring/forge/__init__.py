"""`make classroom`: a repository for each student's work, which a forge grades at each push.

    python -m grader classroom --out DIR

It is the students' archive with a workflow for GitHub (and GitHub Classroom) and one for GitLab.
"""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from textwrap import indent

from grader.authoring import release
from grader.console.run import ExitCode, complain
from grader.course import exercises, settings
from grader.course.exercises import ROOT
from grader.course.message import GraderError, UserError
from grader.course.texts import LANGUAGES, Texts, preferred
from grader.files import write_whole

TEMPLATES = {".github/workflows/grade.yml": "github.yml", ".gitlab-ci.yml": "gitlab.yml"}
PACKAGES = "bubblewrap ca-certificates gcc git libpng-dev make pkg-config python3-venv"
# Where the runner is root already, as in GitLab's containers, there is no sudo. Python would take a
# json.py of the student's, and make a GNUmakefile: at the top stays only what was handed out.
_STEPS = {
    "restore": """\
git config --global --add safe.directory "$PWD"
first=${{MRT_BASE:-$(git rev-list --max-parents=0 HEAD | tail -n 1)}}
find . -mindepth 1 -maxdepth 1 ! -name .git ! -name core_c ! -name notebooks -exec rm -rf {{}} +
git checkout --quiet "$first" -- . ':!core_c' ':!notebooks'
git checkout --quiet "$first" -- {given}
""",
    "tools": """\
as_root() {{ if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }}
as_root apt-get update -qq
as_root apt-get install -y -qq --no-install-recommends {packages} >/dev/null
""",
    "grade": "make grade ANNOTATE=github\n",
    "points": """\
"$(sh grader/setup/environment.sh grade)" -m grader.report.forge build/grade/results.json
""",
}


class ForgeError(UserError):
    """The repository cannot be written: a sentence of [forge] in messages/."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    texts = Texts(preferred())
    parser = argparse.ArgumentParser(prog="python -m grader classroom", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "classroom", metavar="DIR")
    parser.add_argument("--comments", choices=LANGUAGES, help="their language, if not the course's")
    options = parser.parse_args(arguments)
    try:
        _expect_empty(options.out)  # before what takes long
        language = options.comments or settings.load().language
        files = repository(language)
        write(options.out, files)
    except GraderError as error:
        return complain(error.sentence(texts), ExitCode.WRONG_USE)
    print(texts.say("forge.done", path=options.out, count=len(files)))
    return ExitCode.DONE


def repository(language: str) -> dict[str, bytes]:
    """Return the files of the repository by path. Raises ReleaseError when something may not go."""
    files = release.handed_out(ROOT, language)
    made = {path: workflow(name, language).encode() for path, name in TEMPLATES.items()}
    return {**files, ".gitignore": (ROOT / ".gitignore").read_bytes(), **made}


def workflow(template: str, language: str) -> str:
    """Return the text of a workflow, from its template beside this file."""
    given = " ".join(f"core_c/{name}" for name in exercises.load().given)
    text = (Path(__file__).parent / template).read_text(encoding="utf-8")
    margins = _margins(text)
    steps = {
        name: indent(step.format(given=given, packages=PACKAGES), margins[name]).strip()
        for name, step in _STEPS.items()
    }
    return text.format(language=language, **steps)


def _margins(text: str) -> Mapping[str, str]:
    """Return the margin of each step's place in a template."""
    lines = [line for line in text.splitlines() if line.strip().startswith("{")]
    return {line.strip().strip("{}"): line[: len(line) - len(line.lstrip())] for line in lines}


def write(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write the files into a folder. Raises ForgeError."""
    with _named(folder):
        for path, content in files.items():
            write_whole(folder / path, content)


def _expect_empty(folder: Path) -> None:
    """Raise ForgeError unless a folder is empty, or not there."""
    with _named(folder):
        if folder.exists() and any(folder.iterdir()):
            raise ForgeError("forge.not_empty", path=folder)


@contextlib.contextmanager
def _named(folder: Path) -> Iterator[None]:
    """Have a folder that cannot be used named. Raises ForgeError."""
    try:
        yield
    except OSError as error:
        raise ForgeError("forge.cannot_write", path=folder, error=error.strerror) from error

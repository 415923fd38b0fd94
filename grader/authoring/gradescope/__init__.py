"""`make gradescope`: the archive that Gradescope builds an autograder from.

    python -m grader gradescope --out ZIP

It holds this project as it is committed, the solution too, and two scripts: setup.sh, run once when
the container is built, and run_autograder, run for each submission (run.py).
"""

from __future__ import annotations

import argparse
import io
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from grader.authoring import release
from grader.console.run import ExitCode, complain
from grader.course.exercises import ROOT
from grader.course.message import GraderError, UserError
from grader.course.texts import Texts, preferred

TOP = "miniraytracer"
SCRIPTS = ("setup.sh", "run_autograder")
_LEFT_OUT = ("grader/tests/", ".ci/", ".vscode/")
_EXECUTABLE, _PLAIN = 0o100755, 0o100644
_DATE = (1980, 1, 1, 0, 0, 0)  # the same bytes each time


class GradescopeError(UserError):
    """The archive cannot be made: a sentence of [gradescope] in messages/."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    texts = Texts(preferred())
    parser = argparse.ArgumentParser(prog="python -m grader gradescope", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    default = ROOT / "build" / "autograder.zip"
    parser.add_argument("--out", type=Path, default=default, metavar="ZIP")
    options = parser.parse_args(arguments)
    try:
        content = packed(files(ROOT))
        release.write(options.out, content)
    except GraderError as error:
        return complain(error.sentence(texts), ExitCode.WRONG_USE)
    size = texts.number(round(len(content) / 1e6, 1))
    print(texts.say("gradescope.done", path=options.out, mb=size))
    return ExitCode.DONE


def files(root: Path) -> dict[str, bytes]:
    """Return what git tracks, by its place in the archive. Raises GradescopeError, ReleaseError."""
    tracked = [each for each in release.git(root, "ls-files", "-z").split("\0") if each]
    if not tracked:
        raise GradescopeError("gradescope.no_git", path=root)
    names = [each for each in tracked if not each.startswith(_LEFT_OUT)]
    scripts = {name: (Path(__file__).parent / name).read_bytes() for name in SCRIPTS}
    return {**scripts, **{f"{TOP}/{name}": release.read(root, name) for name in names}}


def packed(content: Mapping[str, bytes]) -> bytes:
    """Return the archive."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in sorted(content.items()):
            entry = zipfile.ZipInfo(path, _DATE)
            mode = _EXECUTABLE if path in SCRIPTS else _PLAIN
            entry.create_system, entry.external_attr = 3, mode << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)
    return out.getvalue()

"""Right solutions written differently than the reference: they must get every point.

`variants/variants.toml` lists them. A variant is the reference with the patch ID.patch, then with
the files of the folder ID/, whichever of the two there is; `flags` and `compiler` are what it is
built with instead of the grader's own.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from grader.authoring.specimens import patches
from grader.course import exercises
from grader.course.exercises import malformed, read_toml
from grader.intake.records import Submission

FOLDER = exercises.ROOT / "reference" / "variants"


@dataclass(frozen=True)
class Variant:
    """A legitimate variant: what is different, in a line, and how it is built."""

    id: str
    about: str
    flags: tuple[str, ...] = ()  # after the grader's own
    compiler: str = ""  # the grader's when empty
    tps: tuple[int, ...] = ()  # that it is about; all of them when empty
    apart: bool = False  # allowed by the handout, but functions stay uncalled: to do

    def files(self) -> dict[str, str]:
        """Return its files by name. Raises PatchError."""
        files = patches.reference()
        patch, folder = FOLDER / f"{self.id}.patch", FOLDER / self.id
        if patch.is_file():
            files = patches.patched(patch, files)
        if folder.is_dir():
            files |= {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}
        return files

    def submission(self) -> Submission:
        """Return it as a submission. Raises PatchError."""
        return patches.submission(self.id, self.files())


@cache
def load(path: Path = FOLDER / "variants.toml") -> tuple[Variant, ...]:
    """Read the list. Raises ManifestError."""
    try:
        return tuple(
            Variant(
                id=name,
                about=row["about"],
                flags=tuple(row.get("flags", ())),
                compiler=row.get("compiler", ""),
                tps=tuple(row.get("tps", ())),
                apart=row.get("apart", False),
            )
            for name, row in read_toml(path)["variant"].items()
        )
    except (KeyError, TypeError) as error:
        raise malformed(path, error) from error

"""The reference with a few words of one function changed, as a file of TOML says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from grader.authoring.specimens import patches
from grader.authoring.specimens.patches import PatchError
from grader.intake import definitions


@dataclass(frozen=True)
class FunctionEdit:
    """One change of the reference: `before` stands once in a function; `after` in its place."""

    id: str
    exercise: str  # the one that must lose points
    function: str
    before: str
    after: str

    @property
    def listed_in(self) -> str:
        """The file that errors name."""
        return f"{self.exercise}.toml"

    def written(self, files: Mapping[str, str] | None = None) -> tuple[str, str]:
        """Return the file of the function, and the function with the change. Raises PatchError.

        `files` are the reference's unless others are given.
        """
        for name, text in (patches.reference() if files is None else files).items():
            if own := _function(name, text, self.function):
                if (count := own.count(self.before)) != 1:
                    raise PatchError(
                        f"{self.listed_in}: {self.id}: what comes before stands {count} times in"
                        f" {self.function}; it must stand once"
                    )
                return name, own.replace(self.before, self.after)
        raise PatchError(
            f"{self.listed_in}: {self.id}: the reference has no function {self.function}"
        )

    def files(self, onto: Mapping[str, str] | None = None) -> dict[str, str]:
        """Return files, the reference's unless others are given, changed. Raises PatchError."""
        files = patches.reference() if onto is None else dict(onto)
        name, written = self.written(files)
        files[name] = files[name].replace(_function(name, files[name], self.function), written)
        return files


def _function(file: str, text: str, name: str) -> str:
    """Return the text of a function of a file, "" when it is not there."""
    found = definitions.find(name, {file: text})
    return found.text if found else ""

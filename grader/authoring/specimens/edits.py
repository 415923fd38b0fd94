"""The reference with a few words of one function changed, as a table of them lists it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from grader.authoring.specimens import patches
from grader.authoring.specimens.patches import PatchError
from grader.intake import definitions


@dataclass(frozen=True)
class FunctionEdit:
    """One change of the reference: `before` stands once in a function; `after` in its place."""

    listed_in: ClassVar[str]  # the file that errors name

    id: str
    exercise: str  # the one that must lose points
    function: str
    before: str
    after: str

    def written(self) -> tuple[str, str]:
        """Return the file of the function, and the function with the change. Raises PatchError."""
        for name, text in patches.reference().items():
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

    def files(self) -> dict[str, str]:
        """Return the reference's files with the change. Raises PatchError."""
        files = patches.reference()
        name, written = self.written()
        files[name] = files[name].replace(_function(name, files[name], self.function), written)
        return files


def _function(file: str, text: str, name: str) -> str:
    """Return the text of a function of a file, "" when it is not there."""
    found = definitions.find(name, {file: text})
    return found.text if found else ""

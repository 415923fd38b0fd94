"""The student's files as this session has seen them saved: as they are, and as they were before.

Whoever reads them notes them: what is drawn, and what is checked.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

Files = Mapping[str, bytes]


@dataclass
class Saves:
    """The last two versions of each folder."""

    _seen: dict[Path, tuple[Files, Files]] = field(default_factory=dict)

    def note(self, folder: Path, files: Files) -> None:
        """Note the files as they are."""
        now = self.last(folder)[1]
        if files != now:
            self._seen[folder] = now or files, files

    def last(self, folder: Path) -> tuple[Files, Files]:
        """Return the files as they were before they were last changed, and as they are."""
        return self._seen.get(folder, ({}, {}))


SAVES = Saves()

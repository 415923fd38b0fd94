"""Classes laid by code as Moodle hands them over, and what the desk makes of them."""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from grader.batch import command, csv_table
from grader.tests.batch import moodle_site
from grader.tests.batch.fake_grading import source

HEADER = (
    *("Identifier", "Full name", "ID number", "Status", "Grade", "Maximum grade"),
    *("Grade can be changed", "Last modified (submission)", "Last modified (grade)"),
    "Feedback comments",
)
ON_TIME = "Monday, 2 March 2026, 10:00 PM"
OTHERS = ("raytracer.c", "raytracer.h", "octree.c")


def submission(worth: float, authors: str = "", also: str = "") -> dict[str, str]:
    """Return the files of a submission that is worth that share of the points."""
    files = {"main.c": source(worth, also), **dict.fromkeys(OTHERS, "/* trace_ray */\n")}
    return files | ({"AUTEURS.txt": authors} if authors else {})


def packed(files: Mapping[str, str | bytes]) -> bytes:
    """Return an archive of files."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return memory.getvalue()


def locked(content: bytes) -> bytes:
    """Return an archive whose entries claim to be protected by a password."""
    return _claiming(content, 6, 1)


def deflated_64(content: bytes) -> bytes:
    """Return an archive whose entries claim a compression that few tools read."""
    return _claiming(content, 8, 9)


def _claiming(content: bytes, at: int, value: int) -> bytes:
    """Return an archive with that byte in each local header, and in the list two bytes further."""
    marked = bytearray(content)
    for sign, place in ((b"PK\x03\x04", at), (b"PK\x01\x02", at + 2)):
        start = marked.find(sign)
        while start >= 0:
            marked[start + place] |= value
            start = marked.find(sign, start + 4)
    return bytes(marked)


def table(rows: Sequence[Mapping[str, str]], header: Sequence[str] = HEADER) -> str:
    """Return a worksheet: what a row does not say is what Moodle writes for somebody in time."""
    out = io.StringIO(newline="")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    given = {
        **{"Maximum grade": "20.00", "Grade can be changed": "Yes"},
        **{"Last modified (submission)": ON_TIME, "Last modified (grade)": "-"},
    }
    for row in rows:
        writer.writerow([{**given, **row}.get(name, "") for name in header])
    return out.getvalue()


def row(participant: int, name: str, number: str = "", **cells: str) -> dict[str, str]:
    """Return a row of a worksheet."""
    return {
        **{"Identifier": f"Participant {participant}", "Full name": name, "ID number": number},
        **cells,
    }


@dataclass(frozen=True)
class Desk:
    """What a run of the desk gave: its status, what it said, and its folder."""

    status: int
    said: str
    out: Path

    def lines(self) -> dict[str, tuple[float | None, str]]:
        """Return mark and remarks of each line of grades.csv, by name and participant."""
        sheet = csv_table.read(self.out / "grades.csv")
        at = {name: k for k, name in enumerate(sheet.header)}
        found = {}
        for cells in sheet.rows:
            key = " ".join(filter(None, (cells[at["name"]], cells[at["participant"]])))
            found[key] = (csv_table.number(cells[at["mark"]]), cells[at["remarks"]])
        return found

    def marks(self) -> dict[str, float | None]:
        """Return the mark of each line of grades.csv."""
        return {name: mark for name, (mark, _) in self.lines().items()}

    def sent(self, name: str = "w.csv") -> dict[str, str]:
        """Return what the filled worksheet gives each participant."""
        sheet = csv_table.read(self.out / "moodle" / name)
        at = csv_table.column(sheet.header, ("grade", "note"))
        return {cells[0].split()[-1].removeprefix("Participant"): cells[at] for cells in sheet.rows}

    def feedback(self) -> set[str]:
        """Return the folders of feedback.zip."""
        with zipfile.ZipFile(self.out / "moodle" / "feedback.zip") as archive:
            return {name.split("/")[0] for name in archive.namelist()}


@dataclass(frozen=True)
class Laid:
    """A folder with a class in it; `run` runs the desk on it."""

    folder: Path
    capsys: pytest.CaptureFixture[str]

    def archive(self, entries: Mapping[str, str | bytes], name: str = "all.zip") -> None:
        """Write Moodle's archive."""
        (self.folder / name).write_bytes(packed(entries))

    def write(self, name: str, content: str | bytes) -> None:
        """Write a file beside the archive."""
        data = content.encode() if isinstance(content, str) else content
        (self.folder / name).write_bytes(data)

    def run(self, *words: str, archive: str = "all.zip", out: str = "out") -> Desk:
        """Run the command, in English; every mark that it writes for Moodle must arrive there."""
        self.capsys.readouterr()
        path = self.folder.parent / out
        status = command.main(
            [str(self.folder / archive), "--out", str(path), "--lang", "en", *words]
        )
        said = self.capsys.readouterr()
        assert "Traceback" not in said.err
        for filled in (path / "moodle").glob("*.csv"):
            moodle_site.assert_arrives(filled)
        return Desk(status, said.err + said.out, path)

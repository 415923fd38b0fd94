"""What a folder of submissions holds: one candidate for each, and nothing guessed in silence.

A submission is a folder (of any depth; a git clone too) or an archive. Moodle's names
`Name_12345_assignsubmission_file_` say who it is from, as a folder or as the beginning of a file's
name.
"""

from __future__ import annotations

import os
import shutil
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath

from grader.batch import moodle_archive
from grader.batch.contents import refusals, some
from grader.batch.moodle_archive import FOLDER, Left
from grader.batch.records import BatchError, Candidate
from grader.course import exercises
from grader.course.message import Message
from grader.intake import archives
from grader.intake.file_names import original
from grader.intake.records import Refusal

MAX_NAME = 80  # characters
MAX_LISTED = 6
_BESIDE = (".csv", ".toml")  # worksheet, manual.csv, course.toml: read, or told, by others


@dataclass(frozen=True)
class Found:
    """The candidates, and the files that are none."""

    candidates: list[Candidate]
    strays: list[str]


def discover(path: Path, work: Path, leave: Path) -> Found:
    """Return the submissions of a folder or a Moodle archive, by name.

    Archives are taken apart below `work`; `leave` is no submission (the folder of results). Raises
    BatchError, OSError.
    """
    search = _Search(work, leave)
    if path.is_dir():
        search.folder(path, Left())
    elif not path.is_file():
        raise BatchError("batch.no_submissions", path=path)
    elif not _is_moodle(path):
        raise BatchError("batch.not_moodle", path=path)
    else:
        search.archive(path)
    return Found(_unique(search.candidates), search.strays)


def _is_moodle(path: Path) -> bool:
    return any(FOLDER.match(each.split("/")[0]) for each in moodle_archive.names(path))


@dataclass
class _Search:
    """Looks through folders and archives."""

    work: Path
    leave: Path
    candidates: list[Candidate] = field(default_factory=list)
    strays: list[str] = field(default_factory=list)

    def archive(self, path: Path) -> None:
        """Look through a Moodle archive."""
        folder = self.work / f"from-{_safe(path.name)}"
        folder.mkdir(parents=True)
        self.folder(folder, moodle_archive.unpack(path, folder))

    def folder(self, top: Path, left: Left) -> None:
        """Look through a folder: a candidate for each child, or participant of Moodle's."""
        parts: dict[tuple[str, str], list[Path]] = {}
        names = {*(each.name for each in top.iterdir()), *left.refused, *left.unread}
        for path in (top / name for name in sorted(names)):
            if self._is_nobody(path):
                continue
            if moodle := FOLDER.fullmatch(path.name):
                parts.setdefault((moodle["label"], moodle["number"] or ""), []).append(path)
            elif path.is_symlink() or path.is_dir() or path.name in left.refused:
                self._alone(path.name, path, left)
            elif path.is_file() and moodle_archive.is_archive(path):
                self._packed(path, left)
            elif path.suffix not in _BESIDE:
                self.strays.append(path.name)
        for (label, number), paths in parts.items():
            places = _gathered(paths, self.work / f"loose-{_safe(label)}-{number}", left)
            found = _candidate(label, places, [each.name for each in paths], left)
            name = f"{found.name}_{number}" if number else found.name
            self.candidates.append(replace(found, name=name, number=number, moodle=True))

    def _is_nobody(self, path: Path) -> bool:
        hidden = path.name.startswith(".") or moodle_archive.is_system(path)
        return hidden or path.absolute() == self.leave.absolute()

    def _alone(self, label: str, path: Path, left: Left) -> None:
        self.candidates.append(_candidate(label, [path], [path.name], left))

    def _packed(self, path: Path, left: Left) -> None:
        if path.suffix == ".zip" and _is_moodle(path):
            self.archive(path)
        else:
            self._alone(_stem(path.name), path, left)


def _gathered(paths: Sequence[Path], folder: Path, left: Left) -> list[Path]:
    """Return the places of one participant's files; what is not taken of them goes to `left`.

    Moodle can be told to put no folder for each: every file then bears the participant's name; they
    get a folder together.
    """
    loose = [each for each in paths if not each.is_dir() and not each.is_symlink()]
    if loose:
        folder.mkdir(parents=True, exist_ok=True)
    for path in loose:
        found = FOLDER.fullmatch(path.name)
        rest = (found["rest"] if found else "") or path.name
        if not path.is_file():
            continue
        if not moodle_archive.is_wanted(path):
            left.unread.setdefault(path.name, []).append(".")
        elif (folder / rest).exists():
            left.refused.setdefault(path.name, []).append(Refusal(rest, "twice"))
        else:
            shutil.copy2(path, folder / rest)
    return [*(each for each in paths if each not in loose), *([folder] if loose else [])]


def _candidate(label: str, paths: Sequence[Path], names: Sequence[str], left: Left) -> Candidate:
    """Return the candidate of the places of a submission, which have these names in an archive."""
    refused = [each for name in names for each in left.refused.get(name, [])]
    remarks = list(refusals(refused))
    unread = [each for name in names for each in _unread(name, left)]
    if unread:
        remarks.append(Message("batch.unread", {"names": some(unread)}))
    sources = [each for path in paths for each in _sources(path)]
    problem = None
    if not sources:
        names = ", ".join(exercises.load().student)
        key = "batch.link" if any(each.is_symlink() for each in paths) else "batch.nothing"
        problem = Message(key, {"names": names})
    elif len(sources) > 1:
        listed = ", ".join(each.name for each in sources[:MAX_LISTED])
        problem = Message("batch.several", {"places": listed})
    elif lost := _lost(refused):
        problem = Message("batch.unreadable", {"names": ", ".join(lost)})
    path = sources[0] if sources else paths[0]
    label = _safe(label)
    return Candidate(label[:MAX_NAME].strip(" .") or "-", label, path, "", problem, tuple(remarks))


def _lost(refused: Sequence[Refusal]) -> list[str]:
    """Return what of a submission Moodle's archive has and could not give: it is not whole."""
    wanted = (*exercises.load().student, archives.AUTHORS)
    names = [PurePosixPath(each.path).name for each in refused]
    return [
        each
        for each in dict.fromkeys(names)
        if original(each).casefold() in wanted or moodle_archive.is_archive(Path(each))
    ]


def _unread(name: str, left: Left) -> list[str]:
    """Return the files of a place that Moodle's archive has and that nobody has unpacked."""
    found = FOLDER.fullmatch(name)
    rest = (found["rest"] if found else "") or name
    return [rest if each == "." else each for each in left.unread.get(name, [])]


def _sources(path: Path) -> Iterator[Path]:
    """Yield what in a place may be a submission: itself, and the archives in it."""
    if path.is_symlink():
        return
    if path.is_file():
        yield path
        return
    student = exercises.load().student
    held, packed = False, []
    for seen, file in enumerate(_files(path)):
        if seen >= archives.MAX_ENTRIES:
            break
        held = held or original(file.name).casefold() in student
        if moodle_archive.is_archive(file):
            packed.append(file)
    if held:
        yield path
    yield from packed


def _files(top: Path) -> Iterator[Path]:
    for folder, folders, files in os.walk(top):
        folders[:] = sorted(each for each in folders if not archives.is_ignored(each))
        if len(Path(folder).relative_to(top).parts) >= archives.MAX_DEPTH:
            folders[:] = []
        yield from (Path(folder, each) for each in sorted(files) if not each.startswith("."))


def _stem(name: str) -> str:
    for suffix in moodle_archive.ARCHIVES:
        if name.lower().endswith(suffix):
            return name[: -len(suffix)] or name
    return name


def _safe(name: str) -> str:
    """Return a name as text that can be the name of a folder, and be printed."""
    text = os.fsencode(name).decode(errors="replace")
    text = unicodedata.normalize("NFC", text)
    text = "".join(
        each if each.isprintable() and each not in '/\\:*?"<>|' else "-" for each in text
    )
    return text.strip(" .") or "-"


def _unique(found: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates by name; one whose name is taken gets a number behind it."""
    taken: dict[str, Candidate] = {}
    for each in found:
        name, count = each.name, 1
        while name.casefold() in taken:
            count += 1
            name = f"{each.name} ({count})"
        taken[name.casefold()] = replace(each, name=name)
    return sorted(taken.values(), key=lambda each: each.name)

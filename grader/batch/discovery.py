"""What a folder of submissions holds: one candidate for each, and nothing guessed in silence.

A submission is a folder (of any depth; a git clone too) or an archive. Moodle's names
`Name_12345_assignsubmission_file_` say who it is from, as a folder or as the beginning of a file's
name.
"""

from __future__ import annotations

import os
import re
import shutil
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from grader.batch import moodle_archive
from grader.batch.records import BatchError, Candidate
from grader.course import exercises
from grader.course.message import Message
from grader.intake import archives
from grader.intake.records import Refusal

MAX_LABEL = 80  # characters
MAX_LISTED = 6
_MOODLE = re.compile(
    r"(?P<label>.+?)_(?P<number>\d+)_assignsubmission_(?P<plugin>[a-z]+)(?:_(?P<rest>.*))?"
)


def discover(path: Path, work: Path, leave: Path) -> list[Candidate]:
    """Return the submissions of a folder or a Moodle archive, by name.

    Archives are taken apart below `work`; `leave` is no submission (the folder of results). Raises
    BatchError, OSError.
    """
    if path.is_dir():
        return _unique(_in_folder(path, work, leave, {}))
    if not path.is_file():
        raise BatchError("batch.no_submissions", path=path)
    if not _is_moodle(path):
        raise BatchError("batch.not_moodle", path=path)
    return _unique(_in_archive(path, work, leave))


def _is_moodle(path: Path) -> bool:
    return any(_MOODLE.match(each.split("/")[0]) for each in moodle_archive.names(path))


def _in_archive(path: Path, work: Path, leave: Path) -> list[Candidate]:
    folder = work / f"from-{_safe(path.name)}"
    folder.mkdir(parents=True)
    refused = moodle_archive.unpack(path, folder)
    return _in_folder(folder, work, leave, refused)


def _in_folder(
    top: Path, work: Path, leave: Path, refused: Mapping[str, list[Refusal]]
) -> list[Candidate]:
    """Return the submissions of a folder: one for each child, or participant of Moodle's."""
    found: list[Candidate] = []
    parts: dict[tuple[str, str], list[Path]] = {}
    children = {each.name: each for each in sorted(top.iterdir(), key=lambda each: each.name)}
    for name in sorted({*children, *refused}):
        path = top / name
        if name.startswith(".") or path.absolute() == leave.absolute():
            continue
        if moodle := _MOODLE.fullmatch(name):
            parts.setdefault((moodle["label"], moodle["number"]), []).append(path)
        elif path.is_symlink() or path.is_dir():
            found.append(_candidate(name, "", [path], refused))
        elif path.is_file() and moodle_archive.is_archive(path):
            if path.suffix == ".zip" and _is_moodle(path):
                found += _in_archive(path, work, leave)
            else:
                found.append(_candidate(_stem(name), "", [path], refused))
    for (label, number), paths in parts.items():
        found.append(_candidate(label, number, _gathered(paths, work, number), refused))
    return found


def _gathered(paths: Sequence[Path], work: Path, number: str) -> list[Path]:
    """Return the places of one participant's files; those beside each other get a folder.

    Moodle can be told to put no folder for each: every file then bears the participant's name.
    """
    loose = [each for each in paths if each.is_file() and not each.is_symlink()]
    places = [each for each in paths if each not in loose]
    if not loose:
        return places
    folder = work / f"loose-{number}"
    folder.mkdir(parents=True, exist_ok=True)
    for path in loose:
        found = _MOODLE.fullmatch(path.name)
        rest = (found["rest"] if found else "") or path.name
        if moodle_archive.is_wanted(Path(rest)) and not (folder / rest).exists():
            shutil.copy2(path, folder / rest)
    return [*places, folder]


def _candidate(
    label: str, number: str, paths: Sequence[Path], refused: Mapping[str, list[Refusal]]
) -> Candidate:
    label = _safe(label)
    name = f"{label}_{number}" if number else label
    remarks = tuple(
        Message("batch.refused", {"path": each.path, "reason": Message(f"refused.{each.reason}")})
        for path in paths
        for each in refused.get(path.name, [])[:MAX_LISTED]
    )
    sources = [each for path in paths for each in _sources(path)]
    problem = None
    if not sources:
        names = ", ".join(exercises.load().student)
        key = "batch.link" if any(each.is_symlink() for each in paths) else "batch.nothing"
        problem = Message(key, {"names": names})
    elif len(sources) > 1:
        listed = ", ".join(each.name for each in sources[:MAX_LISTED])
        problem = Message("batch.several", {"places": listed})
    path = sources[0] if sources else paths[0]
    return Candidate(name, label, path, number, problem, remarks)


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
        held = held or file.name in student
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
    return text.strip(" .")[:MAX_LABEL] or "-"


def _unique(found: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates by name; one whose name is taken gets a number behind it."""
    taken: dict[str, Candidate] = {}
    for each in found:
        name, count = each.name, 1
        while name.casefold() in taken:
            count += 1
            name = f"{each.name} ({count})"
        taken[name.casefold()] = Candidate(
            name, each.label, each.path, each.number, each.problem, each.remarks
        )
    return sorted(taken.values(), key=lambda each: each.name)

"""What of a submission is judged: the student's C files, read safely, and what is said of the rest.

    submission = read_submission(Path("core_c"))  # or rendu.zip, rendu.tar.gz

Nothing but the files of `Submission.files` goes any further.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath

from grader.course import exercises
from grader.intake import archives, originals
from grader.intake.archives import CXX_CODE, Entry, SubmissionError
from grader.intake.records import Refusal, Source, Submission

MAX_FILES = 100
MAX_NEARBY = 3
# A folder with more copies than this around it lies among other people's submissions.
MAX_NEIGHBOURS = 5
MAX_FOLDERS = 200
SHIM = "mrt_shim.c"  # the name is ours: a submission's file of that name is not taken

_SANE_NAME = re.compile(r"[A-Za-z0-9_]+\.[ch]")
_UTF8_BOM = b"\xef\xbb\xbf"
_TOP = PurePosixPath(".")

__all__ = ["SHIM", "SubmissionError", "read_submission"]


def read_submission(path: Path, *, look_around: bool = False) -> Submission:
    """Read the C files of a folder, a .zip or a .tar.gz; the student's may lie at any depth.

    `look_around` looks for other versions of them close to the folder: for a person's own work
    only. Raises SubmissionError when there is nothing to judge, or more than one candidate.
    """
    found = list(archives.entries(path))
    place = _candidate(found, path)
    rules = exercises.load()
    own = {
        each.path.name: each
        for each in found
        if each.path.parent == place and each.problem != "twice"
    }
    in_place = path.is_dir() and (path / place).resolve() == exercises.CORE.resolve()
    given = {name: own[name].content for name in rules.given if name in own}
    taken, refused, converted = _sorted_out(own.values())
    authors = [each.content for each in [*own.values(), *found] if _is_authors(each)]
    refused += [Refusal(_shown(each), each.problem) for each in found if _is_unsafe(each, place)]
    sources = [_source(own[name], path) for name in rules.student if name in taken]
    return Submission(
        name=_name(path),
        files=taken,
        missing=tuple(name for name in rules.student if name not in own),
        refused=tuple(refused),
        sources=tuple(sources),
        changed=tuple(_changed(given, originals.read(in_place))),
        converted=tuple(converted),
        nearby=tuple(_nearby(path / place, taken)) if look_around and path.is_dir() else (),
        in_place=in_place,
        authors=authors[0] if authors else b"",
    )


def _candidate(found: Sequence[Entry], path: Path) -> PurePosixPath:
    """Return the one folder that holds student's files: the top when it does, or else the only."""
    rules = exercises.load()
    folders = {
        each.path.parent
        for each in found
        if each.path.name in rules.student and each.problem != "outside"
    }
    names = ", ".join(rules.student)
    if not folders:
        raise SubmissionError("submission.nothing", path=path, names=names)
    if _TOP in folders:
        return _TOP
    if len(folders) > 1:
        listed = ", ".join(sorted(map(str, folders))[:6])
        raise SubmissionError("submission.several", path=path, folders=listed)
    return folders.pop()


def _sorted_out(
    own: Iterable[Entry],
) -> tuple[dict[str, bytes], list[Refusal], list[str]]:
    """Return the files to compile, those that cannot be, and those that were in UTF-16."""
    rules = exercises.load()
    taken: dict[str, bytes] = {}
    refused: list[Refusal] = []
    converted: list[str] = []
    for each in own:
        name = each.path.name
        if name in (*rules.given, *rules.ungraded, SHIM) or _is_authors(each):
            continue
        content, problem = _as_text(each.content)
        problem = each.problem or _wrong_name(name) or problem
        if problem or len(taken) >= MAX_FILES:
            refused.append(Refusal(_shown(each), problem or "many"))
            continue
        taken[name] = content
        if content != each.content:
            converted.append(name)
    return taken, refused, converted


def _is_authors(entry: Entry) -> bool:
    return entry.path.name.lower() == archives.AUTHORS


def _wrong_name(name: str) -> str:
    if PurePosixPath(name).suffix in CXX_CODE:
        return "cxx"
    return "" if _SANE_NAME.fullmatch(name) else "name"


def _as_text(content: bytes) -> tuple[bytes, str]:
    """Return a C file as the compiler takes it: Windows' UTF-16 as UTF-8; else the problem."""
    wide = ""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        wide = "utf-16"
    elif content[1:2] == b"\0" and content[:1] != b"\0":
        wide = "utf-16-le"
    elif content[:1] == b"\0" and content[1:2] != b"\0":
        wide = "utf-16-be"
    if wide:
        try:
            content = content.decode(wide).encode()
        except UnicodeError:
            return b"", "binary"
    return (b"", "binary") if b"\0" in content else (content, "")


def _shown(entry: Entry) -> str:
    """Return an entry's path; a name may be no text at all: it must be printable all the same."""
    return os.fsencode(str(entry.path)).decode(errors="replace")


def _is_unsafe(entry: Entry, place: PurePosixPath) -> bool:
    """Whether an entry elsewhere than among the student's files is worth a word."""
    if entry.problem in ("link", "special", "many"):
        return entry.path.parent != place
    return entry.problem in ("outside", "twice")


def _name(path: Path) -> str:
    name = path.resolve().name
    for suffix in (".zip", ".tar.gz", ".tgz", ".tar"):
        name = name.removesuffix(suffix)
    return os.fsencode(name).decode(errors="replace")


def _source(entry: Entry, path: Path) -> Source:
    inside = f"{path} : {entry.path}" if path.is_file() else os.path.normpath(path / entry.path)
    return Source(entry.path.name, str(inside), entry.modified)


def _changed(given: Mapping[str, bytes], handed_out: Mapping[str, bytes]) -> Iterator[str]:
    """Name the given files that are not the original, however an editor ends its lines."""
    for name, content in given.items():
        if _plain(content) != _plain(handed_out[name]):
            yield name


def _plain(content: bytes) -> bytes:
    return content.removeprefix(_UTF8_BOM).replace(b"\r\n", b"\n").strip()


def _nearby(folder: Path, taken: Mapping[str, bytes]) -> list[Source]:
    """Find other versions of the student's files: in the folder above, beside, and just below."""
    folder = folder.resolve()
    if folder == originals.REFERENCE:
        return []
    around = [folder.parent, *_folders(folder), *_folders(folder.parent)]
    copies: list[Source] = []
    homes = set()
    for place in around:
        for name in exercises.load().student:
            path = place / name
            # os.path.isfile is false, and raises nothing, for what lies in a closed folder.
            if place in (folder, originals.REFERENCE) or not os.path.isfile(path):
                continue
            content, problem = archives.read_file(path)
            if not problem and content != taken.get(name, content):
                homes.add(place)
                copies.append(Source(name, _from_here(path), path.stat().st_mtime))
    copies.sort(key=lambda each: -each.modified)
    return copies[:MAX_NEARBY] if len(homes) <= MAX_NEIGHBOURS else []


def _from_here(path: Path) -> str:
    """Return a path as it is typed here: relative when it is below."""
    here = Path.cwd()
    return str(path.relative_to(here) if here in path.parents else path)


def _folders(parent: Path) -> list[Path]:
    try:
        return [each for each in sorted(parent.iterdir())[:MAX_FOLDERS] if os.path.isdir(each)]
    except OSError:
        return []

"""What of a submission is judged: the student's C files, read safely, and what is said of the rest.

    submission = read_submission(Path("core_c"))  # or rendu.zip, rendu.tar.gz

Nothing but the files of `Submission.files` goes any further.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath

from grader.course import exercises
from grader.intake import archives, originals
from grader.intake.archives import CXX_CODE, Content, Entry, SubmissionError
from grader.intake.authors import NAME
from grader.intake.file_names import original
from grader.intake.records import Refusal, Renaming, Source, Submission

# Of one submission: what is read, compiled and kept of it.
MAX_FILES = 100
MAX_BYTES = 10_000_000
MAX_SHOWN = 200  # characters of a path
MAX_NEARBY = 3
# A folder with more copies than this around it lies among other people's submissions.
MAX_NEIGHBOURS = 5
MAX_FOLDERS = 200
SHIM = "mrt_shim.c"  # the name is ours: a submission's file of that name is not taken

_SANE_NAME = re.compile(r"[A-Za-z0-9_]+\.[ch]")
_TOP = PurePosixPath(".")

__all__ = ["SHIM", "SubmissionError", "read_submission"]


def read_submission(path: Path, *, look_around: bool = False) -> Submission:
    """Read the C files of a folder, a .zip or a .tar.gz; the student's may lie at any depth.

    `look_around` looks for other versions of them close to the folder: for a person's own work
    only. Raises SubmissionError when there is nothing to judge, or more than one candidate.
    """
    listed = list(archives.entries(path))
    found = [each for each in listed if not each.other]
    place = _candidate(found, path)
    rules = exercises.load()
    own, renamed = _as_ours([each for each in found if _is_beside(each, place)])
    authors = own.get(NAME) or next(filter(_is_authors, found), None)
    wanted, refused = _within_budget(own, authors)
    read = archives.contents(path, wanted)
    texts = {name: read[each.path] for name, each in own.items() if each.path in read}
    in_place = path.is_dir() and (path / place).resolve() == exercises.CORE.resolve()
    taken, unread, converted = _sorted_out(own, texts)
    refused += unread
    # Reports show the first ones: those of the course.
    refused.sort(key=lambda each: PurePosixPath(each.path).name not in rules.student)
    refused += [Refusal(_shown(each), each.problem) for each in found if _is_unsafe(each, place)]
    # In core_c itself they must be there: `make mrt` builds with them.
    given = {
        name: texts[name][0] if name in texts else b""
        for name in rules.given
        if name in texts or in_place
    }
    sources = [_source(name, own[name], path) for name in rules.student if name in taken]
    beside = {*own.values(), authors}
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
        authors=read[authors.path][0] if authors and authors.path in read else b"",
        renamed=tuple(renamed),
        unread=tuple(_shown(each) for each in listed if not each.problem and each not in beside),
    )


def _candidate(found: Sequence[Entry], path: Path) -> PurePosixPath:
    """Return the one folder that holds student's files: the top when it does, or else the only."""
    student = exercises.load().student
    safe = [each.path for each in found if each.problem != "outside"]
    folders = {each.parent for each in safe if each.name in student}
    folders = folders or {each.parent for each in safe if original(each.name).lower() in student}
    names = ", ".join(student)
    if not folders:
        raise SubmissionError(_why_nothing(found), path=path, names=names)
    if _TOP in folders:
        return _TOP
    if len(folders) > 1:
        listed = ", ".join(sorted(map(str, folders))[:6])
        raise SubmissionError("submission.several", path=path, folders=listed)
    return folders.pop()


def _as_ours(entries: Sequence[Entry]) -> tuple[dict[str, Entry], list[Renaming]]:
    """Return the files of a folder by the names that they had before anything renamed them.

    A file under its own name is the one; between copies nothing is chosen.
    """
    own = {each.path.name: each for each in entries}
    renamed = []
    for name in (*exercises.load().student, NAME):
        copies = [each for each in entries if original(each.path.name).lower() == name.lower()]
        if name in own or not copies:
            continue
        first = own.pop(copies[0].path.name)
        own[name] = replace(first, problem="copies") if len(copies) > 1 else first
        if not _is_authors(first):
            renamed.append(Renaming(_shown(first), name))
    return own, renamed


def _why_nothing(found: Sequence[Entry]) -> str:
    """Return the sentence for files that were not found: there may be more than was looked at."""
    ends = [each.problem for each in found if each.problem in archives.ENDS]
    return f"submission.nothing_in_{ends[0]}" if ends else "submission.nothing"


def _is_beside(entry: Entry, place: PurePosixPath) -> bool:
    """Whether a file lies beside the student's; another of the same name does not count."""
    return entry.path.parent == place and entry.problem not in ("twice", *archives.ENDS)


def _within_budget(
    own: Mapping[str, Entry], authors: Entry | None
) -> tuple[list[PurePosixPath], list[Refusal]]:
    """Return what to read, and what goes beyond what a submission may hold in all.

    The course's files come first, whatever lies around them.
    """
    rules = exercises.load()
    first = [*rules.student, *rules.given]
    order = [own[name] for name in first if name in own] + ([authors] if authors else [])
    order += [own[name] for name in own if name not in (*first, *rules.ungraded, SHIM)]
    wanted: list[PurePosixPath] = []
    refused: list[Refusal] = []
    size = 0
    for each in dict.fromkeys(each for each in order if not each.problem):
        number, size = len(wanted) + 1, size + each.size
        if number > MAX_FILES or size > MAX_BYTES:
            refused.append(Refusal(_shown(each), "many" if number > MAX_FILES else "total"))
            size -= each.size
        else:
            wanted.append(each.path)
    return wanted, refused


def _sorted_out(
    own: Mapping[str, Entry], texts: Mapping[str, Content]
) -> tuple[dict[str, bytes], list[Refusal], list[str]]:
    """Return the files to compile, those that cannot be, and those that were in UTF-16.

    `texts` are the contents of those that were read.
    """
    rules = exercises.load()
    taken: dict[str, bytes] = {}
    refused: list[Refusal] = []
    converted: list[str] = []
    for name, each in own.items():
        if name in (*rules.given, *rules.ungraded, SHIM):
            continue
        if not each.problem and name not in texts:
            continue  # beyond the budget, which is told
        content, unread = texts.get(name, (b"", each.problem))
        if name == NAME and not unread:
            continue
        text, problem = _as_text(content)
        problem = unread or _wrong_name(name) or problem
        if problem:
            refused.append(Refusal(_shown(each), problem))
            continue
        taken[name] = text
        if text != content:
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
    return os.fsencode(str(entry.path)).decode(errors="replace")[:MAX_SHOWN]


def _is_unsafe(entry: Entry, place: PurePosixPath) -> bool:
    """Whether an entry elsewhere than among the student's files is worth a word."""
    if entry.problem in ("link", "special"):
        return entry.path.parent != place
    return entry.problem in ("outside", "twice", *archives.ENDS)


def _name(path: Path) -> str:
    name = path.resolve().name
    for suffix in (".zip", ".tar.gz", ".tgz", ".tar"):
        name = name.removesuffix(suffix)
    return os.fsencode(name).decode(errors="replace")


def _source(name: str, entry: Entry, path: Path) -> Source:
    inside = f"{path} : {entry.path}" if path.is_file() else os.path.normpath(path / entry.path)
    return Source(name, str(inside), entry.modified)


def _changed(given: Mapping[str, bytes], handed_out: Mapping[str, bytes]) -> Iterator[str]:
    """Name the given files that are not the original, however an editor ends its lines."""
    for name, content in given.items():
        if not originals.is_same(content, handed_out[name]):
            yield name


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

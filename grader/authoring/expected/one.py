"""Makes one suite, picture or mistake of a folder of expected data again; the others stay.

What the manifest says of the folder, its seed and compiler, stays too: a folder has one seed.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from grader.authoring.expected import mistake_bank
from grader.authoring.expected.manifest import drop, merge, write_manifest
from grader.authoring.expected.pictures import lineup, make
from grader.authoring.expected.suites import file_of, recipes, suites
from grader.authoring.specimens import mistakes
from grader.checking.expected_data import read_manifest
from grader.checking.pictures import expected_files
from grader.checking.pictures.candidates import name_of
from grader.checking.pictures.plan import ExpectedPicture, everything, judged
from grader.course import scenes
from grader.course.message import GraderError
from grader.course.nearest import nearest
from grader.execution.session import Library


class UnknownNameError(GraderError):
    """There is no suite, picture or mistake of that name."""

    code = 2


def store_suite(core: Library, folder: Path, name: str) -> None:
    """Make a suite again, from the folder's seed, and what the bank holds by it.

    Raises UnknownNameError, ExpectedError.
    """
    known = {each.name: each for each in recipes()}
    _expect_known("SUITE", name, known)
    seed = int(read_manifest(folder)["seed"])
    (suite,) = suites(core, seed, [known[name]])
    merge(folder, *file_of(suite))
    if "bank" in read_manifest(folder):
        mistake_bank.store(folder, again=lambda mistake: False)


def store_picture(folder: Path, name: str) -> None:
    """Make a picture again, or with a name such as "scene4" a scene: what stands where, and all.

    Of a picture that checks look at, what the mistakes draw there is made again as well.
    Raises UnknownNameError, ExpectedError, OSError.
    """
    numbers = {f"scene{each}": each for each in scenes.load()}
    pictures = {each.name: each for each in everything()}
    _expect_known("PICTURE", name, [*pictures, *numbers])
    place = folder / expected_files.FOLDER
    if name in numbers:
        merge(place, *make.scene_files(numbers[name]))
    for each in pictures.values():
        if name in (each.name, f"scene{each.scene}"):
            merge(place, *make.picture_files(each))
            if each in judged():
                # What mistakes draw is told from what is accepted.
                _store_mistakes_of(folder, each)


def store_mistake(folder: Path, name: str, cache: Path = mistake_bank.CACHE) -> None:
    """Make what the bank holds of a mistake again, and the pictures that it may show in.

    Raises UnknownNameError, ExpectedError, OSError.
    """
    known = {each.id: each for each in mistakes.load()}
    _expect_known("MISTAKE", name, known)
    mistake_bank.store(folder, cache, lambda each: each.id == name)
    place = folder / expected_files.FOLDER
    for picture in judged():
        if lineup.is_of(folder, known[name], picture):
            _store_mistakes_of(folder, picture)
    manifest, now = read_manifest(place), lineup.fingerprints()
    manifest["mistakes"] |= {name: now[name]} if name in now else {}
    write_manifest(place, manifest)


def _store_mistakes_of(folder: Path, picture: ExpectedPicture) -> None:
    """Make the file of the mistakes that show in a picture again; none where none does."""
    files, rules = lineup.files(folder, picture)
    place = folder / expected_files.FOLDER
    if files:
        merge(place, files, rules)
    else:
        drop(place, name_of(picture.name))


def _expect_known(what: str, name: str, known: Iterable[str]) -> None:
    names = list(known)
    if name not in names:
        near = nearest(name, names)
        raise UnknownNameError(f"{what}={name}: there is none; the nearest is {near}")

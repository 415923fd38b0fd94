"""What was found in the place of a submission."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Source:
    """A file as it was found: its name, where it is for the person, when it was last written."""

    name: str
    path: str
    modified: float  # seconds since the epoch


@dataclass(frozen=True)
class Refusal:
    """A file that was not taken; `reason` is a key of [refused] in messages/."""

    path: str
    reason: str


@dataclass(frozen=True)
class Renaming:
    """A file that a browser or a system has renamed, and the name under which it is read."""

    path: str
    name: str


@dataclass(frozen=True)
class Submission:
    """The C files of a submission that are judged, by name; and what was found around them."""

    name: str
    files: Mapping[str, bytes]
    missing: tuple[str, ...]  # the student's files that are not there: the skeleton's stand in
    refused: tuple[Refusal, ...] = ()
    sources: tuple[Source, ...] = ()  # the student's files that were taken, in the course's order
    changed: tuple[str, ...] = ()  # given files that are not the original: not used
    converted: tuple[str, ...] = ()  # files that were in UTF-16
    nearby: tuple[Source, ...] = ()  # other versions of the student's files, close to the folder
    in_place: bool = False  # it is core_c itself: the originals are in the package
    authors: bytes = b""  # the content of its AUTEURS.txt
    renamed: tuple[Renaming, ...] = ()  # files read under the name that they had
    unread: tuple[str, ...] = ()  # files that are no part of what is judged

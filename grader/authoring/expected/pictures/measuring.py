"""Measuring what programs draw, each picture once: a run goes on where the last one stopped."""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from grader.authoring.expected.pictures.program import CACHE, RenderError
from grader.authoring.expected.pictures.sources import PictureSource
from grader.checking.expected_data import FOLDER, read_manifest
from grader.checking.pictures import expected_files
from grader.checking.pictures import measure as rule
from grader.checking.pictures.judgement import judge
from grader.checking.pictures.measure import Measures, measure, outside
from grader.checking.pictures.plan import ExpectedPicture
from grader.checking.shapes import Image
from grader.sandbox import cores

MEMORY = CACHE.with_name("measures.jsonl")
# Right without hit_color, which is what looks for glass.
OPAQUE = frozenset({"options_ignored"})


@dataclass(frozen=True)
class Reached:
    """What a source's picture measures."""

    source: str
    picture: ExpectedPicture
    measures: Measures
    exceeds: float  # the largest measure, over its limit


class _Memory:
    """What was measured, in a file to which each line is added at once."""

    def __init__(self, path: Path) -> None:
        self._path, self._lock = path, threading.Lock()
        lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
        # The last line of a run that was stopped may be cut.
        self._found = dict(json.loads(line) for line in lines if line.endswith("]]"))

    def get(self, key: str) -> Any:
        return self._found.get(key)

    def put(self, key: str, value: Sequence[float] | Sequence[str]) -> None:
        with self._lock:
            self._found[key] = value
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps([key, value]) + "\n")


@cache
def _memory() -> _Memory:
    return _Memory(MEMORY)


def measured(
    sources: Sequence[PictureSource], pictures: Sequence[ExpectedPicture]
) -> list[Reached]:
    """Measure every picture of every source, in the reading asked for.

    What cannot be drawn is left out, with a line; so is what is right in another reading, which
    has limits of its own.
    """
    pairs = [(source, picture) for source in sources for picture in pictures]
    with ThreadPoolExecutor(cores.usable()) as pool:
        return [each for each in pool.map(lambda pair: _measured(*pair), pairs) if each]


def _measured(source: PictureSource, picture: ExpectedPicture) -> Reached | None:
    if picture.stage == "glass" and source.id in OPAQUE:
        return None
    found = _measures(source, picture)
    if isinstance(found, str):
        print(f"left out: {source.id}, {picture.name}: {found}")
        return None
    exceeds = found.exceeds(expected_files.read(FOLDER, picture).limits)
    if 1 < exceeds < np.inf and judge(FOLDER, picture, source.draw(picture)).remark:
        return None
    return Reached(source.id, picture, found, exceeds)


def _measures(source: PictureSource, picture: ExpectedPicture) -> Measures | str:
    """Measure a picture, or find what was measured; a line when it cannot be drawn."""
    key = f"{source.program.id} {source.order(picture).line()} {_digest(picture)}"
    known = _memory().get(key)
    if known is None:
        known = _drawn_and_measured(source, picture)
        _memory().put(key, known)
    return known[0] if isinstance(known[0], str) else Measures(*known)


def _drawn_and_measured(source: PictureSource, picture: ExpectedPicture) -> list[float] | list[str]:
    try:
        drawn = source.draw(picture)
    except RenderError as error:
        return [str(error).splitlines()[0][:200]]
    found = measures(drawn, picture)
    return [found.share, found.tile, found.edges]


def measures(drawn: Image, picture: ExpectedPicture) -> Measures:
    """Measure what was drawn; one that has something else than numbers is infinitely far."""
    if not np.isfinite(drawn).all():
        return Measures(np.inf, np.inf)
    envelope = expected_files.read(FOLDER, picture).envelope
    return measure(drawn, envelope, outside(drawn, envelope))


def _digest(picture: ExpectedPicture) -> str:
    return f"{_files()[f'{picture.name}.npz']['sha256'][:16]} {_rule()}"


@cache
def _files() -> Mapping[str, Any]:
    return dict(read_manifest(FOLDER / expected_files.FOLDER)["files"])


@cache
def _rule() -> str:
    """Return what stands for the way of measuring."""
    return hashlib.sha256(Path(rule.__file__).read_bytes()).hexdigest()[:16]

"""How many intersection tests the student's code makes, by a build that counts them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from grader.build.records import Target
from grader.build.target import COUNT
from grader.execution.session import Library, Session
from grader.lab.bridge.core import Core

Array = npt.NDArray[Any]

SEARCH = "nearest_hit"


class Counter:
    """A session that counts how often a function that intersects an object is entered."""

    def __init__(self, library: Library, session: Session) -> None:
        self._library, self._session = library, session

    def place(self, objects: Array, octree: bool) -> None:
        """Make a scene of objects (an array of C's `object`), with the octree or without."""
        chosen = np.array(self._session.get("options"))
        chosen["octree"] = octree
        self._session.set("options", chosen)
        self._session.set("scene", objects)
        self._session.set("object_count", len(objects))
        self._session.call("scene_changed")

    def total(self, rays: Array) -> int:
        """Return how many tests nearest_hit makes for an array of rays, shape (n,)."""
        before = int(self._session.call(COUNT).result)
        hits = self._library.zeros("intersection", len(rays))
        self._session.call_many(SEARCH, len(rays), rays, hits)
        return int(self._session.call(COUNT).result) - before

    def each(self, rays: Array) -> Array:
        """Return the tests of each ray, in the shape of the array of rays."""
        counts = [self.total(ray[None]) for ray in rays.reshape(-1)]
        return np.array(counts).reshape(rays.shape)


@contextmanager
def counter(core: Core) -> Iterator[Counter]:
    """Build the code of `core` so that it counts, and start it. Raises Stopped."""
    target = Target(*core.size, counted=True)
    with core.engine.apart(target, SEARCH) as (library, session):
        yield Counter(library, session)

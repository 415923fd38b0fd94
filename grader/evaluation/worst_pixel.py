"""From a picture that fails to the pixel: its first wrong value, for the report.

One session for each picture, bounded in time; whatever goes wrong in it leaves the verdict alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from grader.checking.expected_data import ExpectedError
from grader.checking.pictures import expected_files
from grader.checking.pictures.plan import ExpectedPicture
from grader.checking.records import Pinned, Spot
from grader.checking.student import PICTURE_SIZE, Student
from grader.evaluation.records import Finding
from grader.evaluation.replay.case import ReplayedPixel, WrongValue
from grader.evaluation.replay.expected_maps import wanted
from grader.evaluation.replay.faults import first
from grader.evaluation.replay.probe import Probe
from grader.execution import death_messages
from grader.execution.session import Died, Library, Limits, Session

T = TypeVar("T")

LIMITS = Limits(cpu=2.0)


class _SessionCaller:
    """One session, and the function that it runs."""

    def __init__(self, session: Session, core: Library) -> None:
        self._session, self._core = session, core
        self.name = "setup_scene"

    def ask(self, name: str, act: Callable[[Session, Library], T]) -> T:
        """Let `act` use the session. Raises Died."""
        self.name = name
        return act(self._session, self._core)


def with_worst_pixel(finding: Finding, student: Student) -> Finding:
    """Return a finding on a wrong picture with what is told of its worst pixel.

    `student` is the build that drew it. Without the expected maps nothing is told.
    """
    evidence = finding.evidence
    if not evidence.spots:
        return finding
    try:
        found = _pinned(evidence.spots, student)
    except Exception:  # a help beside the verdict, which must not suffer from what it meets
        return finding
    return replace(finding, evidence=replace(evidence, pinned=found))


def _pinned(spots: tuple[Spot, ...], student: Student) -> Pinned | None:
    picture = ExpectedPicture.parse(spots[0].picture)
    texels = expected_files.read_texels(student.folder) if picture.rules.patterned else None
    with student.stage(LIMITS, texels, **picture.options) as (session, core):
        caller, spot = _SessionCaller(session, core), spots[0]
        try:
            session.call("setup_scene", picture.scene)
            probe = Probe(caller, PICTURE_SIZE, picture.scene)
            for spot in spots:
                if fault := _fault(probe, spot, student.folder):
                    return Pinned(spot.picture, spot.i, spot.j, fault.message)
        except ExpectedError:
            return None
        except Died as error:
            told = death_messages.message(error.death, f"{caller.name}()")
            return Pinned(spot.picture, spot.i, spot.j, told, error.death.location)
    return Pinned(spots[0].picture, spots[0].i, spots[0].j)


def _fault(probe: Probe, spot: Spot, folder: Path) -> WrongValue | None:
    """Return the first wrong value of a pixel. Raises Died, ExpectedError."""
    expected = wanted(folder, probe.number, probe.size, spot.i, spot.j)
    if expected is None:
        raise ExpectedError(folder, "no maps")
    drawn = np.array(spot.color, np.float32)
    root = probe.replay(spot.i, spot.j)
    return first(ReplayedPixel(probe, (spot.i, spot.j), root, expected, drawn, folder))

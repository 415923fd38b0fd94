"""The notebook's waits: from saving a C file to its picture, a slider's frame, a crash, live().

The frame is the kernel's part of what a slider waits for, drawing and the page's HTML; slider.py
measures the whole in a browser. Those of live() begin when the save is seen, a twentieth of a
second after it on the mean.
"""

from __future__ import annotations

import os
import shutil
import statistics
import time
from collections.abc import Callable
from pathlib import Path

from grader.authoring.bench import waits
from grader.authoring.bench.programs import BenchError
from grader.course.exercises import CORE, ROOT
from grader.lab import Core, Stopped
from grader.lab.display.picture import image
from grader.lab.display.store import write_json
from grader.lab.live.follower import Follower, View

ROUNDS = 5
SIZE = (640, 360)
# What is waited for, and how long at most, in seconds.
GOALS = {
    "save to picture": 1.0,
    "slider frame": 0.1,
    "crash to sentence": 0.3,
    "live, coarse": 0.3,
    "live, whole": 0.6,
}
_SPOT = "float n_l = vector_dot(n, l);"


def measure(folder: Path) -> dict[str, float]:
    """Return the median seconds of each wait, on the reference; `folder` holds the builds."""
    place = folder / "lab"
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(CORE, place / "core_c")
    for path in (ROOT / "reference").glob("*.[ch]"):
        shutil.copyfile(path, place / "core_c" / path.name)
    os.environ["BUILD"] = str(place / "build")
    core = Core(place / "core_c")
    core.size = SIZE
    source = place / "core_c" / "raytracer.c"
    text = source.read_text(encoding="utf-8")
    image(core.render(scene=0))  # the given files are compiled once for all
    found = {
        "save to picture": _median(lambda k: _save_and_draw(core, source, f"{text}\n/* {k} */\n")),
        "slider frame": _median(lambda k: image(core.render(scene=0, epsilon=1e-4 * (k + 1)))),
    }
    source.write_text(text.replace(_SPOT, f"{_SPOT} volatile int *p = 0; *p = 1;"), "utf-8")
    _crash(core)
    found["crash to sentence"] = _median(lambda k: _crash(core))
    core.close()
    found |= _live(place / "core_c", source, text)
    write_json(folder / "lab.json", {**found, "goals": GOALS})
    return found


def text(found: dict[str, float]) -> str:
    """Return a line for each wait."""
    return waits.text("In the notebook (scene 0, 640x360, wall time)", found, GOALS)


def _save_and_draw(core: Core, source: Path, content: str) -> None:
    source.write_text(content, encoding="utf-8")
    image(core.render(scene=0))


def _live(folder: Path, source: Path, content: str) -> dict[str, float]:
    """Return the median seconds from a save to live()'s two pictures."""
    source.write_text(content, encoding="utf-8")
    follower = Follower(folder, 0, SIZE, {})
    follower.look(lambda view: None)
    taken: dict[bool, list[float]] = {True: [], False: []}
    for k in range(ROUNDS):
        source.write_text(f"{content}\n/* live {k} */\n", encoding="utf-8")
        start, before = time.perf_counter(), follower.view.picture
        drawn = [each for each in _shown(follower) if each[1].picture is not before]
        for is_coarse, seconds in taken.items():
            seconds.append(next(t for t, view in drawn if view.coarse == is_coarse) - start)
    follower.close()
    coarse, whole = (statistics.median(taken[is_coarse]) for is_coarse in (True, False))
    return {"live, coarse": coarse, "live, whole": whole}


def _shown(follower: Follower) -> list[tuple[float, View]]:
    """Return what is shown after a save, and when."""
    seen: list[tuple[float, View]] = []
    follower.look(lambda view: seen.append((time.perf_counter(), view)))
    return seen


def _crash(core: Core) -> None:
    try:
        core.render(scene=0)
    except Stopped as stopped:
        if "shade" in stopped.shown.text:
            return
    raise BenchError("the crash was not told")


def _median(act: Callable[[int], object]) -> float:
    taken = []
    for k in range(ROUNDS):
        start = time.perf_counter()
        act(k)
        taken.append(time.perf_counter() - start)
    return statistics.median(taken)

"""The inspector's wait: from a click on a pixel to its table, in the kernel and in a real browser.

The browser's is timed by the page itself: from the click to the frame that shows the table.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from grader.authoring.bench.browser import BrowserSession, NoBrowser
from grader.authoring.bench.browsing import notebook
from grader.intake.originals import REFERENCE
from grader.lab.display.store import write_json
from grader.lab.inspector import widget
from grader.lab.inspector.looking import InspectedScene

ROUNDS = 15
SIZE = (320, 180)
SCENES = (0, 4, 3)  # the smallest, the one with most mirrors, a thousand spheres
GOAL = 0.15  # seconds, the browser's part included
CELL = "from grader.lab import inspect\n\ninspect({scene}, (1, 1))"
CLICK = """
async ([i, j]) => {
    const output = document.querySelector('.jp-Notebook .jp-Cell');
    const canvas = output.querySelector('.mrt-picture');
    const told = output.querySelector('.mrt-told');
    const box = canvas.getBoundingClientRect();
    const changed = new Promise((done) => {
        const observer = new MutationObserver(() => {
            if (told.dataset.pixel !== `${i},${j}`) return;
            observer.disconnect();
            done();
        });
        observer.observe(told, { attributes: true, attributeFilter: ['data-pixel'] });
    });
    const at = {
        clientX: box.left + (i + 0.5) / 320 * box.width,
        clientY: box.bottom - (j + 0.5) / 180 * box.height,
        bubbles: true,
    };
    const start = performance.now();
    canvas.dispatchEvent(new MouseEvent('click', at));
    const late = new Promise((_, fail) => setTimeout(() => fail(new Error('no table')), 20000));
    await Promise.race([changed, late]);
    await new Promise((done) => requestAnimationFrame(done));
    return (performance.now() - start) / 1000;
}
"""

Waits = dict[str, float]  # the median and the longest, of the kernel and of the whole; seconds


def measure(folder: Path) -> dict[int, Waits]:
    """Return the waits by scene, on the reference; `folder` holds the builds.

    The pixels go through the picture from corner to corner. Without a browser, the kernel's alone.
    """
    found = {scene: _named("kernel", _in_kernel(scene)) for scene in SCENES}
    try:
        # Of a notebook with several, JupyterLab keeps only the cells in sight.
        for scene, waits in found.items():
            with notebook(folder / "inspector", [CELL.format(scene=scene)]) as opened:
                waits |= _named("click", _in_browser(opened))
    except NoBrowser:
        pass  # text() says that there was none
    write_json(folder / "inspector.json", {**{str(k): v for k, v in found.items()}, "goal": GOAL})
    return found


def _named(name: str, seconds: Sequence[float]) -> Waits:
    return {f"{name} median": statistics.median(seconds), f"{name} longest": max(seconds)}


def _pixel(k: int) -> tuple[int, int]:
    return SIZE[0] * k // (ROUNDS + 1), SIZE[1] * k // (ROUNDS + 1)


def _in_kernel(scene: int) -> list[float]:
    inspected = InspectedScene(REFERENCE, scene, SIZE, {})
    try:
        made = widget.make(inspected, inspected.look(0, 0))
        return [_wait(made, k) for k in range(1, ROUNDS + 1)]
    finally:
        inspected.close()


def _wait(made: Any, k: int) -> float:
    start = time.perf_counter()
    made.pixel = list(_pixel(k))
    return time.perf_counter() - start


def _in_browser(opened: BrowserSession) -> list[float]:
    opened.output(0).locator(".mrt-told[data-pixel='1,1']").wait_for()
    opened.output(0).scroll_into_view_if_needed()
    opened.page.evaluate(CLICK, [0, 0])  # not counted
    return [float(opened.page.evaluate(CLICK, _pixel(k))) for k in range(1, ROUNDS + 1)]


def text(found: dict[int, Waits]) -> str:
    """Return a line for each scene."""
    lines = ["In the inspector, from a click to its table (wall time, median and longest)"]
    for scene, waits in found.items():
        kernel = _told(waits, "kernel")
        if "click median" not in waits:
            lines.append(f"  scene {scene:<4} kernel {kernel}   in the browser: not measured")
            continue
        met = "met" if waits["click median"] <= GOAL else "missed"
        goal = f"goal {1000 * GOAL:.0f} ms   {met}"
        lines.append(f"  scene {scene:<4} {_told(waits, 'click')}, kernel {kernel}   {goal}")
    return "\n".join(lines)


def _told(waits: Waits, name: str) -> str:
    return f"{1000 * waits[f'{name} median']:4.0f} {1000 * waits[f'{name} longest']:4.0f} ms"

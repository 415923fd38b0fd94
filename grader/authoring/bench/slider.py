"""A slider in a real browser: what a frame of scene 0 adds to the round trip of an empty slider.

Both are moved in turn in the same notebook of the same JupyterLab, step by step, and timed by the
page itself: from the key to the new picture, decoded.
"""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from pathlib import Path

from grader.authoring.bench.browser import BrowserSession, NoBrowser
from grader.authoring.bench.browsing import notebook
from grader.lab.display.store import write_json

ROUNDS = 15  # of a step of each slider, after one that is not counted
GOAL = 0.1  # seconds above the empty slider
CELLS = (
    "from grader.lab import Core, slider\n\ncore = Core()\ncore.size = (640, 360)",
    "slider(lambda k: k, k=(0, 100))",
    "slider(lambda k: core.render(scene=0, epsilon=1e-4 * (k + 1)), k=(0, 100))",
)
EMPTY, FRAME = 1, 2  # cells
STEP = """
async (cell) => {
    const output = document.querySelectorAll('.jp-Notebook .jp-Cell')[cell];
    const area = output.querySelector('.jp-OutputArea .widget-html-content');
    const changed = new Promise((done) => {
        const observer = new MutationObserver(() => { observer.disconnect(); done(); });
        observer.observe(area, { childList: true, subtree: true, characterData: true });
    });
    const key = { key: 'ArrowRight', bubbles: true };
    const start = performance.now();
    output.querySelector('.noUi-handle').dispatchEvent(new KeyboardEvent('keydown', key));
    await changed;
    const image = area.querySelector('img');
    if (image) await image.decode();
    return (performance.now() - start) / 1000;
}
"""


def measure(folder: Path) -> dict[str, float] | str:
    """Return the median seconds of both sliders, or why no browser can be driven."""
    try:
        with notebook(folder / "slider", CELLS) as opened:
            found = _medians(opened)
    except NoBrowser as error:
        return str(error)
    write_json(folder / "slider.json", {**found, "goal above the empty slider": GOAL})
    return found


def _medians(opened: BrowserSession) -> dict[str, float]:
    rounds = [
        [float(opened.page.evaluate(STEP, cell)) for cell in (EMPTY, FRAME)]
        for _ in range(ROUNDS + 1)
    ]
    empty, frame = zip(*rounds[1:], strict=True)
    return {
        "empty slider": statistics.median(empty),
        "slider frame": statistics.median(frame),
        "above the empty": paired(empty, frame),
    }


def paired(empty: Sequence[float], frame: Sequence[float]) -> float:
    """Return the median of what a frame adds, round by round."""
    return statistics.median(b - a for a, b in zip(empty, frame, strict=True))


def text(found: dict[str, float] | str) -> str:
    """Return a line for each wait, or one that says why there is none."""
    title = "A slider in the browser (scene 0, 640x360, wall time)"
    if isinstance(found, str):
        return f"{title}: not measured, {found}"
    above = found["above the empty"]
    goals = {"above the empty": f"   goal {1000 * GOAL:.0f} ms   {_met(above)}"}
    lines = [
        f"  {name:<18} {1000 * seconds:6.0f} ms{goals.get(name, '')}"
        for name, seconds in found.items()
    ]
    return "\n".join([title, *lines])


def _met(above: float) -> str:
    return "met" if above <= GOAL else "missed"

"""The pictures of a submission for the class page: its own drawing of TP1, and a scene of the end.

Drawn only when asked for: a class agrees to be exhibited.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Iterator

import numpy as np
from PIL import Image as Pictures

from grader.checking.student import PICTURE_SIZE, CallDied, Student, Wrong
from grader.execution.libraries import Libraries
from grader.execution.library_set import NotBuilt
from grader.execution.session import Array
from grader.execution.worker_process import Died, Missing

FOLDER = "gallery"
FINAL_SCENE = 4  # that of the handout's figure 8


def pictures(libraries: Libraries) -> Iterator[tuple[str, bytes]]:
    """Yield the names and contents of a submission's pictures; of one colour, it is none."""
    makers: dict[str, Callable[[Libraries], Array]] = {"drawing": _drawing, "final": _final}
    for name, make in makers.items():
        with contextlib.suppress(CallDied, Wrong, NotBuilt, Died, Missing):
            picture = np.clip(np.nan_to_num(make(libraries)), 0, 1)
            if np.ptp(picture.reshape(-1, 3), axis=0).any():
                yield f"{FOLDER}/{name}.png", _png(picture)


def _drawing(libraries: Libraries) -> Array:
    width, height = PICTURE_SIZE
    with Student(libraries.lend("main.c")).canvas(PICTURE_SIZE) as canvas:
        return canvas.draw("draw", np.zeros((height, width, 3), np.float32)).after


def _final(libraries: Libraries) -> Array:
    return Student(libraries.lend("raytracer.c")).picture(FINAL_SCENE)


def _png(picture: Array) -> bytes:
    """Return a picture as a file; its row 0 is at the bottom."""
    out = io.BytesIO()
    Pictures.fromarray((picture[::-1] * 255).astype(np.uint8)).save(out, "PNG", optimize=True)
    return out.getvalue()

"""Expected data: inputs, and what the reference answers to them.

A folder of expected data holds one `.npz` without pickle for each suite of calls, and
`manifest.json`: the command that made it, the compiler, and for each file its sha256, its tolerance
and the reason for it. `make expected` writes such folders; the checks read them, in
the grader's own process: no expected value goes where a submission runs.

In a file, an array of C structs stands as their bytes (uint8, one row for each struct): numpy has
no portable form for a union. The keys say what an array is:
    0.function, 0.args.r, 0.globals.scene       the first batch of calls
    0.answers.0.result, 0.answers.0.out.it      the reference's answers
    0.answers.1.result ...                      those of another convention that is accepted
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from grader.checking import npz
from grader.checking.npz import Arrays, archived
from grader.course import exercises, sizes
from grader.course.message import FaultError
from grader.execution.session import Address, Library, Session
from grader.intake.header_numbers import header_number

Array = npz.Array

FOLDER = exercises.EXPECTED
SIZE = sizes.UNIT  # of the picture: what the data was made for
# The globals that a batch may set, by the C type of one item.
GLOBALS = {
    "scene": "object",
    "lights": "light",
    "theCamera": "camera",
    "options": "render_options",
    "texels": "color",  # of scene_texture: shape (height, width, 3)
    "object_count": "int",  # where scene[] holds more, which must not count
    "num_lights": "int",
}
COUNTS = {"scene": "object_count", "lights": "num_lights"}


class ExpectedError(FaultError):
    """A file of the expected data cannot be read: the grader's fault, not the submission's.

    As a string it tells the file, what is wrong with it, and the cure.
    """

    def __init__(self, path: Path, error: object) -> None:
        cure = "put the original folder back, or make it again: make expected"
        super().__init__(f"{path}: {error}; {cure}")
        self.path = path


@dataclass(frozen=True)
class Answer:
    """What `count` calls gave: results (None for void), and what was written through pointers."""

    result: Array | None
    out: Mapping[str, Array]


@dataclass(frozen=True)
class Batch:
    """One function, called on many inputs in one setting; the first axis of arrays counts calls.

    `answers` are the reference's, then those of other conventions that are accepted.
    """

    function: str
    args: Mapping[str, Array]
    globals: Mapping[str, Array]
    answers: tuple[Answer, ...] = ()
    tolerance: float = 0.0

    @property
    def count(self) -> int:
        """The number of calls."""
        return len(next(iter(self.args.values())))


def prepare(session: Session, core: Library, batch: Batch) -> None:
    """Set the globals of a batch; the tree of scene_changed is not built.

    A scene, lights or a camera that the batch says nothing of are there all the same: what looks at
    them where it has no reason to does not find zeros.
    """
    lend_texture(session, core, batch.globals.get("texels"))
    for name, value in {**_foreign(core), **batch.globals}.items():
        if name == "texels":
            continue
        session.set(name, value)
        if name in COUNTS:
            count = counted(batch.globals, name) if name in batch.globals else len(value)
            session.set(COUNTS[name], count)


def _foreign(core: Library) -> dict[str, Array]:
    """Return a scene, lights and a camera that have nothing to do with any call."""
    scene, lights, camera = core.zeros("object", 2), core.zeros("light", 2), core.zeros("camera")
    scene["type"], scene["radius"] = (header_number("SPHERE"), header_number("PLANE")), 9
    scene["normal"], scene["dist"] = (0, 1, 0), 7
    scene["mat"]["kd"], scene["mat"]["ks"], scene["mat"]["shininess"] = (9, 0, 9), (0, 9, 0), 3
    lights["position"], lights["col"] = [(5, 60, 7), (-70, 8, 9)], [(8, 0, 1), (0, 7, 2)]
    camera["position"], camera["zdir"], camera["center"] = (31, -17, 23), (0, 0, 1), (0, 0, 1)
    camera["xdir"], camera["ydir"], camera["aspect"] = (0, 1, 0), (1, 0, 0), 3
    return {"scene": scene, "lights": lights, "theCamera": camera}


def counted(settings: Mapping[str, Array], name: str) -> int:
    """Return how many items of "scene" or "lights" count: all, unless their number is set."""
    return int(settings.get(COUNTS[name], len(settings.get(name, ()))))


def lend_texture(session: Session, core: Library, texels: Array | None) -> None:
    """Set scene_texture: an image of shape (height, width, 3), row 0 at the top, or none."""
    image = core.zeros("texture")
    if texels is not None:
        image["height"], image["width"] = texels.shape[:2]
        image["texels"] = session.buffer(texels)
    session.set("scene_texture", image)


def run(session: Session, core: Library, batch: Batch, **addresses: Address) -> Answer:
    """Make the calls of a batch, with the same address for an argument that is not in it.

    Raises what Session.call_many does.
    """
    parameters = core.functions[batch.function].parameters
    values = [addresses.get(each.name, batch.args.get(each.name)) for each in parameters]
    reply = session.call_many(batch.function, batch.count, *values)
    written = [each.name for each in parameters if is_written(each.ctype)]
    return Answer(reply.result, {name: reply.args[name] for name in written})


def is_written(ctype: str) -> bool:
    """Say whether a parameter of that type is one that the function writes through."""
    return ctype.endswith("*") and not ctype.startswith("const ")


# ---- Files --------------------------------------------------------------------------------------


def encode(batches: Sequence[Batch]) -> bytes:
    """Return the content of a suite's file: the same bytes for the same batches."""
    arrays: dict[str, Array] = {}
    for b, batch in enumerate(batches):
        arrays[f"{b}.function"] = np.array(batch.function)
        tables = {"args": batch.args, "globals": batch.globals}
        for a, answer in enumerate(batch.answers):
            tables[f"answers.{a}.out"] = answer.out
            if answer.result is not None:
                arrays[f"{b}.answers.{a}.result"] = answer.result
        for group, table in tables.items():
            arrays |= {f"{b}.{group}.{name}": _plain(value) for name, value in table.items()}
    return archived(arrays)


def read_manifest(folder: Path) -> dict[str, Any]:
    """Read the manifest of a folder. Raises ExpectedError."""
    path = folder / "manifest.json"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(content["files"], dict):
            raise TypeError("files")
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ExpectedError(path, error) from error
    return dict(content)


def read(folder: Path, suite: str, core: Library) -> list[Batch]:
    """Read a suite. Raises ExpectedError, naming the file and the cure."""
    path = folder / f"{suite}.npz"
    rules = rules_of(path)
    try:
        return _batches(arrays_of(path, rules), core, float(rules["tolerance"]))
    except (ValueError, KeyError) as error:
        raise ExpectedError(path, error) from error


def rules_of(path: Path) -> Mapping[str, Any]:
    """Return what the manifest beside a file says of it. Raises ExpectedError."""
    try:
        written = path.with_name("manifest.json").stat().st_mtime_ns
        return dict(_manifest(path.parent, written)["files"][path.name])
    except (OSError, KeyError) as error:
        raise ExpectedError(path, error) from error


@lru_cache(maxsize=8)
def _manifest(folder: Path, written: int) -> dict[str, Any]:
    """Return the manifest of a folder, read again when it was written again."""
    return read_manifest(folder)


def content_of(path: Path, rules: Mapping[str, Any]) -> bytes:
    """Return the content of a file that is as the manifest says. Raises ExpectedError."""
    try:
        content = path.read_bytes()
        if hashlib.sha256(content).hexdigest() != rules["sha256"]:
            raise ValueError("it is not what manifest.json says")
    except (OSError, KeyError, ValueError) as error:
        raise ExpectedError(path, error) from error
    return content


def arrays_of(path: Path, rules: Mapping[str, Any]) -> Arrays:
    """Return the arrays of a file that is as the manifest says. Raises ExpectedError."""
    try:
        return Arrays(content_of(path, rules))
    except ValueError as error:
        raise ExpectedError(path, error) from error


def _plain(value: Array) -> Array:
    """Return structs as their bytes."""
    if value.dtype.names is None:
        return value
    flat = np.frombuffer(np.ascontiguousarray(value).tobytes(), np.uint8)
    return flat.reshape((*value.shape, value.dtype.itemsize))


def _typed(value: Array, dtype: np.dtype[Any]) -> Array:
    """Return bytes as the structs that they are. Raises ValueError when the size is another."""
    if dtype.names is None:
        return value
    if value.shape[-1] != dtype.itemsize:
        raise ValueError("made for other structs")
    return value.view(dtype).reshape(value.shape[:-1])


def _batches(arrays: Mapping[str, Array], core: Library, tolerance: float) -> list[Batch]:
    batches: list[Batch] = []
    while f"{len(batches)}.function" in arrays:
        prefix = f"{len(batches)}."
        own = {key[len(prefix) :]: arrays[key] for key in arrays if key.startswith(prefix)}
        batches.append(_batch(own, core, tolerance))
    return batches


def _batch(own: Mapping[str, Array], core: Library, tolerance: float) -> Batch:
    function = str(own["function"])
    types = {
        each.name: core.dtype(each.pointee or each.ctype)
        for each in core.functions[function].parameters
    }

    def table(group: str) -> dict[str, Array]:
        names = [key[len(group) :] for key in own if key.startswith(group)]
        return {name: _typed(own[group + name], types[name]) for name in names}

    answers: list[Answer] = []
    while any(key.startswith(f"answers.{len(answers)}.") for key in own):
        prefix = f"answers.{len(answers)}."
        answers.append(Answer(own.get(f"{prefix}result"), table(f"{prefix}out.")))
    settings = {
        name: _typed(own[f"globals.{name}"], core.dtype(ctype))
        for name, ctype in GLOBALS.items()
        if f"globals.{name}" in own
    }
    return Batch(function, table("args."), settings, tuple(answers), tolerance)

"""Making inputs: random numbers, C structs, and questions that have one clear answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any
from zlib import crc32

import numpy as np

from grader.checking.expected_data import Array, Batch, prepare, run
from grader.execution.session import Library, Session
from grader.intake.header_numbers import header_number

# What the glue can leave out, from the first pictures of TP2 to the last of TP5.
STAGES: tuple[dict[str, bool], ...] = (
    {"shading": False, "shadows": False, "reflections": False, "refraction": False}
    | {"fresnel": False},
    {"shading": True, "shadows": False, "reflections": False, "refraction": False}
    | {"fresnel": False},
    {"shading": True, "shadows": True, "reflections": False, "refraction": False}
    | {"fresnel": False},
    {"shading": True, "shadows": True, "reflections": True, "refraction": False}
    | {"fresnel": False},
    {"shading": True, "shadows": True, "reflections": True, "refraction": True} | {"fresnel": True},
)


@dataclass(frozen=True)
class Question:
    """Calls to make; `variants` are other calls whose answers are accepted as well."""

    batch: Batch
    variants: tuple[Batch, ...] = ()


@dataclass(frozen=True)
class Suite:
    """The questions of one file. `tolerance` is relative to answers that exceed 1."""

    name: str
    questions: tuple[Question, ...]
    tolerance: float
    reason: str


@dataclass(frozen=True)
class Recipe:
    """How the questions of a suite are made."""

    name: str
    make: Callable[[Maker], Sequence[Question]]
    tolerance: float
    reason: str

    def suite(self, core: Library, session: Session, seed: int) -> Suite:
        """Return the suite, with answers; what it draws depends on its name and the seed alone."""
        maker = Maker(core, session, [seed, crc32(self.name.encode())])
        questions = tuple(maker.answered(each, self.name) for each in self.make(maker))
        return Suite(self.name, questions, self.tolerance, self.reason)


class Maker:
    """Random numbers of one seed, and structs of the reference's types."""

    def __init__(self, core: Library, session: Session, seed: int | Sequence[int]) -> None:
        self.core, self.session = core, session
        self.rng = np.random.default_rng(seed)

    # ---- Numbers and vectors --------------------------------------------------------------------

    def uniform(self, low: float, high: float, *shape: int) -> Array:
        """Return numbers between low and high."""
        return self.rng.uniform(low, high, shape).astype(np.float32)

    def unit(self, count: int) -> Array:
        """Return unit vectors of every direction."""
        v = self.rng.normal(size=(count, 3))
        return norm1(v)

    def around(self, axes: Array, low: float, high: float = 1.0) -> Array:
        """Return unit vectors whose cosine with the given ones lies between low and high."""
        cosine = self.rng.uniform(low, high, (len(axes), 1))
        side = norm1(np.cross(axes, self.unit(len(axes))))
        return norm1(cosine * axes + np.sqrt(1 - cosine**2) * side)

    # ---- Structs --------------------------------------------------------------------------------

    def blank(self, ctype: str, count: int) -> Array:
        """Return structs full of numbers that no answer has: what a call must write, or leave."""
        made = self.core.zeros(ctype, count)
        _fill(made, -77.0)
        return made

    def rays(self, orig: Any, direction: Any, **fields: Any) -> Array:
        """Return rays as ray_init makes them, but for the fields that are given."""
        count = max(len(np.atleast_2d(orig)), len(np.atleast_2d(direction)))
        made = self.core.zeros("ray", count)
        made["orig"], made["dir"] = orig, direction
        made["tmax"], made["seed"] = 1000.0, 1
        for name, value in fields.items():
            made[name] = value
        return made

    def used(self, rays: Array, first: int, low: Array | float, high: Array | float) -> Array:
        """Return rays that have been used before; the `first` ones stay as ray_init makes them.

        Their range ends somewhere from where they have counted so far to `low` at its beginning,
        and to `high` at its end.
        """
        made, count = rays.copy(), len(rays)
        made["tmin"] = low * self.uniform(0, 0.9, count)
        made["tmax"] = high * self.uniform(1.1, 9, count)
        made["depth"] = self.rng.integers(0, 9, count)
        made["seed"] = self.rng.integers(2, 1 << 32, count, dtype=np.uint32)
        made[:first] = rays[:first]
        return made

    def materials(self, count: int, **fields: Any) -> Array:
        """Return opaque materials without pattern; fields that are not given are drawn."""
        made = self.core.zeros("material", count)
        for name in ("kd", "ks", "kr", "kd2"):
            made[name] = self.uniform(0.05, 0.95, count, 3)
        made["shininess"] = self.uniform(1, 200, count).round()
        made["pattern_origin"] = self.uniform(-1, 1, count, 3)
        made["pattern_size"] = self.uniform(0.5, 2, count)
        made["user"] = self.uniform(0, 1, count, 4)
        for name, value in fields.items():
            made[name] = value
        return made

    def objects(self, kind: str, count: int, mat: Array | None = None, **fields: Any) -> Array:
        """Return objects of a type such as "SPHERE"."""
        made = self.core.zeros("object", count)
        made["type"] = int(self.core.constants[kind])
        made["mat"] = self.materials(count) if mat is None else mat
        for name, value in fields.items():
            made[name] = value
        return made

    def hits(self, position: Any, normal: Any, mat: Array) -> Array:
        """Return intersections, as many as there are materials."""
        made = self.core.zeros("intersection", len(mat))
        made["position"], made["normal"], made["mat"] = position, normal, mat
        return made

    def lights(self, position: Any, col: Any) -> Array:
        """Return lights."""
        made = self.core.zeros("light", len(position))
        if len(position):
            made["position"], made["col"] = position, col
        return made

    def options(self, **changed: Any) -> Array:
        """Return the options of the last stage, without the octree; some of them changed."""
        made = self.core.zeros("render_options")
        values = {
            **STAGES[-1],
            "samples": 1,
            "max_depth": 10,
            "epsilon": header_number("EPSILON"),
            **changed,
        }
        for name, value in values.items():
            made[name] = value
        return made

    def switches(self, **changed: Any) -> dict[str, Array]:
        """Return globals for what has no reason to look at anything but the options."""
        return {"options": self.options(**changed)}

    def world(
        self, scene: Array | None = None, lights: Array | None = None, **changed: Any
    ) -> dict[str, Array]:
        """Return globals: a scene and lights, none where none are given, and options."""
        return {
            "scene": self.core.zeros("object", 0) if scene is None else scene,
            "lights": self.core.zeros("light", 0) if lights is None else lights,
            "options": self.options(**changed),
        }

    def camera(self, position: Any, at: Any, fov: float, aspect: float) -> Array:
        """Return a camera that stands upright."""
        made = self.session.call("init_camera", position, at, (0, 1, 0), fov, aspect).result
        return np.asarray(made)

    # ---- Answers --------------------------------------------------------------------------------

    def ask(self, batch: Batch) -> Batch:
        """Return the batch with the reference's answers."""
        prepare(self.session, self.core, batch)
        answer = run(self.session, self.core, batch)
        return replace(batch, answers=(*batch.answers, answer))

    def answered(self, question: Question, name: str) -> Question:
        """Return the question with the reference's answers in it, those that are stored."""
        if not question.batch.count:
            raise ValueError(f"{name}: a batch without any call")
        batch = question.batch if question.batch.answers else self.ask(question.batch)
        others = tuple(self.ask(each).answers[0] for each in question.variants)
        # What only changes globals answers nothing that could be stored.
        told = [each for each in (*batch.answers, *others) if each.result is not None or each.out]
        return Question(replace(batch, answers=tuple(told)))

    def steady(self, batch: Batch, moved: str, amount: float = 2e-3) -> Batch:
        """Keep the calls whose answer is clear: it hardly changes when a point is moved a little.

        `moved` is a point among the arguments, such as "r.orig". What grazes an edge is left out:
        there, correct arithmetic of different kinds gives different answers.
        """
        name, field = moved.split(".")
        base = self.ask(batch)
        keep = np.ones(batch.count, bool)
        for _ in range(4):
            shifted = {key: value.copy() for key, value in batch.args.items()}
            shifted[name][field] += amount * self.unit(batch.count)
            keep &= ~_apart(base, self.ask(replace(batch, args=shifted)))
        return only(batch, keep)

    def stages(self, batch: Batch) -> Question:
        """Return the calls at the first stage; the answers of the later ones are accepted too."""
        staged = [
            replace(batch, globals={**batch.globals, "options": self.options(**stage)})
            for stage in STAGES
        ]
        return Question(staged[0], tuple(staged[1:]))


def floats(values: Any) -> Array:
    """Return numbers as C's floats."""
    return np.asarray(values, np.float32)


def integers(values: Any) -> Array:
    """Return numbers as C's ints."""
    return np.asarray(values, np.int32)


def norm1(vectors: Any) -> Array:
    """Return the vectors made unit, as floats."""
    wide = np.asarray(vectors, np.float64)
    return np.asarray(wide / np.linalg.norm(wide, axis=-1, keepdims=True), np.float32)


def only(batch: Batch, keep: Array) -> Batch:
    """Return the batch with the calls that are marked."""
    return replace(batch, args={name: value[keep] for name, value in batch.args.items()})


def result(batch: Batch) -> Array:
    """Return what the calls of an answered batch gave, as bools."""
    answer = batch.answers[0].result
    if answer is None:
        raise ValueError(f"{batch.function} returns nothing")
    return np.asarray(answer)


def stack(*parts: Array) -> Array:
    """Return arrays one after another; structs keep C's layout, which np.concatenate packs."""
    made = np.zeros((sum(map(len, parts)), *parts[0].shape[1:]), parts[0].dtype)
    start = 0
    for each in parts:
        made[start : start + len(each)] = each
        start += len(each)
    return made


def joined(*parts: Mapping[str, Array]) -> dict[str, Array]:
    """Return arguments one after another."""
    return {name: stack(*(each[name] for each in parts)) for name in parts[0]}


def _fill(made: Array, value: float) -> None:
    for name in made.dtype.names or ():
        if made[name].dtype.names:
            _fill(made[name], value)
        else:
            # Counters and seeds are unsigned, or are used as indices.
            made[name] = value if made[name].dtype.kind == "f" else 77


def _apart(one: Batch, other: Batch) -> Array:
    """Return which calls were answered differently: more than a small move can explain."""
    first, second = one.answers[0], other.answers[0]
    different = np.zeros(one.count, bool)
    parts: list[tuple[Array, Array]] = []
    if first.result is not None and second.result is not None:
        parts.append((first.result, second.result))
    if "it" in first.out:
        # A t in short steps moves far.
        scale = np.maximum(1, first.out["r"]["tmax"] / 50)
        parts.append((first.out["r"]["tmax"] / scale, second.out["r"]["tmax"] / scale))
        parts.append((first.out["it"]["normal"], second.out["it"]["normal"]))
    for a, b in parts:
        wide = np.abs(a.astype(np.float64) - b.astype(np.float64))
        different |= wide.reshape(one.count, -1).max(axis=1) > 0.1
    return different

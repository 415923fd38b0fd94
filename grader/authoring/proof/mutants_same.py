"""Telling mutants that answer as the reference does, bit for bit.

On inputs that no check has: the suites of other seeds, rays and drawings at random without any
regard to what grazes an edge, and every scene at every stage (small: the checks draw them large).
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from grader.authoring.expected.pictures.texels import texels
from grader.authoring.expected.suites import suites
from grader.authoring.expected.vectors.maker import Maker, norm1
from grader.authoring.proof.mutants_changes import Mutant
from grader.authoring.proof.mutants_family import QUICK, Kit
from grader.authoring.specimens import patches
from grader.checking import expected_data
from grader.checking.expected_data import SIZE, Array, Batch
from grader.checking.pictures.plan import ExpectedPicture, everything
from grader.course.exercises import CORE
from grader.execution.session import Address, Library, Limits, Session
from grader.execution.worker_process import Died
from grader.files import content_key
from grader.intake.originals import REFERENCE

SEEDS = range(101, 104)
RAYS = 10_000  # of each type of object
DRAWINGS = 100  # of each function of TP1
LIMITS = Limits(cpu=60)

Part = Callable[[Session, Library], list[Array]]  # some of the answers


def is_same(kit: Kit, mutant: Mutant, cache: Path) -> bool:
    """Say whether a mutant that has been chosen answers as the reference does.

    `cache` is a folder of builds.
    """
    right = patches.submission("reference", patches.reference())
    with Kit(right, cache) as reference:
        return all(
            _digest(kit.core(QUICK), part) == _known(name, reference, part)
            for name, part in _parts(mutant)
        )


@cache
def answers_of() -> str:
    """Return what stands for the program whose answers are the right ones."""
    names = [path for path in sorted(CORE.glob("*.[ch]")) if path.name not in patches.reference()]
    parts = [(path.name, path.read_text(encoding="utf-8")) for path in names]
    return content_key(parts, sorted(patches.reference().items()))


_digests: dict[str, str] = {}  # the reference's, by the names of the parts


def _known(name: str, reference: Kit, part: Part) -> str:
    if name not in _digests:
        _digests[name] = _digest(reference.core(QUICK), part)
    return _digests[name]


def _digest(core: Library, part: Part) -> str:
    """Return what stands for some of the answers; "" when they do not come back."""
    digest = hashlib.sha256()
    try:
        with core.session(LIMITS) as session:
            for each in part(session, core):
                digest.update(each.tobytes())
    except Died:
        return ""
    return digest.hexdigest()


def _parts(mutant: Mutant) -> Iterator[tuple[str, Part]]:
    """Return the parts that a mutant could change, those that take little time first.

    What is drawn with TP1's functions is no scene, and without a tree nothing calls the octree's.
    """
    if mutant.file == "main.c":
        yield "drawings", _drawings
        return
    with_tree = mutant.file == "octree.c"
    for name, batches in _inputs().items():
        if name.startswith("octree") or not with_tree:
            yield name, _calls(batches)
    for picture in everything():
        if picture.rules.octree or not with_tree:
            yield picture.name, _picture(picture)


# ---- Functions ----------------------------------------------------------------------------------


@cache
def _inputs() -> Mapping[str, tuple[Batch, ...]]:
    """Return the batches of the seeds, and rays at random, by the names of their suites."""
    found: dict[str, list[Batch]] = {}
    folder = REFERENCE.parent / "build" / "cache"
    with Kit(patches.submission("reference", patches.reference()), folder) as kit:
        core = kit.core(QUICK)
        for seed in SEEDS:
            for suite in suites(core, seed):
                batches = [each.batch for each in suite.questions]
                found.setdefault(suite.name, []).extend(batches)
        with core.session(LIMITS) as session:
            maker = Maker(core, session, SEEDS[0])
            for kind in ("plane", "sphere", "cylinder", "cone"):
                found[f"any {kind}"] = [_rays(maker, kind)]
    return {name: tuple(batches) for name, batches in found.items()}


def _rays(m: Maker, kind: str) -> Batch:
    """Return rays that may miss, graze, start inside or see a part of their way only."""
    shape: dict[str, Any] = {
        "plane": {"normal": m.unit(RAYS), "dist": m.uniform(-3, 3, RAYS)},
        "sphere": {"center": m.uniform(-2, 2, RAYS, 3), "radius": m.uniform(0.1, 2, RAYS)},
    }.get(kind, {})
    if not shape:
        shape = {"base": m.uniform(-2, 2, RAYS, 3), "axis": m.unit(RAYS)}
        shape |= {"length": m.uniform(0.2, 3, RAYS), "radius": m.uniform(0.1, 2, RAYS)}
    start = m.uniform(-4, 4, RAYS, 3)
    way = norm1(m.uniform(-2, 2, RAYS, 3) - start) * m.uniform(0.3, 3, RAYS, 1)
    rays = m.rays(start, way)
    rays["tmin"][::3] = m.uniform(0, 3, len(rays[::3]))
    rays["tmax"][::5] = m.uniform(0, 9, len(rays[::5]))
    args = {"r": rays, "it": m.blank("intersection", RAYS)}
    return Batch(f"intersect_{kind}", args | {"obj": m.objects(kind.upper(), RAYS, **shape)}, {})


def _calls(batches: tuple[Batch, ...]) -> Part:
    def part(session: Session, core: Library) -> list[Array]:
        return [each for batch in batches for each in _answers(session, core, batch)]

    return part


def _answers(session: Session, core: Library, batch: Batch) -> Iterator[Array]:
    """Return what the calls of a batch give, and what else its setting is there for."""
    expected_data.prepare(session, core, batch)
    answer = expected_data.run(session, core, batch)
    yield from answer.out.values()
    if answer.result is not None:
        yield answer.result
    if batch.function == "populate_spheres":
        yield session.get("scene", int(session.get("object_count")))
    if batch.function in ("camera_ray", "pixel_color"):
        session.call("raytrace")
        yield session.get("output_image")
    if "options" in batch.globals and batch.globals["options"]["octree"]:
        session.call("scene_changed")
        root = int(session.get("scene_octree"))
        if root:
            walked = replace(batch, function="octree_intersect")
            found = expected_data.run(session, core, walked, node=Address(root))
            yield from found.out.values()


def _drawings(session: Session, core: Library) -> list[Array]:
    """Draw with the functions of TP1, also beyond the picture."""
    rng = np.random.default_rng(SEEDS[0])
    width, height = SIZE
    blank = np.zeros((width * height, 3), np.float32)
    drawn = []
    for _ in range(DRAWINGS):
        c1, c2 = rng.uniform(0, 1, (2, 3))
        p1, p2 = rng.uniform(-0.5, 1.5, (2, 3)) * (width, height, 1)
        radius = rng.uniform(-0.1, 1) * height
        for name, args in (
            ("fill", (c1,)),
            ("horizontal_gradient", (c1, c2)),
            ("fill_rect", (c1, p1, p2)),
            ("fill_circle", (radius, p1, c1)),
        ):
            drawn.append(session.call(name, blank, *args).args["img"])
    return drawn


# ---- Pictures -----------------------------------------------------------------------------------


def _picture(picture: ExpectedPicture) -> Part:
    def part(session: Session, core: Library) -> list[Array]:
        options = session.get("options")
        for name, value in picture.options.items():
            options[name] = value
        session.set("options", options)
        table = texels() if picture.rules.patterned else None
        expected_data.lend_texture(session, core, table)
        session.call("setup_scene", picture.scene)
        session.call("raytrace")
        return [session.get("output_image")]

    return part

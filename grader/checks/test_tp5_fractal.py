"""TP5, bonus: the fractal."""

from __future__ import annotations

import numpy as np
import pytest

from grader.checking.comparison import far, unit
from grader.checking.describe import call, pair, value
from grader.checking.expected_data import Array, Batch
from grader.checking.looks import Look
from grader.checking.records import Evidence
from grader.checking.reproducer import of_command
from grader.checking.student import Bench, Student, Wrong, without_answers

# ---- TP5.B2: populate_spheres -------------------------------------------------------------------


def grown(bench: Bench, batch: Batch, case: int) -> tuple[Array, str]:
    """Call populate_spheres; return the spheres of the scene, and the text of the call."""
    bench.prepare(batch)
    text = call(batch, case)
    bench.call("populate_spheres", text, *(column[case] for column in batch.args.values()))
    count = int(bench.session.get("object_count"))
    most = int(bench.core.constants["SCENE_SIZE"])
    if not 0 <= count <= most:
        raise Wrong("failure.overflow", call=text, got=count, most=most)
    return bench.session.get("scene", count), text


def evidence(batch: Batch, case: int, count: int) -> Evidence:
    """Return the C program of a call, which says how many spheres there are."""
    args = [column[case] for column in batch.args.values()]
    look = Look("object_count", count)
    return Evidence(reproducer=of_command("populate_spheres", args, batch, look))


def scenes(student: Student) -> list[tuple[Batch, int, Array, str]]:
    """Return each call's batch and number, its spheres and its text."""
    (batch,) = student.batches("populate_spheres.any")
    with student.bench() as bench:
        made = [(batch, k, *grown(bench, batch, k)) for k in range(batch.count)]
    for _, k, spheres, _ in made:
        if int(batch.args["depth"][k]) == 1:
            note_family(student, batch, k, spheres)
    return made


def note_family(student: Student, batch: Batch, k: int, spheres: Array) -> None:
    """Put down what one generation of children is like, whatever their directions."""
    radius, up = float(batch.args["radius"][k]), batch.args["up"][k]
    ways = spheres["center"] - spheres["center"][:1]
    sums = [spheres["radius"].sum(), np.linalg.norm(ways, axis=1).sum()]
    got = np.array([[len(spheres), *sums, (ways @ up < -batch.tolerance).sum()]])
    right = np.array([[4, 1.75 * radius, 3.75 * radius, 0]])
    student.observations.note("family", got, far(got, right, batch.tolerance), batch.tolerance)


def families(student: Student) -> list[tuple[Batch, int, Array, str]]:
    """Return the calls that made children. Raises Wrong when fewer than half of those asked did.

    How many spheres there are is asked by the count alone.
    """
    asked = [each for each in scenes(student) if each[0].args["depth"][each[1]]]
    made = [each for each in asked if len(each[2]) > CHILDREN]
    if len(made) < len(asked) / 2:
        batch, k, spheres, text = next(each for each in asked if len(each[2]) <= CHILDREN)
        values = {"call": text, "got": len(spheres), "expected": CHILDREN + 1}
        raise Wrong("failure.spheres", **values).showing(evidence(batch, k, CHILDREN + 1))
    return made


CHILDREN = 3  # of a sphere


def family(spheres: Array, tolerance: float) -> tuple[Array, Array]:
    """Return, for each sphere after the first, its parent's number and its distance to touching.

    The parent is the sphere of four times its radius that it comes nearest to touching.
    """
    center, radius = spheres["center"].astype(np.float64), spheres["radius"].astype(np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):  # a NaN fits nowhere
        distance = np.linalg.norm(center[1:, None] - center[None], axis=2)
        gap = np.abs(distance - 1.25 * radius[None]) / radius[None]
        fits = np.abs(radius[1:, None] * 4 - radius[None]) <= tolerance * 4 * radius[1:, None]
    gap = np.where(fits & ~np.isnan(gap), gap, np.inf)
    return gap.argmin(axis=1), gap.min(axis=1)


@pytest.mark.check("tp5.populate_spheres.count")
def test_populate_spheres_count(student: Student) -> None:
    """Depth 0 adds one sphere, the one asked for; depth n adds (3^(n+1) - 1) / 2."""
    for batch, k, spheres, text in scenes(student):
        wanted = (3 ** (int(batch.args["depth"][k]) + 1) - 1) // 2
        places = len(np.unique(np.round(spheres["center"], 4), axis=0))
        if len(spheres) != wanted or places < PLACES * wanted:
            wrong = Wrong(
                "failure.spheres", call=text, got=min(len(spheres), places), expected=wanted
            )
            raise wrong.showing(evidence(batch, k, wanted))
        first = np.append(spheres["center"][0], spheres["radius"][0])
        asked = np.append(batch.args["center"][k], batch.args["radius"][k])
        if far(first[None], asked[None], batch.tolerance)[0]:
            raise Wrong("failure.first", call=text, **pair(first, asked))


PLACES = 0.3  # of the spheres: many in one place are no fractal


@pytest.mark.check("tp5.populate_spheres.tangency")
def test_populate_spheres_tangency(student: Student) -> None:
    """Each child has a quarter of its parent's radius, and touches it."""
    for batch, _, spheres, text in families(student):
        _, gap = family(spheres, batch.tolerance)
        for each in np.flatnonzero(~(gap <= 10 * batch.tolerance)):
            raise Wrong("failure.apart", call=text, sphere=value(spheres[each + 1]))


@pytest.mark.check("tp5.populate_spheres.hemisphere")
def test_populate_spheres_hemisphere(student: Student) -> None:
    """The children stand above their parent, in three directions."""
    for batch, k, spheres, text in families(student):
        parents, gap = family(spheres, batch.tolerance)
        if gap.max() > 10 * batch.tolerance:  # whose child is whose is not known, but of the first
            if len(spheres) > 4:
                continue
            parents = np.zeros(3, int)
        ways = unit(spheres["center"][1:] - spheres["center"][parents])
        ups = np.vstack([batch.args["up"][k][None].astype(np.float64), ways])[parents]
        above = np.einsum("ij,ij->i", ways, ups)
        for each in np.flatnonzero(~(above >= -batch.tolerance)):
            raise Wrong("failure.below", call=text, sphere=value(spheres[each + 1]))
        first = ways[parents == 0]
        if (first @ np.roll(first, 1, axis=0).T).diagonal().max() > 0.99:
            raise Wrong("failure.same_way", call=text)


@pytest.mark.check("tp5.populate_spheres.full")
def test_populate_spheres_full(student: Student) -> None:
    """When the scene is full, it stops without writing beyond, and without going on in vain."""
    (batch,) = student.batches("populate_spheres.any")
    with student.bench() as bench:
        few, _ = grown(bench, batch, int(np.argmax(batch.args["depth"] == 2)))
        if len(np.unique(np.round(few["center"], 4), axis=0)) < 4:
            wrong = Wrong("failure.spheres", call=call(batch, 2), got=1, expected=13)
            raise wrong
        deep = without_answers(batch, depth=np.full(batch.count, DEEP, np.int32))
        most = int(bench.core.constants["SCENE_SIZE"])
        spheres, text = grown(bench, deep, 0)
        if len(spheres) != most:
            wrong = Wrong("failure.spheres", call=text, got=len(spheres), expected=most)
            raise wrong.showing(evidence(deep, 0, most))


DEEP = 20  # generations: three billion spheres, for whoever does not stop

"""TP5, bonus: glass and the fractal."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from grader.checking.comparison import far, unit
from grader.checking.describe import call, number, pair, value
from grader.checking.expected_data import Array, Batch
from grader.checking.ray_origins import expect_fresh, expect_origin
from grader.checking.records import Evidence
from grader.checking.reproducer import Look, of_command
from grader.checking.student import Answers, Bench, Student, Wrong, without_answers

# A share of draws may be that many standard deviations away from its probability, and a little.
DEVIATIONS, SLACK = 4.5, 0.01


# ---- TP5.B1: refracted_ray, glass_color ---------------------------------------------------------


def passing(trial: Answers) -> Array:
    """Return which calls refract."""
    return ~trial.refused


@pytest.mark.check("tp5.refracted_ray.entering")
def test_refracted_ray_entering(student: Student) -> None:
    """A ray that enters bends towards the normal."""
    for suite in ("refracted_ray.entering", "refracted_ray.scaled"):
        for trial in student.trials(suite):
            trial.expect("result")
            trial.expect("out.dir", by=unit)


@pytest.mark.check("tp5.refracted_ray.leaving")
def test_refracted_ray_leaving(student: Student) -> None:
    """A ray that leaves bends away from the normal."""
    for trial in student.trials("refracted_ray.leaving"):
        trial.expect("result")
        trial.expect("out.dir", by=unit)


@pytest.mark.check("tp5.refracted_ray.total")
def test_refracted_ray_total(student: Student) -> None:
    """On total reflection: false, and nothing is written."""
    for trial in student.trials("refracted_ray.total"):
        trial.expect("result")
        trial.expect_kept("out", where=trial.refused)


@pytest.mark.check("tp5.refracted_ray.fields")
def test_refracted_ray_fields(student: Student) -> None:
    """The refracted ray starts off the surface, one deeper, with the seed that goes on."""
    for trial in student.trials("refracted_ray.entering"):
        expect_origin(trial, passing(trial))
        expect_fresh(trial, passing(trial))
        trial.expect("out.depth", "out.seed")


def draws(student: Student, suite: str) -> Iterator[tuple[Answers, Array]]:
    """Yield each trial of glass_color, and which of its rays are reflected.

    That is told by what the submission's own trace_ray sees along the reflected ray: how it sees is
    not the question here.
    """
    with student.bench() as bench:
        for batch in student.batches(suite):
            trial = bench.trial(batch)
            again = Batch("trace_ray", {"r": mirrored_ray(bench, batch)}, {})
            (seen,) = bench.again(again).got("result")
            got = trial.got("result")
            yield trial, ~far(got, np.broadcast_to(seen, got.shape), 1e-3)


def mirrored_ray(bench: Bench, batch: Batch) -> Array:
    """Return the reflected ray that all the calls of a batch share."""
    came, hit = batch.args["in"][:1], batch.args["it"][:1]
    into = np.einsum("ij,ij->i", came["dir"], hit["normal"])[:, None]
    ray = bench.core.zeros("ray", 1)
    for name in ("tmin", "tmax", "seed"):
        ray[name] = came[name]
    ray["dir"] = came["dir"] - 2 * into * hit["normal"]
    ray["orig"] = hit["position"] + np.float32(bench.core.constants["EPSILON"]) * ray["dir"]
    ray["depth"] = came["depth"] + 1
    return ray


def check_share(student: Student, trial: Answers, mirrored: Array, *accepted: float) -> None:
    """Look how many of the rays are reflected: one of the shares, but for chance."""
    share = float(mirrored.mean())
    bounds = [
        DEVIATIONS * np.sqrt(each * (1 - each) / trial.batch.count) + SLACK for each in accepted
    ]
    if not any(abs(share - each) <= bound for each, bound in zip(accepted, bounds, strict=True)):
        student.observations.note("share", np.array([share]), np.array([True]), bounds[0])
        values = {"got": number(100 * share), "expected": number(100 * accepted[0])}
        raise Wrong("failure.share", call=trial.call(0), count=trial.batch.count, **values)


@pytest.mark.check("tp5.glass_color.odds")
def test_glass_color_odds(student: Student) -> None:
    """Over many seeds, Fresnel's share of the rays is reflected."""
    for trial, mirrored in draws(student, "glass_color.odds"):
        check_share(student, trial, mirrored, odds(trial))


@pytest.mark.check("tp5.glass_color.plain")
def test_glass_color_plain(student: Student) -> None:
    """Without options.fresnel, the mean of ks is the share that is reflected."""
    for trial, mirrored in draws(student, "glass_color.plain"):
        mean = float(trial.batch.args["it"]["mat"]["ks"][0].mean())
        # Who does without the options goes by Fresnel.
        check_share(student, trial, mirrored, mean, odds(trial))


@pytest.mark.check("tp5.glass_color.one_ray")
def test_glass_color_one_ray(student: Student) -> None:
    """Each call follows one ray: the reflected one or the refracted one."""
    for trial, mirrored in draws(student, "glass_color.odds"):
        got = trial.got("result")
        # What a refracted ray sees is one colour; a mixture with the other fails the odds.
        others = got[~mirrored]
        floor = others[0] if len(others) else got[0]
        one = ~far(got, np.broadcast_to(floor, got.shape), trial.batch.tolerance)
        trial.complain(~(one | mirrored), "failure.two_rays", got=got)


def odds(trial: Answers) -> float:
    """Return the probability of the reflected ray: Schlick, with kr of the indices 1 and n."""
    args = trial.batch.args
    cosine = -float(args["in"]["dir"][0] @ args["it"]["normal"][0])
    index = float(args["it"]["mat"]["refraction_index"][0])
    kr = ((1 - index) / (1 + index)) ** 2
    return kr + (1 - kr) * (1 - cosine) ** 5


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
        if len(spheres) != wanted:
            wrong = Wrong("failure.spheres", call=text, got=len(spheres), expected=wanted)
            raise wrong.showing(evidence(batch, k, wanted))
        first = np.append(spheres["center"][0], spheres["radius"][0])
        asked = np.append(batch.args["center"][k], batch.args["radius"][k])
        if far(first[None], asked[None], batch.tolerance)[0]:
            raise Wrong("failure.first", call=text, **pair(first, asked))


@pytest.mark.check("tp5.populate_spheres.tangency")
def test_populate_spheres_tangency(student: Student) -> None:
    """Each child has a quarter of its parent's radius, and touches it."""
    for batch, k, spheres, text in scenes(student):
        if batch.args["depth"][k] and len(spheres) < 4:
            wrong = Wrong("failure.spheres", call=text, got=len(spheres), expected=4)
            raise wrong.showing(evidence(batch, k, 4))
        if len(spheres) > 1:
            _, gap = family(spheres, batch.tolerance)
            for each in np.flatnonzero(~(gap <= 10 * batch.tolerance)):
                raise Wrong("failure.apart", call=text, sphere=value(spheres[each + 1]))


@pytest.mark.check("tp5.populate_spheres.hemisphere")
def test_populate_spheres_hemisphere(student: Student) -> None:
    """The children stand above their parent, in three directions."""
    for batch, k, spheres, text in scenes(student):
        if int(batch.args["depth"][k]) == 1 and len(spheres) == 4:
            up = batch.args["up"][k].astype(np.float64)
            ways = unit(spheres["center"][1:] - spheres["center"][0])
            for each in np.flatnonzero(~(ways @ up >= -batch.tolerance)):
                raise Wrong("failure.below", call=text, sphere=value(spheres[each + 1]))
            if (ways @ np.roll(ways, 1, axis=0).T).diagonal().max() > 0.99:
                raise Wrong("failure.same_way", call=text)


@pytest.mark.check("tp5.populate_spheres.full")
def test_populate_spheres_full(student: Student) -> None:
    """When the scene is full, it stops without writing beyond."""
    (batch,) = student.batches("populate_spheres.any")
    with student.bench() as bench:
        deep = without_answers(batch, depth=np.full(batch.count, 11, np.int32))
        most = int(bench.core.constants["SCENE_SIZE"])
        spheres, text = grown(bench, deep, 0)
        if len(spheres) != most:
            wrong = Wrong("failure.spheres", call=text, got=len(spheres), expected=most)
            raise wrong.showing(evidence(deep, 0, most))

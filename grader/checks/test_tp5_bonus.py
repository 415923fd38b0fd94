"""TP5, bonus: glass."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from grader.checking.comparison import far, unit
from grader.checking.describe import number
from grader.checking.expected_data import Array, Batch
from grader.checking.ray_origins import expect_fresh, expect_origin
from grader.checking.student import Answers, Bench, Student, Wrong

# A share of draws may be that many standard deviations away from its probability, and a little.
DEVIATIONS, SLACK = 4.5, 0.01
# Cosine between the refracted direction and the one that arrives: above, it is a copy.
COPY = 1 - 1e-6


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
    refracting(student)
    for trial in student.trials("refracted_ray.total"):
        trial.expect("result")
        trial.expect_kept("out", where=trial.refused)


@pytest.mark.check("tp5.refracted_ray.fields")
def test_refracted_ray_fields(student: Student) -> None:
    """The refracted ray starts off the surface, one deeper, with the seed that goes on."""
    for trial in refracting(student):
        expect_origin(trial, passing(trial))
        expect_fresh(trial, passing(trial))
        trial.expect("out.depth", "out.seed")


def refracting(student: Student) -> list[Answers]:
    """Return the answers to rays that enter, if they are refracted and bend."""
    trials = student.trials("refracted_ray.entering")
    for trial in trials:
        way, came = unit(trial.got("out.dir")), unit(trial.batch.args["in"]["dir"])
        copied = np.einsum("ij,ij->i", way, came) > COPY
        if not (trial.got("result")[passing(trial)].mean() > 0.5 and copied.mean() < 0.5):
            trial.expect("result")
            trial.expect("out.dir", by=unit)
    return trials


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
    """Each call follows one ray, the reflected one or the refracted one; both occur."""
    both = False
    for trial, mirrored, refracted in followed(student, "glass_color.odds"):
        trial.complain(~(mirrored | refracted), "failure.two_rays", got=trial.got("result"))
        both |= bool(mirrored.any() and (~mirrored).any())
    if not both:
        check_share(student, trial, mirrored, odds(trial))


@pytest.mark.check("tp5.glass_color.total")
def test_glass_color_total(student: Student) -> None:
    """On total reflection the reflected ray is followed, always."""
    if not any((~mirrored).any() for _, mirrored in draws(student, "glass_color.odds")):
        next(draws(student, "glass_color.odds"))[0].expect("result")  # never anything else
    for trial, mirrored in draws(student, "glass_color.total"):
        trial.complain(~mirrored, "failure.not_total", got=trial.got("result"))


@pytest.mark.check("tp5.glass_color.seed")
def test_glass_color_seed(student: Student) -> None:
    """The draw moves the seed on, and the bounced ray goes on from there."""
    for trial, mirrored, refracted in followed(student, "glass_color.twice"):
        still = trial.got("in.seed") == trial.batch.args["in"]["seed"]
        values = {"got": trial.got("in.seed"), "expected": trial.batch.answers[0].out["in"]["seed"]}
        trial.complain(still, "failure.output", what="in->seed", **values)
        seen = np.ptp(trial.got("result"), axis=0).max()
        wrong = ~(mirrored | refracted) | (seen < 1e-3)
        trial.complain(wrong, "failure.seed_lost", got=trial.got("result"))


def followed(student: Student, suite: str) -> Iterator[tuple[Answers, Array, Array]]:
    """Yield each trial of glass_color, and which calls gave what either ray sees.

    The rays are those of the submission's own functions, with the seed that the call has left.
    """
    with student.bench() as bench:
        for batch in student.batches(suite):
            trial = bench.trial(batch)
            out = bench.core.zeros("ray", batch.count)
            came = {"out": out, "in": trial.got("in"), "it": batch.args["it"]}
            sides = []
            for name in ("reflected_ray", "refracted_ray"):
                way = bench.again(Batch(name, came, {})).got("out")
                seen = bench.again(Batch("trace_ray", {"r": way}, {})).got("result")
                sides.append(~far(trial.got("result"), seen, trial.batch.tolerance))
            yield trial, sides[0], sides[1]


def odds(trial: Answers) -> float:
    """Return the probability of the reflected ray: Schlick, with kr of the indices 1 and n."""
    args = trial.batch.args
    cosine = abs(float(args["in"]["dir"][0] @ args["it"]["normal"][0]))
    index = float(args["it"]["mat"]["refraction_index"][0])
    kr = ((1 - index) / (1 + index)) ** 2
    return kr + (1 - kr) * (1 - cosine) ** 5

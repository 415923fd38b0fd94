"""TP4, bonus: the octree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.build.target import COUNT, STEPS
from grader.checking.comparison import far
from grader.checking.describe import number, setting
from grader.checking.expected_data import Answer, Batch
from grader.checking.student import Answers, Bench, Student, Wrong, without_answers
from grader.checks import solids
from grader.checks.common import check_results, met_alone
from grader.execution.session import Address
from grader.intake.header_numbers import header_number

# ---- TP4.B1: the octree -------------------------------------------------------------------------


# Of the tests that going through the whole list would take: what a tree of any use stays below.
FEW = 0.5
# Of the hits: what a tree with a mistake in it still finds, objects in one of their boxes only.
SOME = 0.25
ASIDE = 200  # objects where no ray comes


def plant(bench: Bench, batch: Batch) -> Address:
    """Build the tree of a scene, as scene_changed does. Raises Wrong when there is none."""
    bench.prepare(batch)
    bench.call("scene_changed", f"octree_build(scene, object_count){setting(batch)}")
    root = int(bench.session.get("scene_octree"))
    if not root:
        raise Wrong("failure.no_tree", setting=setting(batch).strip())
    return Address(root)


def search(bench: Bench, batch: Batch, root: Address) -> Answers:
    """Search a tree along the rays of a batch."""
    return bench.again(replace(batch, function="octree_intersect"), node=root)


def walk(bench: Bench, batch: Batch) -> Answers:
    """Build the tree of a scene, and search it. Raises Wrong when there is no tree."""
    return search(bench, batch, plant(bench, batch))


def walks(student: Student, suite: str) -> list[Answers]:
    """Search the trees of a suite's scenes."""
    with student.bench() as bench:
        return [walk(bench, batch) for batch in student.batches(suite)]


@pytest.mark.check("tp4.octree.tall")
def test_octree_tall(student: Student) -> None:
    """A cylinder or a cone that reaches into a box overlaps it, and the tree finds it."""
    for trial in student.trials("octree.overlap"):
        right, types = trial.batch.answers[0].result, trial.batch.args["obj"]["type"]
        assert right is not None
        others = types != header_number("PLANE")
        if trial.got("result")[~right & others].all():  # however far it is
            trial.expect("result")
    check_results(student, "octree.tall")
    for batch in student.batches("octree.kinds"):
        with student.bench() as bench:
            try:
                trial = walk(bench, batch)
            except Wrong:  # whether there is a tree is asked elsewhere
                return
            # A cylinder may not be written yet, or be wrong.
            alone = met_alone(bench, batch, batch.args["r"])
        own = Answer(alone.count > 0, {"r": alone.rays, "it": alone.hits})
        one = alone.sound & (alone.count == 1)
        replace(trial, batch=replace(batch, answers=(own,))).expect("result", "r.tmax", where=one)


@pytest.mark.check("tp4.octree.hits")
def test_octree_hits(student: Student) -> None:
    """The tree gives the same hits as the whole list."""
    for trial in walks(student, "octree.hits"):
        trial.expect("result", "r.tmax", "it.mat.kd")


@pytest.mark.check("tp4.octree.misses")
def test_octree_misses(student: Student) -> None:
    """When nothing is met nothing changes, and a hit changes tmax and nothing else of the ray."""
    for trial in walks(student, "octree.misses"):
        trial.expect("result")
        trial.expect_kept("r", "it", where=trial.refused)
    for trial in walks(student, "octree.hits"):
        before = {**trial.answer.out, "r": trial.batch.args["r"]}
        kept = replace(trial.batch, answers=(Answer(trial.answer.result, before),), tolerance=1e-5)
        replace(trial, batch=kept).expect(*(f"r.{name}" for name in solids.KEPT))


@pytest.mark.check("tp4.octree.planes")
def test_octree_planes(student: Student) -> None:
    """Planes stay out of the tree: without anything else there is none."""
    for trial in walks(student, "octree.planes"):
        trial.expect("result")
    (batch,) = student.batches("octree.planes")
    planes = batch.globals["scene"][batch.globals["scene"]["type"] == header_number("PLANE")]
    with student.bench() as bench:
        for scene in (planes, planes[:0]):
            bench.prepare(replace(batch, globals={**batch.globals, "scene": scene}))
            bench.call("scene_changed", f"octree_build(scene, {len(scene)})")
            if int(bench.session.get("scene_octree")):
                raise Wrong("failure.tree_of_nothing", count=len(scene))


@pytest.mark.check("tp4.octree.again")
def test_octree_again(student: Student) -> None:
    """A large scene has its tree as well, and so has every one that comes after it."""
    crowd = max(student.batches("octree.hits"), key=lambda each: len(each.globals["scene"]))
    with student.bench() as bench:
        large = multiplied(crowd, LARGE)
        trial = walk(bench, large)
        whole = bench.again(replace(large, function="intersect_scene"))
        answers = (Answer(whole.answer.result, whole.answer.out),)
        replace(trial, batch=replace(large, answers=answers)).expect("result", "r.tmax")
        for _ in range(AGAIN):
            root = plant(bench, crowd)
        search(bench, crowd, root).expect("result", "r.tmax")


LARGE, AGAIN = 3, 40  # times the crowd along each axis; trees that are built after one another
RAYS = 40  # through the large scene, whose list is long


def multiplied(batch: Batch, times: int) -> Batch:
    """Return the calls in a scene that repeats its own, side by side."""
    scene = batch.globals["scene"]
    copies = []
    for shift in np.ndindex(times, times, times):
        copy = scene.copy()
        copy["center"] += np.float32(8) * np.array(shift, np.float32)
        copies.append(copy)
    table = np.concatenate(copies).astype(scene.dtype)
    rays = {name: each[:RAYS] for name, each in batch.args.items()}
    return without_answers(replace(batch, args=rays, globals={**batch.globals, "scene": table}))


@pytest.mark.check("tp4.octree.fewer_tests", counts=True)
def test_octree_fewer_tests(student: Student) -> None:
    """In a crowd most rays find their hit, and each is tested against few of the objects."""
    crowd = max(student.batches("octree.hits"), key=lambda each: len(each.globals["scene"]))
    objects, rays = len(crowd.globals["scene"]), crowd.count
    trial, tests, steps = counted(student, crowd)
    assert crowd.answers[0].result is not None
    right = crowd.answers[0].out["it"]["position"]
    if far(trial.got("it.position"), right, crowd.tolerance).mean() > 1 - SOME:
        trial.expect("result", "it.position")
    if tests < SOME * rays:  # each of them hits something, which takes a test
        raise Wrong("failure.uncounted", rays=rays, tests=tests)
    if tests > FEW * rays * objects:
        most = number(FEW * objects)
        values = {"rays": rays, "objects": objects, "got": number(tests / rays), "most": most}
        raise Wrong("failure.many_tests", **values)
    # A test that is written out elsewhere is no count: but each object takes steps all the same.
    _, _, more = counted(student, with_others(crowd))
    if more - steps > rays * ASIDE / 4:
        got = number((more - steps) / rays)
        raise Wrong("failure.every_object", aside=ASIDE, got=got)


def counted(student: Student, batch: Batch) -> tuple[Answers, int, int]:
    """Search the tree of a scene; return the answers, the tests of objects, and the steps."""
    with student.counting() as bench:
        root = plant(bench, batch)
        before = [int(bench.session.call(each).result) for each in (COUNT, STEPS)]
        trial = search(bench, batch, root)
        after = [int(bench.session.call(each).result) for each in (COUNT, STEPS)]
    return trial, after[0] - before[0], after[1] - before[1]


def with_others(batch: Batch) -> Batch:
    """Return a batch with as many small objects more, together in a corner where no ray comes."""
    scene = batch.globals["scene"]
    corner = np.array([scene["center"][:, 0].max() - 8, *scene["center"][:, 1:].min(axis=0)])
    others = np.repeat(scene[:1], ASIDE)
    steps = np.indices((ASIDE, 1, 1))[0].reshape(-1)
    places = np.stack([steps % 6, steps // 6 % 6, steps // 36], axis=1)
    others["center"] = corner + places / 10
    others["radius"] = 0.02
    return replace(batch, globals={**batch.globals, "scene": np.append(scene, others)})

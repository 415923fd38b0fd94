"""TP4 - shadows and mirrors, and the octree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.build.target import COUNT, STEPS
from grader.checking.comparison import unit
from grader.checking.describe import number, setting
from grader.checking.expected_data import Batch
from grader.checking.ray_origins import expect_fresh, expect_origin
from grader.checking.student import Answers, Bench, Student, Wrong
from grader.checks.common import check_results, check_stages
from grader.execution.session import Address

# ---- TP4.1: in_shadow ---------------------------------------------------------------------------


@pytest.mark.check("tp4.in_shadow.blocked")
def test_in_shadow_blocked(student: Student) -> None:
    """An object between the point and the light bars the way; elsewhere it does not."""
    check_results(student, "in_shadow.blocked")


@pytest.mark.check("tp4.in_shadow.beyond")
def test_in_shadow_beyond(student: Student) -> None:
    """An object beyond the light bars nothing."""
    check_results(student, "in_shadow.beyond")


@pytest.mark.check("tp4.in_shadow.behind")
def test_in_shadow_behind(student: Student) -> None:
    """An object behind the point bars nothing."""
    check_results(student, "in_shadow.behind")


@pytest.mark.check("tp4.in_shadow.own_surface")
def test_in_shadow_own_surface(student: Student) -> None:
    """The surface on which the point lies does not bar its own light."""
    check_results(student, "in_shadow.own")


@pytest.mark.check("tp4.in_shadow.at_light")
def test_in_shadow_at_light(student: Student) -> None:
    """A light at the point itself is not barred."""
    check_results(student, "in_shadow.at_light")


@pytest.mark.check("tp4.in_shadow.used")
def test_in_shadow_used(student: Student) -> None:
    """direct_light leaves out the lights that are barred, and those only."""
    check_results(student, "in_shadow.used")


# ---- TP4.2: reflected_ray -----------------------------------------------------------------------


@pytest.mark.check("tp4.reflected_ray.direction")
def test_reflected_ray_direction(student: Student) -> None:
    """The direction is reflected about the normal."""
    for trial in student.trials("reflected_ray.unit"):
        trial.expect("out.dir", by=unit)


@pytest.mark.check("tp4.reflected_ray.unit")
def test_reflected_ray_unit(student: Student) -> None:
    """The new direction is unit, even when the ray that arrives has none such."""
    for trial in student.trials("reflected_ray.scaled"):
        trial.expect("out.dir")


@pytest.mark.check("tp4.reflected_ray.origin")
def test_reflected_ray_origin(student: Student) -> None:
    """The new ray starts at the point hit, a little off the surface."""
    for trial in student.trials("reflected_ray.unit"):
        expect_origin(trial, np.ones(trial.batch.count, bool))


@pytest.mark.check("tp4.reflected_ray.depth")
def test_reflected_ray_depth(student: Student) -> None:
    """The depth is one more than that of the ray that arrives."""
    for trial in student.trials("reflected_ray.unit"):
        trial.expect("out.depth")


@pytest.mark.check("tp4.reflected_ray.fresh")
def test_reflected_ray_fresh(student: Student) -> None:
    """The new ray has a range of its own, and goes on with the seed."""
    for trial in student.trials("reflected_ray.unit"):
        expect_fresh(trial, np.ones(trial.batch.count, bool))
        trial.expect("out.seed")


# ---- TP4.3: mirror_color ------------------------------------------------------------------------


@pytest.mark.check("tp4.mirror_color.sky")
def test_mirror_color_sky(student: Student) -> None:
    """Under an empty sky: the mirror's coefficient times the sky."""
    check_stages(student, "mirror_color.sky", empty=True)


@pytest.mark.check("tp4.mirror_color.object")
def test_mirror_color_object(student: Student) -> None:
    """The mirror shows the object that the reflected ray meets."""
    check_stages(student, "mirror_color.object")


@pytest.mark.check("tp4.mirror_color.depth")
def test_mirror_color_depth(student: Student) -> None:
    """After max_depth bounces the mirror adds nothing more."""
    check_stages(student, "mirror_color.depth")


# ---- TP4.B1: the octree -------------------------------------------------------------------------


# Of the tests that going through the whole list would take: what a tree of any use stays below.
FEW = 0.5
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


@pytest.mark.check("tp4.octree.overlap")
def test_octree_overlap(student: Student) -> None:
    """Objects that touch a box overlap it, those that are far do not, and planes never do."""
    check_results(student, "octree.overlap")


@pytest.mark.check("tp4.octree.tall")
def test_octree_tall(student: Student) -> None:
    """A cylinder or a cone that reaches into a box overlaps it, be it by its rim or its tip."""
    check_results(student, "octree.tall")


@pytest.mark.check("tp4.octree.hits")
def test_octree_hits(student: Student) -> None:
    """The tree gives the same hits as the whole list."""
    for trial in walks(student, "octree.hits"):
        trial.expect("result", "r.tmax", "it.mat.kd")


@pytest.mark.check("tp4.octree.misses")
def test_octree_misses(student: Student) -> None:
    """When nothing is met, nothing changes."""
    for trial in walks(student, "octree.misses"):
        trial.expect("result", where=trial.refused)
        trial.expect_kept("r", "it", where=trial.refused)


@pytest.mark.check("tp4.octree.planes")
def test_octree_planes(student: Student) -> None:
    """Planes stay out of the tree."""
    for trial in walks(student, "octree.planes"):
        trial.expect("result")


@pytest.mark.check("tp4.octree.fewer_tests", counts=True)
def test_octree_fewer_tests(student: Student) -> None:
    """In a crowd, each ray is tested against few of the objects."""
    crowd = max(student.batches("octree.hits"), key=lambda each: len(each.globals["scene"]))
    objects, rays = len(crowd.globals["scene"]), crowd.count
    trial, tests, steps = counted(student, crowd)
    trial.expect("result", "r.tmax")
    if tests < rays:  # each of them hits something, which takes a test
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

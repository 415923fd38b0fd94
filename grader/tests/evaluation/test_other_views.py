"""Pictures from another camera, in other colours: who draws is right there, who copies is not."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np
import pytest

from grader.authoring.expected import command
from grader.authoring.expected.pictures import other_views
from grader.checking.pictures import expected_files
from grader.checking.pictures.other_views import FOLDER
from grader.checking.pictures.plan import ExpectedPicture
from grader.course import exercises
from grader.course.sizes import sizes_for
from grader.course.texts import Texts
from grader.evaluation.pipeline import report_of, run_checks
from grader.evaluation.records import Outcome, Report
from grader.execution.libraries import Libraries
from grader.intake.records import Submission
from grader.tests.support.judging import solution

COPIED = "tp2.scene.flat_1"
# The tree, the glass and the samples are laid out and drawn otherwise.
DRAWN = (COPIED, "tp4.scene.octree_3", "tp5.scene.glass_7", "tp5.scene.smooth_0")
COPY = """
static const unsigned char levels[][3] = {%s};
static const int runs[][2] = {%s};
static bool copied(void) {
    if (object_count != 5 || num_lights != 3 || options.shading) {
        return false;
    }
    color *to = output_image;
    for (size_t k = 0; k < sizeof runs / sizeof runs[0]; k++) {
        const unsigned char *c = levels[runs[k][1]];
        for (int n = 0; n < runs[k][0]; n++) {
            *to++ = vector_init(c[0] / 255.f, c[1] / 255.f, c[2] / 255.f);
        }
    }
    return true;
}
void raytrace(void) {
    if (copied()) return;
"""


@pytest.fixture(scope="module")
def views(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the inputs of another seed than the archive's, with other views of a few scenes."""
    folder = tmp_path_factory.mktemp("views")
    words = ["--seed", "8", "--out", str(folder), "--without-pictures", "--without-bank"]
    assert command.main([*words, "--without-views"]) == 0
    other_views.store(folder, 8, (0, 1, 3, 7))
    return folder


def judged(
    files: Mapping[str, str], chosen: Collection[str], cache: Path, fresh: Path | None
) -> Report:
    """Judge pictures as a class's are, with checks of functions that make them count."""
    rules = exercises.load()
    own = [f"tp2.{name}" for name in ("raytrace.every_pixel", "trace_ray.object", "trace_ray.sky")]
    content = {name: text.encode() for name, text in files.items()}
    with Libraries(Submission("r", content, missing=()), sizes_for(None), cache) as libraries:
        findings = run_checks(libraries, rules, None, [*own, *chosen], fresh=fresh)
        return report_of(libraries, rules, findings, Texts("en"))


def copying() -> dict[str, str]:
    """Return the solution, whose raytrace has a picture of the archive in it."""
    picture = expected_files.read_png(exercises.EXPECTED, ExpectedPicture(1, "flat"))
    pixels = np.rint(picture * 255).astype(np.uint8).reshape(-1, 3)
    levels, which = np.unique(pixels, axis=0, return_inverse=True)
    runs = [(len([*group]), key) for key, group in itertools.groupby(which.ravel().tolist())]
    tables = [", ".join("{" + ", ".join(map(str, row)) + "}" for row in t) for t in (levels, runs)]
    files = solution()
    text = files["raytracer.c"]
    assert text.count("void raytrace(void) {\n") == 1
    files["raytracer.c"] = text.replace("void raytrace(void) {\n", COPY % (*tables,))
    return files


@pytest.mark.long
def test_a_copied_picture_earns_nothing_elsewhere(cache: Path, views: Path) -> None:
    """It is right from the archive's camera; from another one it is still the archive's."""
    files = copying()
    before, after = (judged(files, [COPIED], cache, where) for where in (None, views))
    (copied,), (found,) = (
        [each for each in report.checks if each.id == COPIED] for report in (before, after)
    )
    assert copied.outcome is Outcome.PASSED
    assert (found.outcome, found.points) == (Outcome.FAILED, 0)
    assert "from another one, and in other colours" in found.message
    assert {"got", "expected"} <= found.images.keys()
    assert after.learnt == (found.exercise,)


def test_who_draws_is_right_in_any_view(cache: Path, views: Path) -> None:
    """With the tree, through glass and with samples."""
    report = judged(solution(), DRAWN, cache, views)
    assert [each.id for each in report.checks if each.points != each.max_points or each.note] == []
    assert report.learnt == ()


def test_a_seed_has_its_own_views(views: Path, tmp_path: Path) -> None:
    """The same seed gives the same files, another one another camera and other colours."""
    for folder, seed in (("same", 8), ("other", 9)):
        other_views.store(tmp_path / folder, seed, (0,))
    names = sorted(path.name for path in (tmp_path / "same" / FOLDER).glob("scene0.*"))
    assert len(names) > 1
    for name in names:
        kept = (views / FOLDER / name).read_bytes()
        assert (tmp_path / "same" / FOLDER / name).read_bytes() == kept
        assert (tmp_path / "other" / FOLDER / name).read_bytes() != kept

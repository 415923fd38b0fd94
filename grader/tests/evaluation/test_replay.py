"""From a failed picture to the pixel: the first wrong value that the report names."""

from __future__ import annotations

import contextlib
import io
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grader.authoring.specimens import mistakes, variants
from grader.build.builder import build
from grader.build.records import Target
from grader.checking.comparison import Wrong
from grader.checking.expected_data import FOLDER
from grader.checking.pictures.judgement import check_picture
from grader.checking.pictures.measure import Envelope
from grader.checking.pictures.worst_pixels import worst_pixels
from grader.checking.records import Evidence, Spot
from grader.checking.student import Student
from grader.course import exercises
from grader.course.message import Message
from grader.course.texts import Texts
from grader.evaluation.grading import grade
from grader.evaluation.records import Finding, Outcome
from grader.evaluation.worst_pixel import with_worst_pixel
from grader.execution.loops import Loops
from grader.execution.session import Library
from grader.execution.worker_process import start_worker
from grader.intake.records import Submission
from grader.report import page, terminal
from grader.tests.support.judging import solution
from grader.tests.support.reports import every_outcome
from grader.tests.support.sampling import sampled

RULES = exercises.load()
KNOWN = {each.id: each for each in mistakes.load()}
# Known mistakes, and a picture in which they show: as many kinds as there are values.
SAMPLE = {
    "camera_axes_swapped": "scene0.flat",
    "raytrace_corner": "scene0.flat",
    "plane_sign": "scene0.mirror",
    "plane_tmax_ignored": "scene4.shadows",
    "sphere_far_root": "scene0.flat",
    "sphere_tmax_kept": "scene0.flat",
    "sphere_normal_not_unit": "scene0.blinn_phong",
    "sphere_no_inside": "scene7.glass",
    "scene_one_object_short": "scene0.flat",
    "cylinder_endless": "scene2.flat",
    "shade_pi_forgotten": "scene0.blinn_phong",
    "light_direction_reversed": "scene0.blinn_phong",
    "light_clamped": "scene4.mirror",
    "checker_truncated": "scene6.blinn_phong",
    "texture_upside_down": "scene6.blinn_phong",
    "shadow_acne": "scene0.shadows",
    "shadow_reversed": "scene0.shadows",
    "reflection_sign": "scene0.mirror",
    "reflection_range_kept": "scene0.fresnel",
    "mirror_kd": "scene0.mirror",
    "schlick_without_power": "scene0.fresnel",
    "fresnel_mirror_missing": "scene0.fresnel",
    "samples_neighbours_blurred": "scene0.smooth",
    "glass_odds_reversed": "scene7.glass",
}
# The others that show in a picture.
OTHERS = {
    "camera_aspect_forgotten": "scene0.flat",
    "camera_aspect_multiplied": "scene0.flat",
    "camera_fov_in_degrees": "scene0.flat",
    "camera_half_angle_forgotten": "scene0.flat",
    "camera_fov_ignored": "scene0.flat",
    "camera_left_right": "scene0.flat",
    "camera_upside_down": "scene0.flat",
    "camera_not_centred": "scene0.flat",
    "camera_from_zero": "scene0.flat",
    "raytrace_row_length": "scene0.flat",
    "raytrace_upside_down": "scene0.flat",
    "raytrace_axes_swapped": "scene0.flat",
    "raytrace_last_row": "scene0.flat",
    "plane_distance_sign": "scene0.flat",
    "plane_behind": "scene0.flat",
    "plane_tmax_kept": "scene4.flat",
    "plane_miss_writes": "scene0.flat",
    "plane_position_from_zero": "scene4.blinn_phong",
    "sphere_discriminant_without_4": "scene0.flat",
    "sphere_radius_not_squared": "scene0.flat",
    "sphere_b_sign": "scene0.flat",
    "sphere_integer_abs": "scene0.flat",
    "sphere_behind": "scene0.shadows",
    "sphere_tmax_ignored": "scene4.mirror",
    "sphere_normal_inwards": "scene0.blinn_phong",
    "sphere_normal_from_zero": "scene0.blinn_phong",
    "sphere_miss_writes": "scene0.flat",
    "scene_first_hit": "scene0.flat",
    "scene_last_hit": "scene0.flat",
    "scene_last_answer": "scene0.flat",
    "trace_hit_not_tested": "scene0.flat",
    "trace_black_sky": "scene0.flat",
    "trace_answers_swapped": "scene0.flat",
    "cylinder_open": "scene5.flat",
    "cylinder_normal_from_base": "scene6.blinn_phong",
    "cone_both_sides": "scene5.flat",
    "cone_normal_flat": "scene5.shadows",
    "cone_open": "scene5.shadows",
    "shade_h_not_unit": "scene0.blinn_phong",
    "shade_h_halved": "scene0.blinn_phong",
    "shade_view_reversed": "scene0.blinn_phong",
    "shade_phong": "scene0.blinn_phong",
    "shade_factor_forgotten": "scene0.blinn_phong",
    "shade_factor_precedence": "scene0.blinn_phong",
    "shade_kd_ks_exchanged": "scene0.blinn_phong",
    "shade_cosine_forgotten": "scene0.blinn_phong",
    "shade_light_colour_forgotten": "scene0.blinn_phong",
    "light_first_only": "scene4.blinn_phong",
    "light_last_only": "scene4.blinn_phong",
    "light_averaged": "scene4.blinn_phong",
    "light_direction_not_unit": "scene0.blinn_phong",
    "light_position_for_direction": "scene0.blinn_phong",
    "light_starts_at_kd": "scene0.blinn_phong",
    "checker_origin_ignored": "scene6.blinn_phong",
    "texture_axes_swapped": "scene6.blinn_phong",
    "shadow_beyond_light": "scene4.shadows",
    "shadow_long_direction": "scene4.shadows",
    "shadow_answer_inverted": "scene0.shadows",
    "shadow_darkens_all": "scene2.shadows",
    "octree_centres_only": "scene3.shadows",
    "octree_leaf_first_hit": "scene3.shadows",
    "octree_stops_at_leaf": "scene3.shadows",
    "schlick_cosine_sign": "scene0.fresnel",
    "schlick_kr_ignored": "scene0.fresnel",
    "schlick_added": "scene0.fresnel",
    "fresnel_lobe_times_ks": "scene0.fresnel",
    "fresnel_lobe_added": "scene0.fresnel",
    "fresnel_mirror_direction": "scene0.fresnel",
    "samples_outside_pixel": "scene0.smooth",
    "samples_all_at_centre": "scene0.smooth",
    "glass_indices_swapped": "scene7.glass",
    "glass_normal_not_turned": "scene7.glass",
}
# What is told of a hit that is not where the object is: that only t is wrong, where that is so.
FALSE_HITS = {
    "plane_sign": "met",  # of rays that go away from it
    "plane_distance_sign": "t",
    "sphere_tmax_kept": "t",  # it is not written at all
    "sphere_behind": "met",
    "sphere_tmax_ignored": "met",
    "cylinder_endless": "elsewhere",
}
SEED = 2015
PIXELS = 12
LINE = "float n_l = vector_dot(n, l);"


class Renderer:
    """One library, that of whole pictures: what a Student asks for here."""

    def __init__(self, core: Library) -> None:
        self.loops = Loops()
        self.is_mixed = False
        self._core = core

    def renderer(self) -> Library:
        """Return the library for whole pictures."""
        return self._core


@contextlib.contextmanager
def drawing(files: Mapping[str, str], cache: Path) -> Iterator[Student]:
    """Return a submission that draws pictures."""
    content = {name: text.encode() for name, text in files.items()}
    (result,) = build(Submission("rendu", content, missing=()), [Target(320, 180)], cache)
    with start_worker(result.preload) as process:
        yield Student(Renderer(Library(process, result)))  # type: ignore[arg-type]


def failing(student: Student, name: str) -> Finding:
    """Return the finding on a picture that is wrong, as the plugin makes it."""
    scene, _, stage = name.removeprefix("scene").partition(".")
    with pytest.raises(Wrong) as raised:
        check_picture(student, int(scene), stage)
    check = "tp3.scene.blinn_phong_0"
    evidence, message = raised.value.evidence, raised.value.message
    return Finding(check, "title", Outcome.FAILED, message, evidence=evidence)


@pytest.mark.parametrize(
    ("name", "picture"),
    sampled({**SAMPLE, **OTHERS}.items(), SAMPLE.items()),
)
def test_the_first_wrong_value_is_that_of_the_mistake(cache: Path, name: str, picture: str) -> None:
    """Where the picture is most wrong, the exercise named is the one the mistake was made in."""
    with drawing(KNOWN[name].files(), cache) as student:
        found = with_worst_pixel(failing(student, picture), student).evidence.pinned
    assert found is not None
    assert found.picture == picture
    assert found.told is not None, "no value is named"
    assert found.told.values["exercise"] == KNOWN[name].exercise, found.told
    if name in FALSE_HITS:
        assert found.told.values["value"] == Message(f"replay.value.{FALSE_HITS[name]}")


@pytest.mark.parametrize(
    "name",
    sampled(
        ["camera_not_unit", "epsilon_1e_5", "lobe_by_the_normal", "options_ignored"],
        ["epsilon_1e_5", "options_ignored"],
    ),
)
def test_nothing_is_wrong_with_what_is_written_differently(cache: Path, name: str) -> None:
    """No value of a right program is named, at random pixels of a stage."""
    right = next(each for each in variants.load() if each.id == name)
    dice = np.random.default_rng(SEED)
    blank = Finding("tp4.scene.mirror_4", "title", Outcome.FAILED)
    with drawing(right.files(), cache) as student:
        for _ in range(PIXELS):
            spot = Spot(
                "scene4.mirror", int(dice.integers(320)), int(dice.integers(180)), (9, 9, 9)
            )
            found = with_worst_pixel(replace(blank, evidence=Evidence(spots=(spot,))), student)
            assert found.evidence.pinned is not None
            told = found.evidence.pinned.told
            # That nothing was drawn like this is told after all else.
            assert told is not None
            assert told.values["value"] == Message("replay.value.pixel"), spot


def test_light_from_behind_that_is_not_clamped(cache: Path) -> None:
    """Neither shade nor direct_light leaves out lights behind the surface: shade comes first."""
    files = solution()
    text = files["raytracer.c"]
    for test in ("if (n_l <= 0.f) {", "if (vector_dot(it->normal, l) <= 0.f) {"):
        assert text.count(test) == 1
        text = text.replace(test, test.replace("0.f", "-2.f"))
    with drawing({**files, "raytracer.c": text}, cache) as student:
        found = with_worst_pixel(failing(student, "scene4.blinn_phong"), student).evidence.pinned
    assert found is not None
    assert found.told is not None
    assert (found.told.values["exercise"], found.told.values["function"]) == ("TP3.1", "shade")


def test_a_failed_picture_has_its_pixel_in_the_results(cache: Path) -> None:
    """The pixel, its first wrong value, and where that is made."""
    with drawing(KNOWN["light_direction_reversed"].files(), cache) as student:
        finding = with_worst_pixel(failing(student, "scene0.blinn_phong"), student)
    found = finding.evidence.pinned
    assert found is not None
    ((result,), _) = grade([finding], RULES, Texts("en"))
    assert result.pixel is not None
    start = f"The pixel that is most wrong: ({found.i}, {found.j}). The first value that goes wrong"
    assert result.pixel.told.startswith(start)
    assert result.pixel.told.endswith("see TP3.2, function direct_light.")


def test_the_report_shows_the_pixel(tmp_path: Path) -> None:
    """On the page with the call that opens the inspector, on the terminal as one line."""
    content = every_outcome("en", tmp_path)
    html = page.render(content, tmp_path)
    told = "The pixel that is most wrong: (3, 4)."
    assert html.count(f'<p class="pixel">{told}</p>') == 1  # of the check that failed
    assert "<code>inspect(&#34;scene0.flat&#34;, (3, 4))</code>" in html
    content["build"]["rejected"] = {}  # of a file that does not compile nothing more is told
    out = io.StringIO()
    terminal.show(content, tmp_path, Texts("en"), out)
    assert out.getvalue().count(told) == 1


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("volatile int *p = 0; *p = 1;", "in shade (raytracer.c:"),
        ("for (volatile int k = 0; k == 0;) {}", "shade"),
    ],
    ids=["crash", "loop"],
)
def test_what_stops_the_replay_is_told(cache: Path, code: str, words: str) -> None:
    """A crash or a loop at the pixel gives its sentence; the finding is what it was."""
    files = solution()
    with drawing(KNOWN["light_direction_reversed"].files(), cache) as student:
        finding = failing(student, "scene0.blinn_phong")
    ends = files["raytracer.c"].replace(LINE, f"{LINE} {code}")
    with drawing({**files, "raytracer.c": ends}, cache) as student:
        after = with_worst_pixel(finding, student)
    assert replace(after, evidence=replace(after.evidence, pinned=None)) == finding
    ((result,), _) = grade([after], RULES, Texts("en"))
    assert result.pixel is not None
    assert "The pixel that is most wrong: (" in result.pixel.told
    assert "The first value" not in result.pixel.told
    assert words in result.pixel.told


def test_without_the_maps_nothing_is_told(cache: Path, tmp_path: Path) -> None:
    """The picture is judged all the same."""
    folder = tmp_path / "expected"
    shutil.copytree(FOLDER / "pictures", folder / "pictures")
    shutil.copyfile(FOLDER / "manifest.json", folder / "manifest.json")
    with drawing(KNOWN["light_direction_reversed"].files(), cache) as student:
        student.folder = folder
        finding = failing(student, "scene0.blinn_phong")
        (folder / "pictures" / "scene0.light.npz").unlink()
        assert with_worst_pixel(finding, student) == finding


def test_pixels_to_look_at_lie_apart_in_the_worst_tile() -> None:
    """The farthest first; where neighbours' rays part ways only if there is nothing else."""
    plane = np.zeros((3, 40, 40), np.float32)
    envelope = Envelope(plane, plane, np.ones((40, 40), bool))
    error = np.zeros((40, 40), np.float32)
    error[20:30, 10:20] = 0.2
    error[25, 15], error[25, 16], error[20, 11] = 0.9, 0.8, 0.5
    assert worst_pixels(error, envelope)[:2] == ((15, 25), (11, 20))
    envelope.calm[25, 15] = False
    assert worst_pixels(error, envelope)[0] == (16, 25)
    assert worst_pixels(np.zeros((40, 40), np.float32), envelope) == ()

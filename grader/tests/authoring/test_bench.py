"""The benchmarks' writers, readers and ratios; never a clock."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TextIO

import pytest

from grader.authoring.bench import (
    inside,
    inspector,
    measure,
    programs,
    report,
    scenes,
    slider,
    watching,
)
from grader.authoring.bench.grading import RUNS, Grading, TimedGrade
from grader.authoring.bench.measure import Counts, Measured
from grader.authoring.bench.programs import BenchError, Cost
from grader.course import exercises
from grader.evaluation import selection
from grader.intake import definitions
from grader.worker import session

LISTED = """\
eye 0 2 -7
center 0 0 2
xdir 1 0 0
ydir 0 1 0
light 4 6 -4 1.5
sphere 0 1 0 0.5 0.8 0.1 0.1 0.25 50
sphere 1 1 0 0.5 0.8 0.1 0.1 0.25 50
plane 0 1 0 0.5 0.7 0.7 0.6 0 20
"""
POVRAY = """\
  Parse Time:       0 hours  0 minutes  0 seconds (0.500 seconds)
              using 1 thread(s) with 0.400 CPU-seconds total
  Bounding Time:    0 hours  0 minutes  0 seconds (0.250 seconds)
              using 1 thread(s) with 0.200 CPU-seconds total
Rays:            1000   Saved:                 0   Max Level: 11/11
Shadow Ray Tests:           2500   Succeeded:                189159
  Trace Time:       0 hours  0 minutes  2 seconds (2.000 seconds)
              using 1 thread(s) with 1.500 CPU-seconds total
"""
COUNTS = Counts(
    objects=1000, rays=3500, tests=2.0, plane_tests=1.0, octree_bytes=140_000, build_bytes=150_000
)


GRADES = {"whole": TimedGrade(2.9, 3.0), "units": TimedGrade(1.9, 2.0), "one": TimedGrade(0.9, 1.0)}
GRADING = Grading(GRADES, limit=2.0, canary=0.1, peak_mb=400.0)


def a_measure(name: str = "flake5") -> Measured:
    """Return a made-up measure of two rounds, with one peer."""
    ours = [Cost(1.0, 0.1), Cost(3.0, 0.1)]
    peer = [Cost(2.0, 0.4, 3500), Cost(4.0, 0.4, 3500)]
    return Measured(name, COUNTS, 4000.0, 0.5, True, {"mrt": ours, "povray": peer})


def written(write: Callable[[scenes.BenchScene, TextIO, float], None], listed: str = LISTED) -> str:
    """Return the file that a writer makes of a listed scene."""
    out = io.StringIO()
    write(scenes.parse(listed.splitlines()), out, 2.0)
    return out.getvalue()


def test_parse_reads_every_kind_of_line() -> None:
    """Objects keep their numbers, and equal materials are one."""
    scene = scenes.parse(LISTED.splitlines())
    assert scene.view["center"] == (0.0, 0.0, 2.0)
    assert scene.lights == [(4.0, 6.0, -4.0, 1.5)]
    assert [place for place, _ in scene.spheres] == [(0, 1, 0, 0.5), (1, 1, 0, 0.5)]
    assert scene.spheres[0][1] is scene.spheres[1][1]
    assert scene.planes == [((0, 1, 0, 0.5), scenes.BenchMaterial((0.7, 0.7, 0.6), 0.0, 20.0))]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("sphere 1 2 3", "not a line of a scene: 'sphere 1 2 3'"),
        ("torus 1", "not a line of a scene: 'torus 1'"),
        ("eye one", "could not convert"),
    ],
)
def test_parse_refuses_what_is_no_scene(line: str, message: str) -> None:
    """A wrong line is named."""
    with pytest.raises(ValueError, match=message):
        scenes.parse([line])


def test_parse_wants_the_whole_camera() -> None:
    """A list that was cut short is no scene."""
    with pytest.raises(ValueError, match="lacks one of eye"):
        scenes.parse(LISTED.splitlines()[:3])


def test_povray_file_holds_the_same_scene_larger() -> None:
    """Lengths are scaled, directions are not, and d changes its sign."""
    text = written(scenes.write_povray)
    assert "max_trace_level 11 adc_bailout 0" in text
    assert "location <0, 2000, -7000> direction <0, 0, 2> right <2, 0, 0> up <0, 1, 0>" in text
    assert "light_source { <4000, 6000, -4000>, rgb 1.5 }" in text
    assert "sphere { <1000, 1000, 0>, 500 texture { Mat0 } }" in text
    assert "plane { <0, 1, 0>, -500 texture { Mat1 } }" in text


def test_povray_mirrors_follow_schlick_unless_matte() -> None:
    """One material mirrors from 0.25 to 1 by a fifth power; the matte one does not."""
    mirror, matte = (
        line for line in written(scenes.write_povray).splitlines() if "#declare" in line
    )
    assert "reflection { rgb 0.25, rgb 1 falloff 5 }" in mirror
    assert "reflection" not in matte


def test_tachyon_file_holds_the_same_scene() -> None:
    """Its camera has the same field of view; its plane is given by a point."""
    text = written(scenes.write_tachyon)
    assert "ZOOM 2 " in text  # half a height of 1 / aspect, at the distance 2
    assert "SPHERE CENTER 1.0 1.0 0.0 RAD 0.5 Mat0" in text
    assert "PLANE CENTER -0 -0.5 -0 NORMAL 0 1 0 Mat1" in text
    assert text.startswith("BEGIN_SCENE\n")
    assert text.endswith("END_SCENE\n")


def test_povray_statistics_are_read() -> None:
    """Parsing and bounding count together; shadow rays are rays."""
    cost = programs.parse_povray(POVRAY)
    assert (cost.render, cost.rays) == (1.5, 3500)
    assert cost.build == pytest.approx(0.6)


@pytest.mark.parametrize("lost", ["Trace Time", "Bounding Time", "Shadow Ray Tests"])
def test_povray_without_statistics_is_an_error(lost: str) -> None:
    """Nothing is taken for zero."""
    with pytest.raises(BenchError, match="povray: no"):
        programs.parse_povray(POVRAY.replace(lost, "something"))


def test_a_program_that_fails_is_named(tmp_path: Path) -> None:
    """Absent, or with a bad exit status."""
    with pytest.raises(BenchError, match="no-such-program: cannot be run"):
        programs.run(["no-such-program"], tmp_path)
    with pytest.raises(BenchError, match="sh: exit status 3: too bad"):
        programs.run(["sh", "-c", "echo too bad; exit 3"], tmp_path)


def test_counts_add_up_the_kinds_of_tests() -> None:
    """Rays are those cast; tests are per ray that is followed."""
    text = (
        "objects 1000\ntests 6000\ntests 1000\nplane_tests 3500\nrays 3500\ncamera_rays 1000\n"
        "reflected_rays 500\nshadow_rays 2000\noctree_bytes 140000\nbuild_bytes 150000\n"
    )
    assert measure.count(programs.parse_numbers(text)) == COUNTS
    with pytest.raises(BenchError, match="'rays'"):
        measure.count(programs.parse_numbers("objects 1000\n"))


def test_ratios_are_medians_of_pairs() -> None:
    """1/2 and 3/4, not the ratio of the medians."""
    assert a_measure().ratio("povray", "render") == pytest.approx(0.625)
    assert a_measure().ratio("povray", "build") == pytest.approx(0.25)
    assert a_measure().median("povray", "render") == pytest.approx(3.0)


def test_the_figures_of_cray_are_scaled_by_povray() -> None:
    """3 s here for 3.72 s there."""
    assert report.scaled_cray(a_measure()) == pytest.approx(7.68 * 3.0 / 3.72)


def goal_values(scene: Measured) -> dict[str, tuple[float, bool]]:
    """Return the goals of a scene by name."""
    return {goal.what: (goal.value, goal.met) for goal in report.goals([scene], {}, GRADING)}


def test_goals_are_met_or_missed() -> None:
    """Each of the numbers, on both sides of its limit."""
    good = goal_values(a_measure())
    assert all(met for _, met in good.values())
    assert good["flake5: tests a ray / without octree"] == (0.0005, True)
    assert good["flake5: octree bytes a sphere"] == (140.0, True)
    worse = replace(COUNTS, rays=3510, tests=5.0, octree_bytes=160_000)
    bad = goal_values(replace(a_measure(), counts=worse, same_picture=False))
    assert {what for what, (_, met) in bad.items() if not met} == {
        "flake5: pictures with and without octree differ",
        "flake5: rays off POV-Ray's, %",
        "flake5: octree bytes a sphere",
        "flake5: tests a ray / without octree",
    }
    slow = report.goals([], {"0": 1.2, "1": float("nan"), "2": 1.0}, GRADING)
    assert [goal.met for goal in slow[:3]] == [False, False, True]
    grades = {**GRADING.grades, "units": TimedGrade(2.1, 2.0)}
    graded = report.goals([], {}, Grading(grades, limit=1.9, canary=0.2, peak_mb=400.0))
    assert [goal.met for goal in graded] == [True, False, True, False, True, False]


def test_an_absent_peer_is_said_and_left_out() -> None:
    """The report stands without any peer."""
    alone = replace(a_measure(), costs={"mrt": [Cost(1.0, 0.1)]})
    text = report.text([alone], {}, GRADING)
    assert text.endswith("Not installed here, and left out: povray, tachyon")
    assert not any("POV-Ray" in what for what in goal_values(alone))


def test_results_are_written_as_json(tmp_path: Path) -> None:
    """Numbers, ratios and goals; no temporary file stays."""
    path = tmp_path / "results.json"
    report.write_json(path, [a_measure()], {"0": 1.0}, GRADING)
    content = json.loads(path.read_text(encoding="utf-8"))
    assert content["schema"] == 1
    assert content["scenes"][0]["bytes_per_object"] == 140
    assert content["octree_ratios"] == {"0": 1.0}
    assert all(goal["met"] for goal in content["goals"])
    assert list(tmp_path.iterdir()) == [path]


def test_the_driver_draws_and_counts(tmp_path: Path) -> None:
    """The octree changes no picture; without it every ray tries every object."""
    driver = programs.build_driver(tmp_path, "counter", (16, 9), counting=True)
    octree, plain = (
        programs.parse_numbers(programs.run([driver, "flake4", *mode], tmp_path).text)
        for mode in ([], ["--plain"])
    )
    assert octree["picture"] == plain["picture"]
    counts = measure.count(plain)
    assert (counts.objects, counts.tests, counts.octree_bytes) == (7382, 7381, 0)
    assert measure.count(octree).tests < 20
    assert measure.count(octree).octree_bytes > 0
    scene = programs.list_scene(driver, "flake4")
    assert (len(scene.spheres), len(scene.planes), len(scene.lights)) == (7381, 1, 3)
    with pytest.raises(BenchError, match="no such scene"):
        programs.list_scene(driver, "99")


def test_the_inspector_is_told_beside_its_goal() -> None:
    """The whole wait decides, where a browser has measured it; or else there is no verdict."""
    kernel = {"kernel median": 0.01, "kernel longest": 0.03}
    click = {"click median": 0.16, "click longest": 0.4}
    slow, quick = ({**kernel, **click, "click median": each} for each in (0.16, 0.14))
    lines = inspector.text({0: slow, 4: quick, 3: kernel}).splitlines()[1:]
    ends = ["goal 150 ms   missed", "goal 150 ms   met", "in the browser: not measured"]
    assert [line.endswith(end) for line, end in zip(lines, ends, strict=True)] == [True] * 3


def test_a_slider_is_told_beside_its_goal() -> None:
    """What a frame adds is paired with the empty slider's round trip; no browser is said."""
    waits = {"empty slider": 0.06, "slider frame": 0.2, "above the empty": 0.14}
    assert slider.text(waits).endswith("140 ms   goal 100 ms   missed")
    assert slider.text({**waits, "above the empty": 0.04}).endswith("40 ms   goal 100 ms   met")
    assert slider.text("no browser").endswith("not measured, no browser")
    assert slider.paired([0.1, 0.9, 0.1], [0.2, 0.95, 0.4]) == pytest.approx(0.1)


def test_the_stopwatch_fits_the_session_s_module() -> None:
    """What is timed compiles, stands around the call of each case, and adds to what was there."""
    text = Path(session.__file__).read_text(encoding="utf-8")
    names: dict[str, Any] = {"__name__": "timed_session"}
    code = compile(inside.with_stopwatch(text), "session.py", "exec")
    exec(code, names)
    page = bytearray(inside.PLACE + 8)
    assert [names["timed"](page, pow, (2, 3)) for _ in range(2)] == [8, 8]
    before = struct.unpack_from("=d", page, inside.PLACE)
    struct.pack_into("=d", page, inside.PLACE, before[0] + 1.0)
    names["timed"](page, pow, (2, 3))
    assert struct.unpack_from("=d", page, inside.PLACE) >= (before[0] + 1.0,)
    with pytest.raises(BenchError, match="has changed"):
        inside.with_stopwatch("nothing is called here")


def test_what_is_timed_is_what_can_be_asked() -> None:
    """The K= of each run is one that `make grade` takes."""
    rules = exercises.load()
    for settings, _ in RUNS.values():
        if words := settings.get("K"):
            assert selection.choose(rules, None, words)


def test_what_is_saved_for_make_watch_changes_one_function() -> None:
    """The one whose verdict is waited for, each time in another way."""
    source = (exercises.ROOT / "reference" / watching.FILE).read_text(encoding="utf-8")
    first, second = (watching.edited(source, number) for number in (1, 2))
    changed = definitions.changed({watching.FILE: first}, {watching.FILE: second})
    assert [each.id for each in changed] == [watching.EXERCISE]
    assert exercises.load().exercise(watching.EXERCISE).tp == watching.TP
    with pytest.raises(BenchError):
        watching.edited("int a;", 1)

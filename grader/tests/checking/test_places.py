"""Where a picture is wrong: places in words and boxes, SSIM; and who does not load scikit-image."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pillow

from grader.authoring.expected.pictures.wrongs import TABLE, WrongProgram
from grader.checking.expected_data import FOLDER
from grader.checking.pictures import expected_files, image_tools, places, views
from grader.checking.pictures.judgement import Judgement, judge
from grader.checking.pictures.plan import ExpectedPicture
from grader.checking.pictures.regions import read_maps
from grader.checking.shapes import Image, Mask
from grader.course.exercises import ROOT
from grader.course.texts import LANGUAGES, Texts
from grader.tests.support.outputs import outputs
from grader.tests.support.sampling import sampled

SHAPE = (180, 320)
WRONGS = sampled(TABLE, TABLE[::5], TABLE[::20])
FLAT = ExpectedPicture(0, "flat")
LOADED = "sorted({name.partition('.')[0] for name in sys.modules} & {'skimage', 'scipy'})"


def blots(*boxes: tuple[int, int, int, int]) -> Mask:
    """Return a mask with boxes in it: first row and column, and those after the last."""
    wrong = np.zeros(SHAPE, bool)
    for bottom, left, top, right in boxes:
        wrong[bottom:top, left:right] = True
    return wrong


def sentence(wrong: Mask, language: str = "en", scene: int | None = None) -> str:
    """Return what is told of a mask, "" for nothing."""
    maps = None if scene is None else read_maps(FOLDER, scene)
    found = places.told(places.find(wrong, maps))
    return Texts(language).say(found.key, **found.values) if found else ""


def recolored(*boxes: tuple[int, int, int, int]) -> Image:
    """Return the flat picture of scene 0 with boxes of another colour."""
    got = expected_files.read_png(FOLDER, FLAT)
    got[blots(*boxes)] = (1, 0, 1)
    return got


def pixels(found: Judgement, role: str) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Return a picture of a judgement, the top row first."""
    with Pillow.open(io.BytesIO(found.images[role])) as file:
        return np.asarray(file)


# ---- In words ------------------------------------------------------------------------------------


def test_specks_that_lie_near_are_one_place_and_lone_ones_are_none() -> None:
    """The largest place first, with its box and the count of its wrong pixels alone."""
    wrong = blots((10, 20, 14, 40), (100, 200, 110, 210), (100, 213, 110, 223), (60, 60, 61, 61))
    first, second = places.find(wrong)
    assert (first.box, first.count) == ((100, 200, 110, 223), 200)
    assert (second.box, second.count) == ((10, 20, 14, 40), 80)


@pytest.mark.parametrize(
    ("box", "words"),
    [
        ((170, 0, 180, 10), "at the top left"),
        ((170, 155, 180, 165), "at the top"),
        ((170, 310, 180, 320), "at the top right"),
        ((85, 0, 95, 10), "on the left"),
        ((85, 155, 95, 165), "in the middle"),
        ((85, 310, 95, 320), "on the right"),
        ((0, 0, 10, 10), "at the bottom left"),
        ((0, 155, 10, 165), "at the bottom"),
        ((0, 310, 10, 320), "at the bottom right"),
    ],
)
def test_a_place_is_told_by_its_third_of_the_picture(
    box: tuple[int, int, int, int], words: str
) -> None:
    """Row 0 is at the bottom, as everywhere."""
    assert sentence(blots(box)) == f"The differences are in one place: {words} (100 pixels)."


def test_what_is_seen_there_is_named() -> None:
    """In both languages, by the names that regions have."""
    wrong = read_maps(FOLDER, 0).of("sphere_red")
    count = int(wrong.sum())
    told = f"at the bottom left, mostly on the red sphere ({count} pixels)."
    assert sentence(wrong, scene=0) == f"The differences are in one place: {told}"
    told = f"en bas à gauche, surtout sur la sphère rouge ({count} pixels)."
    assert sentence(wrong, "fr", scene=0) == f"Les différences sont à un seul endroit : {told}"


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("count", [1, 2, 3, 4, 9])
def test_three_places_are_told_and_the_others_counted(count: int, language: str) -> None:
    """Each with its number, as its box has it."""
    boxes = [(20, 30 * k, 24 + k, 30 * k + 10) for k in range(count)]
    told = sentence(blots(*boxes), language)
    assert told.count("pixels") == min(count, 3)
    assert f"({10 * (3 + count)} pixels)" in told
    assert (str(count) in told.split(":")[0]) == (count > 3)


def test_what_is_wrong_nearly_everywhere_has_no_place() -> None:
    """Nor has what is right; what is strewn from end to end is told so."""
    assert sentence(blots()) == sentence(blots((0, 0, 180, 200))) == ""
    assert "from one end of the picture to the other" in sentence(
        blots((0, 0, 4, 320), (0, 0, 180, 4), (176, 0, 180, 320))
    )


# ---- In pictures ---------------------------------------------------------------------------------


def test_the_places_of_a_wrong_picture_are_boxed_in_its_difference() -> None:
    """As many boxes as places are told, around them, and none elsewhere."""
    found = judge(FOLDER, FLAT, recolored((20, 30, 40, 60), (150, 200, 160, 215)))
    assert found.places is not None
    assert found.places.key == "places.2"
    grey = (pixels(found, "difference") == views.BOX).all(axis=2)[::-1]
    assert grey[20 - 2, 28:62].all()
    assert grey[148:162, 216].all()
    assert not grey[:, 70:190].any()


def test_the_map_of_what_is_alike_is_white_where_it_is() -> None:
    """SSIM, in few levels; dark where something is wrong, most so along its edges."""
    found = pixels(judge(FOLDER, FLAT, recolored((20, 30, 40, 60))), "similarity")[::-1]
    assert found.shape == SHAPE
    assert (found[:, 80:] == 255).all()
    assert found[20, 40:50].max() < found[30, 45] < 200
    assert len(np.unique(found)) <= views.SHADES


def test_what_is_drawn_by_lot_has_no_such_map() -> None:
    """Two right pictures of glass are not alike."""
    glass = ExpectedPicture(7, "glass")
    got = expected_files.read_png(FOLDER, glass)
    got[:, :160] = 0
    assert "similarity" not in judge(FOLDER, glass, got).images


def test_tiny_pictures_are_not_compared_by_windows() -> None:
    """SSIM needs 7 pixels."""
    tiny = np.zeros((4, 9, 3), np.float32)
    assert image_tools.similarity(tiny, tiny) is None


# ---- Without scikit-image ------------------------------------------------------------------------


@pytest.fixture
def without_tools(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Make scikit-image missing, as in an environment made before it was needed."""
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "skimage", None)
        image_tools.are_there.cache_clear()
        yield
    image_tools.are_there.cache_clear()


@pytest.mark.parametrize("wrong", WRONGS, ids=lambda each: f"{each.id}, {each.picture.name}")
def test_without_it_a_picture_is_judged_the_same(
    wrong: WrongProgram, request: pytest.FixtureRequest
) -> None:
    """Same points, same pixels, a sentence all the same; less is shown."""
    got = wrong.drawn()
    whole = judge(FOLDER, wrong.picture, got)
    request.getfixturevalue("without_tools")
    found = judge(FOLDER, wrong.picture, got)
    assert (found.share, found.pixels) == (whole.share, whole.pixels)
    assert found.complaint is not None
    assert set(whole.images) - set(found.images) <= {"similarity"}
    assert "similarity" not in found.images
    assert found.places is None
    assert found.candidates == ()


def ran(code: str, *words: str) -> str:
    """Return what a process of its own prints last."""
    done = subprocess.run(
        [sys.executable, "-c", code, *words],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    return done.stdout.splitlines()[-1]


def test_right_pictures_do_not_load_it() -> None:
    """Every picture that checks look at; a wrong one does."""
    code = f"""
import json, sys
from grader.checking.expected_data import FOLDER
from grader.checking.pictures import expected_files
from grader.checking.pictures.judgement import judge
from grader.checking.pictures.plan import judged
drawn = [expected_files.read_png(FOLDER, each) for each in judged()]
right = [judge(FOLDER, *each).complaint is None for each in zip(judged(), drawn)]
before = {LOADED}
drawn[0][20:40, 30:60] = (1, 0, 1)
wrong = judge(FOLDER, judged()[0], drawn[0]).complaint is not None
print(json.dumps([all(right), before, wrong, {LOADED}]))
"""
    assert json.loads(ran(code)) == [True, [], True, ["scipy", "skimage"]]


def test_a_grade_of_a_right_solution_does_not_load_it(tmp_path: Path, cache: Path) -> None:
    """From the command line to the report, with a picture of TP3."""
    code = f"""
import sys
from grader.commands import main
code = main(sys.argv[1:])
print(code, *{LOADED})
"""
    words = ["grade", "reference", "--build", str(outputs(tmp_path, cache)), "--tp", "3"]
    assert ran(code, *words) == "0"

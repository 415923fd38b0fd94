"""Judging pictures: right ones in any accepted reading pass, and wrong ones are told in words."""

from __future__ import annotations

import io
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pillow

from grader.authoring.expected.pictures import calibration, drift
from grader.authoring.expected.pictures.calibration import MARGIN
from grader.authoring.expected.pictures.make import maps
from grader.authoring.expected.pictures.readings import REFERENCE, Reading
from grader.authoring.expected.pictures.sources import PictureSource, mixtures
from grader.authoring.expected.pictures.texels import texels
from grader.authoring.expected.pictures.wrongs import TABLE, WrongProgram
from grader.checking.expected_data import FOLDER, ExpectedError, read_manifest
from grader.checking.pictures import expected_files
from grader.checking.pictures.judgement import Judgement, judge
from grader.checking.pictures.measure import tile_means, worst_tile
from grader.checking.pictures.plan import ExpectedPicture, everything
from grader.checking.pictures.plan import judged as all_judged
from grader.checking.shapes import Image
from grader.course.texts import LANGUAGES, Texts
from grader.tests.support.sampling import sampled

EN = Texts("en")
# make calibrate goes through all of them too.
WRONGS = sampled(TABLE, TABLE[::2])
# A key or a value that was not filled in, words of French that must be drawn together, gaps.
UNREADABLE = re.compile(r"[{}]|\b(picture|thing|part)\.\w|\b(de les?|à les?) |  |\(\)")


def drawn(scene: int, stage: str) -> Image:
    """Return the reference's picture, which a test may spoil."""
    seed = 1 if stage == "glass" else 0
    return REFERENCE.draw(ExpectedPicture(scene, stage), texels(), seed).copy()


def told(found: Judgement) -> str:
    """Return the sentence of a complaint, in English."""
    assert found.complaint is not None
    return EN.say(found.complaint.key, **found.complaint.values)


def judged(scene: int, stage: str, got: Image, *only: str) -> Judgement:
    """Judge a picture by the stored ones."""
    return judge(FOLDER, ExpectedPicture(scene, stage), got, only)


# ---- What is right -------------------------------------------------------------------------------


@pytest.mark.parametrize("picture", all_judged(), ids=lambda each: each.name)
def test_the_references_own_picture_is_right(picture: ExpectedPicture) -> None:
    """In full, without a word."""
    assert judged(picture.scene, picture.stage, drawn(picture.scene, picture.stage)) == Judgement()


@pytest.mark.parametrize("source", mixtures(3, seed=99), ids=lambda each: each.id)
def test_mixtures_of_accepted_choices_are_right(source: PictureSource) -> None:
    """With other seeds than those that the limits were made and tried with."""
    for picture in (
        ExpectedPicture(0, "shadows"),
        ExpectedPicture(4, "fresnel"),
        ExpectedPicture(4, "smooth"),
    ):
        assert judged(picture.scene, picture.stage, source.draw(picture)).complaint is None


@pytest.mark.parametrize("patch", ["sphere_direct", "offset_along_the_normal"])
def test_roundings_that_grow_from_bounce_to_bounce_are_right(patch: str) -> None:
    """Among spheres that overlap, right programs that ignore the options share few pixels."""
    got = Reading(patch, (patch,)).draw(ExpectedPicture(3, "fresnel"), texels())
    found = judged(3, "shadows", got)
    assert found.complaint is None
    assert found.remark is not None
    assert found.remark.key == "note.later_features"


def test_ks_in_the_lobe_is_right_with_a_note() -> None:
    """The handout makes Fresnel there optional."""
    plain = drawn(4, "fresnel_plain_lobe")
    found = judged(4, "fresnel", plain)
    assert found.complaint is None
    assert found.remark is not None
    assert found.remark.key == "note.plain_lobe"


@pytest.mark.parametrize(
    ("stage", "ahead"),
    [("flat", "fresnel"), ("blinn_phong", "mirror_unshadowed"), ("shadows", "smooth")],
)
def test_later_features_left_on_are_right_with_a_note(stage: str, ahead: str) -> None:
    """A program that ignores the options does not lose its pictures."""
    found = judged(0, stage, drawn(0, ahead))
    assert found.complaint is None
    assert found.remark is not None
    assert found.remark.key == "note.later_features"


def test_only_the_things_asked_for_count() -> None:
    """The globe of scene 6 may be wrong where the floor is judged, and the reverse."""
    got = drawn(6, "blinn_phong")
    got[maps(6)["object"] == 0] = 0.5
    assert judged(6, "blinn_phong", got, "floor", "sphere_checkered").complaint is None
    assert "the globe" in told(judged(6, "blinn_phong", got, "globe"))


# ---- What is wrong as a whole --------------------------------------------------------------------


@pytest.mark.parametrize("stage", ["flat", "blinn_phong", "shadows", "mirror", "fresnel", "smooth"])
@pytest.mark.parametrize("level", [0.0, 0.5, 1.0])
def test_a_picture_of_one_colour_is_worth_nothing(stage: str, level: float) -> None:
    """Black, grey, white: at every stage."""
    found = judged(0, stage, np.full((180, 320, 3), level, np.float32))
    assert found.share == 0
    assert ("all black" if level == 0 else "one single colour") in told(found)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_no_number_is_counted_and_placed(value: float) -> None:
    """Never compared: a NaN is not above any limit."""
    got = drawn(0, "shadows")
    got[20:22, 30:35, 1] = value
    found = judged(0, "shadows", got)
    assert found.share == 0
    assert "first at pixel (30, 20); pixels concerned: 10." in told(found)
    assert set(found.images) == {"expected", "got", "difference", "detail"}


def test_another_size_is_told() -> None:
    """Both sizes, width first."""
    found = judged(0, "flat", np.zeros((90, 160, 3), np.float32))
    assert told(found) == "The picture is 160 x 90 pixels; 320 x 180 is expected."


@pytest.mark.parametrize(
    ("factor", "words"), [(3.14159, "3.14 times too bright"), (0.5, "2 times")]
)
def test_the_factor_of_a_brightness_is_told(factor: float, words: str) -> None:
    """Of what is lit; the sky stays."""
    got = drawn(4, "blinn_phong")
    got[maps(4)["object"] >= 0] *= factor
    assert words in told(judged(4, "blinn_phong", got))


@pytest.mark.parametrize(
    ("stage", "before", "words"),
    [
        ("blinn_phong", "flat", "without the lighting"),
        ("shadows", "blinn_phong", "without the shadows"),
        ("mirror", "shadows", "without the reflections"),
        ("fresnel", "mirror", "without Fresnel"),
        ("smooth", "fresnel", "without the samples"),
    ],
)
def test_the_stage_before_earns_nothing(stage: str, before: str, words: str) -> None:
    """What the stage is about is missing, and named."""
    found = judged(4, stage, drawn(4, before))
    assert found.share == 0
    assert words in told(found)


# ---- What is wrong in parts ----------------------------------------------------------------------


def without(scene: int, thing: int, stage: str = "flat") -> Image:
    """Return the picture in which an object shows the colour that stands around it."""
    got = drawn(scene, stage)
    where = maps(scene)["object"] == thing
    rows = np.flatnonzero(where.any(axis=1))
    for row in rows:
        columns = np.flatnonzero(where[row])
        got[row, columns] = got[row, columns[0] - 2]
    return got


def test_a_missing_object_is_named_and_the_others_are_paid() -> None:
    """A small sphere costs less than half of the points."""
    found = judged(0, "flat", without(0, 1))
    assert told(found) == "This is missing in the picture: the red sphere."
    assert 0.6 < found.share < 0.95


def test_one_missing_shadow_is_named() -> None:
    """Whose it is, and where it should fall."""
    got, bright = drawn(0, "shadows"), drawn(0, "blinn_phong")
    found = maps(0)
    where = (found["object"] == 4) & (found["blocker"][:, :, 0] == 1)
    got[where] = bright[where]
    complaint = judged(0, "shadows", got)
    assert told(complaint) == "The shadow of the red sphere is missing on the floor."
    assert 0.3 < complaint.share < 0.95


def test_acne_is_told_from_shadows() -> None:
    """Dots strewn over the floor on one side, a patch of shadow on the other."""
    got = drawn(0, "shadows")
    floor = (maps(0)["object"] == 4) & (maps(0)["blocker"][:, :, 0] == -1)
    dots = floor & (np.random.default_rng(1).random(floor.shape) < 0.4)
    got[dots] = 0
    assert "Dark dots are strewn over what is lit (the floor)" in told(judged(0, "shadows", got))
    got = drawn(0, "shadows")
    patch = floor.copy()
    patch[:, :160] = False
    got[patch] = 0
    assert "shadow where the light arrives: the floor" in told(judged(0, "shadows", got))


@pytest.mark.parametrize("wrong", WRONGS, ids=lambda each: f"{each.id}, {each.picture.name}")
def test_what_is_wrong_is_said(wrong: WrongProgram) -> None:
    """Its sentence, the thing or part in it, and what is paid all the same."""
    found = wrong.judged()
    assert wrong.complaint(found) == ""
    assert found.complaint is not None
    for language in LANGUAGES:
        sentence = Texts(language).say(found.complaint.key, **found.complaint.values)
        assert sentence[:1].isupper()
        assert sentence[-1] in ".?"
        assert not UNREADABLE.search(sentence), sentence


# ---- What is shown, and the data -----------------------------------------------------------------


def test_the_images_have_the_pictures_size_and_mark_the_worst_tile() -> None:
    """Expected, got, difference at 320x180; the detail holds both sides of one tile, enlarged."""
    found = judged(0, "flat", without(0, 1))
    sizes = {}
    for role, content in found.images.items():
        with Pillow.open(io.BytesIO(content)) as file:
            sizes[role] = file.size
    assert sizes.pop("detail") == (392, 192)
    assert set(sizes.values()) == {(320, 180)}
    with Pillow.open(io.BytesIO(found.images["difference"])) as file:
        pixels = np.asarray(file)
    assert tuple(pixels[0, 0]) == (255, 255, 255)
    assert (pixels == 20).all(axis=2).any()


def test_worst_tile_and_means_of_tiles() -> None:
    """At any place, not only on a grid; the last row of tiles is smaller."""
    wrong = np.zeros((180, 320), bool)
    wrong[37:53, 101:109] = True
    share, (row, column) = worst_tile(wrong)
    assert (share, row) == (0.5, 37)
    assert 93 <= column <= 101
    plane = np.zeros((180, 320), np.float32)
    plane[176:, :16] = 1
    means = tile_means(plane)
    assert (means[176:, :16] == 1).all()
    assert means.sum() == pytest.approx(64)


def test_every_picture_is_stored_with_its_limits() -> None:
    """The manifest says how it was made; packing loses nothing."""
    files = read_manifest(FOLDER / expected_files.FOLDER)["files"]
    for picture in everything():
        rules = files[f"{picture.name}.npz"]
        assert rules["readings"][0] == "reference"
        for name, row in rules["limits"].items():
            assert row["limit"] >= MARGIN * row["worst"], name
            assert row["reason"]
    values = np.random.default_rng(1).integers(0, 65535, (3, 5, 70)).astype(np.uint16)
    np.testing.assert_array_equal(expected_files.unpacked(expected_files.packed(values)), values)
    far = np.array([0.0, 3.3, 999.0, 1e9])
    np.testing.assert_allclose(
        expected_files.distances(expected_files.distances_packed(far)),
        [0, 3.3, 999, 1000],
        rtol=2e-4,
    )


def test_checks_look_at_the_pictures_whose_limits_are_calibrated() -> None:
    """`make calibrate` has tried right programs on each, and on no other."""
    assert {each.name for each in all_judged()} == calibration._table().keys()


@pytest.mark.long
def test_drift_of_pictures_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file that is not the reference's any more, and one too many."""
    shutil.copytree(FOLDER / expected_files.FOLDER, tmp_path / expected_files.FOLDER)
    folder = tmp_path / expected_files.FOLDER
    (folder / "scene9.flat.npz").write_bytes(b"")
    text = (folder / "manifest.json").read_text(encoding="utf-8")
    for name in ("scene0.flat.npz", "scene0.mirror.npz"):
        text = text.replace(f'"{name}"', f'"{name}~"')
    text = text.replace('"scene0.flat.npz~"', '"scene0.mirror.npz"')
    text = text.replace('"scene0.mirror.npz~"', '"scene0.flat.npz"')
    (folder / "manifest.json").write_text(text, encoding="utf-8")
    content = [(folder / f"scene0.{each}.npz").read_bytes() for each in ("flat", "mirror")]
    for each, name in zip(content, ("mirror", "flat"), strict=True):
        (folder / f"scene0.{name}.npz").write_bytes(each)
    assert drift.check(tmp_path) == 1
    said = capsys.readouterr().out
    assert "scene9.flat.npz: missing, or not in the manifest" in said
    assert "scene0.flat.npz has drifted from the reference; run make expected" in said


@pytest.mark.parametrize("name", ["scene0.flat.npz", "scene0.flat.png", "manifest.json"])
def test_a_file_that_is_not_whole_is_refused(tmp_path: Path, name: str) -> None:
    """One line names the file and the cure."""
    shutil.copytree(FOLDER / expected_files.FOLDER, tmp_path / expected_files.FOLDER)
    (tmp_path / expected_files.FOLDER / name).write_bytes(b"spoiled")
    with pytest.raises(ExpectedError, match="make expected") as error:
        judge(tmp_path, ExpectedPicture(0, "flat"), np.zeros((180, 320, 3), np.float32))
    assert name in str(error.value)
    assert "\n" not in str(error.value)

"""Recognising known mistakes in pictures: what is nearly the same, and when nothing is named."""

from __future__ import annotations

import hashlib
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grader.authoring.expected.pictures import drift, lineup
from grader.authoring.expected.pictures.program import RenderProgram
from grader.authoring.expected.pictures.sources import PictureSource
from grader.authoring.expected.pictures.wrongs import TABLE
from grader.authoring.specimens import mistakes
from grader.checking.expected_data import FOLDER, ExpectedError, read_manifest
from grader.checking.pictures import candidates, expected_files
from grader.checking.pictures.judgement import judge
from grader.checking.pictures.neighbours import Surroundings
from grader.checking.pictures.plan import ExpectedPicture, judged
from grader.checking.records import Evidence
from grader.checking.shapes import Image
from grader.course import exercises
from grader.course.message import Message
from grader.evaluation import recognition
from grader.evaluation.recognition import KnownMistake, encode, with_mistakes
from grader.evaluation.records import Finding, Outcome

RULES = exercises.load()
KNOWN = {each.id: each for each in mistakes.load()}
FLAT, ALSO_FLAT, DISTANCE = "tp2.scene.flat_1", "tp2.scene.flat_4", "tp2.intersect_sphere.distance"


def test_a_border_may_move_by_a_pixel_and_no_more() -> None:
    """What lies around a pixel may stand there; another colour may not."""
    right = np.zeros((8, 9, 3), np.int16)
    right[:, 4:] = 100
    around = Surroundings.of(right[:, 2:-2])
    for shift, count in ((0, 0), (1, 0), (-1, 0), (2, 8)):
        assert around.excluding(np.roll(right, shift, axis=1)[:, 2:-2], 4).sum() == count
    strange = right.copy()
    strange[3, 2, 1] = 50
    around = Surroundings.of(right)
    assert np.argwhere(around.excluding(strange, 4)).tolist() == [[3, 2]]
    assert not around.excluding(strange, 60).any()


@pytest.mark.parametrize("radius", [1, 2])
def test_what_is_around_a_pixel_is_its_square_cut_at_the_borders(radius: int) -> None:
    """As the definition says, pixel by pixel, for levels and for colours."""
    rng = np.random.default_rng(3)
    for image in (rng.integers(-9, 300, (7, 9, 3)).astype(np.int16), rng.random((7, 9, 3))):
        around = Surroundings.of(image, radius)
        for j, i in np.ndindex(7, 9):
            rows, columns = (slice(max(at - radius, 0), at + radius + 1) for at in (j, i))
            square = image[rows, columns].reshape(-1, 3)
            assert (around.low[j, i] == square.min(axis=0)).all()
            assert (around.high[j, i] == square.max(axis=0)).all()


def test_mistakes_are_stored_with_the_pictures_that_show_them() -> None:
    """Of those that show, all but a few that crash; nothing where nothing shows."""
    stored_ids = {
        name for picture in judged() for name in candidates.shown_in(FOLDER, picture.name)
    }
    assert stored_ids <= KNOWN.keys()
    assert len(stored_ids) > 0.7 * sum(each.tp > 1 for each in KNOWN.values())
    assert candidates.shown_in(FOLDER, "scene0.fresnel_plain_lobe") == ()


@pytest.mark.parametrize(
    ("name", "picture"),
    [
        ("sphere_radius_not_squared", ExpectedPicture(0, "flat")),
        ("shade_phong", ExpectedPicture(4, "blinn_phong")),
        ("shadow_beyond_light", ExpectedPicture(4, "shadows")),
        ("mirror_single_bounce", ExpectedPicture(4, "mirror")),
    ],
    ids=lambda each: str(each),
)
def test_a_mistake_is_found_in_another_program(name: str, picture: ExpectedPicture) -> None:
    """One in double, built otherwise: its pixels are not the stored ones."""
    source = PictureSource(name, RenderProgram(KNOWN[name].files(), ("-O1",), double=True))
    assert judge(FOLDER, picture, source.draw(picture)).candidates == (name,)


@pytest.mark.parametrize(
    "wrong",
    [each for each in TABLE if each.id in ("recoloured", "red sphere missing", "too bright")],
    ids=lambda each: each.picture.name,
)
def test_what_no_known_mistake_gives_is_not_named(wrong: object) -> None:
    """Nothing is guessed."""
    assert judge(FOLDER, wrong.picture, wrong.drawn()).candidates == ()  # type: ignore[attr-defined]


def with_drawn(folder: Path, picture: ExpectedPicture, drawn: dict[str, Image]) -> None:
    """Put pictures of mistakes in the place of those of a folder of expected data."""
    name = candidates.name_of(picture.name)
    right, expected = expected_files.read_png(folder, picture), expected_files.read(folder, picture)
    content = candidates.encode(drawn, right, expected.envelope)
    (folder / expected_files.FOLDER / name).write_bytes(content)
    rules = read_manifest(folder / expected_files.FOLDER)
    rules["files"][name] = {"sha256": hashlib.sha256(content).hexdigest()}
    text = json.dumps(rules)
    (folder / expected_files.FOLDER / "manifest.json").write_text(text, encoding="utf-8")


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """Return a copy of the pictures' folder."""
    shutil.copytree(FOLDER / expected_files.FOLDER, tmp_path / expected_files.FOLDER)
    return tmp_path


def test_pictures_that_are_alike_are_suspected_together(data: Path) -> None:
    """One that is a little nearer than the other does not win; one that is far is left out."""
    picture = ExpectedPicture(0, "flat")
    got = expected_files.read_png(data, picture)
    got[60:120, 100:200] = (0.9, 0.9, 0.0)
    alike, far = got.copy(), got.copy()
    alike[60, 100:130] = (0.0, 0.9, 0.9)
    far[60:80, 100:200] = (0.0, 0.9, 0.9)
    broken = got.copy()
    broken[0, 0] = np.nan  # the same but for what is no number
    with_drawn(data, picture, {"same": got, "alike": alike, "far": far, "broken": broken})
    expected = expected_files.read(data, picture)
    assert candidates.near(data, expected, got) == ("same", "alike", "broken")
    assert candidates.shown_in(data, picture.name) == ("same", "alike", "far", "broken")
    elsewhere = np.zeros(got.shape[:2], bool)
    elsewhere[60:80, 100:200] = True
    assert candidates.near(data, expected, far, elsewhere) == ("far",)


def test_a_file_of_mistakes_that_is_not_whole_is_refused(data: Path) -> None:
    """One line names it and the cure."""
    picture = ExpectedPicture(0, "flat")
    (data / expected_files.FOLDER / candidates.name_of(picture.name)).write_bytes(b"spoiled")
    with pytest.raises(ExpectedError, match=r"scene0\.flat\.mistakes\.npz.*make expected"):
        candidates.near(
            data, expected_files.read(data, picture), np.ones((180, 320, 3), np.float32)
        )


def test_other_mistakes_make_the_pictures_drift(
    data: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A patch that has changed must be drawn again."""
    monkeypatch.setattr(drift, "everything", lambda: ())
    monkeypatch.setattr(drift, "_maps", lambda *_: [])
    assert drift.check(data) == 0
    now = {**lineup.fingerprints(), "sphere_far_root": "other"}
    monkeypatch.setattr(lineup, "fingerprints", lambda: now)
    assert drift.check(data) == 1
    assert "what the known mistake sphere_far_root draws has drifted" in capsys.readouterr().out


# ---- What is named -------------------------------------------------------------------------------


def seen(check: str, picture: str, *names: str, **fields: object) -> Finding:
    """Return a picture's check that failed with these candidates, or passed without any."""
    outcome = Outcome.FAILED if names else Outcome.PASSED
    found = Finding(check, "title", outcome, pictures=(picture,), candidates=names)
    return replace(found, **fields)  # type: ignore[arg-type]


def with_bank(folder: Path, names: list[str]) -> Path:
    """Return a folder whose known mistakes fail one check of the spheres."""
    signature = recognition.signature([Finding(DISTANCE, "", Outcome.FAILED, Message("failure"))])
    content = encode({name: KnownMistake("TP2.4", signature) for name in names})
    (folder / recognition.BANK).write_bytes(content)
    rules = {"files": {}, "bank": {"sha256": hashlib.sha256(content).hexdigest()}}
    (folder / "manifest.json").write_text(json.dumps(rules), encoding="utf-8")
    return folder


ONE = seen(FLAT, "scene1.flat", "a", "b")
OTHER = seen(ALSO_FLAT, "scene4.flat", "b", "c")
PASSED, UNJUDGED = Finding(DISTANCE, "", Outcome.PASSED), Finding(DISTANCE, "", Outcome.ERROR)


@pytest.mark.parametrize(
    ("findings", "expected"),
    [
        ((ONE,), ("a", "b")),
        ((ONE, OTHER), ("b",)),  # only one gives both
        ((ONE, seen(ALSO_FLAT, "scene4.flat", "c")), ()),
        ((seen(FLAT, "scene1.flat", "a", "b", "c", "d"),), ()),  # too many
        ((ONE, PASSED), ()),  # where each of them would have failed
        ((ONE, replace(PASSED, through=("TP2.1",))), ("a", "b")),
        ((ONE, UNJUDGED), ("a", "b")),
        ((replace(ONE, outcome=Outcome.PASSED),), ()),
    ],
)
def test_what_explains_all_the_pictures_is_named(
    tmp_path: Path, findings: tuple[Finding, ...], expected: tuple[str, ...]
) -> None:
    """And is wrong nowhere else; three at most."""
    (tmp_path / expected_files.FOLDER).mkdir()
    folder = with_bank(tmp_path, ["a", "b", "c", "d"])
    told = with_mistakes(findings, RULES, folder)
    assert told[0].evidence.mistakes == expected
    assert all(each.evidence == Evidence() for each in told if each.check == DISTANCE)


def test_a_mistake_that_would_show_in_a_right_picture_is_not_named(data: Path) -> None:
    """Scene 4 is right, and one of the two draws it otherwise."""
    with_drawn(data, ExpectedPicture(4, "flat"), {"a": np.zeros((180, 320, 3), np.float32)})
    folder = with_bank(data, ["a", "b"])
    told = with_mistakes([ONE, seen(ALSO_FLAT, "scene4.flat")], RULES, folder)
    assert told[0].evidence.mistakes == ("b",)

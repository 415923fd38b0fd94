"""The verdict on a picture: right, right in another reading, or wrong, and then where and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from grader.checking import reproducer
from grader.checking.comparison import Wrong
from grader.checking.pictures import (
    candidates,
    causes,
    expected_files,
    other_views,
    places,
    views,
    whole,
)
from grader.checking.pictures.expected_files import Expected
from grader.checking.pictures.measure import LEVEL, Floats, Measures, measure, outside, worst_tile
from grader.checking.pictures.plan import COURSE, STAGES, ExpectedPicture
from grader.checking.pictures.regions import (
    MATCH,
    SKY,
    Maps,
    PictureParts,
    Region,
    read_maps,
    regions,
    wrong_share,
)
from grader.checking.pictures.worst_pixels import Pixel, worst_pixels, worth_a_look
from grader.checking.records import Evidence, Spot
from grader.checking.shapes import Image, Mask
from grader.checking.student import PICTURE_SIZE, Student
from grader.course.message import Message

EDGES_ONLY = 0.9  # of the points, when all the regions match and only borders are wrong
CHANGED = 3 / 255  # a region that a stage changes by more is the stage's own


@dataclass(frozen=True)
class Judgement:
    """What became of a picture. It is right when there is no complaint."""

    complaint: Message | None = None
    remark: Message | None = None  # the other reading in which it is right
    share: float = 1.0  # of the points
    images: Mapping[str, bytes] = field(default_factory=dict)
    places: Message | None = None  # where it is wrong
    pixels: tuple[Pixel, ...] = ()  # those to look at
    candidates: tuple[str, ...] = ()  # known mistakes that give nearly the same picture


@dataclass(frozen=True)
class _WrongPicture:
    """A wrong picture, and what it is compared with."""

    folder: Path
    expected: Expected
    got: Image
    error: Floats
    measures: Measures
    only: Mask | None


def check_picture(student: Student, scene: int, stage: str, *only: str) -> None:
    """Draw a stage of a scene with the submission, and judge it by its things (`only`, or all).

    A folder of expected data has the archive's pictures, other views, or both. Raises Wrong,
    CallDied.
    """
    picture = ExpectedPicture(scene, stage)
    elsewhere = other_views.are_there(student.folder)
    if expected_files.are_there(student.folder) or not elsewhere:
        _check_here(student, picture, only)
    # Where things stand in another view is not known.
    if elsewhere and not only:
        other_views.check(student, picture)


def _check_here(student: Student, picture: ExpectedPicture, only: Sequence[str]) -> None:
    """Judge a picture of the archive. Raises Wrong, CallDied."""
    texels = expected_files.read_texels(student.folder) if picture.rules.patterned else None
    got = student.picture(picture.scene, texels, None, **picture.options)
    # A picture of one colour, drawn by stubs, shows nothing.
    empty = student.meets_stubs and whole.is_plain(got)
    found = judge(student.folder, picture, got, only, shown=student.is_begun and not empty)
    student.observations.look_at(picture.name, found.candidates)
    if found.remark:
        student.remarks.append(found.remark)
    if found.complaint:
        program = reproducer.of_picture(picture.scene, picture.options, PICTURE_SIZE)
        complaint = Wrong(found.complaint.key, **found.complaint.values)
        spots = tuple(_spot(picture, got, each) for each in found.pixels)
        evidence = Evidence(found.share, program, found.images, found.places, spots=spots)
        raise complaint.showing(evidence)


def _spot(picture: ExpectedPicture, got: Image, pixel: Pixel) -> Spot:
    i, j = pixel
    r, g, b = map(float, got[j, i])
    return Spot(picture.name, i, j, (r, g, b))


def judge(
    folder: Path,
    picture: ExpectedPicture,
    got: Image,
    only: Sequence[str] = (),
    *,
    shown: bool = True,
) -> Judgement:
    """Judge a picture of shape (180, 320, 3), row 0 at the bottom, as the submission left it.

    `folder` is that of the expected data; `only` names the things that count. What takes long of a
    wrong picture (images, pixels, candidates) is made when it is `shown`. Raises ExpectedError.
    """
    expected = expected_files.read(folder, picture)
    size = expected.envelope.calm.shape
    if got.shape != (*size, 3):
        values = {
            "got": " x ".join(map(str, got.shape[1::-1])),
            "expected": f"{size[1]} x {size[0]}",
        }
        return Judgement(Message("picture.size", dict(values)), share=0.0)
    if broken := whole.not_finite(got):
        unseen = Judgement(broken, share=0.0)
        return _with_first_broken(unseen, folder, picture, got) if shown else unseen
    mask = _counted(folder, picture, only)
    error = _outside(got, expected, mask)
    measures = measure(got, expected.envelope, error)
    if measures.exceeds(expected.limits) <= 1:
        return Judgement()
    case = _WrongPicture(folder, expected, got, error, measures, mask)
    if whole.is_plain(got):
        found = Judgement(whole.plain(got), share=0.0)
    else:
        found = _in_another_reading(case) or _wrong(case)
    if not (found.complaint and shown):
        return found
    return _explained(case, found)


def _explained(case: _WrongPicture, found: Judgement) -> Judgement:
    """Add what is shown and told besides: pictures, places, pixels, known mistakes."""
    envelope = case.expected.envelope
    maps = read_maps(case.folder, case.expected.picture.scene)
    where = places.find(worth_a_look(case.error, envelope), maps)
    return replace(
        found,
        images=_images(case, where),
        places=places.told(where),
        pixels=worst_pixels(case.error, envelope),
        candidates=candidates.near(case.folder, case.expected, case.got, case.only),
    )


def _counted(folder: Path, picture: ExpectedPicture, only: Sequence[str]) -> Mask | None:
    """Return where the things that count are; None: everywhere."""
    if not only:
        return None
    maps = read_maps(folder, picture.scene)
    counted: Mask = np.logical_or.reduce([maps.of(name) for name in only])
    return counted


def _outside(got: Image, expected: Expected, mask: Mask | None) -> Floats:
    error = outside(got, expected.envelope)
    if mask is not None:
        error[~mask] = 0
    return error


def _fits(case: _WrongPicture, picture: ExpectedPicture) -> bool:
    """Say whether what was drawn is another expected picture."""
    other = expected_files.read(case.folder, picture)
    error = _outside(case.got, other, case.only)
    return measure(case.got, other.envelope, error).exceeds(other.limits) <= 1


def _in_another_reading(case: _WrongPicture) -> Judgement | None:
    """Accept ks in the lobe, and stages of the same scene with more features, with a note."""
    picture = case.expected.picture
    if picture.plain_lobe and _fits(case, picture.plain_lobe):
        return Judgement(remark=Message("note.plain_lobe"))
    if any(_fits(case, each) for each in picture.later):
        return Judgement(remark=Message("note.later_features"))
    return None


def _wrong(case: _WrongPicture) -> Judgement:
    """Say where a picture is wrong, and what part of the points it earns all the same."""
    picture = case.expected.picture
    if lacking := _lacking(case):
        values: dict[str, object] = {"feature": Message(f"feature.{lacking}")}
        return Judgement(Message("picture.without", values), share=0.0)
    expected = expected_files.read_png(case.folder, picture)
    maps = read_maps(case.folder, picture.scene)
    found = regions(picture, maps, case.expected.envelope.calm)
    if case.only is not None:
        found = [replace(each, mask=each.mask & case.only) for each in found]
        found = [each for each in found if each.mask.any()]
    objects = maps.thing != maps.things.index(SKY)
    wrong = _wrong_pixels(case)
    complaint = whole.explain(case.got, expected, case.expected.envelope, objects)
    complaint = complaint or _cause(case, expected, wrong, maps, found)
    if complaint.key == whole.UNLIT and "shadows" in STAGES[picture.stage]:
        complaint = Message("picture.all_shadow")
    return Judgement(complaint, share=_share(case, expected, wrong, found))


def _lacking(case: _WrongPicture) -> str:
    """Return the stage that a picture still lacks, when it is right but for that one and others."""
    for each in case.expected.picture.earlier:
        if _fits(case, each):
            return COURSE[COURSE.index(each.stage) + 1]
    return ""


def _images(case: _WrongPicture, where: Sequence[places.Place]) -> Mapping[str, bytes]:
    expected = expected_files.read_png(case.folder, case.expected.picture)
    _, worst = worst_tile(np.rint(case.error / LEVEL).astype(np.int32))
    boxes = [each.box for each in where[: places.MOST_TOLD]]
    images = views.images(case.got, expected, case.error, worst, boxes)
    # Of what is drawn by lot, no two pictures are alike.
    return images if case.expected.envelope.by_means else images | views.alike(case.got, expected)


def _wrong_pixels(case: _WrongPicture) -> Mask:
    envelope = case.expected.envelope
    wrong: Mask = (case.error > envelope.far) & envelope.calm
    return wrong


def _cause(
    case: _WrongPicture, expected: Image, wrong: Mask, maps: Maps, found: Sequence[Region]
) -> Message:
    limits = case.expected.limits
    quiet = replace(case.measures, edges=0.0).exceeds(limits) <= 1
    if limits.edges and quiet:
        return Message("picture.jagged")
    calm = case.expected.envelope.calm
    picture = case.expected.picture
    direct = None
    if "reflections" in STAGES[picture.stage] and picture.stage != "glass":
        direct = expected_files.read_png(case.folder, ExpectedPicture(picture.scene, "shadows"))
    scene = PictureParts(picture, case.got, expected, wrong, calm, maps, found, direct)
    return causes.find(scene)


def _share(case: _WrongPicture, expected: Image, wrong: Mask, found: Sequence[Region]) -> float:
    """Return the share of the points: what the stage is about, times what it leaves as it was."""
    before = _stage_before(case)
    counted: dict[bool, list[float]] = {True: [0.0, 0.0], False: [0.0, 0.0]}
    for each in found:
        is_own = bool(np.abs(expected[each.mask] - before[each.mask]).mean() > CHANGED)
        counted[is_own][0] += each.weight
        counted[is_own][1] += each.weight * (wrong_share(each, wrong) <= MATCH)
    (rest, rest_right), (own, own_right) = counted[False], counted[True]
    around = rest_right / rest if rest else 1.0
    if not case.expected.picture.earlier:
        # Around the things of the first stage there is only the sky, which costs its own part.
        around = 1 - rest / (rest + own) * (1 - around)
    return min(around * (own_right / own if own else 1.0), EDGES_ONLY)


def _stage_before(case: _WrongPicture) -> Image:
    """Return the picture of the stage before; before the first one there is the sky alone."""
    picture = case.expected.picture
    if picture.earlier:
        return expected_files.read_png(case.folder, picture.earlier[0])
    return np.broadcast_to(np.array([0.2, 0.2, 0.6], np.float32), case.got.shape)


def _with_first_broken(
    found: Judgement, folder: Path, picture: ExpectedPicture, got: Image
) -> Judgement:
    """Show a picture that has something else than numbers: its first such pixel is the worst."""
    expected = expected_files.read_png(folder, picture)
    broken = np.zeros(got.shape[:2], np.float32)
    broken[~np.isfinite(got).all(axis=2)] = 1
    j, i = map(int, np.argwhere(broken)[0])
    images = views.images(got, expected, broken, (j, i))
    return replace(found, images=images, pixels=((i, j),))

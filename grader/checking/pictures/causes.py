"""Which part of a picture is wrong, and what that points to, in words."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grader.checking.pictures import image_tools
from grader.checking.pictures.measure import FAR_SMOOTH
from grader.checking.pictures.neighbours import Surroundings
from grader.checking.pictures.plan import STAGES
from grader.checking.pictures.regions import (
    HIGHLIGHT,
    LIT,
    MATCH,
    SHADOW,
    SKY,
    UNLIT,
    WHOLE,
    PictureParts,
    Region,
    named,
    of_thing,
    on_thing,
    wrong_share,
)
from grader.checking.pictures.whole import scale_verdict, typical_factor
from grader.checking.shapes import Image, Mask
from grader.course.message import Message
from grader.course.scenes import load

MOST = 0.9  # share that counts as "all"
INSIDE = 0.5  # of what is wrong: more than edges, though no part is wrong as a whole
NEARLY_NONE = 0.02
PRESENT = 0.7  # of the things: displaced rather than missing
REST = 0.1  # share of the picture from which it can be told that the rest is right
FAINT = 0.25  # contrast at a thing's border, over the expected: below, it is not there
ROUGH = 0.5  # how much darkness changes from a pixel to the next, in acne; 0.1 in a shadow
FEWEST_ONCE = 200  # pixels that see one mirror only, and are right
STRANGE = 0.01  # share of colours that are nowhere near, in a picture sampled wrong
DISPLACED = 0.03  # share that a moved light makes brighter, or darker
BRIGHTER = 3 / 255
SAME = 2 / 255


def find(scene: PictureParts) -> Message:
    """Return the sentence on the part that is wrong, and what that points to."""
    if scene.picture.stage == "glass":
        return _glass(scene)
    is_fine = not any(wrong_share(each, scene.wrong) > MATCH for each in scene.regions)
    if is_fine and (scene.wrong & scene.calm).sum() < INSIDE * scene.wrong.sum():
        return Message("picture.rims", {"thing": named(_worst_thing(scene))})
    causes: list[Callable[[PictureParts], Message | None]] = [_missing, _placed, _sampled, _acne]
    if scene.direct is not None and _is_lit_as(scene, scene.direct):
        causes += [_bounces, _reflections]
    else:
        causes += [_ambient, _shadows, _highlights, _unlit, _light]
    for cause in causes:
        if message := cause(scene):
            return message
    return _worst_region(scene)


def _glass(scene: PictureParts) -> Message:
    """Name what is seen through, or else what is wrong besides."""
    name = _worst_thing(scene)
    is_glass = name in load()[scene.maps.scene].transparent
    key = "picture.glass" if is_glass else "picture.glass_elsewhere"
    return Message(key, {"thing": named(name)})


def _worst_thing(scene: PictureParts) -> str:
    counts = {name: scene.share(scene.maps.of(name)) for name in scene.maps.things}
    return max(counts, key=lambda name: counts[name])


def _missing(scene: PictureParts) -> Message | None:
    """Find things that are wrong all over, when the rest but for their shadows is right."""
    maps = scene.maps
    bad = [name for name in maps.things[1:] if _all_wrong(scene, maps.of(name) & scene.calm)]
    if not 0 < len(bad) < len(maps.things) - 1:
        return None
    touched = np.zeros(scene.wrong.shape, bool)
    for name in bad:
        touched |= maps.of(name) | maps.shadow_of(name) | (maps.seen == maps.things.index(name))
    rest = scene.calm & ~touched
    if rest.sum() < REST * scene.calm.sum() or scene.wrong[rest].mean() > NEARLY_NONE:
        return None
    gone = [name for name in bad if _contrast(scene, maps.of(name)) < FAINT]
    if not gone and scene.direct is not None:
        return None  # mirrors that show something else
    key = "picture.missing" if gone else "picture.recolored"
    names = [named(name) for name in gone or bad]
    if len(names) > 1:
        return Message(f"{key}_several", {"first": names[0], "second": names[1]})
    return Message(key, {"thing": names[0]})


def _all_wrong(scene: PictureParts, mask: Mask) -> bool:
    return bool(mask.any()) and scene.wrong[mask].mean() > MOST


def _contrast(scene: PictureParts, mask: Mask) -> float:
    """Return how strongly a thing's border shows, over how strongly it should."""
    right = mask[:, 1:] != mask[:, :-1]
    up = mask[1:] != mask[:-1]
    steps = []
    for image in (np.clip(scene.got, 0, 1), scene.expected):
        across = np.abs(np.diff(image, axis=1))[right].sum()
        steps.append(float(across + np.abs(np.diff(image, axis=0))[up].sum()))
    return steps[0] / max(steps[1], 1e-6)


def _placed(scene: PictureParts) -> Message | None:
    """Find several things that have their colours, but neither place nor size."""
    if scene.picture.stage != "flat":
        return None
    present, displaced = 0, 0
    for each in scene.regions:
        color = np.median(scene.expected[each.mask], axis=0)
        alike = (np.abs(scene.got - color) < SAME).all(axis=2)
        present += bool(alike.any())
        displaced += wrong_share(each, scene.wrong) > MATCH
    if present < PRESENT * len(scene.regions) or displaced < 2:
        return None
    return Message("picture.placed", {"thing": named(_worst_thing(scene))})


def _acne(scene: PictureParts) -> Message | None:
    """Find dark pixels strewn over what is lit."""
    if "shadows" not in STAGES[scene.picture.stage]:
        return None
    lit = scene.kinds(LIT, HIGHLIGHT)
    dark = np.clip(scene.expected - np.clip(scene.got, 0, 1), 0, 1).max(axis=2)
    dark[~lit] = 0
    if scene.share(lit & (dark > BRIGHTER)) < 0.5:
        return None
    steps = np.abs(np.diff(dark, axis=1))[lit[:, 1:] & lit[:, :-1]].sum()
    if steps / max(float(dark.sum()), 1e-6) < ROUGH:
        return None
    return Message("picture.acne", {"thing": named(_thing_most_in(scene, dark > BRIGHTER))})


def _sampled(scene: PictureParts) -> Message | None:
    """Find the samples of a pixel where they should not be: all its colours are near by."""
    if not (scene.picture.is_smooth and image_tools.are_there()):
        return None
    around = Surroundings.of(scene.expected, radius=2)
    strange = around.excluding(np.clip(scene.got, 0, 1), FAR_SMOOTH[0])
    return Message("picture.jagged") if strange.mean() < STRANGE else None


def _ambient(scene: PictureParts) -> Message | None:
    """Find light where none arrives: behind the things and in their shadows alike."""
    unlit = [each for each in scene.regions if each.kind == UNLIT]
    if not unlit or not all(_is_brightened(each, scene) for each in unlit):
        return None
    shadows = [each for each in scene.regions if each.kind == SHADOW]
    if scene.brighter(scene.kinds(LIT)) < 0 or not all(_is_brightened(e, scene) for e in shadows):
        return None
    worst = max(unlit, key=lambda each: scene.share(each.mask))
    return Message("picture.unlit_bright", {"thing": named(worst.thing)})


def _is_brightened(region: Region, scene: PictureParts) -> bool:
    return wrong_share(region, scene.wrong) > 0.5 and scene.brighter(region.mask) > 0


def _is_lit_as(scene: PictureParts, direct: Image) -> bool:
    """Say whether the direct light is there: nowhere is it darker than without mirrors."""
    plain: Mask = scene.calm & ~scene.maps.highlight
    darker = np.max(direct - np.clip(scene.got, 0, 1), axis=2) > 2 * BRIGHTER
    return bool(darker[plain].mean() < NEARLY_NONE)


def _thing_most_in(scene: PictureParts, mask: Mask) -> str:
    counts = {name: int((mask & scene.maps.of(name)).sum()) for name in scene.maps.things}
    return max(counts, key=lambda name: counts[name])


def _shadows(scene: PictureParts) -> Message | None:
    """Find shadows that are missing, too dark, or where there should be none."""
    if "shadows" not in STAGES[scene.picture.stage]:
        return None
    shadows = [each for each in scene.regions if each.kind == SHADOW]
    bad = [each for each in shadows if wrong_share(each, scene.wrong) > 0.5]
    if bad and scene.share(scene.kinds(SHADOW)) > 0.6:
        worst = max(bad, key=lambda each: scene.share(each.mask))
        fallen = on_thing(worst.thing)
        values: dict[str, object] = {"caster": of_thing(worst.caster), "thing": fallen}
        missing = scene.brighter(worst.mask & scene.wrong) > 0
        return Message("picture.shadow_missing" if missing else "picture.shadow_dark", values)
    lit = [each for each in scene.regions if each.kind in (LIT, HIGHLIGHT)]
    dark = [each for each in lit if scene.brighter(each.mask & scene.wrong) < -2 * BRIGHTER]
    bad = [each for each in dark if wrong_share(each, scene.wrong) > 0.02]
    if not bad or typical_factor(scene.got, scene.expected, _known(scene)) is not None:
        return None
    worst = max(bad, key=lambda each: scene.share(each.mask))
    if scene.share(worst.mask) < 0.4 or scene.brighter(scene.wrong) > -BRIGHTER:
        return None
    return Message("picture.shadow_extra", {"thing": named(worst.thing)})


def _known(scene: PictureParts) -> Mask:
    """Return the colours of lit parts whose ratio can be told, shape (height, width, 3)."""
    usable = (scene.expected > 0.08) & (scene.expected < 0.92)
    known: Mask = usable & scene.kinds(LIT)[:, :, None]
    return known


def _highlights(scene: PictureParts) -> Message | None:
    """Find highlights that are wrong alone."""
    bad = [each for each in scene.regions if each.kind == HIGHLIGHT]
    if scene.share(scene.kinds(HIGHLIGHT)) < 0.6 or not bad:
        return None
    worst = max(bad, key=lambda each: scene.share(each.mask))
    bright = scene.brighter(worst.mask & scene.wrong) > 0
    key = "picture.highlight_bright" if bright else "picture.highlight_dark"
    return Message(key, {"thing": named(worst.thing)})


def _unlit(scene: PictureParts) -> Message | None:
    """Find parts that no light reaches wrong, and what is lit right."""
    if scene.share(scene.kinds(UNLIT, SHADOW)) < MOST:
        return None
    bad = [each for each in scene.regions if each.kind in (UNLIT, SHADOW)]
    worst = max(bad, key=lambda each: scene.share(each.mask))
    bright = scene.brighter(worst.mask & scene.wrong) > 0
    key = "picture.unlit_bright" if bright else "picture.unlit_dark"
    return Message(key, {"thing": named(worst.thing)})


def _bounces(scene: PictureParts) -> Message | None:
    """Find only what takes several mirrors to be seen wrong."""
    count = scene.maps.bounces[1 if "fresnel" in STAGES[scene.picture.stage] else 0]
    once = scene.calm & (count == 1)
    if scene.share(count >= 2) < 0.97 or once.sum() < FEWEST_ONCE:
        return None
    return Message("picture.bounces", {"thing": named(_thing_most_in(scene, scene.wrong))})


def _reflections(scene: PictureParts) -> Message | None:
    """Find what a mirror shows too bright or too dark."""
    name = _worst_thing(scene)
    here = scene.wrong & scene.maps.of(name)
    bright = scene.brighter(here) > 0
    values: dict[str, object] = {"thing": named(name)}
    if "fresnel" in STAGES[scene.picture.stage]:
        return Message("picture.fresnel_bright" if bright else "picture.fresnel_dark", values)
    seen = np.bincount(scene.maps.seen[here], minlength=1)
    values["seen"] = of_thing(scene.maps.things[int(seen.argmax())])
    return Message("picture.mirror_bright" if bright else "picture.mirror_dark", values)


def _light(scene: PictureParts) -> Message | None:
    """Find what is lit wrong: by a factor, or as if the light came from elsewhere."""
    if scene.share(scene.kinds(LIT, HIGHLIGHT, SHADOW)) < 0.5:
        return None
    factor = typical_factor(scene.got, scene.expected, _known(scene), exceptions=0.15)
    if factor is not None and abs(factor - 1) > 0.03:
        return scale_verdict("picture.lit_", factor)
    lit = scene.wrong & scene.kinds(LIT, HIGHLIGHT)
    over = np.clip(scene.got, 0, 1)[lit] - scene.expected[lit]
    brighter, darker = (over > BRIGHTER).any(axis=1).mean(), (over < -BRIGHTER).any(axis=1).mean()
    highlights = [each for each in scene.regions if each.kind == HIGHLIGHT]
    if min(brighter, darker) > DISPLACED and any(
        wrong_share(each, scene.wrong) > 0.5 for each in highlights
    ):
        return Message("picture.light_moved")
    return None


def _worst_region(scene: PictureParts) -> Message:
    """Name the part that is most wrong."""
    worst = max(scene.regions, key=lambda each: scene.share(each.mask))
    here = worst.mask & scene.wrong
    share = round(100 * wrong_share(worst, scene.wrong))
    values: dict[str, object] = {"part": worst.words, "share": max(share, 1)}
    if worst.kind == WHOLE:
        key = "picture.sky" if worst.thing == SKY else "picture.part_other"
    else:
        bright = scene.brighter(here) > 0
        key = "picture.part_bright" if bright else "picture.part_dark"
    return Message(key, values)

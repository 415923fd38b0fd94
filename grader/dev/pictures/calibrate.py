"""make calibrate: the limits of pictures, from right programs; and how far mistakes exceed them.

Right programs are the variants of grader/dev/variants/, the reference under other compilers and
flags, and a hundred mixtures of accepted choices drawn by lot, with which nothing is set: they show
that the limits hold for what they were not made from.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from grader.dev import mistakes, variants
from grader.dev.pictures import calibration
from grader.dev.pictures.make import texels
from grader.dev.pictures.program import Order, Program, RenderError
from grader.dev.pictures.readings import REFERENCE, Reading
from grader.expected import FOLDER
from grader.pictures import stored
from grader.pictures.judging import judge
from grader.pictures.measure import Measures, measure, outside
from grader.pictures.plan import JUDGED, SAMPLES, Picture
from grader.shapes import Image

MIXTURES = 100
SOME = 4  # pictures of each mixture
# Right without hit_color, which is what looks for glass.
OPAQUE = frozenset({"options_ignored"})
# Where the mistakes of a TP show.
STAGES_OF_TP: Mapping[int, Sequence[str]] = {
    2: ("flat", "shadows"),
    3: ("blinn_phong",),
    4: ("shadows", "mirror"),
    5: ("fresnel", "smooth", "glass"),
}
SEED = 4  # of the mixtures
Draw = Callable[[Picture], Image]


@dataclass(frozen=True)
class Source:
    """A program that draws: a right one or a mistake."""

    id: str
    draw: Draw


@dataclass(frozen=True)
class Reached:
    """What a source's picture measures."""

    source: str
    picture: Picture
    measures: Measures
    exceeds: float  # the largest measure, over its limit


def right_programs() -> list[Source]:
    """Return what the limits are made from."""
    found = [_by_reading(each) for each in _other_builds()]
    for each in variants.load():
        if each.apart:
            continue  # it draws another stage
        try:
            found.append(by_files(each.id, each.files(), each.flags, each.compiler))
        except RenderError as error:
            print(f"left out: {each.id}: {str(error)[-200:]}")  # C++ alone, for instance
    return found


def mixtures(count: int = MIXTURES, seed: int = SEED) -> list[Source]:
    """Return right programs that mix accepted choices, drawn by lot."""
    lot = np.random.default_rng(seed)
    return [_by_reading(_mixture(lot, k)) for k in range(count)]


def _other_builds() -> Iterator[Reading]:
    yield REFERENCE
    for flags in ("-O0", "-O1", "-O3", "-Os", "-O3 -ffp-contract=fast -mfma", "-O3 -march=native"):
        yield Reading(f"gcc {flags}", flags=tuple(flags.split()))
    yield Reading("clang -O2", compiler="clang")
    yield Reading("clang -O0", compiler="clang", flags=("-O0",))
    yield Reading("epsilon 1e-5", settings={"epsilon": 1e-5})
    yield Reading("epsilon 5e-4", settings={"epsilon": 5e-4})
    yield Reading("depth 9", settings={"max_depth": 9})  # depth >= max_depth is black
    yield Reading("normal, 1e-4", ("offset_normal",))
    yield Reading("samples 5", settings={"samples": 5})


def _mixture(lot: np.random.Generator, number: int) -> Reading:
    """Draw a mixture: sampling, seeds, epsilon, offset, lobe, rays' length, precision, flags."""
    names = []
    flags = [lot.choice(["-O0", "-O1", "-O2", "-O3"])]
    if lot.random() < 0.4:
        names.append("offset_normal")
    if lot.random() < 0.4:
        names.append("lobe_n_v")
    pattern = lot.choice(["", "corner", "end_points", "random", "random", "unclamped"])
    if pattern:
        names.append(f"samples_{pattern}")
    if pattern == "random":
        flags.append(f"-DDRAW={lot.integers(100, 2**31)}")
    if lot.random() < 0.3:
        flags.append(f"-DRAY_TMAX={lot.choice(['1e4f', '1e6f', '1e30f'])}")
    # In the middle of their squares, 2x2 samples do too; elsewhere they are as many as asked for.
    centred = pattern in ("", "unclamped")
    samples = int(lot.integers(2, 5)) if centred else SAMPLES
    settings = {"epsilon": float(10 ** lot.uniform(-4.5, -3)), "samples": samples}
    double = bool(lot.random() < 0.3)
    return Reading(f"mixture {number}", tuple(names), tuple(flags), double, settings)


def _by_reading(reading: Reading) -> Source:
    def draw(picture: Picture) -> Image:
        settings = dict(reading.settings)
        if not picture.is_smooth:
            settings.pop("samples", None)
        seed = 1000 + len(reading.id) if picture.stage == "glass" else 0
        return replace(reading, settings=settings).draw(picture, texels(), seed)

    return Source(reading.id, draw)


def by_files(
    name: str,
    files: Mapping[str, str],
    flags: Sequence[str] = (),
    compiler: str = "",
) -> Source:
    """Return what draws with the student's files of a program. Raises RenderError."""
    program = Program(files, flags, compiler)

    def draw(picture: Picture) -> Image:
        (drawn,) = program.pictures([Order(picture.scene, picture.options)], texels())
        return drawn

    return Source(name, draw)


# ---- Measuring -----------------------------------------------------------------------------------


def measured(sources: Sequence[Source], pictures: Sequence[Picture]) -> list[Reached]:
    """Measure every picture of every source that can be drawn, in the reading asked for."""
    pairs = [(source, picture) for source in sources for picture in pictures]
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        return [each for each in pool.map(lambda pair: _measured(*pair), pairs) if each]


def _measured(source: Source, picture: Picture) -> Reached | None:
    if picture.stage == "glass" and source.id in OPAQUE:
        return None
    expected = stored.read(FOLDER, picture)
    try:
        drawn = source.draw(picture)
    except RenderError as error:
        print(f"left out: {source.id}, {picture.name}: {str(error).splitlines()[0][:200]}")
        return None
    if not np.isfinite(drawn).all():
        return Reached(source.id, picture, Measures(np.inf, np.inf), np.inf)
    found = measure(drawn, expected.envelope, outside(drawn, expected.envelope))
    exceeds = found.exceeds(expected.limits)
    if exceeds > 1 and judge(FOLDER, picture, drawn).remark:
        return None  # right in another reading, which has limits of its own
    return Reached(source.id, picture, found, exceeds)


def worst(reached: Sequence[Reached]) -> dict[str, dict[str, Any]]:
    """Return the worst of each measure by picture, as calibration.json holds it."""
    table: dict[str, dict[str, Any]] = {}
    for each in reached:
        row = table.setdefault(each.picture.name, {})
        for name in calibration.defaults(each.picture):
            value = round(float(getattr(each.measures, name)), 6)
            if value > row.get(name, {"worst": 0.0})["worst"]:
                row[name] = {"worst": value, "variant": each.source}
    return dict(sorted(table.items()))


def set_limits() -> int:
    """Set the limits, then try them; return the exit code."""
    table = worst(measured(right_programs(), JUDGED))
    Path(calibration.TABLE).write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
    calibration.forget()
    too_near = [
        f"{picture.name}, {name}: {row['worst']:g} of {row['limit']:g}, {row['reason']}"
        for picture in JUDGED
        for name, row in calibration.limits(picture).items()
        if row["limit"] > calibration.HIGHEST * calibration.defaults(picture)[name]
    ]
    return report_limits(too_near)


def report_limits(too_near: Sequence[str]) -> int:
    """Print limits and what comes too near to them."""
    for picture in JUDGED:
        for name, row in calibration.limits(picture).items():
            print(f"{picture.name:28} {name:6} worst {row['worst']:<9g} limit {row['limit']:g}")
    for line in too_near:
        print(f"a right program comes within {calibration.MARGIN:g}x of the highest limit: {line}")
    return 1 if too_near else 0


def try_limits() -> int:
    """Judge mixtures and mistakes by the limits; return the exit code."""
    lot = np.random.default_rng(SEED)
    held_out = [
        each
        for source in mixtures()
        for each in measured([source], [JUDGED[k] for k in lot.permutation(len(JUDGED))[:SOME]])
    ]
    failed = {each.source for each in held_out if each.exceeds > 1}
    print(f"mixtures with every picture right: {MIXTURES - len(failed)} of {MIXTURES}")
    for each in held_out:
        if each.exceeds > 1:
            print(f"  {each.source}: {each.picture.name} {each.exceeds:.2f} x the limit")
    print("mistakes, by the picture that shows them most, in multiples of the limit:")
    for each in sorted(strongest(), key=lambda each: each.exceeds):
        print(f"  {each.source:32} {each.picture.name:20} {each.exceeds:8.1f}")
    return 1 if failed else 0


def strongest() -> list[Reached]:
    """Return, for each known mistake that can show in a picture, the one that shows it most."""
    found = []
    for mistake in mistakes.load():
        stages = STAGES_OF_TP.get(mistake.tp, ())
        pictures = [each for each in JUDGED if each.stage in stages]
        reached = measured([by_files(mistake.id, mistake.files())], pictures)
        if reached:
            found.append(max(reached, key=lambda each: each.exceeds))
    return found

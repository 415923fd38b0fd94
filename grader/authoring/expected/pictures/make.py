"""Draws what is accepted, and writes the files that checking/pictures/expected_files.py reads."""

from __future__ import annotations

import io
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image as Pillow
from skimage.segmentation import find_boundaries

from grader.authoring.expected.manifest import put, write_manifest
from grader.authoring.expected.pictures import lineup
from grader.authoring.expected.pictures.calibration import limits
from grader.authoring.expected.pictures.readings import LOBE, REFERENCE, SEEDS, program, readings
from grader.authoring.expected.pictures.texels import texels
from grader.build import toolchain
from grader.checking.expected_data import Array, read_manifest
from grader.checking.npz import archived
from grader.checking.pictures import expected_files
from grader.checking.pictures.expected_files import BRIGHTEST, UNITS, distances_packed, packed
from grader.checking.pictures.measure import tile_means
from grader.checking.pictures.plan import COURSE, STAGES, ExpectedPicture, everything, judged
from grader.checking.shapes import Image, Mask
from grader.checking.student import PICTURE_SIZE
from grader.course import scenes
from grader.sandbox import cores

BAND = 16 / 255  # where samples change a pixel by more, edges are measured
GLOSS = 0.1  # of the specular light, from which on a pixel is in a highlight
NORMAL_UNITS = 32767


def make(folder: Path) -> None:
    """Write the folder of expected pictures: whole, or not at all."""
    with tempfile.TemporaryDirectory(dir=folder.parent) as name:
        part = Path(name) / expected_files.FOLDER
        part.mkdir()
        with ThreadPoolExecutor(cores.usable()) as pool:
            made = [*pool.map(picture_files, everything()), *pool.map(scene_files, scenes.load())]
            made.append(({"texture.png": png(texels()[::-1])}, {}))
            _write(part, made)
            # What mistakes draw is told from what is accepted.
            made += pool.map(partial(lineup.files, Path(name)), judged())
            _write(part, made)
        folder.mkdir(exist_ok=True)
        for old in folder.iterdir():
            old.unlink()
        for each in sorted(part.iterdir()):
            shutil.copyfile(each, folder / each.name)


def _write(folder: Path, made: Sequence[tuple[dict[str, bytes], Mapping[str, Any]]]) -> None:
    """Write files, and their manifest with what it says of each."""
    files: dict[str, Any] = {}
    for contents, rules in made:
        files |= put(folder, contents, rules)
    manifest = {
        "command": "python -m grader.authoring.expected.pictures",
        "size": list(PICTURE_SIZE),
        "compiler": toolchain.find_compiler().version.splitlines()[0],
        "mistakes": lineup.fingerprints(),
        "files": files,
    }
    write_manifest(folder, manifest)


def write_limits(folder: Path) -> None:
    """Put today's limits into the manifest of a folder of expected pictures."""
    content = read_manifest(folder)
    for picture in everything():
        content["files"][f"{picture.name}.npz"]["limits"] = limits(picture)
    write_manifest(folder, content)


@cache
def maps(scene: int) -> Array:
    """Return what stands where in a scene."""
    return program(REFERENCE).maps(scene, texels())


def picture_files(picture: ExpectedPicture) -> tuple[dict[str, bytes], Mapping[str, Any]]:
    """Return the files of a picture by name, and what the manifest says of each."""
    accepted = readings(picture)
    if picture.stage == "glass":
        drawn = [each.draw(picture, texels(), seed) for each in accepted for seed in each.seeds]
        planes = np.clip(np.stack(drawn), 0, 1).transpose(0, 3, 1, 2)
        planes = np.stack([[tile_means(plane) for plane in each] for each in planes])
        drawn = [np.mean(drawn[: len(SEEDS)], axis=0)]
    else:
        drawn = [each.draw(picture, texels()) for each in accepted]
        planes = np.clip(np.stack(drawn), 0, 1).transpose(0, 3, 1, 2)
    stack = planes * UNITS
    low = np.floor(stack.min(axis=0)).astype(np.uint16)
    high = np.ceil(stack.max(axis=0)).astype(np.uint16)
    arrays = {"low": packed(low), "range": packed((high - low).astype(np.uint16))}
    flat_out = picture.stage == "glass"  # means know no edges
    arrays["calm"] = np.packbits(np.ones_like(low[0]) if flat_out else calm(picture))
    if picture.is_smooth:
        arrays |= band(picture, drawn[0])
    names = {f"{picture.name}.npz": archived(arrays)}
    if picture.stage in (*COURSE, "glass"):
        names[f"{picture.name}.png"] = png(drawn[0])
    return names, {"readings": [each.id for each in accepted], "limits": limits(picture)}


def scene_files(scene: int) -> tuple[dict[str, bytes], Mapping[str, Any]]:
    """Return the maps of a scene as a file."""
    found = maps(scene)
    arrays = {
        "object": found["object"].astype(np.int16),
        "t": distances_packed(found["t"]),
        "normal": np.rint(found["normal"] * NORMAL_UNITS).astype(np.int16),
        "blocker": found["blocker"].transpose(2, 0, 1).astype(np.int16),
        "mirrored": found["mirrored"].astype(np.int16),
        "bounces": found["bounces"].transpose(2, 0, 1).astype(np.uint8),
        "highlight": np.packbits(found["highlight"] > GLOSS),
        "kr": np.rint(found["kr"] * 255).astype(np.uint8),
    }
    files = {"maps": arrays, "light": light_arrays(scene, found)}
    return {f"scene{scene}.{name}.npz": archived(each) for name, each in files.items()}, {}


def light_arrays(scene: int, found: Array) -> dict[str, Array]:
    """Return the light at the first hit of each pixel, for the inspector.

    Of shade with Fresnel, `low` and `range` hold the accepted readings: h.v, n.v or ks in the lobe.
    """
    other = program(LOBE).maps(scene, texels())["lit"][:, :, 1]
    plain, ours = found["lit"][:, :, 0], found["lit"][:, :, 1]
    low, high = (each.reduce([plain, ours, other]) for each in (np.minimum, np.maximum))
    planes = {"kd": found["kd"], "fresnel": found["fresnel"], "plain": plain, "low": low}
    units = {name: _in_units(each) for name, each in {**planes, "high": high}.items()}
    units["range"] = units.pop("high") - units["low"]
    arrays = {name: packed(each) for name, each in units.items()}
    arrays["n_l"] = np.rint(np.moveaxis(found["n_l"], -1, 0) * 127).astype(np.int8)
    return arrays


def _in_units(colors: Array) -> Array:
    """Return colours, shape (height, width, ..., 3), as planes (..., 3, height, width)."""
    units = np.rint(np.clip(colors, 0, BRIGHTEST) * UNITS).astype(np.uint16)
    return np.ascontiguousarray(np.moveaxis(units, (0, 1), (-2, -1)))


def calm(picture: ExpectedPicture) -> Mask:
    """Return the pixels whose ray takes the same path as those of their eight neighbours."""
    on = STAGES[picture.stage]
    column = 0
    if on & {"shadows", "reflections", "fresnel"}:
        column = 3 if "fresnel" in on and "reflections" in on else 2 if "reflections" in on else 1
    path = maps(picture.scene)["path"][:, :, column]
    same: Mask = ~find_boundaries(path, connectivity=2, mode="thick")
    return same


def band(picture: ExpectedPicture, smooth: Image) -> dict[str, Array]:
    """Return where samples matter, and the colours there with and without them."""
    plain = replace(REFERENCE, settings={"samples": 1}).draw(picture, texels())
    both = [np.clip(each, 0, 1).reshape(-1, 3) for each in (smooth, plain)]
    pixels = np.flatnonzero((np.abs(both[0] - both[1]) > BAND).any(axis=1))
    values = [np.rint(each[pixels] * UNITS).astype(np.uint16) for each in both]
    return {"band": pixels.astype(np.uint16), "smooth": values[0], "plain": values[1]}


def png(picture: Image) -> bytes:
    """Return a picture as a file, the top row first."""
    pixels = np.rint(np.clip(picture[::-1], 0, 1) * 255).astype(np.uint8)
    memory = io.BytesIO()
    Pillow.fromarray(pixels).save(memory, "PNG", optimize=True)
    return memory.getvalue()

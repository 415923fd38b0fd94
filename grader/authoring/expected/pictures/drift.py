"""Stores the pictures, and says whether they are still what the reference gives."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from grader.authoring.expected.manifest import changed
from grader.authoring.expected.pictures import lineup
from grader.authoring.expected.pictures.calibration import MARGIN, limits
from grader.authoring.expected.pictures.make import make, maps
from grader.authoring.expected.pictures.readings import REFERENCE
from grader.authoring.expected.pictures.texels import texels
from grader.checking.expected_data import FOLDER, read_manifest
from grader.checking.pictures import expected_files
from grader.checking.pictures.measure import measure, outside
from grader.checking.pictures.plan import ExpectedPicture, everything
from grader.course import scenes
from grader.sandbox import cores

MOVED = 0.002  # share of pixels whose object may differ: rounding at edges
LIGHT = 1e-3  # by which what a light adds may differ, colours from 0 to 1


def store(folder: Path) -> None:
    """Make the pictures of a folder of expected data; another folder than ours gets a copy.

    They do not depend on a seed.
    """
    if folder.resolve() == FOLDER:
        make(folder / expected_files.FOLDER)
    else:
        shutil.copytree(
            FOLDER / expected_files.FOLDER, folder / expected_files.FOLDER, dirs_exist_ok=True
        )


def check(folder: Path) -> int:
    """Draw the reference's pictures again and compare; say what has drifted.

    Another compiler may round otherwise: they must stay within half of the limits.
    """
    manifest = read_manifest(folder / expected_files.FOLDER)
    files = {*manifest["files"], "manifest.json"}
    there = {path.name for path in (folder / expected_files.FOLDER).iterdir()}
    drifted = [f"{name}: missing, or not in the manifest" for name in sorted(files ^ there)]
    other = changed(lineup.fingerprints(), manifest.get("mistakes", {}))
    drifted += [f"what the known mistake {name} draws" for name in other]
    with ThreadPoolExecutor(cores.usable()) as pool:
        pairs = [(folder, picture) for picture in everything()]
        drifted += [line for each in pool.map(lambda pair: _picture(*pair), pairs) for line in each]
    drifted += [line for scene in scenes.load() for line in _maps(folder, scene)]
    for line in drifted:
        print(
            f"{folder / expected_files.FOLDER}: {line} has drifted from the reference;"
            " run make expected"
        )
    return 1 if drifted else 0


def _picture(folder: Path, picture: ExpectedPicture) -> Sequence[str]:
    expected = expected_files.read(folder, picture)
    drawn = REFERENCE.draw(picture, texels(), seed=1 if picture.stage == "glass" else 0)
    found = measure(drawn, expected.envelope, outside(drawn, expected.envelope))
    set_now = {name: row["limit"] for name, row in limits(picture).items()}
    kept = {name: getattr(expected.limits, name) for name in set_now}
    wrong = found.exceeds(expected.limits) > 1 / MARGIN or kept != set_now
    return [f"{picture.name}.npz"] if wrong else []


def _maps(folder: Path, scene: int) -> Sequence[str]:
    arrays = expected_files.read_arrays(folder, f"scene{scene}.maps.npz")
    moved = np.mean(arrays["object"] != maps(scene)["object"])
    lines = [f"scene{scene}.maps.npz"] if moved > MOVED else []
    kept = expected_files.read_arrays(folder, f"scene{scene}.light.npz")
    plain = np.clip(maps(scene)["lit"][:, :, 0], 0, expected_files.BRIGHTEST)
    away = np.abs(expected_files.colors(kept["plain"]) - np.moveaxis(plain, (0, 1), (-2, -1)))
    dimmed = np.mean((away > LIGHT).any(axis=(0, 1)))
    return [*lines, *([f"scene{scene}.light.npz"] if dimmed > MOVED else [])]

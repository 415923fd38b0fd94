"""The scenes from another camera and in other colours: what no picture of the archive shows.

    views/scene4.npz            the camera, and the colours of the objects
    views/scene4.shadows.npz    the reference's picture

They lie in a folder of expected data of another seed. A picture is judged roughly there, by the
means of its tiles: that what was drawn for the archive is right is asked of the other pictures.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grader.checking.comparison import Wrong
from grader.checking.expected_data import Array, ExpectedError, arrays_of, rules_of
from grader.checking.pictures import views
from grader.checking.pictures.measure import Floats, tile_means
from grader.checking.pictures.plan import ExpectedPicture
from grader.checking.records import Evidence
from grader.checking.shapes import Image
from grader.checking.student import Student
from grader.execution.session import Library, Session

FOLDER = "views"  # in the folder of expected data
COLORS = ("kd", "kd2")
SAMPLES = 2  # per side of a pixel, where the archive's pictures have more
FAR = 0.05  # of the mean of a tile, in a channel
LOST = 0.5  # of the tiles: a picture that has more of them wrong earns nothing
# Of the tiles: right programs have up to 0.19 of them wrong, the archive's pictures 0.66 and more.
WRONG = 0.35


@dataclass(frozen=True)
class OtherView:
    """A scene as the archive does not show it; `objects` has `kd` and `kd2` of each.

    `texels` are those of scene_texture, if the scene has patterns.
    """

    scene: int
    camera: Array  # the struct's bytes
    objects: dict[str, Array]
    texels: Array | None = None

    def begin(self, session: Session, core: Library) -> None:
        """Lay the scene out; the tree is built once all is in its place."""
        options = session.get("options")
        before = options.copy()
        options["octree"] = 0
        session.set("options", options)
        session.call("setup_scene", self.scene)
        session.set("theCamera", np.frombuffer(self.camera.tobytes(), core.dtype("camera"))[0])
        scene = session.get("scene", int(session.get("object_count")))
        for name, values in self.objects.items():
            scene["mat"][name] = values
        session.set("scene", scene)
        session.set("options", before)
        session.call("scene_changed")


def are_there(folder: Path) -> bool:
    """Say whether a folder of expected data has other views."""
    return (folder / FOLDER).is_dir()


def accepted(picture: ExpectedPicture) -> list[ExpectedPicture]:
    """Return what may be drawn: the picture, or with more features. Roughly, a lobe is a lobe."""
    return [each for each in (picture, *picture.later) if not each.stage.endswith("plain_lobe")]


def settings(picture: ExpectedPicture) -> dict[str, int]:
    """Return the fields of render_options with which a picture is drawn."""
    return {**picture.options, "samples": SAMPLES if picture.is_smooth else 1}


def check(student: Student, picture: ExpectedPicture) -> None:
    """Draw a picture from another camera, and judge it. Raises Wrong, CallDied, ExpectedError."""
    view = _read(student.folder, picture.scene)
    got = student.picture(picture.scene, view.texels, view.begin, **settings(picture))
    drawn = [_picture(student.folder, each) for each in accepted(picture)]
    wrong, expected = min(((_wrong(got, each), each) for each in drawn), key=_share)
    if (share := float(wrong.mean())) > WRONG:
        j, i = map(int, np.argwhere(wrong)[0])
        shown = views.images(got, expected, wrong.astype(np.float32), (j, i))
        complaint = Wrong("picture.other_view", share=round(100 * share))
        raise complaint.showing(Evidence(max(0.0, 1 - share / LOST), images=shown))


def _wrong(got: Image, expected: Image) -> Array:
    """Return which pixels lie in wrong tiles; what is no number is wrong."""

    def means(picture: Image) -> Floats:
        clipped = np.clip(picture, 0, 1)
        return np.stack([tile_means(clipped[:, :, k]) for k in range(3)])

    away: Array = ~(np.abs(means(got) - means(expected)) <= FAR).all(axis=0)
    return away


def _share(pair: tuple[Array, Any]) -> float:
    return float(pair[0].mean())


def _read(folder: Path, scene: int) -> OtherView:
    arrays = _arrays(folder, f"scene{scene}.npz")
    colors = {name: arrays[name] for name in COLORS}
    return OtherView(scene, arrays["camera"], colors, arrays.get("texels"))


def _picture(folder: Path, picture: ExpectedPicture) -> Image:
    levels: Array = _arrays(folder, f"{picture.name}.npz")["picture"]
    return levels.astype(np.float32) / np.float32(255)


def _arrays(folder: Path, name: str) -> Any:
    path = folder / FOLDER / name
    try:
        return arrays_of(path, rules_of(path))
    except KeyError as error:
        raise ExpectedError(path, error) from error

"""The handout's figures and the texture: what the pictures must show, whatever their size."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from grader.authoring.drawings import figures, texture
from grader.authoring.drawings.contact_sheet import to_pixels
from grader.course.exercises import ROOT
from grader.execution.session import Library, open_core

WIDTH, HEIGHT = 160, 90
SKY = (51, 51, 153)

Levels = npt.NDArray[np.int64]
Pictures = dict[str, Levels]


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Draw everything, small, as `make figures` does; hold that every file is named."""
    build = tmp_path_factory.mktemp("les figures")
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        assert figures.main(["--build", str(build), "--width", str(WIDTH)]) == 0
    assert printed.getvalue().split("\n")[:-1] == [
        str(build / "figures" / f"{name}.png")
        for name in [*(figure.name for figure in figures.FIGURES), "contact_sheet"]
    ]
    return build / "figures"


@pytest.fixture(scope="module")
def pictures(out: Path) -> Pictures:
    """Return each picture's levels by name, the BOTTOM row first, as in `output_image`."""
    found = {}
    for figure in figures.FIGURES:
        with Image.open(out / f"{figure.name}.png") as file:
            found[figure.name] = np.asarray(file.convert("RGB")).astype(np.int64)[::-1]
    return found


@pytest.fixture(scope="module")
def core(cache: Path) -> Iterator[Library]:
    """Return the reference solution, small."""
    with open_core(ROOT / "reference", WIDTH, HEIGHT, cache=cache) as opened:
        yield opened


def mask(picture: Levels, color: tuple[int, int, int]) -> npt.NDArray[np.bool_]:
    """Return where a picture has exactly this colour."""
    found: npt.NDArray[np.bool_] = (picture == color).all(axis=-1)
    return found


def bytes_of(*color: float) -> tuple[int, int, int]:
    """Return a colour's levels as ./mrt writes them."""
    red, green, blue = (int(np.float32(v) * np.float32(255)) for v in color)
    return red, green, blue


# ---- The handout's figures -------------------------------------------------------------------


def test_every_picture_has_its_size(out: Path, pictures: Pictures) -> None:
    """Every figure has the size asked for, and the sheet has room for all of them."""
    assert {picture.shape for picture in pictures.values()} == {(HEIGHT, WIDTH, 3)}
    wanted = {
        "figure_3",
        "figure_4",
        "figure_5",
        "figure_9",
        *(f"figure_1_mrt_{k}" for k in "0123"),
    }
    wanted |= {f"figure_{k}_{side}" for k in "678" for side in ("left", "right")}
    assert wanted <= set(pictures)
    with Image.open(out / "contact_sheet.png") as sheet:
        sheet.load()
        assert sheet.width > 4 * 480
        assert sheet.height > 5 * 270
    assert not list(out.glob(".*"))


def test_figure_1_follows_its_formulas(pictures: Pictures) -> None:
    """./mrt 0 to 3: exact pixels, but for gradient rows within one level."""
    j, i = np.mgrid[:HEIGHT, :WIDTH]
    assert mask(pictures["figure_1_mrt_0"], (255, 0, 0)).all()
    box = (i >= WIDTH / 4) & (i <= WIDTH / 3) & (j >= HEIGHT / 5) & (j <= HEIGHT / 4)
    plain = np.where(box[..., None], bytes_of(0.2, 0.6, 0.7), bytes_of(0.7, 0.3, 0.1))
    np.testing.assert_array_equal(pictures["figure_1_mrt_1"], plain)
    share = (j / HEIGHT)[..., None]
    rows = np.trunc(255 * (share * (0, 0, 1) + (1 - share) * (1, 1, 1)))
    assert np.abs(pictures["figure_1_mrt_2"] - rows).max() <= 1
    sun = np.hypot(i - int(4 * WIDTH / 5), j - int(4 * HEIGHT / 5)) < WIDTH / 20
    grass = j <= HEIGHT / 4
    rows[sun] = (255, 255, 0)
    rows[grass] = bytes_of(0.1, 0.8, 0.4)
    assert np.abs(pictures["figure_1_mrt_3"] - rows).max() <= 1
    assert mask(pictures["figure_1_mrt_3"], (255, 255, 0)).sum() == sun.sum()


def test_figure_3_follows_its_formula(pictures: Pictures) -> None:
    """The camera's rays give the handout's red and green; ray (0, 0) is at the bottom left."""
    j, i = np.mgrid[:HEIGHT, :WIDTH]
    red = (i + 0.5 - WIDTH / 2) / (WIDTH / 2) * 0.5 + 0.5
    green = (j + 0.5 - HEIGHT / 2) / (HEIGHT / 2) * 0.5 + 0.5
    expected = np.trunc(255 * np.stack([red, green, np.zeros_like(red)], axis=-1))
    assert np.abs(pictures["figure_3"] - expected).max() <= 1


def test_figure_4_shows_flat_colours_in_their_places(pictures: Pictures) -> None:
    """Sky, floor and the four spheres' kd, and nothing else; red on the left, green on top."""
    picture = pictures["figure_4"]
    names = {
        "sky": SKY,
        "floor": bytes_of(0.5, 0.9, 0.7),
        "grey": bytes_of(0.5, 0.5, 0.5),
        "red": bytes_of(0.9, 0, 0),
        "green": (0, 255, 0),
        "blue": bytes_of(0, 0, 0.6),
    }
    assert {tuple(color) for color in picture.reshape(-1, 3)} == set(names.values())
    row, column = {}, {}
    for name, color in names.items():
        row[name], column[name] = (each.mean() for each in np.nonzero(mask(picture, color)))
    assert column["red"] < column["grey"] < column["blue"]
    assert row["blue"] < row["grey"] < row["green"]
    assert row["floor"] < row["sky"]


def test_figures_5_and_6_add_light_then_shadows(pictures: Pictures) -> None:
    """Light leaves the sky alone and rounds the spheres; shadows only darken, and on the floor."""
    flat, lit, shadowed = (pictures[f"figure_{k}"] for k in ("4", "5", "6_left"))
    assert (mask(lit, SKY) == mask(flat, SKY)).all()
    grey = mask(flat, bytes_of(0.5, 0.5, 0.5))
    assert len(np.unique(lit[grey][:, 0])) > 20
    assert (shadowed <= lit).all()
    floor = mask(flat, bytes_of(0.5, 0.9, 0.7))
    assert not mask(lit, (0, 0, 0))[floor].any()
    assert 0.02 < mask(shadowed, (0, 0, 0))[floor].mean() < 0.2


def test_figure_6_right_has_acne(pictures: Pictures) -> None:
    """Without epsilon, lit points fall into their own shadow, here and there on every sphere."""
    sound, ill, flat = (pictures[f"figure_{k}"] for k in ("6_left", "6_right", "4"))
    assert (ill <= sound).all()
    for color in (bytes_of(0.5, 0.5, 0.5), (0, 255, 0)):
        lit = mask(flat, color) & (sound.max(axis=-1) > 20)
        assert 0.1 < (ill[lit].max(axis=-1) == 0).mean() < 0.9


def test_figure_7_adds_reflections(pictures: Pictures) -> None:
    """Mirrors only add light; Fresnel makes the far floor mirror the sky, the near floor barely."""
    none, plain, fresnel = (pictures[f"figure_{k}"] for k in ("6_left", "7_left", "7_right"))
    assert (plain >= none).all()
    grey = mask(pictures["figure_4"], bytes_of(0.5, 0.5, 0.5))
    assert (plain[grey] - none[grey])[:, 2].mean() > 40
    floor = mask(pictures["figure_4"], bytes_of(0.5, 0.9, 0.7))
    horizon = np.nonzero(floor[:, 0])[0].max()
    added = (fresnel - plain)[..., 2]
    assert added[horizon - 2].mean() > 60
    assert np.median(added[1]) < 30


def test_figure_8_smooths_the_edges_only(pictures: Pictures) -> None:
    """Anti-aliasing changes edges, not the calm rest; scene 4 has its red wall on the right."""
    change = np.abs(pictures["figure_8_left"] - pictures["figure_7_right"]).max(axis=-1)
    assert 0.01 < (change > 8).mean() < 0.15
    assert np.median(change) <= 1
    red, green = (pictures["figure_8_right"][40:, :, c] for c in (0, 1))
    wall = np.nonzero((red > 60) & (green < 30))[1]
    assert wall.mean() > 0.8 * WIDTH


# ---- The project's own scenes ----------------------------------------------------------------


def objects(core: Library, number: int) -> npt.NDArray[Any]:
    """Return the objects of a scene."""
    with core.session(figures.LIMITS) as s:
        assert s.call("setup_scene", number).result
        found: npt.NDArray[Any] = s.get("scene", int(s.get("object_count")))
    return found


@pytest.mark.parametrize("name", ["scene_5", "scene_6", "scene_7", "figure_9", "scene_10"])
def test_own_scenes_are_neither_dark_nor_burnt(pictures: Pictures, name: str) -> None:
    """Bright colours are there, and at most a few highlights are white."""
    brightest = pictures[name].max(axis=-1)
    assert np.percentile(brightest, 90) > 150
    assert (brightest == 255).mean() < 0.05


def test_own_scenes_show_what_they_are_for(core: Library) -> None:
    """Cylinders and cones in 5, patterns in 6, glass and water in 7, all of it on the poster."""
    constant = core.constants
    solids = {constant["CYLINDER"], constant["CONE"]}
    patterns = {constant["PATTERN_CHECKER"], constant["PATTERN_IMAGE"]}
    assert solids <= set(objects(core, 5)["type"])
    assert patterns <= set(objects(core, 6)["mat"]["pattern"])
    indices = {round(float(index), 2) for index in objects(core, 7)["mat"]["refraction_index"]}
    assert indices == {0, 1.33, 1.5}
    poster = objects(core, 10)
    assert solids <= set(poster["type"])
    assert patterns <= set(poster["mat"]["pattern"])
    assert poster["mat"]["refraction_index"].max() == 1.5
    assert (poster["mat"]["kr"].max(axis=-1) > 0.8).any(), "a mirror"


def test_procedural_scene_has_its_generations(core: Library) -> None:
    """Scene 8: a planet and a hundred bushes of 1 + 3 + 9 + 27 + 81 spheres."""
    radii = objects(core, 8)["radius"]
    assert len(radii) == 1 + 100 * 121
    sizes, counts = np.unique(np.round(np.log(radii / radii.max()), 3), return_counts=True)
    assert len(sizes) == 1 + 2 * 5
    assert sorted(counts) == sorted([1, *(n * 3**k for n in (34, 66) for k in range(5))])


@pytest.mark.parametrize("number", [6, 7, 10])
def test_no_checker_border_lies_on_the_floor(core: Library, number: int) -> None:
    """The floor is inside a layer of cubes: rounding cannot decide its colours."""
    found = objects(core, number)
    floor = found[found["type"] == core.constants["PLANE"]][0]
    height = -floor["dist"] - floor["mat"]["pattern_origin"][1]
    layer = float(height / floor["mat"]["pattern_size"])
    assert 0.2 < layer % 1 < 0.8


def test_the_globe_wears_the_texture(core: Library, planet: Levels) -> None:
    """Unlit, the globe of scene 6 shows the map's own colours, north up, in the right place."""
    image = figures.of_scene(6, shading=False)
    with core.session(figures.LIMITS) as s:
        levels = to_pixels(image(core, s), WIDTH, HEIGHT).astype(int)
        camera = s.get("theCamera")
        globe = s.get("scene", 1)[0]
    # The ray through the globe's centre meets the point that faces the camera.
    to_globe = globe["center"] - camera["position"]
    x, y = (to_globe @ camera[axis] / (to_globe @ camera["zdir"]) for axis in ("xdir", "ydir"))
    scale = WIDTH / 2 / np.tan(np.radians(camera["fov"] / 2))
    d = -to_globe / np.linalg.norm(to_globe)
    u, v = 0.5 + np.arctan2(d[0], d[2]) / (2 * np.pi), np.arccos(d[1]) / np.pi
    got = levels[int(HEIGHT / 2 - y * scale), int(WIDTH / 2 + x * scale)]
    row, column = int(v * texture.HEIGHT), int(u * texture.WIDTH)
    near = planet[row - 3 : row + 4, column - 3 : column + 4].reshape(-1, 3)
    assert np.abs(near - got).max(axis=-1).min() <= 1


# ---- The texture -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def planet() -> Levels:
    """Return the map's levels, north first."""
    return texture.planet().astype(np.int64)


def test_committed_texture_is_up_to_date(capsys: pytest.CaptureFixture[str]) -> None:
    """`python -m grader.authoring.drawings.texture` would change nothing; the file is small."""
    assert texture.main(["--check"]) == 0
    assert capsys.readouterr() == ("", "")
    assert texture.TEXTURE.stat().st_size <= 400_000


def test_texture_has_no_seam_and_no_pinch(planet: Levels) -> None:
    """The two ends of a row are as near as neighbours are; a pole is one colour."""
    steps = np.abs(np.diff(planet, axis=1)).mean(axis=(0, 2))
    seam = np.abs(planet[:, 0] - planet[:, -1]).mean()
    assert seam <= np.percentile(steps, 99)
    assert np.ptp(planet[0], axis=0).max() <= 10
    assert np.ptp(planet[-1], axis=0).max() <= 10


def test_texture_has_sea_land_and_snow(planet: Levels) -> None:
    """Blue covers about a half of the sphere, snow some of it, land the rest."""
    area = np.sin((np.arange(texture.HEIGHT) + 0.5) / texture.HEIGHT * np.pi)[:, None]
    area = np.broadcast_to(area, planet.shape[:2]) / (area.sum() * texture.WIDTH)
    red, _, blue = np.moveaxis(planet, -1, 0)
    assert 0.4 < area[(blue > red + 20)].sum() < 0.7
    assert 0.2 < area[(red > blue + 5)].sum() < 0.5
    assert 0.02 < area[planet.min(axis=-1) > 235].sum() < 0.15


def test_texture_drift_is_seen(
    planet: Levels,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """--check lets a rounding pass, and names a changed, a cut and a missing file; exit 1."""
    monkeypatch.setattr(texture, "planet", lambda: planet.astype(np.uint8))
    path = tmp_path / "texture.ppm"
    assert texture.main(["--out", str(path)]) == 0
    whole = path.read_bytes()
    last = whole[-1]
    for content, words in [
        (whole[:-1] + bytes([last - 1]), ""),
        (whole[:-1] + bytes([last ^ 128]), "differs by up to 128 levels"),
        (whole[:-1], "another size or format"),
        (None, "cannot be read (No such file or directory)"),
    ]:
        if content is None:
            path.unlink()
        else:
            path.write_bytes(content)
        assert texture.main(["--check", "--out", str(path)]) == bool(words)
        cure = "run `python -m grader.authoring.drawings.texture`"
        assert capsys.readouterr().err == (f"texture.ppm: {words}; {cure}\n" if words else "")


# ---- Errors ----------------------------------------------------------------------------------


def test_unwritable_output_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file in the place of the build folder, or of the texture's: its name and the cure."""
    blocked = tmp_path / "build"
    blocked.write_text("")
    assert figures.main(["--build", str(blocked)]) == 1
    err = capsys.readouterr().err
    assert err == f"{blocked / 'figures'}: Not a directory; check it, or give --build DIR\n"
    assert texture.main(["--out", str(blocked / "texture.ppm")]) == 1
    err = capsys.readouterr().err
    assert err == "texture.ppm: cannot be written (Not a directory); give a writable --out file\n"
    assert [path.name for path in tmp_path.iterdir()] == ["build"]


def test_a_wrong_width_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """A width without room for a picture is a wrong use."""
    with pytest.raises(SystemExit) as stopped:
        figures.main(["--width", "8"])
    assert stopped.value.code == 2
    assert "--width must be at least 32" in capsys.readouterr().err


def test_a_damaged_texture_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is no picture in texture.ppm stops the figures with one line that names it."""
    damaged = tmp_path / "texture.ppm"
    damaged.write_bytes(b"no picture")
    monkeypatch.setattr(figures, "TEXTURE", damaged)
    scenes = [figure for figure in figures.FIGURES if figure.name == "figure_4"]
    monkeypatch.setattr(figures, "FIGURES", scenes)
    assert figures.main(["--build", str(tmp_path), "--width", "32"]) == 1
    err = capsys.readouterr().err
    assert str(damaged) in err
    assert err.count("\n") == 1

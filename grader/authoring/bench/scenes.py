"""A scene as the driver lists it, and the same for POV-Ray and for Tachyon.

All three draw it alike: pixel centres, no anti-aliasing, lights that do not fade, hard shadows, and
mirrors traced to the same depth whatever they add. Shading differs a little; rays do not.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TextIO

DEPTH = 10  # of ours: a ray that has bounced more often is black
SKY = (0.2, 0.2, 0.6)
# POV-Ray skips what a mirror shows nearer than 1e-3: its file draws the same picture, larger.
POVRAY_SCALE = 1000.0

Vector = tuple[float, ...]
_VIEW = ("eye", "center", "xdir", "ydir")


@dataclass(frozen=True)
class BenchMaterial:
    """Diffuse colour; mirror and specular share, the same for each colour; Blinn's exponent."""

    kd: Vector
    ks: float
    shininess: float


@dataclass(frozen=True)
class BenchScene:
    """What the driver's --list says; lengths in scene units."""

    view: dict[str, Vector]  # eye, center (from the eye to the middle of the picture), xdir, ydir
    lights: list[Vector]  # x, y, z, level
    spheres: list[tuple[Vector, BenchMaterial]]  # x, y, z, radius
    planes: list[tuple[Vector, BenchMaterial]]  # unit normal, then its distance d: p.normal + d = 0


def parse(lines: Iterable[str]) -> BenchScene:
    """Read the driver's list. Raises ValueError, which names the line, when it is none."""
    scene = BenchScene({}, [], [], [])
    shapes = {"sphere": scene.spheres, "plane": scene.planes}
    materials: dict[Vector, BenchMaterial] = {}
    for line in lines:
        word, *rest = line.split()
        numbers = tuple(map(float, rest))
        if word in _VIEW and len(numbers) == 3:
            scene.view[word] = numbers
        elif word == "light" and len(numbers) == 4:
            scene.lights.append(numbers)
        elif word in shapes and len(numbers) == 9:
            key = numbers[4:]
            material = materials.setdefault(key, BenchMaterial(key[:3], *key[3:]))
            shapes[word].append((numbers[:4], material))
        else:
            raise ValueError(f"not a line of a scene: {line.strip()!r}")
    if set(scene.view) != set(_VIEW):
        raise ValueError(f"the scene's list lacks one of {', '.join(_VIEW)}")
    return scene


def _named(scene: BenchScene) -> dict[BenchMaterial, str]:
    found = dict.fromkeys(material for _, material in (*scene.spheres, *scene.planes))
    return {material: f"Mat{number}" for number, material in enumerate(found)}


def _triple(v: Iterable[float]) -> str:
    return "<" + ", ".join(f"{x:.9g}" for x in v) + ">"


def write_povray(scene: BenchScene, out: TextIO, aspect: float) -> None:
    """Write POV-Ray's scene for a picture `aspect` times as wide as high."""
    names = _named(scene)
    out.writelines(line + "\n" for line in _povray_head(scene, aspect))
    for material, name in names.items():
        out.write(f"#declare {name} = {_povray_texture(material)}\n")
    for sphere, material in scene.spheres:
        x, y, z, radius = _scaled(sphere)
        out.write(f"sphere {{ <{x}, {y}, {z}>, {radius} texture {{ {names[material]} }} }}\n")
    for (*normal, dist), material in scene.planes:
        place = f"{_triple(normal)}, {-dist * POVRAY_SCALE:.9g}"
        out.write(f"plane {{ {place} texture {{ {names[material]} }} }}\n")


def _scaled(v: Iterable[float]) -> list[str]:
    return [f"{x * POVRAY_SCALE:.9g}" for x in v]


def _povray_head(scene: BenchScene, aspect: float) -> Iterator[str]:
    yield "#version 3.7;"
    # Its levels count from 1; without a bail-out every mirror is followed, however faint.
    yield f"global_settings {{ assumed_gamma 1 max_trace_level {DEPTH + 1} adc_bailout 0 }}"
    yield f"background {{ rgb {_triple(SKY)} }}"
    # Its picture spans right and up, its plane stands at direction: ours spans 2 xdir.
    right = _triple(2 * x for x in scene.view["xdir"])
    up = _triple(2 * y / aspect for y in scene.view["ydir"])
    eye = ", ".join(_scaled(scene.view["eye"]))
    place = f"location <{eye}> direction {_triple(scene.view['center'])}"
    yield f"camera {{ perspective {place} right {right} up {up} }}"
    for *position, level in scene.lights:
        yield f"light_source {{ <{', '.join(_scaled(position))}>, rgb {level:.9g} }}"


def _povray_texture(material: BenchMaterial) -> str:
    ks = material.ks
    mirror = f"reflection {{ rgb {ks:.9g}, rgb 1 falloff 5 }}" if ks > 0 else ""  # Schlick's
    return (
        f"texture {{ pigment {{ rgb {_triple(material.kd)} }} "
        f"finish {{ ambient 0 diffuse 1 specular {ks:.9g} roughness {1 / material.shininess:.9g} "
        f"{mirror} }} }}"
    )


def write_tachyon(scene: BenchScene, out: TextIO, aspect: float) -> None:
    """Write Tachyon's scene for a picture `aspect` times as wide as high."""
    names = _named(scene)
    out.writelines(line + "\n" for line in _tachyon_head(scene, aspect))
    for material, name in names.items():
        out.write(f"TEXDEF {name} {_tachyon_texture(material)}\n")
    for (x, y, z, radius), material in scene.spheres:
        out.write(f"SPHERE CENTER {x} {y} {z} RAD {radius} {names[material]}\n")
    for (*normal, dist), material in scene.planes:
        foot = _words(-dist * n for n in normal)
        out.write(f"PLANE CENTER {foot} NORMAL {_words(normal)} {names[material]}\n")
    out.write("END_SCENE\n")


def _words(v: Iterable[float]) -> str:
    return " ".join(f"{x:.9g}" for x in v)


def _tachyon_head(scene: BenchScene, aspect: float) -> Iterator[str]:
    view = scene.view
    # Half the picture's height is 1/2 at the distance ZOOM.
    zoom = aspect / 2 * math.sqrt(sum(x * x for x in view["center"]))
    yield "BEGIN_SCENE"
    yield "RESOLUTION 1280 720"
    yield f"CAMERA ZOOM {zoom:.9g} ASPECTRATIO 1.0 ANTIALIASING 0 RAYDEPTH {DEPTH + 1}"
    yield f"CENTER {_words(view['eye'])} VIEWDIR {_words(view['center'])}"
    yield f"UPDIR {_words(view['ydir'])} END_CAMERA"
    yield f"BACKGROUND {_words(SKY)}"
    for *position, level in scene.lights:
        yield f"LIGHT CENTER {_words(position)} RAD 0.001 COLOR {_words([level] * 3)}"


def _tachyon_texture(material: BenchMaterial) -> str:
    return (
        f"AMBIENT 0 DIFFUSE 1 SPECULAR {material.ks:.9g} OPACITY 1 "
        f"PHONG PLASTIC {material.ks:.9g} PHONG_SIZE {material.shininess:.9g} "
        f"COLOR {_words(material.kd)} TEXFUNC 0"
    )

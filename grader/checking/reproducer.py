"""A failing call as a C program: what a student pastes into my_tests.c and runs with `make try`.

The program sets what matters of the scene, makes the one call, and prints what it gives beside what
is expected. Numbers are written so that the very same floats are read back. A `$expected` in the
text stands for that word in the student's language: see `told`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from string import Template
from typing import Any

import numpy as np

from grader.checking import c_literals
from grader.checking.expected_data import SIZE, Array, Batch, counted
from grader.checking.looks import Look, aligned, printing, printing_of, sample_of, setting_before
from grader.course.texts import Texts
from grader.intake.header_numbers import header_number

MAX_OBJECTS = 40  # of a scene: a longer program helps nobody
# Neither materials, lights nor options play a part in these, unless the material is looked at.
_GEOMETRY = {"camera_ray", "in_shadow", "reflected_ray", "octree_intersect", "box_overlaps_object"}
_CAMERA = ("camera_ray", "raytrace", "pixel_color")
# The functions that come before any shading, and the options that they heed without it.
_FLAT = ("", "trace_ray", "pixel_color")
_FLAT_OPTIONS = ("shading", "samples", "max_depth")
EXPECTED = "reproducer.expected"  # the key of what stands before an expected value
_TYPES = {"light_color": "color", "kr": "color", "p": "point3", "center": "point3"}
_GREY = "init_material(vector_init(0.5f, 0.5f, 0.5f), vector_init(0.f, 0.f, 0.f), 1.f)"
_FRAME = """\
/* {command} */
#include "raytracer.h"

#include <stdio.h>

int main(void) {{
{body}
    return 0;
}}
"""


def told(program: str, texts: Texts) -> str:
    """Return a program with its words in a language."""
    return Template(program).safe_substitute(expected=texts.get(EXPECTED))


def told_again(program: str, word: str, texts: Texts) -> str:
    """Return a program in another language; `word` is what stands in it before expected values."""
    return program.replace(f"/* {word} ", f"/* {texts.get(EXPECTED)} ") if word else program


def of_case(batch: Batch, case: int, hidden: Sequence[str], *looks: Look) -> str:
    """Return the program of one call of a batch; "" when its scene is too long to read.

    Parameters in `hidden` are only written by the function.
    """
    if len(batch.globals.get("scene", ())) > MAX_OBJECTS:
        return ""
    writer = _Writer(batch.function, looks)
    return _program(
        SIZE if batch.function in _CAMERA else None,
        [*writer.setting(batch.globals), *writer.arguments(batch, case, hidden)],
        [*setting_before(looks), *writer.call(batch, looks)],
    )


def of_drawing(
    name: str,
    size: tuple[int, int],
    args: Sequence[Any],
    pixel: tuple[int, int] = (0, 0),
    before: Any = (0, 0, 0),
    expected: Any = None,
) -> str:
    """Return the program of a call of TP1 on an image of one colour, and what a pixel becomes."""
    i, j = pixel
    # As many digits as the report shows: the noise that stood there has more than one can read.
    before, expected = (
        each if each is None else c_literals.short(each) for each in (before, expected)
    )
    fill = f"output_image[k] = {c_literals.vector(before)};"
    values = ", ".join(["output_image", *(c_literals.literal(each) for each in args)])
    looks = aligned([(printing(f"pixel ({i}, {j})", "pixel", np.zeros(3)), expected)])
    return _program(
        size,
        [f"for (int k = 0; k < WIDTH * HEIGHT; k++) {{\n        {fill}\n    }}"],
        [f"{name}({values});", f"color pixel = output_image[{j} * WIDTH + {i}];", *looks],
    )


def of_command(name: str, args: Sequence[Any], setting: Batch | None = None, *looks: Look) -> str:
    """Return the program of a call in the setting of a batch, whose looks are C expressions."""
    settings = setting.globals if setting else {}
    if len(settings.get("scene", ())) > MAX_OBJECTS:
        return ""
    call = f"{name}({', '.join(c_literals.literal(each) for each in args)});"
    rows = [(printing(each.pick, each.pick, each.expected), each.expected) for each in looks]
    return _program(SIZE, [*_Writer("").setting(settings)], [call, *aligned(rows)])


def command_of(scene: int) -> str:
    """Return the words that draw a scene with the program."""
    return f"./mrt {scene + int(header_number('FIRST_RAYTRACED_SCENE'))} image"


def of_picture(scene: int, settings: Mapping[str, Any], size: tuple[int, int]) -> str:
    """Return the program that draws a scene with other fields of `options`, and ./mrt's words."""
    pairs = [*c_literals.settings(settings)]
    words = " ".join([command_of(scene), *(word for _, word in pairs)])
    fields = [statement for statement, _ in pairs]
    return _program(
        size,
        [f"setup_scene({scene});", *fields, "scene_changed();"],
        [f"/* {words} */", "raytrace();"],
    )


def _program(
    size: tuple[int, int] | None, setting: Sequence[str], statements: Sequence[str]
) -> str:
    command = f"make try WIDTH={size[0]} HEIGHT={size[1]}" if size else "make try"
    parts = ["\n".join(f"    {line}" for line in part) for part in (setting, statements) if part]
    return _FRAME.format(command=command, body="\n\n".join(parts))


class _Writer:
    """Declarations and calls; materials are declared once and named."""

    def __init__(self, function: str, looks: Sequence[Look] = ()) -> None:
        self.function = function
        self._is_geometry = function.startswith("intersect_") or function in _GEOMETRY
        self._is_grey = self._is_geometry and not any(".mat" in each.pick for each in looks)
        self._fields = ["refraction_index", "pattern", "kd2", "pattern_origin", "pattern_size"]
        self._fields += [name for name in ("kr", "user") if _is_looked_at(name, looks)]
        self._is_seeded = function == "glass_color" or _is_looked_at("seed", looks)
        self._materials: dict[tuple[str, ...], str] = {}

    def setting(self, settings: Mapping[str, Array]) -> Iterator[str]:
        """Yield what sets the globals that matter."""
        if self.function in ("", *_CAMERA) and "theCamera" in settings:
            yield f"theCamera = {c_literals.camera(settings['theCamera'])};"
        if not self._is_geometry and "options" in settings:
            options = settings["options"]
            # Before hit_color has looked at `shading`, these look at nothing else.
            is_flat = self.function in _FLAT and not options["shading"]
            yield from c_literals.options(options, _FLAT_OPTIONS if is_flat else ())
            self._fields += (
                ["kr"] if options["fresnel"] and self.function != "refracted_ray" else []
            )
            for each in () if is_flat else settings.get("lights", ()):
                where, color = (c_literals.vector(each[name]) for name in ("position", "col"))
                yield f"add_light({where}, {color});"
            if "num_lights" in settings and not is_flat:
                yield f"num_lights = {counted(settings, 'lights')};"
        for each in settings.get("scene", ()):
            material, lines = self._material(each["mat"])
            yield from lines
            yield f"add_object({c_literals.solid(each, material)});"
        if "object_count" in settings:
            yield f"object_count = {counted(settings, 'scene')};"
        if "texels" in settings:
            yield from c_literals.texture(settings["texels"])

    def arguments(self, batch: Batch, case: int, hidden: Sequence[str]) -> Iterator[str]:
        """Yield the declarations of a call's parameters."""
        for name, column in batch.args.items():
            item = column[case]
            names = item.dtype.names or ()
            if "orig" in names:
                yield from (
                    [f"ray {name} = {{0}};"]
                    if name in hidden
                    else c_literals.ray(name, item, self._is_seeded)
                )
            elif "normal" in names and "mat" in names and "type" not in names:
                yield f"intersection {name} = {{0}};"
                if name not in hidden:
                    yield from self._intersection(name, item)
            elif "type" in names:
                material, lines = self._material(item["mat"])
                yield from lines
                yield f"object {name} = {c_literals.solid(item, material)};"
            elif "shininess" in names:
                yield from c_literals.material(name, item, self._fields)
            elif names:  # a box or a light: two vectors
                kind = "box" if "min" in names else "light"
                parts = ", ".join(c_literals.vector(item[each]) for each in names)
                yield f"{kind} {name} = {{{parts}}};"
            else:
                kind = _TYPES.get(name, "vec3") if item.ndim else c_literals.kind(item)
                yield f"{kind} {name} = {c_literals.literal(item)};"

    def call(self, batch: Batch, looks: Sequence[Look]) -> Iterator[str]:
        """Yield the call, and the printing of what it gives."""
        values = [f"&{key}" if each.dtype.names else key for key, each in batch.args.items()]
        result = batch.answers[0].result if batch.answers else None
        if self.function == "octree_intersect":
            yield "octree_node *node = octree_build(scene, object_count);"
            values.insert(0, "node")
        call = f"{self.function}({', '.join(values)});"
        if result is None:
            yield call
        else:
            kind = "color" if result.ndim > 1 else c_literals.kind(result[0])
            yield f"{kind} result = {call}"
            if all(each.pick != "result" for each in looks):
                looks = [Look("result"), *looks]
        for each in looks:
            if each.unit:
                yield f"vec3 direction = vector_normalized({each.pick});"
        rows = [(printing_of(each, sample_of(batch, each.pick)), each.expected) for each in looks]
        yield from aligned(rows)

    def _intersection(self, name: str, item: Any) -> Iterator[str]:
        yield f"{name}.position = {c_literals.vector(item['position'])};"
        yield f"{name}.normal = {c_literals.vector(item['normal'])};"
        if not self._is_geometry:
            material, lines = self._material(item["mat"])
            yield from lines
            yield f"{name}.mat = {material};"

    def _material(self, item: Any) -> tuple[str, list[str]]:
        """Return the name of a material, and its declaration when it is new."""
        name = "mat" if not self._materials else f"mat_{len(self._materials) + 1}"
        lines = (
            [f"material mat = {_GREY};"]
            if self._is_grey
            else [*c_literals.material("$", item, self._fields)]
        )
        known = self._materials.get(tuple(lines))
        if known:
            return known, []
        self._materials[tuple(lines)] = name
        return name, [line.replace("$", name) for line in lines]


def _is_looked_at(field: str, looks: Sequence[Look]) -> bool:
    return any(each.pick.endswith(f".{field}") for each in looks)

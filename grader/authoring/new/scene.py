"""A new scene: how it is built, and what is said of it; its pictures are drawn by make expected."""

from __future__ import annotations

import re

from grader.authoring.new.edits import MARK, Edit, NewError, behind, read
from grader.checking.reproducer import command_of
from grader.intake.header_numbers import header_number

SOURCE = "core_c/scene.c"
USAGE = "core_c/utils.h"
TABLE = "grader/course/scenes.toml"
_LAST = re.compile(r"scene_(\d+)(?=\};)")  # of the table in setup_scene
# In the program's help: how many there are, then what each is, in every language.
_COUNTED = re.compile(r'(?P<first>" +)(?P<from>\d+ \S+ )\d+(?P<words>  .* 0 \S+ )\d+(?=\W)')
_DESCRIBED = re.compile(r'(?P<margin>" +)(?P<what>\d+ [^"\n]*?, (?P<last>\d+) [^",]*)\\n"')


def edits(number: str) -> list[Edit]:
    """Return the files of a new scene. Raises NewError."""
    text = read(SOURCE)
    found = _LAST.search(text)
    if not found:
        raise NewError(f"{SOURCE}: setup_scene has no table of scenes")
    last = int(found[1])
    if number != str(last + 1):
        raise NewError(f"SCENE={number}: the next one is {last + 1}")
    text = _LAST.sub(f"scene_{last}, scene_{number}", text)
    before = rf"^static void scene_{last}\(void\) \{{\n(?:.*\n)*?\}}\n"
    return [
        Edit(SOURCE, behind(SOURCE, text, before, _function(number))),
        Edit(TABLE, f"{read(TABLE).rstrip()}\n{_rules(number)}"),
        Edit(USAGE, _usage(read(USAGE), last)),
    ]


def then(number: str) -> list[str]:
    """Return the commands that draw it, and what asks for one of its pictures."""
    picture = f"PICTURE=scene{number}.shadows"
    asked = f"make new CHECK=tp4.scene.shadows_{number} {picture} EXERCISE=TP4.1"
    drawn = f"make mrt SRC=reference && {command_of(int(number))}"
    return ["make skeleton", drawn, f"make expected PICTURE=scene{number}", asked]


def _function(number: str) -> str:
    ball = "init_sphere(0.f, 0.1f, 0.f, 0.3f, plastic(0.5f, 0.5f, 0.5f))"
    floor = "init_plane(0.f, 1.f, 0.f, 0.2f, plastic(0.5f, 0.9f, 0.7f))"
    return f"""
static void scene_{number}(void) {{
    handout_camera();
    add_light(vector_init(-200.f, 170.f, 300.f), grey(2.f));
    add_object({ball}); /* {MARK} its objects, lights and camera */
    add_object({floor});
}}
"""


def _rules(number: str) -> str:
    """Return what scenes.toml says of it."""
    stages = "those that checks ask for, and what may be drawn instead"
    return f"""
[scene.{number}]
stages = ["short"] # {MARK} {stages}
things = ["sphere_grey", "floor"] # {MARK} its objects, in their order
"""


def _usage(text: str, last: int) -> str:
    """Return the program's help with one more."""
    words = int(header_number("FIRST_RAYTRACED_SCENE")) + last
    text = _COUNTED.sub(
        lambda each: (
            f"{each['first']}{each['from']}{words + 1}{each['words']}{last + 1}"
            if each[0].endswith(f" {last}")
            else each[0]
        ),
        text,
    )
    return _DESCRIBED.sub(
        lambda each: (
            f'{each["margin"]}{each["what"]},\\n"\n{" " * 19}{each["margin"]}{words + 1}'
            f' {MARK} what it is\\n"'
            if each["last"] == str(words)
            else each[0]
        ),
        text,
    )

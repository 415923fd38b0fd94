"""scenes.toml and the numbers of the headers: each said in one place."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from grader.checking.pictures.plan import STAGES, everything
from grader.course import exercises, scenes
from grader.course.exercises import ManifestError
from grader.course.texts import LANGUAGES, sentences
from grader.execution.session import Library
from grader.intake.header_numbers import header_number, kinds
from grader.tests.support import sources


def test_scenes_say_what_there_is() -> None:
    """Scenes of scene.c, stages of the plan, bonuses of the manifest, things with a name."""
    bonuses = {each.id for each in exercises.load().exercises if each.bonus}
    for number, scene in scenes.load().items():
        assert number in sources.scenes()
        assert {*scene.stages} <= {*STAGES}
        assert {*scene.shows} <= bonuses
        assert {*scene.transparent} <= {*scene.things}
        for language in LANGUAGES:
            assert all(f"thing.{each}.name" in sentences(language) for each in scene.things)
    assert len(everything()) == len({each.name for each in everything()})


@pytest.mark.parametrize(
    "text",
    [
        "[scene.0]\nstages = []\nthings = []\n",
        "[stages]\n[scene.x]\nstages = []\nthings = ['floor']\n",
        "[stages]\n[scene.0]\nstages = []\nthings = []\n",
        "[stages]\n[scene.0]\nstages = []\nthings = ['floor']\ncolour = 1\n",
    ],
)
def test_a_malformed_table_is_named(tmp_path: Path, text: str) -> None:
    """One line with the file."""
    path = tmp_path / "scenes.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ManifestError, match=r"^scenes\.toml: missing or malformed key: .*\Z"):
        scenes.load(path)


def test_numbers_of_the_headers_are_those_of_the_library(reference: Library) -> None:
    """As the compiler has them; each type of object has its name."""
    sized = ("WIDTH", "HEIGHT")
    for name, value in reference.constants.items():
        if name not in sized:
            assert header_number(name) == pytest.approx(value, rel=1e-6), name
    assert {name: reference.constants[name] for name in kinds().values()} == {
        name: number for number, name in kinds().items()
    }


def test_no_module_says_a_number_of_the_headers_again() -> None:
    """None assigns to the name of a macro, or of a constant of an enum."""
    names = ("SPHERE", "PLANE", "CYLINDER", "CONE", "EPSILON", "RAY_TMAX", "MAX_LIGHTS")
    told = re.compile(rf"^_?(?:{'|'.join(names)})\b[^=\n]*= *[\d(]", re.MULTILINE)
    modules = [path for path in exercises.PACKAGE.rglob("*.py") if "tests" not in path.parts]
    assert [path.name for path in modules if told.search(path.read_text(encoding="utf-8"))] == []

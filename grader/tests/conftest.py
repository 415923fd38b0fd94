"""What the tests of the grader share: a cache of builds, and small submissions made for a test.

`make test` runs them side by side, in several processes of pytest-xdist; those of a module stay in
one, so that a fixture of the module is made once.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.execution.session import Library, open_core

ROOT = Path(__file__).resolve().parents[2]

Write = Callable[..., Path]

# The modules that take longest, half a minute each or more: begun first, none is waited for alone.
LONGEST = [
    "browser/test_themes",
    "setup/test_makefile",
    "commands/test_grade",
    "checking/test_pictures_judged",
    "checking/test_expected_data",
    "batch/test_class",
    "authoring/test_release",
    "evaluation/test_replay",
    "authoring/notebooks/test_notebook_runs",
    "evaluation/test_attribution",
    "evaluation/test_half_written",
    "browser/test_live",
    "evaluation/test_attempts",
    "authoring/notebooks/test_drawings",
    "authoring/test_gradescope",
    "checks/test_checks",
    "evaluation/test_lent_checks",
    "authoring/test_alike",
    "commands/test_bad_submissions",
    "authoring/test_figures",
    "setup/program/test_program_memory",
    "evaluation/test_recognition",
    "authoring/test_cases",
    "evaluation/test_other_views",
    "core/test_program",
    "batch/test_secrets",
    "batch/test_crew",
    "sandbox/test_isolation",
    "lab/test_tools",
    "sandbox/hostile/test_hostile",
    "sandbox/hostile/test_claims",
    "sandbox/test_surroundings",
]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the tests of the longest modules first."""
    tests = Path(__file__).parent
    places = {tests / f"{name}.py": place for place, name in enumerate(LONGEST)}
    if missing := [str(path) for path in places if not path.is_file()]:
        raise pytest.UsageError(f"LONGEST names no module: {', '.join(missing)}")
    items.sort(key=lambda item: places.get(item.path, len(places)))


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of builds that all the tests share; its name is hard on every path.

    The processes of pytest-xdist have it in common: what one has compiled no other compiles again.
    """
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "builds" / "été au labo"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@pytest.fixture
def submission(tmp_path: Path) -> Write:
    """Return a function that writes a submission and returns its folder.

    `submission(fill_red=CODE)` puts another body in a function of TP1; `files={...}` adds files, or
    removes one whose content is None.
    """

    def write(files: dict[str, str | None] | None = None, **bodies: str) -> Path:
        folder = tmp_path / "rendu"
        folder.mkdir(exist_ok=True)
        include = '#include "raytracer.h"\n'
        content: dict[str, str | None] = {
            "main.c": main_c({**STUDENT_MAIN, **bodies}),
            "raytracer.h": '#include "exercises.h"\n',
            "raytracer.c": include,
            "octree.c": include,
            **(files or {}),
        }
        for name, text in content.items():
            if text is not None:
                (folder / name).write_text(text, encoding="utf-8")
        return folder

    return write


@pytest.fixture(scope="session", params=[False, True], ids=["plain", "sanitized"])
def reference(request: pytest.FixtureRequest, cache: Path) -> Iterator[Library]:
    """Return the reference solution at 96x64, in both builds."""
    with open_core(ROOT / "reference", 96, 64, sanitized=request.param, cache=cache) as core:
        yield core

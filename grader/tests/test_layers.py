"""The flow goes one way: a package imports those of a line above its own, never the reverse."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from grader.course.exercises import PACKAGE

# From the first to the last; __init__.py and __main__.py stand at either end.
LAYERS = (
    "course files setup worker",
    "console intake sandbox",
    "build",
    "execution",
    "checking",
    "evaluation",
    "checks lab report",
    "batch commands",
    "authoring",
)
RANK = {name: rank for rank, row in enumerate(LAYERS) for name in row.split()}


def modules() -> Iterator[tuple[Path, str]]:
    """Yield the modules, but for the tests, with the package (or the module beside) of each."""
    for path in sorted(PACKAGE.rglob("*.py")):
        own = path.relative_to(PACKAGE).with_suffix("").parts[0]
        if own not in ("tests", "__init__", "__main__"):
            yield path, own


def imported(path: Path) -> Iterator[str]:
    """Yield the packages of the grader that a module imports from, wherever it does so."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "grader":
            inside = (node.module or "").split(".")[1:]
            yield from inside[:1] or (each.name for each in node.names)
        elif isinstance(node, ast.Import):
            names = (each.name.split(".") for each in node.names)
            yield from (each[1] for each in names if each[0] == "grader" and len(each) > 1)


def test_every_package_has_its_layer() -> None:
    """A new package must be given its place in the flow, which has nine layers at most."""
    assert {own for _, own in modules()} == set(RANK)
    assert len(LAYERS) <= 9


def test_no_package_imports_a_later_one() -> None:
    """Each import stays at home or goes to a line above."""
    last = len(LAYERS)
    up = {
        f"{path.relative_to(PACKAGE).as_posix()}: {other}"
        for path, own in modules()
        for other in imported(path)
        if other not in (own, "__version__") and RANK.get(other, last) >= RANK[own]
    }
    assert up == set()


def test_a_module_can_be_read_at_one_sitting() -> None:
    """It has 300 lines at most."""
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path, _ in modules()}
    assert {path for path, lines in lengths.items() if lines > 300} == set()

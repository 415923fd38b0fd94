"""The functions of the reference, as trees: which of them are judged, and by which exercises.

A file is parsed by pycparser as it stands, without its comments, behind the declarations of the
given headers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from pycparser import c_ast, c_generator, c_parser  # type: ignore[import-untyped]

from grader.authoring.specimens import patches
from grader.build import toolchain
from grader.build.declarations import declared
from grader.build.headers import SYSTEM_TYPES
from grader.build.records import Target
from grader.checking.expected_data import SIZE
from grader.course import exercises
from grader.course.exercises import CORE, ROOT
from grader.setup import c_text

# Not judged: the program's start, a drawing of one's own with its helpers, what calls `fill`, and
# the colours and the directions of the fractal, which are free.
LEFT_OUT = frozenset({"main", "fill_red", "draw", "fractal_material", "child_direction"})
_DIRECTIVE = re.compile(r"^[ \t]*#.*$", re.MULTILINE)


@dataclass(frozen=True, eq=False)
class MutatedSource:
    """A file of the reference, and its functions."""

    name: str
    text: str
    plain: str  # without comments and directives, at the same places
    functions: Mapping[str, c_ast.FuncDef]
    parameters: Mapping[str, tuple[str, ...]]  # the types of every function's, the headers' too


@cache
def owners(file: str, function: str) -> tuple[str, ...]:
    """Return the exercises whose functions are, or call, a function of a file."""
    source = parsed(file)
    judged = _exercise_functions()
    found, helpers = {function} & judged, {function} - judged
    seen: set[str] = set()
    while helpers:
        seen |= helpers
        callers = {
            name for name, each in source.functions.items() if _called(each) & helpers
        } - LEFT_OUT
        found |= callers & judged
        helpers = callers - judged - seen
    return tuple(each.id for each in exercises.load().exercises if found & {*each.functions})


@cache
def _exercise_functions() -> frozenset[str]:
    return frozenset(name for each in exercises.load().exercises for name in each.functions)


def _called(function: c_ast.FuncDef) -> set[str]:
    return {
        node.name.name
        for node, _ in walk(function.body)
        if isinstance(node, c_ast.FuncCall) and isinstance(node.name, c_ast.ID)
    }


@cache
def parsed(name: str) -> MutatedSource:
    """Read a file of the reference."""
    text = patches.reference()[name]
    plain = c_text.blanked(text, literals=False)
    plain = _DIRECTIVE.sub(lambda found: " " * len(found[0]), plain)
    prelude = "".join(f"typedef int {each};\n" for each in SYSTEM_TYPES)
    tree = c_parser.CParser().parse(f'{prelude}{_headers()}\n# 1 "{name}"\n{plain}', "given")
    printer = c_generator.CGenerator()
    functions, parameters = {}, {}
    for node in tree.ext:
        is_own = isinstance(node, c_ast.FuncDef)
        declaration = node.decl if is_own else node
        if isinstance(declaration, c_ast.Decl) and isinstance(declaration.type, c_ast.FuncDecl):
            parameters[declaration.name] = _types(printer, declaration.type)
        if is_own:
            functions[declaration.name] = node
    return MutatedSource(name, text, plain, functions, parameters)


@cache
def _headers() -> str:
    """Return what the given headers declare."""
    flags = toolchain.defines(Target(*SIZE))
    binding, _ = declared(CORE, flags, toolchain.find_compiler(), ROOT / "build" / "cache")
    return binding.cdef


def _types(printer: Any, declaration: c_ast.FuncDecl) -> tuple[str, ...]:
    listed = declaration.args.params if declaration.args else []
    return tuple(
        str(printer._generate_type(each.type, emit_declname=False))  # as bind.py asks
        for each in listed
    )


def walk(node: c_ast.Node) -> Iterator[tuple[c_ast.Node, c_ast.Node | None]]:
    """Return a node and those below it, each with its parent."""
    todo: list[tuple[c_ast.Node, c_ast.Node | None]] = [(node, None)]
    while todo:
        each, parent = todo.pop()
        yield each, parent
        todo += [(child, each) for _, child in reversed(each.children())]


def left_out(source: MutatedSource) -> frozenset[str]:
    """Return the functions that are left out, and the helpers that only `draw` calls."""
    calls = {name: _called(each) for name, each in source.functions.items()}
    found = {name for name in source.functions if name in LEFT_OUT}
    judged = _exercise_functions()
    while True:
        more = {
            name
            for name in source.functions
            if name not in found | judged
            and (callers := {other for other, called in calls.items() if name in called})
            and callers <= found
        }
        if not more:
            return frozenset(found)
        found |= more


@cache
def extent(source: MutatedSource, function: str) -> tuple[int, int]:
    """Return where the text of a function begins and ends."""
    lines = source.plain.split("\n")
    start = sum(len(line) + 1 for line in lines[: source.functions[function].decl.coord.line - 1])
    end = source.plain.index("{", start) + 1
    depth = 1
    while depth:
        depth += {"{": 1, "}": -1}.get(source.plain[end], 0)
        end += 1
    return start, end

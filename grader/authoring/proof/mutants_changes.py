"""Systematic small changes of the reference: one operator, number, statement or argument at a time.

The text of the function that holds a change is written again from the tree; what stands around it
is left as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pycparser import c_ast, c_generator  # type: ignore[import-untyped]

from grader.authoring.proof.mutants_source import MutatedSource, extent, left_out, parsed, walk
from grader.authoring.specimens import patches
from grader.files import content_key

# What an operator may be mistaken for: its edge, or its opposite.
_OPERATORS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "<": (("relational", "<="), ("relational", ">=")),
    "<=": (("relational", "<"), ("relational", ">")),
    ">": (("relational", ">="), ("relational", "<=")),
    ">=": (("relational", ">"), ("relational", "<")),
    "==": (("relational", "!="),),
    "!=": (("relational", "=="),),
    "+": (("arithmetic", "-"),),
    "-": (("arithmetic", "+"),),
    "*": (("arithmetic", "/"),),
    "/": (("arithmetic", "*"),),
    "%": (("arithmetic", "*"),),
    "&&": (("logical", "||"),),
    "||": (("logical", "&&"),),
    "&": (("logical", "|"),),
    "|": (("logical", "&"),),
    "^": (("logical", "|"),),
    "<<": (("arithmetic", ">>"),),
    "+=": (("arithmetic", "-="),),
    "*=": (("arithmetic", "/="),),
    "|=": (("logical", "&="),),
}
# Functions for which two arguments may change places without any difference that is judged: one
# seed of a pixel is as good as another.
_SYMMETRIC = frozenset(
    {
        "vector_add",
        "vector_vec_mul",
        "vector_dot",
        "vector_min",
        "vector_max",
        "fmaxf",
        "pixel_seed",
    }
    | {"smaller", "larger", "both", "boxes_overlap"}
)
# Functions of one argument that give what could stand in its place.
_WRAPPERS = frozenset({"vector_normalized", "sqrtf", "fabsf", "floorf"})
_NEXT = {"x": "y", "y": "z", "z": "x"}


@dataclass(frozen=True)
class Mutant:
    """The reference with one change; `before` and `after` are what was changed, as C writes it."""

    file: str
    function: str
    line: int  # where the function begins, or what is changed where the tree knows it
    kind: str
    before: str
    after: str
    written: str  # the function with the change

    @property
    def text(self) -> str:
        """The file with the change."""
        source = parsed(self.file)
        start, end = extent(source, self.function)
        return source.text[:start] + self.written + source.text[end:]

    @property
    def id(self) -> str:
        """What it is known by, as long as the function is the same."""
        parts = (self.file, self.function, self.written)
        return content_key(*parts)

    def files(self) -> dict[str, str]:
        """Return the reference's files with the change in them."""
        return {**patches.reference(), self.file: self.text}


@dataclass(frozen=True)
class _Edit:
    """A change of the tree that can be undone; `shown` is what it is told by."""

    kind: str
    shown: c_ast.Node
    act: Callable[[], None]
    undo: Callable[[], None]
    gone: bool = False  # nothing is left of it


def mutants() -> Iterator[Mutant]:
    """Return every mutant, in the order of the files; none stands twice."""
    seen = set()
    for name in patches.reference():
        if name.endswith(".c"):
            for each in _of_file(parsed(name)):
                if each.id not in seen:
                    seen.add(each.id)
                    yield each


# ---- Changing -----------------------------------------------------------------------------------


def _of_file(source: MutatedSource) -> Iterator[Mutant]:
    printer = c_generator.CGenerator()
    skipped = left_out(source)
    for name, function in source.functions.items():
        if name in skipped:
            continue
        for edit in _edits(source, function):
            before = printer.visit(edit.shown).strip()
            edit.act()
            after = "" if edit.gone else printer.visit(edit.shown).strip()
            written = printer.visit(function).strip()
            edit.undo()
            line = getattr(edit.shown.coord, "line", 0) or function.decl.coord.line
            yield Mutant(source.name, name, line, edit.kind, before, after, written)


def _edits(source: MutatedSource, function: c_ast.FuncDef) -> Iterator[_Edit]:
    for node, parent in list(walk(function.body)):
        # A number or a name says little without what it stands in.
        around = parent if parent is not None else node
        yield from _words(node, around)
        if isinstance(node, c_ast.Constant):
            yield from _numbers(node, around)
        elif isinstance(node, c_ast.FuncCall):
            yield from _swaps(source, node)
        elif isinstance(node, c_ast.Compound):
            yield from _deletions(node)
        elif isinstance(node, c_ast.TernaryOp):
            yield _exchanged("swapped arguments", node, node, "iftrue", "iffalse")
        yield from _conditions(node)
        yield from _unwrapped(node)


def _words(node: c_ast.Node, around: c_ast.Node) -> Iterator[_Edit]:
    """Put another operator, truth or component in the place of one."""
    if isinstance(node, (c_ast.BinaryOp, c_ast.Assignment)):
        for kind, other in _OPERATORS.get(node.op, ()):
            yield _set(kind, node, node, "op", other)
    elif isinstance(node, c_ast.ID) and node.name in ("true", "false"):
        yield _set("constant", around, node, "name", str(node.name == "false").lower())
    elif isinstance(node, c_ast.StructRef) and node.field.name in _NEXT:
        yield _set("component", around, node.field, "name", _NEXT[node.field.name])


def _set(kind: str, shown: c_ast.Node, node: c_ast.Node, name: str, value: Any) -> _Edit:
    """Return the change of one attribute of a node."""
    old = getattr(node, name)
    return _Edit(kind, shown, lambda: setattr(node, name, value), lambda: setattr(node, name, old))


def _exchanged(kind: str, shown: c_ast.Node, node: c_ast.Node, one: str, two: str) -> _Edit:
    def act() -> None:
        first, second = getattr(node, one), getattr(node, two)
        setattr(node, one, second)
        setattr(node, two, first)

    return _Edit(kind, shown, act, act)


def _numbers(node: c_ast.Constant, around: c_ast.Node) -> Iterator[_Edit]:
    """Change a number: twice as large and of the other sign, or one more and one less."""
    if node.type == "int":
        value = int(node.value, 0)
        yield _set("off by one", around, node, "value", str(value + 1))
        yield _set("off by one", around, node, "value", str(value - 1))
    elif node.type in ("float", "double"):
        size = float(node.value.rstrip("fF"))
        if size == 0:
            yield _set("constant", around, node, "value", "1.f")
            return
        yield _set("constant", around, node, "value", f"{2 * size!r}f")
        yield _set("constant", around, node, "value", "0.f")
        if not (isinstance(around, c_ast.UnaryOp) and around.op == "-"):
            yield _set("sign", around, node, "value", f"(-{node.value})")


def _swaps(source: MutatedSource, node: c_ast.FuncCall) -> Iterator[_Edit]:
    """Exchange neighbouring arguments of the same type."""
    name = getattr(node.name, "name", "")
    types = source.parameters.get(name, ())
    if name in _SYMMETRIC or not node.args:
        return
    given = node.args.exprs

    def swap(k: int) -> Callable[[], None]:
        def act() -> None:
            given[k], given[k + 1] = given[k + 1], given[k]

        return act

    for k in range(min(len(given), len(types)) - 1):
        if types[k].replace("const ", "") == types[k + 1].replace("const ", ""):
            yield _Edit("swapped arguments", node, swap(k), swap(k))


def _deletions(block: c_ast.Compound) -> Iterator[_Edit]:
    """Leave out a statement: an assignment, a call, or an `if` with what it guards."""
    kinds = (c_ast.Assignment, c_ast.FuncCall, c_ast.If, c_ast.Continue, c_ast.Break, c_ast.For)
    for k, each in enumerate(block.block_items or ()):
        if isinstance(each, kinds):
            yield _Edit(
                "deleted statement",
                each,
                lambda k=k: block.block_items.pop(k),  # type: ignore[misc]
                lambda k=k, each=each: block.block_items.insert(k, each),  # type: ignore[misc]
                gone=True,
            )


def _conditions(node: c_ast.Node) -> Iterator[_Edit]:
    """Turn a condition around that is no comparison: comparisons have their own changes."""
    condition = getattr(node, "cond", None)
    if isinstance(condition, c_ast.Node) and not isinstance(condition, c_ast.BinaryOp):
        bare = isinstance(condition, c_ast.UnaryOp) and condition.op == "!"
        other = condition.expr if bare else c_ast.UnaryOp("!", condition)
        yield _set("logical", node, node, "cond", other)


def _unwrapped(node: c_ast.Node) -> Iterator[_Edit]:
    """Leave out a minus, a `!` or a function such as vector_normalized around an expression."""
    for name, child in node.children():
        if isinstance(child, c_ast.UnaryOp) and child.op in ("-", "!") and name != "cond":
            kind, inner = ("sign" if child.op == "-" else "logical"), child.expr
        elif isinstance(child, c_ast.FuncCall) and getattr(child.name, "name", "") in _WRAPPERS:
            kind, inner = "deleted call", child.args.exprs[0]
        else:
            continue
        yield _put(kind, node, name, inner)


def _put(kind: str, node: c_ast.Node, place: str, value: c_ast.Node) -> _Edit:
    """Return the change of a child, by the name that pycparser gives it, such as "exprs[1]"."""
    name, _, index = place.partition("[")
    if not index:
        return _set(kind, node, node, name, value)
    items, k = getattr(node, name), int(index[:-1])
    old = items[k]

    def put(what: c_ast.Node) -> None:
        items[k] = what

    return _Edit(kind, node, lambda: put(value), lambda: put(old))

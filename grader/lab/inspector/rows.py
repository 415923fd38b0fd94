"""A replayed pixel as rows: one for each ray, its shadow rays below it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from grader.evaluation.replay.case import WrongValue
from grader.evaluation.replay.expected_maps import NO_BLOCKER
from grader.evaluation.replay.faults import differs_from_own
from grader.evaluation.replay.ray_tree import Lit, Node
from grader.lab.display.card import Shown, card, escape, fold, stack, table
from grader.lab.display.vectors import Array, Color, Vec3, number, swatch
from grader.lab.display.words import say, texts
from grader.lab.inspector.looking import InspectedScene, Seen

COLUMNS = ("ray", "meets", "color", "t", "point", "normal", "n_l", "seen", "k")
# The column in which a wrong value stands; the others stand for the whole ray.
_PLACES = {
    **dict.fromkeys(("object", "met", "elsewhere", "missed"), "meets"),
    **dict.fromkeys(("t", "normal"), ""),
    **dict.fromkeys(("seen", "hidden"), "seen"),
    **dict.fromkeys(
        ("shade", "direct", "mirror", "glass", "odds", "trace", "pixel", "mean"), "color"
    ),
    "position": "point",
    "fresnel": "k",
}
_INDENT = 1.1  # em, for each bounce
_CELL = "text-align:left"


@dataclass(frozen=True)
class Row:
    """One ray: `id` is 0 for the camera's, 1 for its first bounce; 0.2 is a shadow ray."""

    id: str
    level: int
    cells: dict[str, Shown | str] = field(default_factory=dict)
    wrong: str = ""  # the column in which the first wrong value stands


def rows(inspected: InspectedScene, seen: Seen) -> list[Row]:
    """Return the rows of a pixel that was replayed."""
    if seen.case is None:
        return []
    made: list[Row] = []
    before: Node | None = None
    for depth, node in enumerate(seen.case.root.walk()):
        made.append(_ray(inspected, node, before, depth, seen.fault))
        made += [_light(depth, each, seen.fault) for each in node.lights]
        before = node
    return made


def _ray(
    inspected: InspectedScene, node: Node, before: Node | None, depth: int, fault: WrongValue | None
) -> Row:
    cells: dict[str, Shown | str] = {"ray": say(f"inspect.ray.{node.kind.value}", depth=depth)}
    cells["meets"] = say("inspect.too_deep") if node.is_beyond else inspected.name(node.object)
    if node.hit is not None:
        cells["t"] = number(node.hit.t)
        cells["point"] = repr(Vec3(node.hit.position))
        cells["normal"] = repr(Vec3(node.hit.normal))
    if before is not None and before.bounce is not None:
        cells["k"] = repr(Vec3(before.bounce.k))
    cells["color"] = _colored(node.trace)
    return Row(str(depth), depth, cells, _wrong(fault, depth, None))


def _light(depth: int, lit: Lit, fault: WrongValue | None) -> Row:
    if lit.seen is None:
        seen = say("inspect.not_looked")
    else:
        seen = say("inspect.seen" if lit.seen else "inspect.hidden")
    cells: dict[str, Shown | str] = {
        "ray": say("inspect.ray.shadow", light=lit.index),
        "n_l": number(lit.n_l),
        "seen": seen if lit.n_l > 0 else say("inspect.behind"),
        "color": _colored(lit.adds) if lit.counts else say("inspect.nothing"),
    }
    return Row(f"{depth}.{lit.index}", depth + 1, cells, _wrong(fault, depth, lit.index))


def _wrong(fault: WrongValue | None, depth: int, light: int | None) -> str:
    if fault is None or (fault.depth, fault.light) != (depth, light):
        return ""
    return _PLACES.get(fault.value, "ray") or fault.value


def _colored(color: Array) -> Shown:
    return swatch(Color(color))


# ---- As HTML and text --------------------------------------------------------------------------


def told(inspected: InspectedScene, seen: Seen) -> Shown:
    """Return everything about a pixel: the sentences, then the table."""
    if seen.stopped is not None:
        i, j = seen.pixel
        head = say("inspect.stopped", i=i, j=j)
        return stack([Shown(f"<p>{escape(head)}</p>", head), seen.stopped])
    return stack([summary(inspected, seen), tabled(rows(inspected, seen))])


def summary(inspected: InspectedScene, seen: Seen) -> Shown:
    """Return the pixel's colour, whether it is the sum of its parts, and what goes wrong first."""
    lines = list(_sentences(inspected, seen))
    inside = "".join(f"<p>{escape(each)}</p>" for each in lines)
    text = "\n".join(lines)
    if seen.fault is not None and seen.fault.wanted:
        asked = [say("inspect.wanted", value=seen.fault.wanted), *_reference(inspected, seen)]
        told = "".join(f"<p>{escape(each)}</p>" for each in asked)
        inside += fold(say("inspect.ask"), told)
    return card(inside, text, "bad" if seen.fault else "plain")


def _sentences(inspected: InspectedScene, seen: Seen) -> Iterator[str]:
    case, (i, j) = seen.case, seen.pixel
    if case is None:
        return
    color = repr(Color(case.root.trace))
    yield say("inspect.pixel", i=i, j=j, thing=inspected.name(case.root.object), color=color)
    if differs_from_own(case):
        yield say("inspect.something_else", got=color, total=repr(Color(case.root.total)))
    if seen.fault is not None:
        yield sentence(seen.fault)
    elif case.wanted is not None:
        yield say("inspect.no_fault")
    else:
        yield say("inspect.no_maps")


def _reference(inspected: InspectedScene, seen: Seen) -> Iterator[str]:
    """Tell what the reference meets at the pixel, and the light there, for who asks."""
    wanted = seen.case.wanted if seen.case is not None else None
    if wanted is None:
        return
    lights = range(len(inspected.probe.content.lights))
    yield say(
        "inspect.reference",
        thing=inspected.name(int(wanted.object[0])),
        n_l=", ".join(number(float(wanted.n_l[0, k])) for k in lights),
        seen=", ".join(str(k) for k in lights if wanted.blocker[0, k] == NO_BLOCKER) or "-",
        bounces=int(wanted.bounces[0, int(inspected.probe.on("fresnel"))]),
    )


def sentence(fault: WrongValue) -> str:
    """Say which value goes wrong first, and where it is made."""
    message = fault.message
    return texts().say(message.key, **message.values)


def tabled(found: list[Row]) -> Shown:
    """Return the rows as a table; the cell of the first wrong value is marked by a cross."""
    used = [name for name in COLUMNS if any(name in each.cells for each in found)]
    heads = [say(f"inspect.column.{name}") for name in used]
    cells = [[_marked(each, name) for name in used] for each in found]
    text = table(heads, cells).text
    head = "".join(f'<th scope="col" style="{_CELL}">{escape(each)}</th>' for each in heads)
    body = "".join(
        _line(row, dict(zip(heads, line, strict=True)), used.index("ray"))
        for row, line in zip(found, cells, strict=True)
    )
    caption = escape(say("inspect.caption"))
    style = "overflow-x:auto;max-width:100%"
    return Shown(
        f'<div style="{style}" tabindex="0" role="group" aria-label="{caption}">'
        f'<table class="mrt-rays"><caption style="text-align:left">{caption}</caption>'
        f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>",
        text,
    )


def _marked(row: Row, name: str) -> Shown | str:
    cell = row.cells.get(name, "")
    text = cell.text if isinstance(cell, Shown) else cell
    if name == "ray":
        text = "  " * row.level + text
    if row.wrong != name:
        return Shown(cell.html if isinstance(cell, Shown) else escape(cell), text)
    mark = say("inspect.mark")
    html = cell.html if isinstance(cell, Shown) else escape(cell)
    return Shown(f"<strong>{escape(mark)} {html}</strong>", f"{mark} {text}")


def _line(row: Row, cells: dict[str, Shown | str], head: int) -> str:
    """Return a row; each cell knows its column, which is said beside it where there is no room."""
    parts = []
    for k, (column, cell) in enumerate(cells.items()):
        html = cell.html if isinstance(cell, Shown) else escape(cell)
        if k == head:
            pad = f"padding-left:{row.level * _INDENT:.1f}em;{_CELL};font-weight:normal"
            parts.append(f'<th scope="row" style="{pad}">{html}</th>')
        else:
            parts.append(f'<td data-column="{escape(column)}" style="{_CELL}">{html}</td>')
    return f'<tr data-row="{row.id}">{"".join(parts)}</tr>'

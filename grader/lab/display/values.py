"""C's values as Python sees them: named, with their units, read-only.

A `Record` is a struct, or a whole array of structs: `rays.dir` is then an array too.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from grader.checking.describe import OBJECTS
from grader.intake.header_numbers import header_number, kinds
from grader.lab.display.card import Shown, escape, table
from grader.lab.display.vectors import Array, Color, Vec3, number, swatch
from grader.lab.display.words import say

MAX_SHOWN = 12  # items of a list
# The unit of a field, by a key of [lab.unit] in messages/.
_UNITS = {
    **dict.fromkeys(("orig", "position", "center", "radius", "base", "length", "dist"), "scene"),
    **dict.fromkeys(("t", "tmin", "tmax"), "dir"),
    **dict.fromkeys(("normal", "axis", "xdir", "ydir", "zdir"), "unit"),
    **dict.fromkeys(("kd", "ks", "kr", "kd2", "col"), "color"),
    "fov": "degrees",
    "depth": "bounces",
}
_COLORS = ("kd", "ks", "kr", "kd2", "col")
_MATERIAL = ("kd", "ks", "shininess", "kr")


class Record:
    """A struct of C, or an array of them; its fields are read by their names."""

    kind = "Record"

    def __init__(self, data: Array) -> None:
        data = np.array(data)
        data.flags.writeable = False
        self._data = data

    @property
    def data(self) -> Array:
        """The numpy array of the structs."""
        return self._data

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the array; () for one struct."""
        return self._data.shape

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in (self._data.dtype.names or ()):
            known = ", ".join(self._names())
            raise AttributeError(f"{self.kind}: {name}? {known}")
        return _friendly(name, self._data[name], self.shape)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._names()]

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError(f"one {self.kind}, not several")
        return len(self._data)

    def __bool__(self) -> bool:
        return True

    def __getitem__(self, index: Any) -> Any:
        return record(self._data[index], type(self))

    def __iter__(self) -> Iterator[Any]:
        return (self[k] for k in range(len(self)))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and bool(np.array_equal(self._data, other._data))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return self._shown().text

    def _repr_html_(self) -> str:
        """Return a small table."""
        return self._shown().html

    def _names(self) -> tuple[str, ...]:
        """Return the fields worth showing."""
        return tuple(name for name in self._data.dtype.names or () if name != "seed")

    def _title(self) -> str:
        return _named(self.kind)

    def _cells(self) -> list[tuple[str, Any]]:
        return [(name, getattr(self, name)) for name in self._names()]

    def short(self) -> str:
        """Return one struct on one line."""
        cells = ", ".join(f"{name}={_plain(value)}" for name, value in self._cells())
        return f"{self._title()}({cells})"

    def _shown(self) -> Shown:
        if self.shape:
            return self._list()
        rows = [[name, _value(value), _unit(name)] for name, value in self._cells()]
        width = max(len(name) for name, _ in self._cells())
        lines = [self._title()]
        for name, value in self._cells():
            unit = f"  [{_unit(name)}]" if _unit(name) else ""
            lines.append(f"  {name:<{width}}  {_plain(value)}{unit}")
        inside = table(["", "", ""], rows)
        return Shown(f"<b>{escape(self._title())}</b>{inside.html}", "\n".join(lines))

    def _list(self) -> Shown:
        flat = self._data.reshape(-1)
        items = [record(flat[k], type(self)) for k in range(min(len(flat), MAX_SHOWN))]
        rows = [[str(k), *each._row()] for k, each in enumerate(items)]
        inside = table(["", *self._heads()], rows)
        head = f"{_named(self.kind)} x {' x '.join(map(str, self.shape))}"
        rest = say("more", count=len(flat) - len(items)) if len(flat) > len(items) else ""
        text = "\n".join(filter(None, [head, inside.text, rest]))
        return Shown(f"<b>{escape(head)}</b>{inside.html}{escape(rest)}", text)

    def _heads(self) -> list[str]:
        """Return the columns of a list."""
        return list(self._names())

    def _row(self) -> list[Shown | str]:
        """Return one struct in these columns."""
        return [_value(getattr(self, name)) for name in self._heads()]


class Ray(Record):
    """A half-line r(t) = orig + t dir, of which t in [tmin, tmax] counts."""

    kind = "Ray"

    def at(self, t: npt.ArrayLike) -> Any:
        """Return the point r(t); for several t, an array of points."""
        points = self._data["orig"] + np.asarray(t, np.float32)[..., None] * self._data["dir"]
        return Vec3(points) if points.shape == (3,) else points


class Material(Record):
    """What a surface is made of: kd diffuse, ks specular, kr reflectance at normal incidence."""

    kind = "Material"

    def _names(self) -> tuple[str, ...]:
        names: tuple[str, ...] = _MATERIAL
        if self.shape == ():
            names += ("refraction_index",) if self._data["refraction_index"] else ()
            pattern = self._data["pattern"]
            names += ("pattern", "pattern_origin") if pattern else ()
            names += ("kd2", "pattern_size") if pattern == header_number("PATTERN_CHECKER") else ()
        return names


class Object(Record):
    """A sphere, a plane, a cylinder or a cone, with its material `mat`."""

    kind = "Object"

    def _names(self) -> tuple[str, ...]:
        if self.shape:
            return super()._names()
        return (*OBJECTS.get(self._kind(), ("type",)), "mat")

    def _kind(self) -> str:
        return kinds().get(int(self._data["type"]), "")

    def _title(self) -> str:
        return _named(self._kind().title() or self.kind)

    def _heads(self) -> list[str]:
        return ["type", say("geometry"), *_MATERIAL]

    def _row(self) -> list[Shown | str]:
        names = [name for name in self._names() if name != "mat"]
        shape = ", ".join(f"{name} {_plain(getattr(self, name))}" for name in names)
        return [self._title(), shape, *(_value(getattr(self.mat, name)) for name in _MATERIAL)]


class Light(Record):
    """A point of light: its position and its colour col, which does not fade with distance."""

    kind = "Light"


class Camera(Record):
    """The eye and the three directions of the picture."""

    kind = "Camera"


class Intersection(Record):
    """A point that was hit: its unit normal, its position, a copy of the material."""

    kind = "Intersection"


class Hit(Record):
    """What a ray meets: `hit`, and then t, position, normal, material (NaN where it misses)."""

    kind = "Hit"

    @property
    def material(self) -> Material:
        """The material at the point hit."""
        return cast(Material, record(self._data["mat"], Material))

    def __bool__(self) -> bool:
        if self.shape:
            raise TypeError("several rays: look at .hit, an array of booleans")
        return bool(self._data["hit"])

    def _names(self) -> tuple[str, ...]:
        return ("hit", "t", "position", "normal", "mat")

    def _heads(self) -> list[str]:
        return ["hit", "t", "position", "normal"]


class Miss(Hit):
    """A ray that meets nothing; false in an `if`."""

    kind = "Miss"

    def _names(self) -> tuple[str, ...]:
        return ("hit",)


STRUCTS: dict[str, type[Record]] = {
    "ray": Ray,
    "material": Material,
    "object": Object,
    "light": Light,
    "camera": Camera,
    "intersection": Intersection,
}


def record(data: Array, kind: type[Record]) -> Record:
    """Return structs of that class; one hit that is none is a Miss."""
    if kind is Hit and np.shape(data) == () and not data["hit"]:
        kind = Miss
    return kind(data)


def _named(kind: str) -> str:
    """Return the name of a kind of struct in the language of the notebook."""
    return say(f"kind.{kind}")


def _friendly(name: str, value: Array, lead: tuple[int, ...]) -> Any:
    """Return a field as Python has it; `lead` is the shape of the array of structs."""
    if value.dtype.names:
        return record(value, Material)
    if lead == () and value.shape == (3,):
        return Color(value) if name in _COLORS else Vec3(value)
    return value.item() if value.shape == () else value


def _plain(value: Any) -> str:
    if isinstance(value, Record):
        return value.short()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return number(value)
    return repr(value)


def _value(value: Any) -> Shown | str:
    if isinstance(value, Color):
        return swatch(value)
    if isinstance(value, Material):
        rest = ", ".join(f"{name} {_plain(getattr(value, name))}" for name in _MATERIAL[1:])
        return Shown(f"kd {swatch(value.kd).html}, {escape(rest)}", value.short())
    return _plain(value)


def _unit(name: str) -> str:
    return say(f"unit.{_UNITS[name]}") if name in _UNITS else ""

"""Calling a C function with friendly values; arrays of them in one message.

A parameter that is only written (`it`, `out`) need not be given: what is written there is returned.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grader.build.records import Function, Parameter
from grader.checking.expected_data import is_written
from grader.execution.marshalling import Address, Reply
from grader.execution.session import Library, Session
from grader.lab.display import values
from grader.lab.display.error_cards import sentence
from grader.lab.display.stopped import Stopped
from grader.lab.display.values import Record
from grader.lab.display.vectors import Array, Color, Vec3

MOST_CALLS = 20_000  # in one message
_WHOLE = ("img", "objects")  # parameters that are tables, not one item of many
_ONLY_WRITTEN = ("it", "out")


@dataclass(frozen=True)
class Call:
    """A function and its arguments, in the order of the parameters; None: only written."""

    function: Function
    arguments: tuple[Any, ...]

    @property
    def hidden(self) -> list[str]:
        """The parameters in which the result is found."""
        pairs = zip(self.function.parameters, self.arguments, strict=True)
        return [each.name for each, value in pairs if value is _HIDDEN]


_HIDDEN = object()


def bind(function: Function, args: Sequence[Any], named: Mapping[str, Any]) -> Call:
    """Give each parameter its argument. Raises Stopped when they do not fit."""
    parameters = function.parameters
    left = [each for each in parameters if each.name not in named]
    if len(args) != len(left):
        left = [each for each in left if not _is_only_written(function, each)]
    if len(args) != len(left) or not set(named) <= {each.name for each in parameters}:
        raise Stopped(sentence("lab.arguments", call=signature(function)))
    given = {**dict(zip([each.name for each in left], args, strict=True)), **named}
    return Call(function, tuple(given.get(each.name, _HIDDEN) for each in parameters))


def signature(function: Function) -> str:
    """Return a call as it is written here."""
    names = [each.name for each in function.parameters if not _is_only_written(function, each)]
    return f"{function.name}({', '.join(names)})"


def perform(session: Session, core: Library, call: Call) -> Any:
    """Make the call, or as many as the arrays in it have items. Raises Died, Stopped."""
    parameters = call.function.parameters
    columns = [
        _column(core, each, value) for each, value in zip(parameters, call.arguments, strict=True)
    ]
    lead = _lead(parameters, columns, core, call.function)
    if lead == ():
        reply = session.call(call.function.name, *columns)
    else:
        reply = _many(session, core, call.function, columns, lead)
    _write_back(call, reply)
    return _result(call, reply, columns, lead)


def _is_only_written(function: Function, parameter: Parameter) -> bool:
    name = parameter.name
    return is_written(parameter.ctype) and (
        name in _ONLY_WRITTEN or (function.name, name) == ("camera_ray", "r")
    )


def _dtype(core: Library, parameter: Parameter) -> np.dtype[Any]:
    return core.dtype(parameter.pointee or parameter.ctype)


def _column(core: Library, parameter: Parameter, value: Any) -> Any:
    """Return a value as an array of the parameter's type; NULL and addresses as they are."""
    dtype = _dtype(core, parameter)
    if value is _HIDDEN:
        return np.zeros((), dtype)
    if value is None or isinstance(value, Address):
        return value
    try:
        return _as_struct(value, dtype) if dtype.names else _as_numbers(value, parameter, dtype)
    except (TypeError, ValueError):
        kind = parameter.pointee or parameter.ctype
        raise Stopped(sentence("lab.argument", name=parameter.name, kind=kind)) from None


def _as_struct(value: Any, dtype: np.dtype[Any]) -> Array:
    if isinstance(value, (list, tuple)):
        return np.stack([_as_struct(each, dtype) for each in value])
    data = value.data if isinstance(value, Record) else np.asarray(value)
    if data.dtype == dtype:
        return data
    shared = set(dtype.names or ()) & set(data.dtype.names or ())
    if not shared:
        raise TypeError(value)
    array = np.zeros(data.shape, dtype)
    for name in shared:
        array[name] = data[name]
    return array


def _as_numbers(value: Any, parameter: Parameter, dtype: np.dtype[Any]) -> Array:
    array = np.asarray(value, dtype.base)
    if parameter.name in _WHOLE:
        return array.reshape(-1, *dtype.shape)
    if parameter.ctype == "point3" and array.shape[-1:] == (2,):
        # A pixel's position (i, j): z is not looked at.
        array = np.concatenate([array, np.zeros_like(array[..., :1])], axis=-1)
    if array.shape[array.ndim - len(dtype.shape) :] != dtype.shape:
        raise TypeError(value)
    return array


def _lead(
    parameters: Sequence[Parameter], columns: Sequence[Any], core: Library, function: Function
) -> tuple[int, ...]:
    """Return the shape of the array of calls; () for one call."""
    shapes = []
    for parameter, column in zip(parameters, columns, strict=True):
        if isinstance(column, np.ndarray) and parameter.name not in _WHOLE:
            own = len(_dtype(core, parameter).shape)
            shapes.append(column.shape[: column.ndim - own])
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        text = ", ".join(str(shape) for shape in shapes if shape)
        raise Stopped(sentence("lab.shapes", call=signature(function), shapes=text)) from None


def _many(
    session: Session,
    core: Library,
    function: Function,
    columns: Sequence[Any],
    lead: tuple[int, ...],
) -> Reply:
    """Make the calls, some thousands in one message; the reply has them all, in shape `lead`."""
    count = math.prod(lead)
    spread = []
    for parameter, column in zip(function.parameters, columns, strict=True):
        if isinstance(column, np.ndarray) and parameter.name not in _WHOLE:
            own = _dtype(core, parameter).shape
            column = np.broadcast_to(column, (*lead, *own)).reshape(count, *own)
        spread.append(column)
    replies = []
    for start in range(0, max(count, 1), MOST_CALLS):
        end = min(start + MOST_CALLS, count)
        part = [
            each[start:end] if isinstance(each, np.ndarray) and len(each) == count else each
            for each in spread
        ]
        replies.append(session.call_many(function.name, end - start, *part))
    args = {name: _joined([each.args[name] for each in replies], lead) for name in replies[0].args}
    results = [each.result for each in replies]
    return Reply(None if results[0] is None else _joined(results, lead), args)


def _joined(parts: Sequence[Array], lead: tuple[int, ...]) -> Array:
    whole = np.concatenate(parts)
    return whole.reshape(*lead, *whole.shape[1:])


def _write_back(call: Call, reply: Reply) -> None:
    """Let arrays that were passed hold what the function has written, as in C."""
    for parameter, value in zip(call.function.parameters, call.arguments, strict=True):
        written = isinstance(value, np.ndarray) and is_written(parameter.ctype)
        if written and value.flags.writeable:
            np.copyto(value, reply.args[parameter.name].reshape(value.shape))


def _result(call: Call, reply: Reply, columns: Sequence[Any], lead: tuple[int, ...]) -> Any:
    hidden = call.hidden
    if "it" in hidden:
        return _hits(reply.result, reply.args["r"]["tmax"], reply.args["it"])
    if hidden:
        return _ray(reply.args[hidden[0]], reply.result, lead)
    return friendly(call.function.result, reply.result)


def _hits(found: Array, t: Array, it: Array) -> Any:
    """Return what rays have met.

    Parameters
    ----------
    found, t : array of shape S
        Whether there is a hit, and how far, in lengths of the ray's dir.
    it : array of `intersection`, shape S
        What the function wrote, which means something where there is a hit only.
    """
    inside = it.dtype.fields["mat"][0]  # type: ignore[index]
    dtype = np.dtype(
        [
            ("hit", "?"),
            ("t", "f4"),
            ("position", "f4", (3,)),
            ("normal", "f4", (3,)),
            ("mat", inside),
        ]
    )
    data = np.zeros(np.shape(found), dtype)
    data["hit"], data["t"], data["mat"] = found, np.where(found, t, np.nan), it["mat"]
    for name in ("position", "normal"):
        data[name] = np.where(np.asarray(found)[..., None], it[name], np.nan)
    return values.record(data[()], values.Hit)


def _ray(data: Array, found: Any, lead: tuple[int, ...]) -> Any:
    """Return the rays written; None, or NaN among several, where there is none."""
    if found is not None and lead == () and not found:
        return None
    data = np.array(data)
    if found is not None and lead:
        data["dir"][~found] = np.nan
    return values.Ray(data)


def friendly(ctype: str, value: Any) -> Any:
    """Return what a C function has returned as a Python value."""
    if value is None or isinstance(value, Address):
        return value
    array = np.asarray(value)
    if array.dtype.names:
        return values.record(array, values.STRUCTS.get(ctype, Record))
    if ctype in ("color", "vec3", "point3") and array.shape == (3,):
        return Color(array) if ctype == "color" else Vec3(array)
    return array.item() if array.shape == () else array

"""What makes a file no results.json, by results.schema.json: the words of JSON Schema it uses."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("results.schema.json")
Schema = Mapping[str, Any]
_TYPES: dict[str, tuple[type, ...]] = {
    "object": (dict,),
    "array": (list,),
    "string": (str,),
    "boolean": (bool,),
    "number": (int, float),
    "integer": (int,),
}


@cache
def whole() -> dict[str, Any]:
    """Return the schema of results.json."""
    content: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return content


def faults(value: Any, schema: Schema | None = None, place: str = "$") -> Iterator[str]:
    """Yield where a value is not as its schema says."""
    schema = whole() if schema is None else schema
    if "$ref" in schema:
        schema = whole()["$defs"][schema["$ref"].rpartition("/")[2]]
    if "const" in schema and value != schema["const"]:
        yield f"{place}: not {schema['const']}"
    if "enum" in schema and value not in schema["enum"]:
        yield f"{place}: not one of {schema['enum']}"
    if "type" not in schema:
        return
    wanted = schema["type"]
    if not isinstance(value, _TYPES[wanted]) or isinstance(value, bool) is not (
        wanted == "boolean"
    ):
        yield f"{place}: not of type {wanted}"
    else:
        yield from _inside(value, schema, place)


def _inside(value: Any, schema: Schema, place: str) -> Iterator[str]:
    if isinstance(value, dict):
        yield from _of_object(value, schema, place)
    elif isinstance(value, list):
        for number, each in enumerate(value):
            yield from faults(each, schema["items"], f"{place}[{number}]")
    elif isinstance(value, str):
        if not re.search(schema.get("pattern", ""), value):
            yield f"{place}: not like {schema['pattern']}"
    elif value < schema.get("minimum", value):
        yield f"{place}: below {schema['minimum']}"


def _of_object(value: dict[str, Any], schema: Schema, place: str) -> Iterator[str]:
    properties = schema.get("properties", {})
    for name in schema.get("required", ()):
        if name not in value:
            yield f"{place}.{name}: missing"
    for name, each in value.items():
        other = schema.get("additionalProperties", True)
        if name in properties:
            yield from faults(each, properties[name], f"{place}.{name}")
        elif other is False:
            yield f"{place}.{name}: unknown"
        elif other is not True:
            yield from faults(each, other, f"{place}.{name}")

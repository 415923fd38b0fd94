"""What the given headers declare, kept by their content: to derive it takes a parser, and its time.

The same headers, flags, compiler and code of ours give the same declarations.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from grader.build.records import Binding, Function, Parameter
from grader.build.toolchain import Compiler
from grader.course import exercises
from grader.files import content_key, write_whole

# Of what is derived, beside the headers.
SOURCES = ("headers.py", "shim/watch.c", "shim/acts.c", "shim/paint.c")


def declared(
    folder: Path, defines: Sequence[str], compiler: Compiler, cache: Path
) -> tuple[Binding, str]:
    """Return the binding of the headers in `folder` and the shim's text, as headers.derive does.

    Raises BindError.
    """
    headers = [folder / name for name in exercises.load().given if name.endswith(".h")]
    texts = [each.read_bytes() for each in headers]
    texts += [(exercises.PACKAGE / "build" / name).read_bytes() for name in SOURCES]
    key = content_key(texts, [*defines], compiler)
    kept = cache / "declared" / f"{key}.json"
    try:
        return _read(json.loads(kept.read_text(encoding="utf-8")))
    except (OSError, ValueError, KeyError, TypeError):
        from grader.build.headers import derive  # pycparser, which is seldom needed

        binding, shim = derive(folder, defines, compiler.command)
        content = {"binding": asdict(binding), "shim": shim}
        write_whole(kept, json.dumps(content).encode())
        return binding, shim


def _read(content: dict[str, Any]) -> tuple[Binding, str]:
    data = content["binding"]
    functions = {name: _function(row) for name, row in data["functions"].items()}
    structs = {name: tuple(fields) for name, fields in data["structs"].items()}
    constants = tuple(data["constants"])
    binding = Binding(data["cdef"], functions, data["variables"], structs, constants)
    return binding, str(content["shim"])


def _function(row: dict[str, Any]) -> Function:
    parameters = tuple(Parameter(**each) for each in row["parameters"])
    return Function(**{**row, "parameters": parameters, "by_address": tuple(row["by_address"])})

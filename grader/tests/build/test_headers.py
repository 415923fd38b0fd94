"""Declarations, shim and dtypes derived from the headers."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from grader.build import toolchain
from grader.build.headers import derive
from grader.build.records import BindError, Binding, Target
from grader.course import exercises
from grader.execution.dtypes import Types

FLAGS = toolchain.defines(Target(96, 64))


def derive_from(folder: Path, header: str) -> tuple[Binding, str]:
    """Derive from a folder that holds this text as exercises.h."""
    (folder / "exercises.h").write_text(header, encoding="utf-8")
    return derive(folder, FLAGS, toolchain.find_compiler().command)


@pytest.fixture(scope="module")
def core_binding() -> Binding:
    """Return the binding of the core's own headers."""
    return derive(exercises.CORE, FLAGS, toolchain.find_compiler().command)[0]


def test_every_function_of_the_manifest_is_declared(core_binding: Binding) -> None:
    """The manifest names only functions that exercises.h declares."""
    names = {name for each in exercises.load().exercises for name in each.functions}
    assert names <= set(core_binding.functions)


def test_gcc_and_clang_give_the_same_declarations(core_binding: Binding) -> None:
    """The declarations come from the headers, not from the compiler."""
    for command in ("gcc", "clang"):
        found = toolchain.find_compiler(command)
        assert derive(exercises.CORE, FLAGS, found.command)[0] == core_binding


def test_system_headers_and_bodies_do_not_leak(core_binding: Binding) -> None:
    """Neither printf nor the inside of an inline function is in the declarations."""
    assert "printf" not in core_binding.cdef
    assert "sqrtf" not in core_binding.cdef
    assert "vector_print" in core_binding.functions


def test_each_function_gets_a_wrapper(tmp_path: Path) -> None:
    """It fills the stack first, and takes addresses where cffi cannot pass a value."""
    binding, shim = derive_from(
        tmp_path,
        """typedef struct { int a; union { struct { int b; }; struct { float c; }; }; } both;
        static inline int twice(int n) { if (n) { return 2 * n; } return 0; }
        both make(int n);
        int take(both value, int n);
        int plain(const both *value);
        """,
    )
    symbols = {name: each.symbol for name, each in binding.functions.items()}
    assert symbols == {
        "twice": "mrt_call_twice",
        "make": "mrt_call_make",
        "take": "mrt_call_take",
        "plain": "mrt_call_plain",
    }
    assert "int mrt_call_twice(int n) { mrt_paint(); return twice(n); }" in shim
    assert "{ mrt_paint(); *mrt_result = make(n); }" in shim
    assert "{ mrt_paint(); return take(*value, n); }" in shim
    assert binding.structs == {"both": ("a", "b", "c")}


def test_constants_are_the_numbers_of_macros_and_enums(tmp_path: Path) -> None:
    """Guards, strings and macros with parameters are no constants; sums of constants are."""
    binding, _ = derive_from(
        tmp_path,
        """#define GUARD
        #define TEXT "a"
        #define CALL(x) x
        #define ONE 1e-4f
        #define TWO (ONE * 2 + WIDTH)
        #define UNKNOWN (elsewhere + 1)
        enum { SPHERE = 1, PLANE };
        extern int n; extern int table[WIDTH * 2];
        """,
    )
    assert binding.constants == ("WIDTH", "HEIGHT", "ONE", "TWO", "SPHERE", "PLANE")
    assert set(binding.variables) == {"n", "table"}


@pytest.mark.parametrize("header", ["int f(", '#include "absent.h"\n', "#error no\n"])
def test_broken_headers_name_the_file(tmp_path: Path, header: str) -> None:
    """What cannot be read is a clear error of the machine, with the file's name."""
    with pytest.raises(BindError, match=r"exercises\.h"):
        derive_from(tmp_path, header)


def test_dtypes_have_the_layout_of_c(core_binding: Binding, tmp_path: Path) -> None:
    """The compiler, asked directly, agrees on every struct's size and every field's place."""
    types = Types(core_binding)
    lines = []
    for struct, fields in core_binding.structs.items():
        lines.append(f'printf("%zu ", sizeof({struct}));')
        lines += [f'printf("%zu ", offsetof({struct}, {name}));' for name in fields]
    source = tmp_path / "layout.c"
    source.write_text(
        '#include "exercises.h"\n#include <stddef.h>\n#include <stdio.h>\nint main(void) {'
        + "\n".join(lines)
        + "}",
        encoding="utf-8",
    )
    command = [
        "gcc",
        *FLAGS,
        "-iquote",
        str(exercises.CORE),
        str(source),
        "-o",
        str(tmp_path / "a"),
    ]
    subprocess.run(command, check=True, timeout=30)
    done = subprocess.run([str(tmp_path / "a")], check=True, timeout=30, capture_output=True)
    assert types.layout == tuple(int(each) for each in done.stdout.split())


def test_dtypes_of_vectors_pointers_and_unions(core_binding: Binding) -> None:
    """vec3 is three floats, a pointer an address, and a union's members overlap."""
    types = Types(core_binding)
    assert types.dtype("color") == np.dtype(("f4", (3,)))
    assert types.dtype("color *") == np.dtype("u8")
    assert types.dtype("ray")["orig"] == np.dtype(("f4", (3,)))
    objects = types.dtype("object").fields
    assert objects is not None
    assert objects["center"][1] == objects["normal"][1] == objects["base"][1]
    with pytest.raises(KeyError, match="nothing"):
        types.dtype("nothing")

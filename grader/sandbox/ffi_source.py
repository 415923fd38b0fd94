"""cffi's declarations, made ready once, so that a worker needs neither a parser nor its time."""

from __future__ import annotations

import contextlib
import tempfile
from functools import cache
from pathlib import Path

import _cffi_backend

from grader.course import exercises
from grader.files import content_key, write_whole
from grader.worker import lockdown
from grader.worker.session import LIBC

KEPT = exercises.ROOT / "build" / "cache" / "bindings"  # of what is the grader's own


def library_source(cdef: str, library: str = "") -> bytes:
    """Return `abi_source` for a library's declarations, with what a session needs of the C library.

    It is kept beside the library, when there is one.
    """
    return abi_source(cdef + LIBC, Path(library).parent.parent / "bindings" if library else None)


def lock_source() -> bytes:
    """Return `abi_source` for what a process shuts itself in with."""
    return abi_source(lockdown.LIBC, KEPT)


def abi_source(cdef: str, folder: Path | None = None) -> bytes:
    """Return Python code that makes `ffi`, with these declarations, of cffi's compiled part alone.

    It is kept in `folder`, when one is given and can be written.
    """
    if folder is None:
        return _generate(cdef)
    key = content_key(_cffi_backend.__version__, cdef)
    kept = folder / f"{key}.py"
    try:
        return kept.read_bytes()
    except OSError:
        source = _generate(cdef)
    with contextlib.suppress(OSError):  # a cache that cannot be written costs time, nothing else
        write_whole(kept, source)
    return source


@cache
def _generate(cdef: str) -> bytes:
    # They bring a parser, which takes as long to import as all the rest, and is seldom needed.
    import cffi
    from cffi import recompiler

    ffi = cffi.FFI()
    ffi.cdef(cdef)
    ffi.set_source("mrt_abi", None)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mrt_abi.py"
        recompiler.make_py_source(ffi, "mrt_abi", str(path))
        return path.read_bytes()

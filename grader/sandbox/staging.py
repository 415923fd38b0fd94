"""The folder with everything that a worker may read: its own files and cffi's compiled part.

Neither the rest of the grader, nor expected data, nor the reference.
"""

from __future__ import annotations

import atexit
import os
import py_compile
import shutil
import tempfile
from functools import cache
from importlib.machinery import SourceFileLoader
from importlib.util import cache_from_source
from pathlib import Path

import _cffi_backend

import grader
from grader import worker
from grader.sandbox.bubblewrap import NOBODY
from grader.sandbox.ffi_source import lock_source
from grader.sandbox.levels import Level, current


@cache
def stage() -> Path:
    """Make the folder, once for this process, which removes it at its end; return it."""
    folder = private_folder()
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    package = folder / "grader"
    (package / "worker").mkdir(parents=True)
    sources = [Path(grader.__file__), *Path(worker.__file__).parent.glob("*.py")]
    root = Path(grader.__file__).parent
    for source in sources:
        _copy_compiled(source, package / source.relative_to(root))
    shutil.copyfile(root / "sandbox" / "launch.py", folder / "launch.py")
    (folder / "lock_abi.py").write_bytes(lock_source())
    backend = Path(_cffi_backend.__file__)
    shutil.copyfile(backend, folder / backend.name)
    libraries = backend.parent / "cffi.libs"  # some wheels bring libffi
    if libraries.is_dir():
        shutil.copytree(libraries, folder / libraries.name)
    _open_to_all(folder)
    folder.chmod(0o755)
    return folder


def _copy_compiled(source: Path, copy: Path) -> None:
    """Copy a module, and its compiled code, which Python keeps beside it where it may write."""
    shutil.copy2(source, copy)  # with its date: compiled code is held against it
    compiled = Path(cache_from_source(str(copy)))
    compiled.parent.mkdir(exist_ok=True)
    SourceFileLoader(source.stem, str(source)).get_code(source.stem)  # is kept from now on
    try:
        shutil.copyfile(cache_from_source(str(source)), compiled)
    except OSError:
        py_compile.compile(str(copy), doraise=True)


def private_folder() -> Path:
    """Make a folder that no other user can enter, but, without a sandbox, whom root becomes."""
    folder = Path(tempfile.mkdtemp(prefix="mrt-"))
    if os.geteuid() == 0 and current().level is not Level.STRONG:
        os.chown(folder, 0, NOBODY)
        folder.chmod(0o710)
    return folder


def _open_to_all(folder: Path) -> None:
    for path in folder.rglob("*"):
        path.chmod(0o755 if path.is_dir() else 0o644)

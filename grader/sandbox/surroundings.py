"""What programs read from the environment although nobody here has asked for it: none of it counts.

Compilers, linkers, sanitizers and submissions get an environment made from nothing (tools.py,
worker_process.py). What needs the person's own, such as where programs are, gets it without the
names below; and the grader's own process drops them first of all.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from fnmatch import fnmatchcase

LOCALE = {"LC_ALL": "C.UTF-8"}
# As their manuals list them.
_NAMES = (
    *("PYTHON?*", "PYTEST_*", "COV_CORE_*", "COVERAGE_*"),  # Python, pytest, coverage
    *("CPATH", "*_INCLUDE_PATH", "COMPILER_PATH", "LIBRARY_PATH", "GCC_*", "COLLECT_*"),  # gcc
    *("DEPENDENCIES_OUTPUT", "SUNPRO_DEPENDENCIES", "SOURCE_DATE_EPOCH", "TEMP", "TMP"),
    *("CCC_*", "CLANG_*", "LLVM_*"),
    *("LD_*", "LDEMULATION", "GNUTARGET", "GLIBC_TUNABLES", "MALLOC_*", "GCONV_PATH"),  # ld, libc
    *("*SAN_OPTIONS", "*SAN_SYMBOLIZER_PATH"),  # sanitizers
    *("MAKEFLAGS", "GNUMAKEFLAGS", "MFLAGS", "MAKEFILES", "MAKELEVEL", "MAKEOVERRIDES"),
    *("DEBUGINFOD_*", "MAKE_TERMOUT", "MAKE_TERMERR"),
)
# Where Python finds itself and the project, and how it writes: they change no mark.
_KEPT = (
    *("PYTHONPATH", "PYTHONHOME", "PYTHONPLATLIBDIR", "PYTHONUSERBASE", "LD_LIBRARY_PATH"),
    *("PYTHONUTF8", "PYTHONIOENCODING", "PYTHONUNBUFFERED", "PYTHONHASHSEED"),
    *("PYTHONDONTWRITEBYTECODE", "PYTHONPYCACHEPREFIX", "PYTHONNOUSERSITE", "PYTHONSAFEPATH"),
)


def is_read(name: str) -> bool:
    """Whether a program would read a variable that nobody here has set."""
    return name not in _KEPT and any(fnmatchcase(name, each) for each in _NAMES)


def cleaned(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without what programs would read in it."""
    return {name: value for name, value in environment.items() if not is_read(name)}


def of_a_question() -> dict[str, str]:
    """Return the environment of a compiler that is asked, say, for its version."""
    return {**LOCALE, "PATH": os.environ.get("PATH", os.defpath)}


def drop() -> None:
    """Drop them from this process; begin again where Python itself has read some.

    For a command's own process, before it does anything.
    """
    clean = cleaned(os.environ)
    if any(name.startswith("PYTHON") for name in os.environ.keys() - clean.keys()):
        os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], clean)
    for name in os.environ.keys() - clean.keys():
        del os.environ[name]

"""The C compiler: which one, with which flags on which system, and its sanitizers' runtime."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from grader.build.records import Target
from grader.course.message import UserError
from grader.sandbox import surroundings

COMPILE_SECONDS = 30
UNSEEN = ("no_instrument_function", "no_sanitize_coverage")  # attributes that hide from counting
QUESTION_SECONDS = 20  # for a question such as --version


class ToolchainError(UserError):
    """No usable compiler: the machine's fault."""


@dataclass(frozen=True)
class Compiler:
    """A command such as ("gcc",), what it says of itself, and the platform (sys.platform)."""

    command: tuple[str, ...]
    version: str
    platform: str = sys.platform

    @property
    def is_clang(self) -> bool:
        """Whether it takes clang's flags rather than gcc's."""
        return "clang" in self.version


@cache
def find_compiler(wanted: str = "") -> Compiler:
    """Return the compiler that `wanted` or CC names, or the first of gcc, clang, cc.

    Raises ToolchainError, with the cure, when there is none.
    """
    wanted = wanted or os.environ.get("CC", "")
    for text in [wanted] if wanted else ["gcc", "clang", "cc"]:
        command = tuple(shlex.split(text))
        if command and shutil.which(command[0]):
            return Compiler(command, ask(command, "--version"))
    raise ToolchainError("machine.no_compiler", tried=wanted or "gcc, clang, cc")


def ask(command: Sequence[str], question: str) -> str:
    """Return what the compiler prints on stdout when asked; "" when it fails."""
    try:
        done = subprocess.run(
            [*command, question],
            capture_output=True,
            text=True,
            env=surroundings.of_a_question(),
            errors="replace",
            timeout=QUESTION_SECONDS,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise ToolchainError("machine.compiler_fails", command=command[0], error=error) from error
    return done.stdout.strip() if done.returncode == 0 else ""


def compile_flags(compiler: Compiler, target: Target, language: str = "c") -> list[str]:
    """Return the flags that compile one file for a target; the same for student and reference.

    `language` is "c" or "c++".
    """
    flags = ["-x", language, "-std=gnu11" if language == "c" else "-std=gnu++17"]
    # Of a newer DWARF, addr2line before 2.41 takes lines of headers for lines of the C file.
    flags += ["-gdwarf-4", "-fPIC", "-ffp-contract=off", "-Wall", "-Wextra"]
    # Of another local variable or a parameter; a name of a header may well be taken again.
    flags += ["-Wshadow" if compiler.is_clang else "-Wshadow=local"]
    flags += ["-fno-color-diagnostics" if compiler.is_clang else "-fdiagnostics-color=never"]
    flags += ["-ferror-limit=20"] if compiler.is_clang else ["-fmax-errors=20"]
    if compiler.platform != "darwin":
        # So that one function can take another's place when the library is linked (substitute.py).
        flags += ["-ffunction-sections"]
        flags += ["-fsemantic-interposition"] if compiler.is_clang else []
    if target.sanitized:
        # -O0 compiles in a third of the time, and the line numbers of a report are true; what only
        # the optimiser warns of, the build for pictures tells.
        flags += ["-O0", "-fno-omit-frame-pointer", *sanitize_flags()]
    elif target.counted:
        flags += ["-O0"]
    else:
        # Lines and functions are all that is read of what the compiler notes: to note no more
        # (-g1) takes a sixth less. Endless calls end and are told in one way in every build: the
        # optimiser makes no loop of them, and a function stays in one piece.
        flags += ["-O2", "-g1", "-fno-optimize-sibling-calls"]
        flags += [] if compiler.is_clang else ["-fno-partial-inlining"]
    return flags + defines(target) + [each for each in target.defines if each[:2] != "-D"]


def defines(target: Target) -> list[str]:
    """Return the -D flags of a target."""
    own = [each for each in target.defines if each[:2] == "-D"]
    return [f"-DWIDTH={target.width}", f"-DHEIGHT={target.height}", *own]


def counting_flags() -> list[str]:
    """Return the flags by which the entries of functions and the steps of the code are counted."""
    flags = ["-finstrument-functions", "-fsanitize-coverage=trace-pc"]
    # Who pastes such a word together, unseen by sanitizer_guard.py, has another one.
    return flags + [f"-D{name}=unused" for each in UNSEEN for name in (each, f"__{each}__")]


def sanitize_flags() -> list[str]:
    """Return the flags of AddressSanitizer and UBSan; the first wrong act ends the process."""
    return ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


def link_flags(compiler: Compiler, target: Target) -> list[str]:
    """Return the flags that make the library out of the objects."""
    flags = sanitize_flags() if target.sanitized else []
    if compiler.platform == "darwin":
        # Two-level names already keep a library's own symbols apart; a missing function is found
        # when called.
        return [*flags, "-dynamiclib", "-undefined", "dynamic_lookup", "-lm"]
    # -Bsymbolic: a student's global called `index` or `y1` must not bind to the interpreter's.
    # lazy: a missing function fails when it is called, not when the library is loaded.
    return [*flags, "-shared", "-Wl,-Bsymbolic", "-Wl,-z,lazy", "-lm"]


def strict_link_flags(compiler: Compiler) -> list[str]:
    """Return the flags that hold a library to what a program needs: a `main`."""
    return [] if compiler.platform == "darwin" else ["-Wl,--require-defined=main"]


def lenient_link_flags(compiler: Compiler) -> list[str]:
    """Return the flags that let the first of several definitions of a name count."""
    return [] if compiler.platform == "darwin" else ["-Wl,-z,muldefs"]


def mixed_link_flags(compiler: Compiler) -> list[str]:
    """Return the flags that leave out the functions whose place another has taken."""
    return [*lenient_link_flags(compiler), "-Wl,--gc-sections"]


def cxx_library(compiler: Compiler) -> str:
    """Return the flag that links the library of C++."""
    return "-lc++" if compiler.platform == "darwin" else "-lstdc++"


def library_suffix(compiler: Compiler) -> str:
    """Return what the name of a shared library ends with on the compiler's platform."""
    return ".dylib" if compiler.platform == "darwin" else ".so"


@cache
def sanitizer_runtime(compiler: Compiler) -> str:
    """Return the sanitizers' runtime, a path or two with a colon between; "" when there is none.

    It is to be preloaded: each session then finds it there, and need not load it.
    """
    for names in _runtime_questions(compiler):
        answers = [ask(compiler.command, f"-print-file-name={name}") for name in names]
        # The compiler answers with the bare name when it has no such file.
        if all(Path(each).is_absolute() and Path(each).is_file() for each in answers):
            return ":".join(str(Path(each).resolve()) for each in answers)
    return ""


def _runtime_questions(compiler: Compiler) -> list[list[str]]:
    """Return names of libraries; each list is a whole runtime, the first that is there is right."""
    if compiler.platform == "darwin":
        return [["libclang_rt.asan_osx_dynamic.dylib"]]
    if compiler.is_clang:
        machine = os.uname().machine
        return [[f"libclang_rt.asan-{machine}.so"], ["libclang_rt.asan.so"]]
    return [["libasan.so", "libubsan.so"]]

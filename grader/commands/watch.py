"""`watch`: grades again each time that one of the C files is saved, until it is interrupted.

python -m grader watch PATH [what grade takes]

First what has changed, in a few lines, then all that was asked for. Each grade is made by a child
of this process, which has all that a grade needs at hand, and no thread.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import importlib
import os
import pkgutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import datetime
from pathlib import Path

from grader import checks, commands
from grader.build import toolchain
from grader.console import parser as usage
from grader.console.run import ExitCode, run
from grader.course import exercises, settings
from grader.course.texts import Texts
from grader.files import Marks, marks
from grader.intake import definitions
from grader.sandbox import orphans
from grader.sandbox.staging import stage
from grader.setup.folding import put

# How editors tell when a round begins and ends: .vscode/tasks.json.
BEGINS, ENDS = "== ", "-- "
SECONDS, WRITING_SECONDS = 0.05, 0.02  # between two looks; that an editor takes for one file

Sources = Mapping[str, str]  # text of the C files by name
Grade = Callable[[Sequence[str]], int]


def main(arguments: Sequence[str]) -> int:
    """Run the command line; return the exit code: 2 for a wrong use, 0 when it is interrupted."""
    texts = Texts(usage.language(arguments))
    code = run(lambda: _watch(arguments, texts), texts)
    return ExitCode.DONE if code == ExitCode.INTERRUPTED else code


def _watch(arguments: Sequence[str], texts: Texts) -> int:
    # Elsewhere a process that has used the system's libraries cannot be trusted after a fork.
    if not sys.platform.startswith("linux"):
        return watch(arguments, _fresh, time.sleep, texts)
    warm(texts)
    return watch(arguments, lambda words: in_child(words, texts), time.sleep, texts)


def watch(
    arguments: Sequence[str], grade: Grade, wait: Callable[[float], None], texts: Texts
) -> int:
    """Grade at once, and after each save; return the exit code of a grade that cannot be asked."""
    options = commands.parser(texts).parse_args(["grade", *arguments])
    seen: Marks | None = None
    code: Sources = {}
    while True:
        now = marks(options.path)
        if now != seen:
            wait(WRITING_SECONDS)  # an editor may write in several steps
            if marks(options.path) != now:
                continue
            before, code, seen = code, _sources(options.path), now
            print(f"{BEGINS}{datetime.now():%H:%M:%S}", flush=True)
            for more in rounds(options, before, code):
                if (ended := grade([*arguments, *more])) == ExitCode.WRONG_USE:
                    return ended
                if marks(options.path) != seen:
                    break  # of the past already
            print(ENDS + texts.say("watch.waiting"), flush=True)
        wait(SECONDS)


def rounds(options: argparse.Namespace, before: Sources, now: Sources) -> Iterator[list[str]]:
    """Yield what is added to the command line of each grade that a save asks for.

    What has changed comes first, unless that is nothing, or all, or something else is asked for.
    """
    counted = settings.load().is_counted
    asked = {
        each.id
        for each in exercises.load().exercises
        if each.checks and (counted(each.tp) if options.tp is None else each.tp == options.tp)
    }
    changed = [each.id for each in definitions.changed(before, now) if each.id in asked]
    if before and not options.keyword and 0 < len(changed) < len(asked):
        yield ["-k", " ".join(changed), "--brief", "--sketch"]
        yield []
    else:
        yield ["--sketch"]


def _sources(folder: Path) -> Sources:
    found = {}
    for name in exercises.load().student:
        with contextlib.suppress(OSError):
            found[name] = (folder / name).read_text(encoding="utf-8", errors="replace")
    return found


# ---- One grade ----------------------------------------------------------------------------------


def warm(texts: Texts) -> None:
    """Load what every grade loads, and ask this machine what every grade asks, once."""
    importlib.import_module("grader.commands.grade")
    for each in pkgutil.iter_modules(checks.__path__):
        importlib.import_module(f"{checks.__name__}.{each.name}")
    texts.say("watch.waiting")
    toolchain.sanitizer_runtime(toolchain.find_compiler())
    stage()
    gc.collect()
    gc.freeze()  # a child that went through all this would copy its pages


def in_child(words: Sequence[str], texts: Texts) -> int:
    """Grade in a fork of this process; return the exit code. Nothing is left of it."""
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        _be_child(words)
    try:
        _, status = os.waitpid(child, 0)
    except KeyboardInterrupt:
        os.kill(child, signal.SIGINT)  # which a terminal has told it already
        os.waitpid(child, 0)
        raise
    finally:
        orphans.sweep()
    code = os.waitstatus_to_exitcode(status)
    if code < 0:
        put(texts.say("watch.died", signal=-code), sys.stderr)
        return ExitCode.FAILED
    return code


def _be_child(words: Sequence[str]) -> None:
    """Grade, and end this process, whatever happens."""
    code: object = ExitCode.FAILED
    try:
        orphans.guard()
        code = commands.main(["grade", *words])
    except SystemExit as end:
        code = end.code
    finally:
        with contextlib.suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code if isinstance(code, int) else ExitCode.FAILED)


def _fresh(words: Sequence[str]) -> int:
    return subprocess.run([sys.executable, "-m", "grader", "grade", *words]).returncode

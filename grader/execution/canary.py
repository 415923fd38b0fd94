"""Proves a level of isolation: tries, as a submission would, what must be refused.

A bird of our own is compiled and run through the same compiler runner and the same worker as a
submission. Its library is kept; what a compiler can see is tried each time.
`python -m grader.execution.canary` prints what was not refused, with the mend.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import socket
import struct
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from grader.build import toolchain
from grader.course.exercises import ROOT
from grader.course.message import GraderError
from grader.course.texts import Texts, preferred
from grader.execution.worker_process import Died, Limits, SessionSocket, start_worker
from grader.files import content_key
from grader.sandbox.levels import Isolation, IsolationError, Level, current, using
from grader.sandbox.tools import give_away, run_tool, take_back

CDEF = """
int read_file(const char *path);
int write_file(const char *path);
int reach_network(int port);
int signal_process(int process);
int start_process(int unused);
int leave_memory(int unused);
int trace_worker(int unused);
void mrt_watch(void *memory, int sanitized);
"""
SOURCE = Path(__file__).with_name("canary.c")
LIMITS = Limits(cpu=2)
COMPILE_SECONDS = 20
_SECRET = "a secret of the grader"


class CanaryError(GraderError):
    """The canary itself could not be built or run: nothing is proved."""


@dataclass(frozen=True)
class Proof:
    """A level, and the acts that it did not refuse: keys of [canary] in messages/."""

    isolation: Isolation
    permitted: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether all that the level promises was seen."""
        return not self.permitted or self.isolation.level is Level.PORTABLE


def prove(cache: Path = ROOT / "build" / "cache") -> Proof:
    """Try every forbidden act at the current level. Raises CanaryError, or MachineError.

    The compiled canary is kept in `cache`, if that can be written.
    """
    with (
        tempfile.TemporaryDirectory(prefix="mrt-canary-") as name,
        socket.socket() as listener,
        start_worker() as process,
    ):
        folder = Path(name)
        folder.chmod(0o777)  # what protects the secret must be the isolation, not its rights
        secret = folder / "secret"
        secret.write_text(_SECRET, encoding="ascii")
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        permitted = [*_while_compiling(folder, secret)]
        library = _library(folder, cache / "canary")
        process.declare(str(library), CDEF, sanitized=False)
        with process.fork(str(library), LIMITS) as channel:
            permitted += _while_running(channel, secret, listener.getsockname()[1])
    return Proof(current(), tuple(permitted))


def _while_running(channel: SessionSocket, secret: Path, port: int) -> Iterator[str]:
    acts: list[tuple[str, str, bytes]] = [
        ("read", "read_file", _path(secret)),
        ("write", "write_file", _path(secret.with_name("written"))),
        ("network", "reach_network", struct.pack("=i", port)),
        ("signal", "signal_process", struct.pack("=i", os.getpid())),
        ("process", "start_process", bytes(4)),
        ("memory", "leave_memory", bytes(4)),
        ("trace", "trace_worker", bytes(4)),
    ]
    for act, function, argument in acts:
        kind = "table" if function.endswith("_file") else "value"
        head = {"do": "call", "name": function, "function": function, "count": 1}
        head["parameters"] = [(kind, len(argument))]
        size = 4 + (len(argument) if kind == "table" else 0)
        try:
            (could,) = struct.unpack_from("=i", channel.ask(head, size, argument))
        except Died as error:
            raise CanaryError(f"{function}: {error}") from error
        if could:
            yield act


def _while_compiling(folder: Path, secret: Path) -> Iterator[str]:
    """Have the compiler take in a file that it must not see; its assembler is the quickest to."""
    spy = folder / "spy"
    spy.mkdir()
    (spy / "spy.s").write_text(f'.incbin "{secret}"\n', encoding="utf-8")
    out = folder / "spied"
    out.mkdir()
    give_away(out)
    command = [*toolchain.find_compiler().command, "-c", "spy.s", "-o", str(out / "spy.o")]
    if run_tool(command, spy, writable=[out], seconds=COMPILE_SECONDS).status == 0:
        yield "include"


def _library(folder: Path, cache: Path) -> Path:
    """Return the compiled canary: the one of the cache, or else a new one, made in `folder`."""
    compiler = toolchain.find_compiler()
    made_of = [*compiler.command, compiler.version, SOURCE.read_text(encoding="utf-8")]
    key = content_key(made_of)
    kept = cache / f"{key}.so"
    if kept.is_file():
        return kept
    built = _build(folder)
    try:
        cache.mkdir(parents=True, exist_ok=True)
        part = cache / f"{key}.{os.getpid()}"
        shutil.copyfile(built, part)
        part.replace(kept)
    except OSError:
        return built
    return kept


def _build(folder: Path) -> Path:
    source, out = folder / "source", folder / "built"
    source.mkdir()
    out.mkdir()
    shutil.copyfile(SOURCE, source / SOURCE.name)
    give_away(out)
    library = out / "canary.so"
    command = [*toolchain.find_compiler().command, "-std=gnu11", "-fPIC", "-shared", SOURCE.name]
    ran = run_tool([*command, "-o", str(library)], source, (), [out], COMPILE_SECONDS)
    if ran.status != 0:
        raise CanaryError(ran.errors.strip()[:500])
    take_back(library)
    return library


def _path(path: Path) -> bytes:
    return os.fsencode(path) + b"\0"


def main(words: list[str]) -> int:
    """Print the level, then what is permitted; return 1 unless the level holds."""
    texts = Texts(preferred(""))
    try:
        with using(Level(words[0])) if words else contextlib.nullcontext():
            proof = prove()
    except IsolationError as error:
        sys.stdout.write(f"{texts.say(f'isolation.{error.best.level.value}')}\n")
        sys.stdout.write(f"{error.sentence(texts)}\n")
        return 1
    lines = [texts.say(f"isolation.{proof.isolation.level.value}")]
    if proof.isolation.reason:
        lines.append(texts.say(proof.isolation.reason, detail=proof.isolation.detail))
    lines += [texts.say(f"canary.{act}") for act in proof.permitted]
    if not proof.permitted:
        lines.append(texts.say("isolation.proved"))
    sys.stdout.write("\n".join(lines) + "\n")
    return 0 if proof.holds else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

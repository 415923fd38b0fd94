"""From a folder of C files to shared libraries.

A submission's own files are copied, with our given files, into a clean folder of the cache; each
file is compiled for each target, as many at once as there are cores; the objects and the shim are
linked. Everything is kept by content: the same sources, flags and compiler are never compiled
twice, and a library's name is its content's, because `dlopen` gives the old code for a path it has
already loaded.

    results = build(read_submission(Path("core_c")), [Target(320, 180)], Path("build/cache"))
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import stat
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

from grader import manifest, toolchain
from grader.bind import derive
from grader.records import Binding, BuildResult, BuildStatus, Target, Told
from grader.toolchain import Compiler

MAX_FILE_BYTES = 1_000_000
MAX_FILES = 100
SHIM = "mrt_shim.c"  # the name is ours: a submission's file of that name is not taken

_SANE_NAME = re.compile(r"[A-Za-z0-9_]+\.[ch]")


class SubmissionError(Told):
    """The folder is not a submission: wrong use."""


class BuildError(Told):
    """The machine or the given files are at fault, not the submission."""


@dataclass(frozen=True)
class Submission:
    """The C files of a submission that are judged, by name; and what was left out."""

    name: str
    files: Mapping[str, bytes]
    missing: tuple[str, ...]  # the student's files that are not there: the skeleton's stand in
    refused: tuple[str, ...]  # .c and .h files that are links, too large or oddly named


@dataclass(frozen=True)
class _Object:
    """A compiled file; `errors` is "" when it compiled."""

    path: Path
    errors: str
    warnings: str


def read_submission(folder: Path) -> Submission:
    """Read the C files of a folder: regular files only, with sane names and of a sane size.

    Raises SubmissionError when there is no such folder, or none of the student's files in it.
    """
    rules = manifest.load()
    files: dict[str, bytes] = {}
    refused: list[str] = []
    for path in _listing(folder):
        if path.name in (*rules.given, *rules.ungraded, SHIM) or path.suffix not in (".c", ".h"):
            continue
        status = path.lstat()
        regular = stat.S_ISREG(status.st_mode) and status.st_size <= MAX_FILE_BYTES
        if regular and _SANE_NAME.fullmatch(path.name) and len(files) < MAX_FILES:
            files[path.name] = _content(path)
        else:
            # A name may be no text at all: it must be printable all the same.
            refused.append(os.fsencode(path.name).decode(errors="replace"))
    missing = tuple(name for name in rules.student if name not in files)
    if len(missing) == len(rules.student):
        names = ", ".join(rules.student)
        raise SubmissionError("submission.nothing", path=folder, names=names)
    return Submission(folder.resolve().name, files, missing, tuple(refused))


def build(
    submission: Submission, targets: Sequence[Target], cache: Path, compiler: Compiler | None = None
) -> list[BuildResult]:
    """Build the submission for each target, in parallel; the results stand in the targets' order.

    Raises BuildError (or a ToolchainError, a BindError) when the machine is at fault.
    """
    compiler = compiler or toolchain.find_compiler()
    try:
        sources = _clean_folder(submission, cache)
        jobs = [_Job(sources, target, compiler, cache) for target in targets]
        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            objects = {
                (job, name): pool.submit(job.compile, name) for job in jobs for name in job.units()
            }
            shims = [pool.submit(job.bind) for job in jobs]
            done = [[objects[job, name].result() for name in job.units()] for job in jobs]
            return [
                job.link(parts, *shim.result())
                for job, parts, shim in zip(jobs, done, shims, strict=True)
            ]
    except OSError as error:
        raise BuildError(
            "machine.cannot_write", path=error.filename or cache, error=error.strerror
        ) from error


def _listing(folder: Path) -> list[Path]:
    if not folder.exists():
        raise SubmissionError("submission.no_folder", path=folder)
    if not folder.is_dir():
        raise SubmissionError("submission.not_a_folder", path=folder)
    try:
        return sorted(folder.iterdir())
    except OSError as error:
        raise SubmissionError("submission.closed", path=folder, error=error.strerror) from error


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise SubmissionError("submission.closed", path=path, error=error.strerror) from error


def _clean_folder(submission: Submission, cache: Path) -> Path:
    """Lay the submission's files and the given ones side by side; return the folder."""
    rules = manifest.load()
    files = dict(submission.files)
    for name in (*rules.given, *submission.missing):
        try:
            files[name] = (manifest.CORE / name).read_bytes()
        except OSError as error:
            raise BuildError(
                "machine.given_missing", name=f"core_c/{name}", error=error.strerror
            ) from error
    folder = cache / "sources" / _key(sorted(files.items()))
    if not folder.is_dir():
        folder.parent.mkdir(parents=True, exist_ok=True)
        part = Path(tempfile.mkdtemp(dir=folder.parent))
        part.chmod(0o755)
        for name, content in files.items():
            (part / name).write_bytes(content)
        try:
            part.rename(folder)
        except OSError:
            # Another run was quicker: its folder has the same content.
            shutil.rmtree(part)
            if not folder.is_dir():
                raise
    return folder


def _key(*parts: object) -> str:
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:24]


@dataclass(frozen=True)
class _Job:
    """One target of one submission."""

    sources: Path
    target: Target
    compiler: Compiler
    cache: Path

    def units(self) -> list[str]:
        """Return the names of the files to compile."""
        return sorted(path.name for path in self.sources.glob("*.c"))

    def compile(self, name: str) -> _Object:
        """Compile one file of the clean folder."""
        return self._compile(self.sources / name, name)

    def bind(self) -> tuple[Binding, _Object]:
        """Derive the declarations, and compile the shim made from them."""
        flags = toolchain.defines(self.target)
        binding, text = derive(self.sources, flags, self.compiler.command)
        shim = self.cache / "shims" / f"{_key(text)}.c"
        _write(shim, text.encode())
        return binding, self._compile(shim, SHIM)

    def link(self, objects: Sequence[_Object], binding: Binding, shim: _Object) -> BuildResult:
        """Make the library, unless a file was in error."""
        rules = manifest.load()
        named = [*zip(self.units(), objects, strict=True), (SHIM, shim)]
        for name, each in named:
            if each.errors and name in (*rules.given, SHIM):
                raise BuildError("machine.given_broken", name=name, log=each.errors)
        warnings = tuple(line for each in objects for line in each.warnings.splitlines())
        result = BuildResult(BuildStatus.REJECTED, self.target, warnings=warnings)
        errors = "".join(each.errors for each in objects)
        library = self.cache / "libraries" / self._library_name([each for _, each in named])
        if not errors and not library.exists():
            errors = self._link(library, named)
        if errors:
            return replace(result, log=errors)
        return replace(
            result,
            status=BuildStatus.BUILT,
            library=str(library.resolve()),
            binding=binding,
            preload=toolchain.sanitizer_runtime(self.compiler) if self.target.sanitized else "",
        )

    def _library_name(self, objects: Sequence[_Object]) -> str:
        flags = toolchain.link_flags(self.compiler, self.target)
        key = _key([each.path.name for each in objects], flags, self.compiler)
        return f"mrt-{key}{toolchain.library_suffix(self.compiler)}"

    def _compile(self, source: Path, name: str) -> _Object:
        flags = toolchain.compile_flags(self.compiler, self.target)
        headers = [(path.name, path.read_bytes()) for path in sorted(self.sources.glob("*.h"))]
        key = _key(self.compiler, flags, name, source.read_bytes(), headers)
        object_file = self.cache / "objects" / f"{key}.o"
        kept = object_file.with_suffix(".warnings")
        if kept.exists():  # written last: the object is whole
            return _Object(object_file, "", kept.read_text(encoding="utf-8"))
        # Relative names: messages and debugging information show the student's own file.
        place = name if source.parent == self.sources else str(source.resolve())
        flags += [f"-ffile-prefix-map={self.sources.resolve()}=.", "-iquote", "."]
        command = [*self.compiler.command, *flags, "-c", place, "-o"]
        status, output = _run(command, object_file, self.sources)
        if status != 0:
            return _Object(object_file, output or f"{name}: {self.compiler.command[0]} failed", "")
        _write(kept, output.encode())
        return _Object(object_file, "", output)

    def _link(self, library: Path, named: Sequence[tuple[str, _Object]]) -> str:
        """Link the objects; return what is wrong, "" when nothing is."""
        files = [str(each.path.resolve()) for _, each in named]
        flags = toolchain.link_flags(self.compiler, self.target)
        command = [*self.compiler.command, *files, *flags, "-o"]
        status, output = _run(command, library, self.sources)
        for name, each in named:
            output = output.replace(str(each.path.resolve()), name)
        return (output or "the linker failed") if status != 0 else ""


def _run(command: Sequence[str], output: Path, cwd: Path) -> tuple[int, str]:
    """Run the compiler, whose output then takes its name; return status and messages."""
    output.parent.mkdir(parents=True, exist_ok=True)
    handle, part = tempfile.mkstemp(dir=output.parent, suffix=output.suffix)
    os.close(handle)
    try:
        done = subprocess.run(
            [*command, str(Path(part).resolve())],
            cwd=cwd,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=toolchain.COMPILE_SECONDS,
            check=False,
            env={**os.environ, "LC_ALL": "C.UTF-8"},
        )
        if done.returncode == 0:
            os.chmod(part, 0o755)
            os.replace(part, output)
        return done.returncode, done.stderr
    except subprocess.TimeoutExpired:
        return 1, f"compiling takes more than {toolchain.COMPILE_SECONDS} s\n"
    finally:
        Path(part).unlink(missing_ok=True)


def _write(path: Path, content: bytes) -> None:
    """Write a file whole: others see the old one, or the new one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, part = tempfile.mkstemp(dir=path.parent)
    with os.fdopen(handle, "wb") as out:
        out.write(content)
    os.chmod(part, 0o644)
    os.replace(part, path)

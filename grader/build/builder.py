"""From the C files of a submission to shared libraries.

A submission's own files are copied, with our given files, into a clean folder of the cache; each
file is compiled for each target, as many at once as there are cores; the objects and the shim are
linked. A file that does not compile gives way to the skeleton's, so that the others are judged.

    results = build(read_submission(Path("core_c")), [Target(320, 180)], Path("build/cache"))

A `Builder` does it in the background, target by target:

    with Builder(submission, cache) as builder:
        small = builder.start(Target(96, 64))
        small.result().result.library
"""

from __future__ import annotations

import contextlib
import re
import shutil
import tempfile
from collections.abc import Container, Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from grader.build import own_headers, sanitizer_guard, toolchain
from grader.build.compiler_run import BuildError
from grader.build.records import BuildResult, Target
from grader.build.target import LANGUAGES, ObjectFile, Symbols, TargetBuild
from grader.build.toolchain import Compiler
from grader.course import exercises as manifest
from grader.course import settings
from grader.files import closed_folder, content_key
from grader.intake import originals
from grader.intake.records import Submission
from grader.sandbox import cores
from grader.sandbox.budget import Budget

__all__ = ["BuildError", "Builder", "Built", "build"]

MAX_TARGETS = 8  # in the making at the same time
_CHANGED = re.compile("error: conflicting types for")


@dataclass(frozen=True)
class Built:
    """A target that is done: its result, and what it was linked from."""

    job: TargetBuild
    kept: Mapping[str, bytes]  # the submission's files that compile
    objects: Mapping[str, ObjectFile]
    symbols: Mapping[str, Symbols]  # of the objects that are not given
    shim: ObjectFile
    result: BuildResult


def build(
    submission: Submission, targets: Sequence[Target], cache: Path, compiler: Compiler | None = None
) -> list[BuildResult]:
    """Build the submission for each target, in parallel; the results stand in the targets' order.

    A file that does not compile is left out, the skeleton's standing in, until the rest does.
    Raises BuildError (or another error of Told, or a BindError) when the machine is at fault.
    """
    with Builder(submission, cache, compiler) as builder:
        return [each.result().result for each in [builder.start(target) for target in targets]]


class Builder:
    """Builds one submission in the background; a context manager.

    A future raises BuildError (or another error of Told, or a BindError) when the machine is at
    fault.
    """

    def __init__(
        self,
        submission: Submission,
        cache: Path,
        compiler: Compiler | None = None,
        budget: Budget | None = None,
        jobs: int | None = None,
    ) -> None:
        """`jobs` files are compiled at once, by default as many as there are processors."""
        self.compiler = compiler or toolchain.find_compiler()
        self._budget = budget or Budget()  # of the submission
        self._slow: dict[tuple[Path, str], ObjectFile] = {}
        self._submission, self._cache = submission, cache
        with contextlib.suppress(OSError):  # who compiles will say what is wrong
            closed_folder(cache)
        self._compilers = ThreadPoolExecutor(jobs or cores.usable())
        # What takes little time does not queue behind the files of the targets to come.
        self._quick = ThreadPoolExecutor(2 * MAX_TARGETS)
        self._targets = ThreadPoolExecutor(MAX_TARGETS)  # they wait for the others

    def __enter__(self) -> Builder:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Give up what has not begun, and wait for the rest."""
        for pool in (self._compilers, self._quick, self._targets):
            pool.shutdown(cancel_futures=True)

    def start(self, target: Target, like: Future[Built] | None = None) -> Future[Built]:
        """Build for a target, after those that were started before.

        `like` is another target, whose rejected files are known. For another picture size, at which
        only TP1's functions are called, its objects that are not TP1's serve as they are; for one
        that counts, none.
        """
        return self._targets.submit(self._build, target, like)

    def _build(self, target: Target, like: Future[Built] | None) -> Built:
        base = like.result() if like else None
        try:
            return self._built(target, base)
        except OSError as error:
            raise BuildError(
                "machine.cannot_write", path=error.filename or self._cache, error=error.strerror
            ) from error

    def _built(self, target: Target, base: Built | None) -> Built:
        kept = dict(base.kept if base else self._submission.files)
        rejected = dict(base.result.rejected) if base else {}
        while True:
            sources = _clean_folder(kept, self._submission.in_place, self._cache)
            job = TargetBuild(sources, target, self.compiler, self._cache, self._budget, self._slow)
            binding = self._quick.submit(job.bind)
            objects = self._objects(job, kept, base)
            wrong = _to_leave_out(job, objects, kept)
            if not wrong:
                linked = self._quick.submit(job.link, objects, *binding.result(), rejected)
                symbols = job.symbols({name: objects[name] for name in job.own()})
                wrong = _switching_off(symbols)
            if not wrong:
                return Built(job, kept, objects, symbols, binding.result()[1], linked.result())
            rejected |= wrong
            kept = _without(kept, wrong)

    def _objects(
        self, job: TargetBuild, kept: Container[str], base: Built | None
    ) -> Mapping[str, ObjectFile]:
        """Compile every file; with a base, those alone whose objects would not serve."""
        if base is None or job.target.counted:
            return self._compile_all(job, job.units(), kept)
        exercises = manifest.load().exercises
        again = [name for name in job.own() if name in {e.file for e in exercises if e.tp == 1}]
        others = [name for name in job.own() if name not in again]
        objects = self._compile_all(job, [name for name in job.units() if name not in others], kept)
        if not any(each.errors for each in objects.values()):
            symbols = job.symbols({name: objects[name] for name in again})
            if not _is_apart(symbols.values(), [base.symbols[name] for name in others]):
                return self._compile_all(job, job.units(), kept)
        return objects | {name: base.objects[name] for name in others}

    def _compile_all(
        self, job: TargetBuild, names: Sequence[str], own: Container[str]
    ) -> dict[str, ObjectFile]:
        """Compile files; those of the submission as C++ where C does not do.

        When the files that are not C are all C++, the others are built as C++ too wherever they
        can: functions that they share have other names there.
        """
        ours = [name for name in names if name not in own]
        theirs = [name for name in names if name in own]
        first, second = LANGUAGES if settings.load().dialect == "c" else LANGUAGES[::-1]
        given = self._compiled(job, ours, "c")
        done = self._compiled(job, theirs, first)
        broken = [name for name, each in done.items() if each.errors]
        # In C++ a changed signature would be another function of the same name.
        if broken and not any(_CHANGED.search(done[name].errors) for name in broken):
            # The broken ones alone first: most often they are no C++ either.
            other = self._compiled(job, broken, second)
            if not any(each.errors for each in other.values()):
                other = self._compiled(job, theirs, second)
                done |= {name: each for name, each in other.items() if not each.errors}
        done |= given
        return {name: done[name] for name in names}

    def _compiled(
        self, job: TargetBuild, names: Sequence[str], language: str
    ) -> dict[str, ObjectFile]:
        # The longest first: the others fill the time beside it.
        order = sorted(names, key=lambda name: -(job.sources / name).stat().st_size)
        made = self._compilers.map(lambda name: job.compile(name, language), order)
        done = dict(zip(order, made, strict=True))
        return {name: done[name] for name in names}


def _is_apart(drawing: Iterable[Symbols], others: Sequence[Symbols]) -> bool:
    """Say whether TP1's files hold all of TP1, and call nothing of the submission's other files.

    (Nothing but exercises of other TPs, which TP1's functions do not call.)
    """
    files = list(drawing)
    exercises = manifest.load().exercises
    theirs = {name for each in exercises if each.tp == 1 for name in each.functions}
    later = {name for each in exercises if each.tp != 1 for name in each.functions}
    defined = frozenset[str]().union(*(each.defined for each in files))
    wanted = frozenset[str]().union(*(each.wanted for each in files))
    elsewhere = frozenset[str]().union(*(each.defined for each in others))
    return theirs <= defined and not wanted & elsewhere - later


def _switching_off(symbols: Mapping[str, Symbols]) -> dict[str, str]:
    """Return the errors of the files that define what would switch the sanitizers off."""
    found = {name: sanitizer_guard.in_symbols(name, each.defined) for name, each in symbols.items()}
    many = {name: f"{name}:1:1: error: it defines too many names\n" for name in symbols}
    found |= {name: many[name] for name, each in symbols.items() if not each.whole}
    return {name: errors for name, errors in found.items() if errors}


def _to_leave_out(
    job: TargetBuild, objects: Mapping[str, ObjectFile], kept: Mapping[str, bytes]
) -> dict[str, str]:
    """Return the submission's files that keep the rest from compiling, with what is said of them.

    A header of the submission's own comes first: it may be all that is wrong with the others.
    Raises BuildError when a given file is in error.
    """
    broken = {name: each.errors for name, each in objects.items() if each.errors}
    for name in manifest.load().given:
        if name in broken:
            raise BuildError("machine.given_broken", name=name, log=broken[name])
    headers = {name: _alone(job, name) for name in kept if broken and name.endswith(".h")}
    headers = {name: errors for name, errors in headers.items() if errors}
    files = {name: errors for name, errors in broken.items() if name in kept}
    # The skeleton's own files fail with a header that compiles by itself, at worst.
    return headers or files or {name: "".join(broken.values()) for name in kept if broken}


def _alone(job: TargetBuild, header: str) -> str:
    """Return the errors of a header by itself, "" when it compiles in one language at least.

    In C++ a changed signature would be another function of the same name.
    """
    tried = [job.compile(header, language).errors for language in LANGUAGES]
    return tried[0] if all(tried) or _CHANGED.search(tried[0]) else ""


def _without(kept: Mapping[str, bytes], wrong: Mapping[str, str]) -> dict[str, bytes]:
    """Return the files without the wrong ones; of a header, what can stay does."""
    left = {name: kept[name] for name in kept if name not in wrong}
    for name, errors in wrong.items():
        if name.endswith(".h") and (rest := own_headers.without_changed(kept[name], errors)):
            left[name] = rest
    return left


def _clean_folder(files: Mapping[str, bytes], in_place: bool, cache: Path) -> Path:
    """Lay the submission's files and what was handed out side by side; return the folder."""
    files = {**originals.read(in_place), **files}
    folder = cache / "sources" / content_key(sorted(files.items()))
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

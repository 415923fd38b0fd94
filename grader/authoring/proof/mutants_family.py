"""One program that holds several mutants of a function, and the libraries made of it.

To compile them together takes a fraction of the time. The function only calls one of its variants,
number 0 being the reference's, by a global variable that each session sets when it begins.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from grader.authoring.proof.mutants_changes import Mutant
from grader.authoring.proof.mutants_source import extent, parsed
from grader.authoring.specimens import patches
from grader.build import substitution, toolchain
from grader.build.builder import Builder, Built
from grader.build.records import Binding, BuildResult, BuildStatus, Target
from grader.checking.expected_data import SIZE
from grader.checking.shapes import Size
from grader.checking.student import PICTURE_SIZE
from grader.execution.loops import Loops
from grader.execution.session import DEFAULT_LIMITS, Library, Session
from grader.execution.worker_process import Limits, WorkerProcess, start_worker
from grader.intake.records import Submission

SELECTOR = "mrt_mutant"
# Optimised, so that many answers take little time.
QUICK = Target(*SIZE)


class FamilyError(Exception):
    """The program does not compile, for a reason that is none of the mutants'."""


class Kit:
    """The libraries of a program, each made when it is asked for; a context manager.

    With `selects`, the program is a family's, and sessions run the mutant `number`.
    """

    def __init__(self, submission: Submission, cache: Path, selects: bool = False) -> None:
        self.loops = Loops()
        self.kept: dict[tuple[Path, str], Any] = {}
        self.is_mixed = False
        self.number = 0
        self._cache, self._selects = cache, selects
        self._stack = contextlib.ExitStack()
        self._builder = self._stack.enter_context(Builder(submission, cache))
        self._runtime = toolchain.sanitizer_runtime(self._builder.compiler)
        self._built: dict[Target, Built] = {}
        self._cores: dict[str, Library] = {}
        self._workers: dict[str, WorkerProcess] = {}

    def __enter__(self) -> Kit:
        return self

    def __exit__(self, *error: object) -> None:
        self._stack.close()

    def choose(self, number: int) -> None:
        """Run that mutant from now on."""
        self.number, self.loops = number, Loops()

    def errors(self) -> str:
        """Return what the compiler says against the program, "" when nothing."""
        result = self._make(Target(*SIZE, bool(self._runtime))).result
        failed = result.status is not BuildStatus.BUILT
        return "".join(result.rejected.values()) or (result.log if failed else "")

    def unit(self, size: Size) -> Library:
        """Return the library for functions, with pictures of that size."""
        return self.core(Target(*size, bool(self._runtime)))

    def probed(self, size: Size) -> Library:
        """Return the library for functions, with the probe in the place of trace_ray."""
        built = self._make(Target(*size, bool(self._runtime)))
        return self._core(substitution.probed(built))

    def renderer(self) -> Library:
        """Return the library for whole pictures."""
        return self.core(Target(*PICTURE_SIZE))

    def counter(self) -> Library:
        """Return the library that counts how often objects are tested."""
        return self.core(Target(*PICTURE_SIZE, counted=True))

    def core(self, target: Target) -> Library:
        """Return the library of a target."""
        return self._core(self._make(target).result)

    def _core(self, result: BuildResult) -> Library:
        if result.library not in self._cores:
            if result.preload not in self._workers:
                worker = self._stack.enter_context(start_worker(result.preload))
                self._workers[result.preload] = worker
            worker = self._workers[result.preload]
            if self._selects and result.binding is not None:
                result = replace(result, binding=_with_selector(result.binding))
                self._cores[result.library] = _FamilyCore(worker, result, self)
            else:
                self._cores[result.library] = Library(worker, result)
        return self._cores[result.library]

    def _make(self, target: Target) -> Built:
        if target not in self._built:
            if self._selects:
                _seed(self._cache, target)
            self._built[target] = self._builder.start(target).result()
        return self._built[target]


class _FamilyCore(Library):
    """A library in whose sessions one of several mutants runs."""

    def __init__(self, process: WorkerProcess, library: BuildResult, kit: Kit) -> None:
        super().__init__(process, library)
        self._kit = kit

    @contextlib.contextmanager
    def session(self, limits: Limits = DEFAULT_LIMITS) -> Iterator[Session]:
        """Start a fresh process, and choose the mutant in it."""
        with super().session(limits) as session:
            session.set(SELECTOR, self._kit.number)
            yield session


def _with_selector(binding: Binding) -> Binding:
    return replace(
        binding,
        cdef=f"{binding.cdef}\nextern int {SELECTOR};",
        variables={**binding.variables, SELECTOR: "int"},
    )


@contextlib.contextmanager
def opened(chosen: Sequence[Mutant], cache: Path) -> Iterator[tuple[Kit, Sequence[Mutant]]]:
    """Build mutants of one function together; yield their libraries, and those that compile.

    In the libraries the first of these has number 1. `cache` is a folder of builds that nothing
    else uses. Raises FamilyError.
    """
    with _tidied(cache):
        while True:
            files, lines = program(chosen)
            with Kit(patches.submission(chosen[0].function, files), cache, selects=True) as kit:
                errors = kit.errors()
                broken = {int(each) for each in _ERROR.findall(errors)}
                if not errors:
                    yield kit, chosen
                    return
            kept = [each for each, own in zip(chosen, lines, strict=True) if not broken & {*own}]
            if len(kept) == len(chosen):
                raise FamilyError(f"{chosen[0].file}: {chosen[0].function}: {errors}")
            chosen = kept


_ERROR = re.compile(r"^\w+\.c:(\d+):\d+: error:", re.MULTILINE)


def program(chosen: Sequence[Mutant]) -> tuple[dict[str, str], list[range]]:
    """Return the files of a program that holds mutants, and the lines that each stands on."""
    source, name = parsed(chosen[0].file), chosen[0].function
    start, end = extent(source, name)
    own = source.plain[start:end]
    head = own[: own.index("{")].strip()
    parameters = source.functions[name].decl.type.args.params
    arguments = ", ".join(each.name for each in parameters if each.name)
    gives = "" if re.match(r"(static )?void \w", head) else "return "
    texts = [source.text[:start], f"int {SELECTOR};\n{head};\n"]
    lines, cases = [], []
    for number, written in enumerate([own, *(each.written for each in chosen)]):
        first = sum(text.count("\n") for text in texts) + 1
        texts.append(re.sub(rf"\b{name}\b", f"{name}__{number}", written, count=1) + "\n")
        lines.append(range(first, first + texts[-1].count("\n")))
        cases.append(f"case {number}: {gives}{name}__{number}({arguments}); break;\n")
    # A default, so that the compiler sees a value returned whatever happens.
    cases[0] = cases[0].replace("case 0", "default", 1)
    texts += [f"{head} {{ switch ({SELECTOR}) {{\n", *cases, "} }", source.text[end:]]
    return {**patches.reference(), source.name: "".join(texts)}, lines[1:]


# ---- What is built ------------------------------------------------------------------------------

_kept: dict[Path, set[Path]] = {}  # the builds that stay, by the folder that holds them


@contextlib.contextmanager
def _tidied(cache: Path) -> Iterator[None]:
    """Take away in the end what has been built in a cache of one's own, but for the reference's."""
    _kept.setdefault(cache, set(_builds(cache)))
    yield
    for path in sorted(_builds(cache) - _kept[cache], reverse=True):
        path.unlink() if not path.is_dir() else path.rmdir()


@cache
def _seed(cache: Path, target: Target) -> None:
    """Build the reference, whose objects serve for the files that a mutant leaves alone."""
    before = _builds(cache)
    with Kit(patches.submission("reference", patches.reference()), cache) as kit:
        kit.core(target)
    _kept[cache] |= _builds(cache) - before


def _builds(cache: Path) -> frozenset[Path]:
    names = ("sources", "objects", "libraries")
    return frozenset(path for name in names for path in cache.glob(f"{name}/**/*"))

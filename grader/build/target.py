"""One target of a submission: its files compiled, and linked with the shim into a library.

Everything is kept by content: the same sources, flags and compiler are never compiled twice, and a
library's name is its content's, because `dlopen` gives the old code for a path it has already
loaded.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from grader.build import diagnostics, sanitizer_guard, toolchain
from grader.build.compiler_run import BuildError, make
from grader.build.declarations import declared
from grader.build.records import Binding, BuildResult, BuildStatus, Function, Target
from grader.build.toolchain import Compiler
from grader.course import exercises
from grader.course.message import UserError
from grader.files import content_key, write_whole
from grader.intake.submission import SHIM
from grader.sandbox.budget import Budget
from grader.sandbox.tools import PARTS, run_tool

LANGUAGES = ("c", "c++")
NM_SECONDS = 20
SYMBOL_BYTES = 1_000_000  # of the list of a submission's: a right one's takes some thousands
COUNTING = exercises.PACKAGE / "build" / "shim" / "count.c"
COUNT, STEPS = "mrt_object_tests", "mrt_steps"  # its functions, whose numbers only grow


class MixError(UserError):
    """What a submission is made of does not go with the reference's functions."""


@dataclass(frozen=True)
class ObjectFile:
    """A compiled file; `errors` is "" when it compiled."""

    path: Path
    errors: str
    warnings: str
    language: str = "c"


@dataclass(frozen=True)
class Symbols:
    """The global names that an object defines, and those that it takes from elsewhere."""

    defined: frozenset[str] = frozenset()
    wanted: frozenset[str] = frozenset()
    whole: bool = True  # nothing was left out


def _listed(output: str, paths: Sequence[Path]) -> dict[Path, Symbols]:
    """Return what nm has listed: the path of an object when there are several, then its names."""
    heads = {f"{path}:": path for path in paths}
    found: dict[Path, tuple[set[str], set[str]]] = {}
    own = found.setdefault(paths[0], (set(), set())) if len(paths) == 1 else (set(), set())
    for line in output.splitlines():
        if line in heads:
            own = found.setdefault(heads[line], (set(), set()))
        elif len(words := line.split(" ")) > 1:
            own[words[1] in ("U", "w")].add(words[0])
    return {path: Symbols(frozenset(d - w), frozenset(w)) for path, (d, w) in found.items()}


def _in_order(names: Iterable[str]) -> list[str]:
    """Return the names of files, the student's own first, as the course lists them."""
    student = exercises.load().student
    return sorted(names, key=lambda name: (*[name != each for each in student], name))


@dataclass(frozen=True)
class TargetBuild:
    """One target of one submission."""

    sources: Path
    target: Target
    compiler: Compiler
    cache: Path
    budget: Budget | None = None  # None: what is built is no submission
    # What was given up, by folder and file: it would take as long again for another target.
    slow: MutableMapping[tuple[Path, str], ObjectFile] = field(default_factory=dict)

    def units(self) -> list[str]:
        """Return the names of the files to compile."""
        return sorted(path.name for path in self.sources.glob("*.c"))

    def compile(self, name: str, language: str) -> ObjectFile:
        """Compile one file of the clean folder as one of LANGUAGES."""
        if known := self.slow.get((self.sources, name)):
            return known
        done = self._compile(self.sources / name, name, language)
        if name in exercises.load().given:
            return done
        paths = {path.name: path for path in (self.sources / name, *self._own_headers())}
        texts = {each: path.read_bytes() for each, path in paths.items()}
        if done.errors:
            return replace(done, errors=diagnostics.with_macros(done.errors, texts))
        # A header by itself is compiled to be told of; what includes it is looked at.
        return replace(done, errors=sanitizer_guard.in_text(texts)) if name in self.own() else done

    def own(self) -> list[str]:
        """Return the names of the files to compile that are not given."""
        given = exercises.load().given
        return [name for name in self.units() if name not in given]

    def _own_headers(self) -> list[Path]:
        given = exercises.load().given
        return [path for path in sorted(self.sources.glob("*.h")) if path.name not in given]

    def symbols(self, objects: Mapping[str, ObjectFile]) -> dict[str, Symbols]:
        """Return what each object defines and wants, by the names of their files.

        Raises OSError when the machine has no `nm`.
        """
        paths = [each.path.resolve() for each in objects.values()]
        # No plugin: binutils loads all that it finds, LLVM's among them, which takes it 20 ms.
        flags = [] if self.compiler.platform == "darwin" else ["--plugin=/dev/null"]
        command = ["nm", *flags, "-P", "-g", *map(str, paths)]
        ran = run_tool(command, self.sources, paths, seconds=NM_SECONDS, most=SYMBOL_BYTES)
        if ran.killed or not ran.began:
            raise BuildError("machine.failed", detail="nm: killed")
        listed = _listed(ran.output, paths)
        if ran.cut:  # what is not seen may be anything: of the last one listed
            last = list(listed)[-1]
            listed[last] = replace(listed[last], whole=False)
        return {
            name: listed.get(path, Symbols()) for name, path in zip(objects, paths, strict=True)
        }

    def weakened(self, each: ObjectFile, names: Sequence[str]) -> ObjectFile:
        """Return the object with these names weak: another's definition takes their place.

        Raises MixError, BuildError.
        """
        if not names:
            return each
        flags = [f"--weaken-symbol={name}" for name in names]
        path = each.path.with_name(f"{content_key(each.path.name, flags)}.o")
        if not path.exists():
            command = ["objcopy", *flags, str(each.path.resolve())]
            made = make(command, path, self.sources, [each.path], each.path.name)
            if made.failed:
                raise MixError("machine.failed", detail=made.said)
        return replace(each, path=path)

    def mixed(self, named: Sequence[tuple[str, ObjectFile]]) -> str:
        """Return the library of objects some of whose names are weak.

        Raises MixError, BuildError.
        """
        flags = toolchain.mixed_link_flags(self.compiler)
        library = self.cache / "libraries" / self._library_name([each for _, each in named], flags)
        if not library.exists() and (errors := self._link(library, named, flags)):
            raise MixError("machine.failed", detail=errors)
        return str(library.resolve())

    def bind(self) -> tuple[Binding, ObjectFile]:
        """Derive the declarations, and compile the shim made from them."""
        flags = toolchain.defines(self.target)
        binding, text = declared(self.sources, flags, self.compiler, self.cache)
        if self.target.counted:
            counts = {each: Function(each, each, "uint64_t", ()) for each in (COUNT, STEPS)}
            binding = replace(
                binding,
                cdef="".join([binding.cdef, *(f"\nuint64_t {each}(void);" for each in counts)]),
                functions={**binding.functions, **counts},
            )
            text += COUNTING.read_text(encoding="utf-8")
        return binding, self.compile_text(SHIM, text)

    def compile_text(self, name: str, text: str) -> ObjectFile:
        """Compile a file of the grader's own."""
        source = self.cache / "shims" / content_key(text) / name
        write_whole(source, text.encode())
        return self._compile(source, name)

    def link(
        self,
        objects: Mapping[str, ObjectFile],
        binding: Binding,
        shim: ObjectFile,
        rejected: Mapping[str, str],
    ) -> BuildResult:
        """Make the library; `rejected` are the errors of the files that were left out."""
        if shim.errors:
            raise BuildError("machine.given_broken", name=SHIM, log=shim.errors)
        # Of what is defined twice the first counts: the shim's, then that of the course's files.
        named = [(SHIM, shim), *((name, objects[name]) for name in _in_order(objects))]
        result = BuildResult(
            BuildStatus.REJECTED,
            self.target,
            warnings=tuple(w for _, each in named for w in each.warnings.splitlines()),
            log="".join(rejected[name] for name in _in_order(rejected)),
            rejected=rejected,
            cxx=tuple(name for name, each in named if each.language == "c++"),
        )
        library = self.cache / "libraries" / self._library_name([each for _, each in named])
        failure, linker = self._linked(library, named)
        if failure:
            return replace(result, log=result.log + failure)
        return replace(
            result,
            status=BuildStatus.BUILT,
            library=str(library.resolve()),
            binding=binding,
            preload=toolchain.sanitizer_runtime(self.compiler) if self.target.sanitized else "",
            linker=linker,
            tables=self._tables(shim),
        )

    def _tables(self, shim: ObjectFile) -> str:
        """Return a library of the shim alone: a submission's could tell other constants."""
        library = self.cache / "libraries" / self._library_name([shim])
        if not library.exists() and (errors := self._link(library, [(SHIM, shim)], [])):
            raise BuildError("machine.given_broken", name=SHIM, log=errors)
        return str(library.resolve())

    def _linked(self, library: Path, named: Sequence[tuple[str, ObjectFile]]) -> tuple[str, str]:
        """Link as strictly as a program is, then without; return the failure, and the complaint.

        What has no `main`, or defines a function twice, is no program, and can be judged.
        """
        kept = library.with_suffix(".complaint")
        if library.exists() and kept.exists():
            return "", kept.read_text(encoding="utf-8")
        failure = complaint = self._link(library, named, toolchain.strict_link_flags(self.compiler))
        if complaint:
            failure = self._link(library, named, toolchain.lenient_link_flags(self.compiler))
        if not failure:
            write_whole(kept, complaint.encode())
        return failure, complaint

    def _library_name(self, objects: Sequence[ObjectFile], extra: Sequence[str] = ()) -> str:
        flags = [*toolchain.link_flags(self.compiler, self.target), *extra]
        key = content_key([each.path.name for each in objects], flags, self.compiler)
        return f"mrt-{key}{toolchain.library_suffix(self.compiler)}"

    def _compile(self, source: Path, name: str, language: str = "c") -> ObjectFile:
        flags = toolchain.compile_flags(self.compiler, self.target, language)
        if self.target.counted and name != SHIM:  # what counts does not count itself
            flags += toolchain.counting_flags()
        given = exercises.load().given
        # A given file includes given headers only: it is compiled once for every submission.
        own = [] if name in given or source.parent != self.sources else self._own_headers()
        headers = [self.sources / each for each in given if each.endswith(".h")] + own
        texts = [(each.name, each.read_bytes()) for each in headers]
        key = content_key(self.compiler, flags, name, source.read_bytes(), texts)
        object_file = self.cache / "objects" / f"{key}.o"
        kept = object_file.with_suffix(".warnings")
        if kept.exists():  # written last: the object is whole
            return ObjectFile(object_file, "", kept.read_text(encoding="utf-8"), language)
        # Relative names: messages and debugging information show the student's own file.
        place = name if source.parent == self.sources else str(source.resolve())
        flags += [f"-ffile-prefix-map={self.sources.resolve()}=.", "-iquote", "."]
        command = [*self._driver(), *flags, "-c", place, "-o"]
        budget = None if name in given or source.parent != self.sources else self.budget
        made = make(command, object_file, self.sources, [source], name, budget)
        if made.failed:
            done = ObjectFile(object_file, made.said, "")
            if made.slow:
                self.slow[self.sources, name] = done
            return done
        write_whole(kept, made.said.encode())
        return ObjectFile(object_file, "", made.said, language)

    def _driver(self) -> list[str]:
        """Return the compiler's command; gcc also tells how each of its parts has ended."""
        return [*self.compiler.command, *([] if self.compiler.is_clang else PARTS)]

    def _link(
        self, library: Path, named: Sequence[tuple[str, ObjectFile]], extra: Sequence[str]
    ) -> str:
        """Link the objects; return what is wrong, "" when nothing is."""
        files = [str(each.path.resolve()) for _, each in named]
        flags = [*toolchain.link_flags(self.compiler, self.target), *extra]
        if any(each.language == "c++" for _, each in named):
            flags.append(toolchain.cxx_library(self.compiler))
        command = [*self._driver(), *files, *flags, "-o"]
        inputs = [each.path for _, each in named]
        first = next((name for name, _ in named if name != SHIM), SHIM)
        made = make(command, library, self.sources, inputs, first, self.budget)
        said = made.said
        for name, each in named:
            said = said.replace(str(each.path.resolve()), name)
        return said if made.failed else ""

"""One target of a submission: its files compiled, and linked with the shim into a library.

Everything is kept by content: the same sources, flags and compiler are never compiled twice, and a
library's name is its content's, because `dlopen` gives the old code for a path it has already
loaded.
"""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from grader.build import sanitizer_guard, toolchain
from grader.build.declarations import declared
from grader.build.records import Binding, BuildResult, BuildStatus, Function, Target
from grader.build.toolchain import Compiler
from grader.course import exercises
from grader.course.message import UserError
from grader.files import write_whole
from grader.intake.submission import SHIM
from grader.sandbox.tools import OUT_OF_TIME, give_away, run_tool, take_back

LANGUAGES = ("c", "c++")
# What a sandbox says that cannot begin, and the compiler's drivers of their own parts.
_KILLED = re.compile(
    r"^(?:bwrap|setpriv|prlimit): "
    r"|^[\w.+/-]+: (?:fatal )?error: (?:Killed signal terminated program"
    r"|\w+ terminated with signal 9|unable to execute command: Killed)",
    re.MULTILINE,
)
NM_SECONDS = 20
COUNTING = exercises.PACKAGE / "build" / "shim" / "count.c"
COUNT = "mrt_object_tests"  # its function: the entries since it was last called


class BuildError(UserError):
    """The machine or the given files are at fault, not the submission."""


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

    defined: frozenset[str]
    wanted: frozenset[str]


def _in_order(names: Iterable[str]) -> list[str]:
    """Return the names of files, the student's own first, as the course lists them."""
    student = exercises.load().student
    return sorted(names, key=lambda name: (*[name != each for each in student], name))


def key_of(*parts: object) -> str:
    """Return a name that stands for the content of its arguments."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:24]


@dataclass(frozen=True)
class TargetBuild:
    """One target of one submission."""

    sources: Path
    target: Target
    compiler: Compiler
    cache: Path

    def units(self) -> list[str]:
        """Return the names of the files to compile."""
        return sorted(path.name for path in self.sources.glob("*.c"))

    def compile(self, name: str, language: str) -> ObjectFile:
        """Compile one file of the clean folder as one of LANGUAGES."""
        done = self._compile(self.sources / name, name, language)
        if done.errors or name not in self.own():
            return done
        texts = {
            path.name: path.read_bytes() for path in (self.sources / name, *self._own_headers())
        }
        return replace(done, errors=sanitizer_guard.in_text(texts))

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
        command = ["nm", *flags, "-P", "-g", "-A", *map(str, paths)]
        ran = run_tool(command, self.sources, paths, seconds=NM_SECONDS)
        if ran.killed:
            raise BuildError("machine.failed", detail="nm: killed")
        lines = ran.output.splitlines()
        found = {}
        for name, path in zip(objects, paths, strict=True):
            prefix = f"{path}: "
            own = [line[len(prefix) :].split(" ") for line in lines if line.startswith(prefix)]
            wanted = frozenset(words[0] for words in own if words[1:2] in (["U"], ["w"]))
            found[name] = Symbols(frozenset(words[0] for words in own) - wanted, wanted)
        return found

    def weakened(self, each: ObjectFile, names: Sequence[str]) -> ObjectFile:
        """Return the object with these names weak: another's definition takes their place.

        Raises MixError, BuildError.
        """
        if not names:
            return each
        flags = [f"--weaken-symbol={name}" for name in names]
        path = each.path.with_name(f"{key_of(each.path.name, flags)}.o")
        if not path.exists():
            command = ["objcopy", *flags, str(each.path.resolve())]
            status, output = _run(command, path, self.sources, [each.path])
            if status != 0:
                raise MixError("machine.failed", detail=output)
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
            binding = replace(
                binding,
                cdef=f"{binding.cdef}\nuint64_t {COUNT}(void);",
                functions={**binding.functions, COUNT: Function(COUNT, COUNT, "uint64_t", ())},
            )
            text += COUNTING.read_text(encoding="utf-8")
        return binding, self.compile_text(SHIM, text)

    def compile_text(self, name: str, text: str) -> ObjectFile:
        """Compile a file of the grader's own."""
        source = self.cache / "shims" / key_of(text) / name
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
        # The course's files first: of what is defined twice, theirs counts.
        named = [(name, objects[name]) for name in _in_order(objects)] + [(SHIM, shim)]
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
        key = key_of([each.path.name for each in objects], flags, self.compiler)
        return f"mrt-{key}{toolchain.library_suffix(self.compiler)}"

    def _compile(self, source: Path, name: str, language: str = "c") -> ObjectFile:
        flags = toolchain.compile_flags(self.compiler, self.target, language)
        given = exercises.load().given
        # A given file includes given headers only: it is compiled once for every submission.
        own = [] if name in given or source.parent != self.sources else self._own_headers()
        headers = [self.sources / each for each in given if each.endswith(".h")] + own
        texts = [(each.name, each.read_bytes()) for each in headers]
        key = key_of(self.compiler, flags, name, source.read_bytes(), texts)
        object_file = self.cache / "objects" / f"{key}.o"
        kept = object_file.with_suffix(".warnings")
        if kept.exists():  # written last: the object is whole
            return ObjectFile(object_file, "", kept.read_text(encoding="utf-8"), language)
        # Relative names: messages and debugging information show the student's own file.
        place = name if source.parent == self.sources else str(source.resolve())
        flags += [f"-ffile-prefix-map={self.sources.resolve()}=.", "-iquote", "."]
        command = [*self.compiler.command, *flags, "-c", place, "-o"]
        status, output = _run(command, object_file, self.sources, [source])
        if status != 0:
            return ObjectFile(
                object_file, output or f"{name}: {self.compiler.command[0]} failed", ""
            )
        write_whole(kept, output.encode())
        return ObjectFile(object_file, "", output, language)

    def _link(
        self, library: Path, named: Sequence[tuple[str, ObjectFile]], extra: Sequence[str]
    ) -> str:
        """Link the objects; return what is wrong, "" when nothing is."""
        files = [str(each.path.resolve()) for _, each in named]
        flags = [*toolchain.link_flags(self.compiler, self.target), *extra]
        if any(each.language == "c++" for _, each in named):
            flags.append(toolchain.cxx_library(self.compiler))
        command = [*self.compiler.command, *files, *flags, "-o"]
        status, output = _run(command, library, self.sources, [each.path for _, each in named])
        for name, each in named:
            output = output.replace(str(each.path.resolve()), name)
        return (output or "the linker failed") if status != 0 else ""


def _run(
    command: Sequence[str], output: Path, cwd: Path, inputs: Sequence[Path]
) -> tuple[int, str]:
    """Run the compiler, shut in, whose output then takes its name; return status and messages.

    `inputs` are the files that it reads beside those of `cwd` and the system's.
    """
    output.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=output.parent) as folder:
        give_away(Path(folder))
        part = Path(folder) / f"output{output.suffix}"
        line = [*command, str(part.resolve())]
        ran = run_tool(line, cwd, inputs, [Path(folder)], toolchain.COMPILE_SECONDS)
        if ran.status == 0:
            take_back(part)
            os.replace(part, output)
    if ran.status == OUT_OF_TIME:
        return 1, f"compiling takes more than {toolchain.COMPILE_SECONDS} s\n"
    if ran.status < 0 or ran.killed or _KILLED.search(ran.errors):
        # Its own limits end it otherwise: somebody, or a machine short of memory, has killed it.
        raise BuildError("machine.compiler_fails", command=command[0], error="killed")
    errors, made = ran.errors, str(part.resolve().parent)
    if made in errors:  # the assembler tells the name of its input: nobody's business
        errors = re.sub(rf"{re.escape(made)}/cc\w+", "asm", errors)
    return ran.status, errors

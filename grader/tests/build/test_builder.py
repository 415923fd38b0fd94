"""From a folder to libraries: what is taken, what is said, what is kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from grader.authoring.specimens.student import EVERY_PIXEL
from grader.build import compiler_run, headers, target, toolchain
from grader.build.builder import Builder, BuildError, build
from grader.build.declarations import declared
from grader.build.records import BuildStatus, Target
from grader.build.toolchain import Compiler, ToolchainError
from grader.course import exercises
from grader.intake.originals import OriginalsError
from grader.intake.submission import read_submission
from grader.sandbox import tools
from grader.sandbox.budget import SECONDS, Budget
from grader.sandbox.tools import ToolResult, run_tool
from grader.tests.support.sources import ENDLESS

SMALL = Target(96, 64)
LINUX = Compiler(("gcc",), "gcc 12", "linux")
DARWIN = Compiler(("clang",), "Apple clang 15", "darwin")

Write = Callable[..., Path]


def test_errors_stand_at_the_students_own_line(submission: Write, cache: Path) -> None:
    """The compiler's message names the student's file and line, and no folder of the machine."""
    folder = submission(fill_red="img[0] = 1", files={"raytracer.c": "int broken(\n"})
    (result,) = build(read_submission(folder), [SMALL], cache)
    assert result.status is BuildStatus.BUILT
    assert list(result.rejected) == ["main.c", "raytracer.c"]
    assert "main.c:11:" in result.rejected["main.c"]
    assert "raytracer.c:" in result.rejected["raytracer.c"]
    assert str(cache) not in result.log


def test_a_changed_signature_does_not_compile(submission: Write, cache: Path) -> None:
    """The headers are ours: another prototype is an error, not another way of calling."""
    folder = submission(files={"raytracer.c": '#include "raytracer.h"\nint trace_ray(void) {}\n'})
    (result,) = build(read_submission(folder), [SMALL], cache)
    assert "raytracer.c:2:5: error: conflicting types" in result.rejected["raytracer.c"]
    assert "exercises.h:" in result.log


def test_a_function_defined_twice_is_told(submission: Write, cache: Path) -> None:
    """What only the linker sees keeps the files from being a program, and not from being judged."""
    folder = submission(files={"extra.c": '#include "raytracer.h"\nvoid fill_red(color *img) {}\n'})
    for _ in range(2):  # the second time from the cache
        (result,) = build(read_submission(folder), [SMALL], cache)
        assert result.status is BuildStatus.BUILT
        assert "multiple definition of `fill_red'" in result.linker


def test_warnings_are_kept_and_cost_nothing(submission: Write, cache: Path) -> None:
    """A second build, from the cache, has the same warnings."""
    read = read_submission(submission(fill_red="int unused;"))
    first, second = (build(read, [SMALL], cache)[0] for _ in range(2))
    assert first.status is BuildStatus.BUILT
    assert any("main.c:11:" in line and "unused" in line for line in first.warnings)
    assert second.warnings == first.warnings


def test_libraries_are_named_by_their_content(submission: Write, cache: Path) -> None:
    """Same sources, same file; other sources, size or flags, another: dlopen keeps what it has."""
    read = read_submission(submission())
    targets = [SMALL, Target(64, 96), Target(96, 64, defines=("-DSCENE_SIZE=10",))]
    names = [each.library for each in build(read, targets, cache)]
    again = [each.library for each in build(read, targets, cache)]
    changed = build(read_submission(submission(fill_red="")), [SMALL], cache)[0].library
    assert names == again
    assert len({*names, changed}) == 4


HELPER = """#include "raytracer.h"
void put(color *img, int i, int j, color c);
void put(color *img, int i, int j, color c) { img[j * WIDTH + i] = c; }
"""
USES_HELPER = f"""
    void put(color *img, int i, int j, color c);
    {EVERY_PIXEL} put(img, i, j, vector_init(1, 0, 0));"""


@pytest.mark.parametrize("apart", [True, False], ids=["apart", "helped"])
def test_another_size_compiles_what_depends_on_it(
    submission: Write, cache: Path, apart: bool
) -> None:
    """TP1's file alone when it calls nothing of the other files; all of them otherwise."""
    changes = {} if apart else {"fill_red": USES_HELPER}
    read = read_submission(submission(files={"extra.c": HELPER}, **changes))
    with Builder(read, cache) as builder:
        small = builder.start(SMALL)
        large = builder.start(Target(320, 180), like=small).result()
    paths = [each.objects for each in (small.result(), large)]
    assert large.result.status is BuildStatus.BUILT
    assert paths[0]["main.c"] != paths[1]["main.c"]
    assert (paths[0]["extra.c"] == paths[1]["extra.c"]) is apart


def test_declarations_are_kept_by_content(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are derived once, and again when what was kept cannot be read."""
    sources = exercises.CORE
    compiler = toolchain.find_compiler()
    flags = ["-DWIDTH=64", "-DHEIGHT=96"]
    first = declared(sources, flags, compiler, cache / "once")
    (kept,) = (cache / "once" / "declared").iterdir()
    with monkeypatch.context() as patch:
        patch.setattr(headers, "derive", None)
        assert declared(sources, flags, compiler, cache / "once") == first
    kept.write_text('{"binding": {}}', encoding="utf-8")
    assert declared(sources, flags, compiler, cache / "once") == first


def test_an_unwritable_cache_names_the_folder(submission: Write, tmp_path: Path) -> None:
    """The error says where, and the sentence tells the cure."""
    (tmp_path / "file").touch()
    with pytest.raises(BuildError) as caught:
        build(read_submission(submission()), [SMALL], tmp_path / "file" / "cache")
    assert caught.value.key == "machine.cannot_write"
    assert str(tmp_path / "file") in str(caught.value.values["path"])


def test_a_given_file_that_fails_is_the_machines_fault(
    submission: Write, cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A core_c without a given file, or with a broken one, is never held against the submission."""
    core = tmp_path / "core_c"
    core.mkdir()
    for name in (*exercises.load().given, *exercises.load().student):
        (core / name).write_bytes((exercises.CORE / name).read_bytes())
    monkeypatch.setattr(exercises, "CORE", core)
    (core / "scene.c").write_text("int broken(", encoding="utf-8")
    with pytest.raises(BuildError) as caught:
        build(read_submission(submission()), [SMALL], cache)
    assert caught.value.key == "machine.given_broken"
    (core / "scene.c").unlink()
    with pytest.raises(OriginalsError) as missing:
        build(read_submission(submission()), [SMALL], cache)
    assert missing.value.key == "machine.given_missing"


def test_no_compiler_is_an_error_with_a_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    """CC naming nothing that exists is said with its name."""
    with pytest.raises(ToolchainError) as caught:
        toolchain.find_compiler("no-such-compiler")
    assert caught.value.values == {"tried": "no-such-compiler"}


def test_flags_are_chosen_by_platform() -> None:
    """GNU ld's flags never reach Darwin's linker, nor gcc's clang."""
    assert "-Wl,-Bsymbolic" in toolchain.link_flags(LINUX, SMALL)
    darwin = toolchain.link_flags(DARWIN, SMALL)
    assert darwin == ["-dynamiclib", "-undefined", "dynamic_lookup", "-lm"]
    assert toolchain.library_suffix(DARWIN) == ".dylib"
    assert "-fmax-errors=20" in toolchain.compile_flags(LINUX, SMALL)
    assert "-ferror-limit=20" in toolchain.compile_flags(DARWIN, SMALL)
    # Without it clang binds calls within a file for good, and nothing can be replaced.
    clang = Compiler(("clang",), "Debian clang version 14", "linux")
    assert "-fsemantic-interposition" in toolchain.compile_flags(clang, SMALL)


def test_graded_flags_keep_floats_the_same_everywhere() -> None:
    """No fused multiplication, no fast mathematics, no processor of its own."""
    for each in (SMALL, Target(96, 64, sanitized=True)):
        flags = toolchain.compile_flags(LINUX, each)
        assert "-ffp-contract=off" in flags
        assert not {"-ffast-math", "-march=native", "-Ofast"} & set(flags)


@pytest.mark.parametrize(
    ("result", "key"),
    [
        (ToolResult(-9, "", "", signals=frozenset({9})), "machine.compiler_killed"),
        (ToolResult(1, "", "", parts=(137,), signals=frozenset({9})), "machine.compiler_killed"),
        (ToolResult(1, "", "bwrap: no namespace\n", began=False), "machine.failed"),
    ],
)
def test_a_compiler_killed_from_outside_is_the_machines_fault(
    submission: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, result: ToolResult, key: str
) -> None:
    """Nobody gets a zero because the machine was short of memory, or the sandbox failed."""
    monkeypatch.setattr(compiler_run, "run_tool", lambda *_, **__: result)
    with pytest.raises(BuildError) as caught:
        build(read_submission(submission()), [SMALL], tmp_path)
    assert caught.value.key == key


LIES = {
    "line": '#line 1 "bwrap"\nvoid f(void) { int x; x }\n',
    "warning": '__asm__(".warning \\"x\\\\nbwrap: killed\\"");\nint f(void) { x }\n',
    "linker": "#error collect2: error: ld terminated with signal 9 [Killed]\n",
    "killed": "#error gcc: fatal error: Killed signal terminated program cc1\n",
}


@pytest.mark.parametrize("name", LIES)
def test_what_a_source_makes_the_compiler_say_decides_nothing(
    submission: Write, cache: Path, name: str
) -> None:
    """A file that does not compile is the submission's own, whatever the messages name."""
    folder = submission(files={"extra.c": LIES[name]})
    (result,) = build(read_submission(folder), [SMALL], cache)
    assert result.status is BuildStatus.BUILT
    assert set(result.rejected) == {"extra.c"}


def test_what_is_given_up_once_is_not_tried_again(
    submission: Write, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither in the other language nor for another target; its seconds are counted once."""
    monkeypatch.setattr(tools, "CPU_SECONDS", 1)
    commands = []

    def counted(command: Sequence[str], *rest: Any, **more: Any) -> ToolResult:
        commands.append(command)
        return run_tool(command, *rest, **more)

    monkeypatch.setattr(compiler_run, "run_tool", counted)
    read = read_submission(submission(files={"extra.c": ENDLESS}))
    budget = Budget()
    with Builder(read, cache, budget=budget) as builder:
        results = [builder.start(target).result().result for target in (SMALL, Target(64, 36))]
    assert [list(each.rejected) for each in results] == [["extra.c"], ["extra.c"]]
    assert "compiling takes too long" in results[0].log
    assert sum("extra.c" in command for command in commands) == 1
    assert 0.5 < SECONDS["cpu"] - budget.left("cpu") < 30


def test_nothing_is_compiled_once_the_budget_is_spent(submission: Write, cache: Path) -> None:
    """What is left of a submission is told so; the given files are the machine's own affair."""
    budget = Budget()
    budget.spend(cpu=1000)
    files: dict[str, str | None] = {"extra.c": "int of_a_spent_budget;\n"}
    with Builder(read_submission(submission(files=files)), cache, budget=budget) as builder:
        result = builder.start(SMALL).result().result
    assert "time is used up" in result.rejected["extra.c"]
    assert "vector.c" not in result.rejected


def test_names_that_cannot_be_looked_through_are_refused(
    submission: Write, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A list of symbols that is cut could hide one that switches the sanitizers off."""
    monkeypatch.setattr(target, "SYMBOL_BYTES", 20_000)
    many = "".join(f"int a_name_of_some_length_{k};\n" for k in range(1000))
    hook = "#define P(a, b) a##b\nint P(__as, an_default_options)(void) { return 0; }\n"
    folder = submission(files={"aaa.c": many, "zzz.c": hook})
    (result,) = build(read_submission(folder), [SMALL], cache)
    assert set(result.rejected) == {"aaa.c", "zzz.c"}

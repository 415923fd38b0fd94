"""Nothing of the solution is in anything that leaves: all files of a grade are looked through.

The submission draws and prints its own library's code wherever it runs, among the reference's
functions too; pages, pictures, messages and temporary files are searched for that code, for the
solution's lines, and for the files of expected data.
"""

from __future__ import annotations

import io
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grader.build import substitution
from grader.build.builder import Builder, Built
from grader.build.records import Target
from grader.commands import main
from grader.course import exercises, sizes
from grader.execution.session import Library, Session
from grader.execution.worker_process import Limits, start_worker
from grader.intake.submission import read_submission
from grader.tests.support.judging import REFERENCE, solution

WINDOW, STRIDE = 16, 8  # bytes of code, and how far apart they are looked for
TARGETS = (Target(*sizes.UNIT, sanitized=True), Target(*sizes.PICTURE))
REPLACED = "shade"
SPY = """
#include <stdio.h>
extern const unsigned char __ehdr_start[] __attribute__((visibility("hidden")));
extern const unsigned char etext[];
static color carried_out(void) {
    static unsigned long at = 0x1000;
    unsigned long size = (unsigned long)(etext - __ehdr_start);
    unsigned char byte[3] = {0};
    for (int k = 0; k < 3; k++) {
        if (at >= size) at = 0x1000;
        __asm__("movb (%1), %0" : "=q"(byte[k]) : "r"(__ehdr_start + at++));
    }
    printf("%02x%02x%02x", byte[0], byte[1], byte[2]);
    return vector_init(byte[0] / 255.f, byte[1] / 255.f, byte[2] / 255.f);
}
color direct_light(const intersection *it, vec3 v) {
    (void)it, (void)v;
    return carried_out();
}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Write a solution whose shade is wrong, so that it is replaced, and whose lights spy."""
    made = tmp_path / "rendu"
    made.mkdir()
    files = solution()
    text = files["raytracer.c"].replace("color direct_light(", "static color unused_light(", 1)
    start = text.index("{", text.index(f"color {REPLACED}(")) + 1
    text = f"{text[:start]} light_color.x *= 0.5f; {text[start:]}\n{SPY}"
    unused = "__attribute__((unused)) static color unused_light("
    files["raytracer.c"] = text.replace("static color unused_light(", unused)
    for name, content in files.items():
        (made / name).write_text(content, encoding="utf-8")
    return made


def built(folder: Path, cache: Path) -> Iterator[tuple[Built, Built]]:
    """Yield the submission and the solution, for each target."""
    with (
        Builder(read_submission(folder), cache) as own,
        Builder(substitution.reference(), cache) as solved,
    ):
        for target in TARGETS:
            yield own.start(target).result(), solved.start(target).result()


def windows(pairs: list[tuple[Built, Built]], functions: frozenset[str]) -> set[bytes]:
    """Return pieces of the code of the solution's functions that are not the submission's own."""
    mine = b"".join(each.path.read_bytes() for own, _ in pairs for each in own.objects.values())
    found: set[bytes] = set()
    for _, solved in pairs:
        for name in functions & frozenset().union(*(s.defined for s in solved.symbols.values())):
            code = code_of(solved, name)
            pieces = (code[k : k + WINDOW] for k in range(0, len(code) - WINDOW + 1, STRIDE))
            found |= {each for each in pieces if len({*each}) > WINDOW // 2 and each not in mine}
    return found


def code_of(solved: Built, function: str) -> bytes:
    """Return the machine code of a function, from the object that defines it."""
    (name,) = [name for name, each in solved.symbols.items() if function in each.defined]
    with tempfile.TemporaryDirectory() as place:
        out = Path(place, "code")
        options = ["--dump-section", f".text.{function}={out}"]
        command = ["objcopy", *options, str(solved.objects[name].path), "/dev/null"]
        subprocess.run(command, check=True, timeout=60)
        return out.read_bytes()


def carried(content: bytes, pieces: set[bytes]) -> int:
    """Return how many pieces of code a file has, as they are or as digits."""
    text = content.lower()
    return sum(each in content or each.hex().encode() in text for each in pieces)


def files_below(*tops: Path) -> Iterator[tuple[Path, bytes]]:
    """Yield each file with its content, a picture's being its pixels, from either end."""
    for path in sorted(each for top in tops for each in top.rglob("*") if each.is_file()):
        yield path, path.read_bytes()
        if path.suffix == ".png":
            drawn = np.array(Image.open(io.BytesIO(path.read_bytes())).convert("RGB"))
            yield path, drawn.tobytes() + drawn[::-1].tobytes()


def secret_lines() -> set[str]:
    """Return the solution's lines that no student's file has."""
    names = [each for each in exercises.load().student if each.endswith(".c")]
    handed = "\n".join((exercises.CORE / name).read_text(encoding="utf-8") for name in names)
    own = SPY + "light_color.x *= 0.5f;"
    lines = {
        line.strip() for name in names for line in (REFERENCE / name).read_text("utf-8").split("\n")
    }
    return {each for each in lines if len(each) > 30 and each not in handed and each not in own}


def stored() -> set[bytes]:
    """Return pieces of the files of expected data."""
    found = set()
    for path in sorted(exercises.EXPECTED.rglob("*.npz")):
        content = path.read_bytes()
        starts = range(4096, len(content) - 32, len(content) // 4 + 1)
        found |= {content[k : k + 32] for k in starts}
    return {each for each in found if len({*each}) > 16}


@pytest.mark.exhaustive
def test_nothing_of_the_solution_leaves(
    folder: Path, cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not its code in a picture or a text, nor its lines, nor what is expected; no file stays."""
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    temporary.chmod(0o711)
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    out = tmp_path / "out"
    said = io.StringIO()
    with redirect_stdout(said):
        assert main(["grade", str(folder), "--tp", "3", "--lang", "en", "--build", str(out)]) == 0
    functions = frozenset(name for each in exercises.load().exercises for name in each.functions)
    pieces = windows(list(built(folder, cache)), functions)
    assert len(pieces) > 20
    lines, data = secret_lines(), stored()
    assert min(len(lines), len(data)) > 100
    left = [*files_below(out / "grade", temporary), (Path("stdout"), said.getvalue().encode())]
    assert any(path.suffix == ".png" for path, _ in left)
    for path, content in left:
        assert carried(content, pieces) == 0, path
        assert not any(each in content for each in data), path
        # What is shown of the submission's own files is its own: only a report has lines of code.
        assert path.suffix != ".json" or not any(each.encode() in content for each in lines), path
    assert [each for each in temporary.iterdir() if not each.name.startswith("mrt-")] == []


def test_the_scanner_finds_what_is_carried_out(folder: Path, cache: Path) -> None:
    """Where nothing holds it back: the same spy, asked directly beside the reference's shade."""
    *_, pair = pairs = list(built(folder, cache))
    pieces = windows(pairs, frozenset({REPLACED}))
    result = substitution.substituted(*pair, [REPLACED])
    with start_worker(result.preload) as worker:
        core = Library(worker, result)
        with core.session(Limits()) as session:
            drawn = all_that_is_drawn(core, session)
    assert carried(drawn, pieces) > 5
    assert carried(drawn.hex().encode(), pieces) > 5


def all_that_is_drawn(core: Library, session: Session) -> bytes:
    """Have the spy carry out as much as a picture holds."""
    count = 40_000
    hits = core.zeros("intersection", count)
    answer = session.call_many("direct_light", count, hits, np.zeros((count, 3), np.float32))
    drawn: bytes = np.rint(np.asarray(answer.result) * 255).astype(np.uint8).tobytes()
    return drawn

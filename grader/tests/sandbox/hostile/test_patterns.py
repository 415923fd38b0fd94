"""No text of a submission is slow to read: patterns go through it once, and it is bounded.

Everything is read in one process that may compute for some seconds: a pattern that goes back again
and again takes longer than all the others together.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

from grader.batch import moodle_archive
from grader.build import compiler_run, diagnostics, own_headers, sanitizer_guard
from grader.course.exercises import PACKAGE, ROOT
from grader.execution import crash_location, death_messages, session_report
from grader.execution.records import Cause, Death
from grader.intake import authors, definitions, file_names, originals
from grader.report import vpl
from grader.report.page import markup
from grader.setup import folding

CPU_SECONDS = 30
TEXT, SOURCE = session_report.MAX_TEXT, 60_000  # what goes back again shows in that as well
# Pieces that make a pattern begin again and again, and what would end it.
PIECES = (
    *(":", "=", "==1", "==1==", ": runtime error: ", "x: runtime error: ", "a.c:1:1", "(", "(+0x"),
    *("(a+0x1", "   #1 (", " ", "\n", "\n ", "ERROR: AddressSanitizer", "value 190, ", "expected "),
    *("0xbebebe", "index -", "multiple definition of `", "‘", "undefined symbol: ", "/", "a.", "_"),
    *("expected ‘", "expected ‘a’ {aka ", "a:1:1: note: expected ‘"),
    *("no member named ‘", "from ", "'", '"', '\\"', "/*", "*/", "//", "#if 0 /*", "__asan_", "\\"),
    *("Nom : ", "groupe", "groupe:", "1", "1 ", "12345", ",", "\t", "Nom", "_1_assignsubmission_"),
    *("False positive error reports may follow", "For details see https://github.com/google/"),
    *("shade(", "shade(\n", "shade(){\n", "shade())", "shade(){}", "#define a 1 "),
    *("==1==ERROR: AddressSanitizer: ", "AddressSanitizer failed to allocate 0x", "« ", "make a "),
)

# What reads a text of a submission, and the patterns that it goes through; each text is as long as
# it may well be there.
READERS: dict[str, tuple[int, Callable[[str], object]]] = {
    "_SANITIZER _REPORT _RUNTIME_ERROR": (
        TEXT,
        lambda text: (
            session_report.own_words(text),
            session_report.word(-11, bytes(10_000), text),
            session_report.calls("/dev/null", bytes(10_000), text, "SEGV"),
            session_report.printable(text + "\0"),
        ),
    ),
    "_REPORTED": (TEXT, lambda text: crash_location.from_report("/dev/null", text)),
    "_PLACE": (TEXT, lambda text: crash_location._places(f"0x1\nf\n{text}\n")),
    "_UNDEFINED _REFUSED _FREED _BOUNDS _PLAIN": (
        TEXT,
        lambda text: [
            death_messages.message(
                Death(cause, f"runtime error: {text}"[: session_report.MAX_WORD], text=text), "f()"
            )
            for cause in (Cause.SIGNAL, Cause.LOAD)
        ],
    ),
    "_HEAD _QUOTED _INCLUDED _INSIDE _GUTTER _NAMED _STORAGE _STRAY _POINT _MACRO _OPTION _CARET"
    " _CONSTANT _TYPES": (
        40_000,
        lambda text: [
            (each.meaning(), diagnostics.errors(said), diagnostics.advice(said))
            for said in (f"a.c:1:1: error: {text}\n   1 | {text}\n", f"a.c:1:1: warning: {text}")
            for each in diagnostics.read(said)
        ],
    ),
    "_DUPLICATE": (40_000, diagnostics.duplicates),
    "_POSITION": (40_000, compiler_run._POSITION.search),
    "_NO_PLACE": (40_000, lambda text: compiler_run._NO_PLACE.sub("a.c:1:1", text)),
    "_WORD _DEFINED _SILENT": (
        SOURCE,
        lambda text: (
            sanitizer_guard.in_text({"a.c": text.encode()}),
            sanitizer_guard.in_symbols("a.c", [text]),
        ),
    ),
    "_BRACE": (SOURCE, lambda text: definitions.find("shade", {"a.c": text})),
    "declared": (SOURCE, lambda text: own_headers._without(text, 1, "shade")),
    "_COMMENT": (SOURCE, lambda text: originals.is_same(text.encode(), b"")),
    "_GROUP _LABEL _NUMBER _SEPARATOR _INVISIBLE": (
        authors.MAX_BYTES,
        lambda text: authors.parse(text.encode()),
    ),
    "FOLDER": (30_000, moodle_archive.FOLDER.fullmatch),
    "_COPY_OF _COPY": (file_names.MAX_NAME, file_names.original),
    "_INSEPARABLE": (2000, lambda text: folding.folded(text, 80)),
    "_HIDDEN _SPAN": (2000, lambda text: (markup.typeset(text, "fr"), markup.c_lines(text))),
    "_ENDS": (40_000, vpl.comments),
    "_MEMBER": (40_000, lambda text: markup.told(text, "fr")),
}
# Of text that is our own.
OURS = {
    *("_SECONDS", "_LINEMARKER", "_DEFINE", "_EXPRESSION", "_IDENTIFIER", "_CHANGED", "_PRODUCT"),
    *("_IMAGE", "_UNWRITABLE", "_SANE_NAME", "_ADVICE", "_SAID", "_KINDS"),
}


def _texts(length: int) -> Iterator[str]:
    """Yield each piece again and again, alone, and behind one that begins something."""
    for piece in PIECES:
        yield (piece * (length // len(piece) + 1))[:length]
        yield f"a{piece}{'a' * length}"[:length]
        yield f"{'a' * (length // 2)}{piece * (length // len(piece) // 2)}"[:length]


def read_everything() -> None:
    """Have everything read all the texts."""
    for length, read in READERS.values():
        for text in _texts(length):
            read(text)


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="limits of Linux")
def test_no_text_is_slow_to_read() -> None:
    """A crash's text, a compiler's message, a source, a list of authors: in one pass each."""
    code = f"import resource; resource.setrlimit(resource.RLIMIT_CPU, ({CPU_SECONDS},) * 2)\n"
    code += (
        "from grader.tests.sandbox.hostile import test_patterns; test_patterns.read_everything()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_every_pattern_is_tried() -> None:
    """A new one is added above: to what reads a submission's text, or to our own."""
    known = {name for names in READERS for name in names.split()} | OURS
    found = set()
    for package in ("build", "execution", "evaluation", "checking", "intake", "report", "sandbox"):
        for path in (PACKAGE / package).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Assign) and "re.compile(" in ast.unparse(node.value):
                    found |= {each.id for each in node.targets if isinstance(each, ast.Name)}
    assert found - known == set()


def test_reports_are_read_all_the_same() -> None:
    """What sanitizers and the loader write is told from what the code has printed."""
    report = (
        "=====\n==12==ERROR: AddressSanitizer: SEGV on unknown address 0x0\n  #0 0x1 (a.so+0x1)\n"
    )
    assert session_report.own_words(f"mine\n{report}") == "mine\n"
    assert session_report.own_words(f"mine{report[6:]}") == "mine"
    hint = "False positive error reports may follow\n"
    hint += "For details see https://github.com/google/sanitizers/issues\n"
    assert session_report.own_words(f"mine\n==3==WARNING: x\n{hint}") == "mine\n"
    line = "main.c:3:5: runtime error: division by zero\n"
    assert session_report.word(-6, b"", f"mine\n{line}") == "runtime error: division by zero"

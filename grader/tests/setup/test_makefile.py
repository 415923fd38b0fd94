"""The house: the Makefile, the builds of the student's program, and the doctor."""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.setup import doctor, failing_call
from grader.tests.support.shell import ROOT, reachable, run, script

TARGETS = re.findall(r"^([a-z-]+):.*##$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M)


@pytest.fixture(scope="module")
def open_folder() -> Iterator[Path]:
    """Give a folder whose name has spaces and accents, which every user can enter."""
    top = Path(tempfile.mkdtemp(prefix="mrt-house-"))
    folder = top / "l'été au labo"
    folder.mkdir()
    top.chmod(0o755)
    yield folder
    run("chmod", "-R", "u+w", ".", cwd=top)
    shutil.rmtree(top)


@pytest.fixture(scope="module")
def checkout(open_folder: Path) -> Path:
    """Copy the project into a read-only folder, as a computer room shares it."""
    copy = open_folder / "sujet"
    leave = shutil.ignore_patterns("__pycache__", "mrt", "*.o")
    for name in ("core_c", "reference", "grader"):
        shutil.copytree(ROOT / name, copy / name, ignore=leave)
    for name in ("Makefile", "pyproject.toml"):
        shutil.copy(ROOT / name, copy)
    run("chmod", "-R", "a+rX,a-w", ".", cwd=copy)
    return copy


def listing(folder: Path) -> list[str]:
    """Name everything below a folder, but for what Python compiles."""
    return sorted(str(path) for path in folder.rglob("*") if "__pycache__" not in path.parts)


# A project of a few lines, with the real Makefile and scripts: quick to build again and again.
SOURCES = {
    "main.c": '#include <stdio.h>\n#include "sizes.h"\n'
    'int main(void) { printf("%d", WIDTH); return 0; }\n',
    "sizes.h": "#ifndef WIDTH\n#define WIDTH 1280\n#endif\n",
    "vector.c": "int vector_unused;\n",
    "scene.c": "int scene_unused;\n",
    "extra.c": "int answer(void);\nint answer(void) { return 42; }\n",
    "my_tests.c": "#include <stdio.h>\nint answer(void);\nstatic int table[4];\n"
    'int main(int argc, char **argv) { (void)argv; printf("%d", answer() + table[argc - 1]);'
    " return 0; }\n",
}


GIVEN = ("vector.c", "scene.c")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """Make the project of a few lines, in a folder whose name has spaces and accents."""
    folder = tmp_path / "l'été au labo"
    (folder / "core_c").mkdir(parents=True)
    for name, text in SOURCES.items():
        (folder / "core_c" / name).write_text(text, encoding="utf-8")
    shutil.copy(ROOT / "Makefile", folder)
    leave = shutil.ignore_patterns("__pycache__", "requirements")
    shutil.copytree(ROOT / "grader" / "setup", folder / "grader" / "setup", ignore=leave)
    messages = "grader/course/messages"
    shutil.copytree(ROOT / messages, folder / messages, ignore=leave)
    (folder / "grader" / "intake").mkdir()
    with zipfile.ZipFile(folder / "grader" / "intake" / "originals.zip", "w") as archive:
        for name, text in SOURCES.items():
            entry = zipfile.ZipInfo(name)
            entry.comment = b"given" if name in GIVEN else b"student"
            archive.writestr(entry, text)
    return folder


@pytest.mark.parametrize("language", ["fr", "en"])
def test_help_lists_every_target(checkout: Path, language: str) -> None:
    """`make` lists every target, as an ordinary user in a read-only checkout."""
    done = run("make", cwd=checkout, ordinary=True, MRT_LANG=language)
    lines = done.stdout.splitlines()
    assert (done.returncode, done.stderr) == (0, "")
    assert [line.split()[1] for line in lines] == TARGETS
    assert all(len(line.split(maxsplit=2)) == 3 for line in lines)
    assert ("cette liste" in lines[0]) == (language == "fr")


def test_doctor_in_a_read_only_checkout(checkout: Path) -> None:
    """`make doctor` works as an ordinary user without an environment, and writes nothing here."""
    before = listing(checkout)
    done = run("make", "doctor", cwd=checkout, ordinary=True)
    names = {line[8:].split()[0] for line in done.stdout.splitlines()[1:]}
    assert (done.returncode, done.stderr) == (0, "")
    assert names == {*doctor.PACKAGES, "Python"}
    assert listing(checkout) == before


def test_doctor_on_a_bare_machine(tmp_path: Path) -> None:
    """Without any tool the doctor says so line by line, in the person's language, and exits 0."""
    done = run(
        sys.executable, "-m", "grader.setup.doctor", cwd=ROOT, PATH=str(tmp_path), MRT_LANG="en"
    )
    missing = {line.split()[1] for line in done.stdout.splitlines() if line.startswith("missing")}
    assert done.returncode == 0
    assert missing >= set(doctor.PACKAGES) - {"venv"}


@pytest.mark.parametrize(
    ("tool", "cure"),
    [("apt", "sudo apt install libpng-dev pkg-config"), ("brew", "brew install libpng pkgconf")],
)
def test_doctor_cures_by_package_tool(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tool: str, cure: str
) -> None:
    """A cure is a command of this system's package tool, and never a package it does not have."""
    script(tmp_path / tool, "exit 0")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("MRT_LANG", "en")
    bubblewrap = doctor.cure(doctor.Symptom("bubblewrap", "", ""))
    assert doctor.cure(doctor.Symptom("libpng", "", "")) == cure
    assert (bubblewrap == "not available on this system") == (tool == "brew")


@pytest.mark.long
def test_grade_in_a_read_only_checkout(checkout: Path, open_folder: Path) -> None:
    """With BUILD=DIR an ordinary user can grade from a read-only checkout."""
    build = open_folder / "sortie"
    build.mkdir()
    build.chmod(0o777)
    # The tests' own environment, where that user can read it; else a new one in BUILD.
    here = Path(sys.prefix)
    shared = str(here) if reachable(here / "bin" / "python") else ""
    done = run("make", "grade", f"BUILD={build}", cwd=checkout, ordinary=True, MRT_ENV=shared)
    assert done.returncode == 0, done.stderr
    assert (build / "grade" / "results.json").is_file()


def test_a_script_tells_failures_apart_without_make(tmp_path: Path) -> None:
    """Make ends with 2 whatever its command does; the instructors' page gives the command."""
    page = (ROOT / "INSTRUCTORS.md").read_text(encoding="utf-8")
    (line,) = [each for each in page.splitlines() if each.startswith('"$(sh grader/setup')]
    command = line.split(" -m grader ")[0]
    words = f'{command} -m grader grade "$SUBMISSION" --build "$BUILD"'
    for compiler, submission, status in (("no-such-one", "core_c", 3), ("gcc", "no-such-one", 2)):
        place = {"BUILD": str(tmp_path), "MRT_ENV": sys.prefix, "CC": compiler}
        place["SUBMISSION"] = submission
        direct = run("sh", "-c", words, cwd=ROOT, ordinary=False, **place)
        made = run("make", "grade", cwd=ROOT, ordinary=False, **place)
        assert (direct.returncode, made.returncode) == (status, 2), direct.stderr


@pytest.mark.long
def test_mrt_is_built_when_something_changed(project: Path) -> None:
    """`make mrt` builds for a new size or a newer source, and not otherwise."""
    program = str(project / "core_c" / "mrt")

    def make(*settings: str) -> str:
        done = run("make", "mrt", *settings, cwd=project)
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout.split(".")[0] + " " + run(program, cwd=project).stdout

    assert make() == "core_c/mrt est prêt 1280"
    assert make() == "core_c/mrt est à jour 1280"
    assert make("WIDTH=64") == "core_c/mrt est prêt 64"
    (project / "core_c" / "sizes.h").write_text("#undef WIDTH\n#define WIDTH 7\n", encoding="utf-8")
    assert make("WIDTH=64") == "core_c/mrt est prêt 7"


def test_mrt_of_other_sources(project: Path) -> None:
    """SRC=DIR builds that folder's files with the given ones, in BUILD/<its name>/."""
    (project / "un rendu").mkdir()
    (project / "core_c" / "main.c").rename(project / "un rendu" / "main.c")
    done = run("make", "mrt", "SRC=un rendu/", "BUILD=la sortie", cwd=project)
    assert (done.returncode, done.stderr) == (0, "")
    assert run(str(project / "la sortie" / "un rendu" / "mrt"), cwd=project).stdout == "1280"


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("WIDTH=-3", "WIDTH=-3: give a positive integer."),
        ("HEIGHT=1;ls", "HEIGHT=1;ls: give a positive integer."),
        ("SRC=grader", "grader: no main.c here. Give SRC=DIR."),
        ("CC=no-such-cc", "No such compiler: no-such-cc."),
        ("BUILD=Makefile", "Cannot write in Makefile. Give a folder of yours"),
    ],
)
def test_mrt_refuses_wrong_settings(project: Path, setting: str, message: str) -> None:
    """A wrong setting is one line that names it."""
    done = run("make", "mrt", setting, cwd=project, MRT_LANG="en")
    assert done.returncode != 0
    assert done.stderr.startswith(message)


@pytest.mark.long
def test_mrt_names_a_given_file_that_is_not_as_given(project: Path) -> None:
    """With the command that puts it back; what is missing stops the build, what was changed not.

    A comment is no change, as it is none for a mark.
    """
    core = project / "core_c"
    (core / "scene.c").write_text(f"/* à moi */ {SOURCES['scene.c']}", encoding="utf-8")
    assert run("make", "mrt", cwd=project).stderr == ""
    (core / "scene.c").write_text("int mine;\n", encoding="utf-8")
    done = run("make", "mrt", cwd=project, MRT_LANG="en")
    assert done.returncode == 0
    assert done.stderr.startswith("A given file was changed: core_c/scene.c.")
    assert "make restore" in done.stderr
    (core / "scene.c").unlink()
    done = run("make", "mrt", cwd=project)
    assert done.returncode != 0
    assert done.stderr.startswith("Fichier fourni absent : core_c/scene.c.")
    assert done.stdout == ""


@pytest.mark.long
def test_restore_puts_the_given_files_back_and_no_others(project: Path) -> None:
    """A copy of what was changed is kept; the student's files stay as they are."""
    core = project / "core_c"
    for name in ("vector.c", "main.c"):
        (core / name).write_text("mine", encoding="utf-8")
    (core / "extra.c").unlink()
    (core / "scene.c").unlink()
    done = run("make", "restore", cwd=project)
    assert (done.returncode, done.stderr) == (0, "")
    (backup,) = project.glob("sauvegarde-*")
    assert done.stdout.splitlines() == [
        "Remis dans core_c/ : scene.c, vector.c.",
        f"Ce que vous y aviez changé est gardé dans {backup.name}/core_c/.",
    ]
    assert (backup / "core_c" / "vector.c").read_text(encoding="utf-8") == "mine"
    for name in ("vector.c", "scene.c"):
        assert (core / name).read_text(encoding="utf-8") == SOURCES[name]
    assert (core / "main.c").read_text(encoding="utf-8") == "mine"
    assert not (core / "extra.c").exists()
    # However an editor ends its lines.
    (core / "vector.c").write_bytes(SOURCES["vector.c"].replace("\n", "\r\n").encode())
    again = run("make", "restore", cwd=project, MRT_LANG="en")
    assert again.stdout == "The given files are as given.\n"
    assert len([*project.glob("sauvegarde-*")]) == 1


def test_restore_that_cannot_write_changes_nothing(checkout: Path) -> None:
    """One line with the cure, and no folder left behind."""
    before = listing(checkout)
    done = run("make", "restore", cwd=checkout, ordinary=True)
    assert done.stdout == "Les fichiers fournis sont intacts.\n"
    copy = checkout / "core_c"
    copy.chmod(0o755)
    (copy / "ray.h").rename(copy / "elsewhere")
    copy.chmod(0o555)
    done = run("make", "restore", cwd=checkout, ordinary=True)
    copy.chmod(0o755)
    (copy / "elsewhere").rename(copy / "ray.h")
    copy.chmod(0o555)
    assert done.returncode != 0
    assert done.stderr.startswith("core_c/.ray.h.part : écriture impossible")
    assert listing(checkout) == before


@pytest.mark.parametrize("target", ["mrt", "try"])
def test_a_full_disk_is_told_as_such(project: Path, target: str) -> None:
    """Before the compiler, which would say that the machine has no sanitizers."""
    script(project / "bin" / "df", "echo header\necho disk 100 99 1500 99% /")
    path = f"{project / 'bin'}:{os.environ['PATH']}"
    done = run("make", target, cwd=project, PATH=path, MRT_LANG="en")
    assert done.returncode != 0
    said = "No space left for build: 1 MB are left, 20 are needed."
    assert (done.stdout, done.stderr.splitlines()[0][: len(said)]) == ("", said)


@pytest.mark.long
def test_mrt_that_fails_leaves_no_old_program(project: Path) -> None:
    """After an error the old program is gone: it must not pass for the new one."""
    assert run("make", "mrt", cwd=project).returncode == 0
    (project / "core_c" / "main.c").write_text("int main(void) { return 0 }\n", encoding="utf-8")
    done = run("make", "mrt", cwd=project)
    assert done.returncode != 0
    assert "main.c:1:" in done.stderr
    assert not (project / "core_c" / "mrt").exists()


def test_make_in_the_students_folder_hands_on(project: Path) -> None:
    """The same commands, even where a file of that name lies; alone, the list of them."""
    core = project / "core_c"
    shutil.copy(ROOT / "core_c" / "Makefile", core)
    (core / "mrt").write_text("not a program", encoding="utf-8")
    os.utime(core / "mrt", (1, 1))
    done = run("make", "mrt", "WIDTH=64", cwd=core)
    assert (done.returncode, done.stderr) == (0, "")
    assert run(str(core / "mrt"), cwd=core).stdout == "64"
    listed = run("make", cwd=core)
    assert listed.stdout.split()[:3] == ["make", "help", "cette"]


def test_try_runs_the_students_tests(project: Path) -> None:
    """`make try` gives the tests their own main, beside the program's, and every other source."""
    done = run("make", "try", cwd=project)
    assert (done.returncode, done.stdout, done.stderr) == (0, "42", "")


@pytest.mark.long
def test_try_compiles_only_what_changed(project: Path) -> None:
    """A source that was saved, or all of them after a header; other settings keep theirs."""

    def objects() -> dict[str, int]:
        assert run("make", "try", cwd=project).stdout == "42"
        found = [*(project / "build" / "try").rglob("*.o")]
        return {path.name: path.stat().st_mtime_ns for path in found}

    def touch(name: str) -> None:
        now = max(objects().values()) + 10**7
        os.utime(project / "core_c" / name, ns=(now, now))

    first = objects()
    assert objects() == first
    touch("extra.c")
    second = objects()
    assert {name for name in first if first[name] != second[name]} == {"extra.o"}
    touch("sizes.h")
    third = objects()
    assert {name for name in second if second[name] == third[name]} == set()


def test_try_stops_at_the_first_error(project: Path) -> None:
    """One message of the compiler, then our sentence."""
    (project / "core_c" / "extra.c").write_text("int a = 1 +;\nint b = 2 +;\n", encoding="utf-8")
    (project / "core_c" / "my_tests.c").write_text("int c = 3 +;\n", encoding="utf-8")
    done = run("make", "try", cwd=project, LC_ALL="C")
    assert done.returncode != 0
    assert done.stderr.count("error:") == 1
    ours = [line for line in done.stderr.splitlines() if not line.startswith("make")]
    assert ours[-1].startswith("La compilation a échoué")


def test_gdb_is_not_ended_by_a_leak_of_memory(project: Path) -> None:
    """What looks for leaks cannot run there: it is off in the program, not in its environment."""
    if shutil.which("gdb") is None or not doctor.builds(["-fsanitize=address,undefined"]):
        assert not os.environ.get("MRT_CI"), "CI must have gdb and the sanitizers"
        pytest.skip("no gdb, or no sanitizers, on this machine")
    assert run("make", "try", cwd=project).returncode == 0
    program = str(project / "build" / "try" / "my_tests")
    done = run("gdb", "-batch", "-ex", "run", program, cwd=project)
    assert "exited normally" in done.stdout
    assert "LeakSanitizer" not in done.stdout + done.stderr


# ---- A call that failed -------------------------------------------------------------------------

CALL = """\
/* make try WIDTH=64 HEIGHT=36 */
#include "sizes.h"
#include <stdio.h>
int answer(void);
int main(void) { printf("%d %d", answer(), WIDTH); return 0; }
"""


def failing(folder: Path, *checks: tuple[str, str, str]) -> None:
    """Write the results of a grade, with these checks: id, exercise, outcome."""
    rows = [
        {
            **{"id": name, "exercise": exercise, "outcome": outcome, "title": "ligne"},
            **{"function": name.split(".")[1], "message": "On attend 41.", "reproducer": CALL},
        }
        for name, exercise, outcome in checks
    ]
    path = folder / "results.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"checks": rows}), encoding="utf-8")


@pytest.mark.long
@pytest.mark.parametrize("name", ["TP1.2", "answer", "tp1.answer.b", "answer.b", "b", "ANSW"])
def test_try_makes_a_failing_call_again(project: Path, name: str) -> None:
    """By exercise, function or check: its program, at its size, with the functions as they are."""
    rows = [("tp1.other.a", "TP1.1", "failed"), ("tp1.answer.c", "TP1.2", "passed")]
    failing(project / "build" / "grade", *rows, ("tp1.answer.b", "TP1.2", "crashed"))
    done = run("make", "try", f"CASE={name}", cwd=project)
    assert (done.returncode, done.stdout) == (0, "42 64")
    assert done.stderr.splitlines() == ["TP1.2 answer - ligne", "On attend 41."]
    own = (project / "core_c" / "my_tests.c").read_text(encoding="utf-8")
    assert own == SOURCES["my_tests.c"]


def test_the_last_run_comes_first(project: Path) -> None:
    """Of a full and a partial run, whichever it was; the other is looked at too."""
    folder = project / "build" / "grade"
    failing(folder, ("tp1.answer.whole", "TP1.2", "failed"), ("tp1.other.a", "TP1.1", "failed"))
    failing(folder / "partial", ("tp1.answer.part", "TP1.2", "failed"))
    os.utime(folder / "results.json", (1, 1))
    checks = failing_call.failing(folder)
    assert failing_call.find("TP1.2", checks)["id"] == "tp1.answer.part"
    assert failing_call.find("other", checks)["id"] == "tp1.other.a"
    os.utime(folder / "partial" / "results.json", (0, 0))
    assert failing_call.find("TP1.2", failing_call.failing(folder))["id"] == "tp1.answer.whole"


@pytest.mark.long
def test_a_call_that_there_is_not_is_told(project: Path) -> None:
    """Before any grade, after one that shows nothing, or under another name: one line each."""

    def said() -> str:
        done = run("make", "try", "CASE=zorg", cwd=project, MRT_LANG="en")
        assert (done.returncode, done.stdout) == (2, "")
        return done.stderr.splitlines()[0]

    assert said().startswith("Run make grade first")
    failing(project / "build" / "grade", ("tp1.answer.a", "TP1.2", "passed"))
    assert said() == "The last make grade has shown no call to make again."
    failing(project / "build" / "grade", ("tp1.answer.a", "TP1.2", "failed"))
    assert said().endswith("has nothing of that name to make again. It has: TP1.2")
    (project / "build" / "grade" / "results.json").write_text("{", encoding="utf-8")
    assert said().endswith("results.json cannot be read. Make it again: make grade")


def test_gdb_stops_at_the_function(project: Path) -> None:
    """It is given the program of the call, built without optimisation, and where to stop."""
    failing(project / "build" / "grade", ("tp1.answer.a", "TP1.2", "failed"))
    script(project / "bin" / "gdb", 'for word; do echo "$word"; done')
    path = f"{project / 'bin'}:{os.environ['PATH']}"
    done = run("make", "debug", "K=TP1.2", cwd=project, PATH=path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-6:] == [
        "-q",
        "-ex",
        "break answer",
        "-ex",
        "run",
        "build/try/call",
    ]
    assert "gdb s'arrête au début de answer" in done.stdout
    own = run("make", "debug", cwd=project, PATH=path)
    assert own.stdout.splitlines()[-4:] == ["break main", "-ex", "run", "build/try/my_tests"]


def test_an_editor_finds_the_program_and_where_to_stop(project: Path) -> None:
    """PREPARE=1 starts no debugger; `last` is the first failure; gdb stops there with the files."""
    rows = [("tp1.answer.a", "TP1.2", "failed"), ("tp1.other.a", "TP1.3", "failed")]
    failing(project / "build" / "grade", *rows)
    script(project / "bin" / "gdb", "exit 9")
    path = f"{project / 'bin'}:{os.environ['PATH']}"
    done = run("make", "debug", "CASE=last", "PREPARE=1", cwd=project, PATH=path)
    assert done.returncode == 0, done.stderr
    folder = project / "build" / "try"
    assert run(str(folder / "debugged"), cwd=project).stdout == "42 64"
    assert (folder / "debugged.gdb").read_text(encoding="utf-8") == "break answer\n"
    if gdb := shutil.which("gdb"):
        words = ("-batch", "-x", "build/try/debugged.gdb", "-ex", "run", "build/try/debugged")
        assert "Breakpoint 1, answer ()" in run(gdb, *words, cwd=project).stdout


def test_debug_without_gdb_says_how_to_get_it(project: Path) -> None:
    """As a missing compiler does."""
    tools = (
        "sh",
        "make",
        "cat",
        "mktemp",
        "mkdir",
        "rm",
        "cksum",
        "cut",
        "find",
        "basename",
        "awk",
        "df",
    )
    for name in (*tools, "cc", "as", "ld", "python3", "uname"):
        if found := shutil.which(name):
            (project / "bin").mkdir(exist_ok=True)
            (project / "bin" / name).symlink_to(found)
    done = run("make", "debug", cwd=project, PATH=str(project / "bin"), MRT_LANG="en")
    assert done.returncode != 0
    assert done.stderr.startswith("gdb is missing. Run make doctor")


def test_try_without_tests(project: Path) -> None:
    """Without my_tests.c `make try` says what to write and where."""
    (project / "core_c" / "my_tests.c").unlink()
    done = run("make", "try", cwd=project, MRT_LANG="en")
    assert done.returncode != 0
    assert done.stderr.startswith("core_c/my_tests.c is missing: write a main() there")


def test_try_sees_a_memory_error(project: Path) -> None:
    """A read past a table stops the tests, and the file and line are named."""
    if not doctor.builds(["-fsanitize=address,undefined"]):
        assert not os.environ.get("MRT_CI"), "CI must have the sanitizers"
        pytest.skip("no sanitizers on this machine")
    tests = project / "core_c" / "my_tests.c"
    tests.write_text(SOURCES["my_tests.c"].replace("argc - 1", "argc + 3"), encoding="utf-8")
    done = run("make", "try", cwd=project)
    assert done.returncode != 0
    assert "my_tests.c:4" in done.stderr


def test_try_hides_no_missing_first_value(project: Path) -> None:
    """A local variable that nothing was given to is no zero, with the sanitizers or without."""
    if not doctor.builds(["-ftrivial-auto-var-init=pattern"]):
        assert not os.environ.get("MRT_CI"), "CI must have gcc 12"
        pytest.skip("the compiler fills no variable")
    tests = project / "core_c" / "my_tests.c"
    text = (
        '#include <stdio.h>\nint main(void) { float sum; printf("%g", (double)sum); return 0; }\n'
    )
    tests.write_text(text, encoding="utf-8")
    assert run("make", "try", cwd=project).stdout.startswith("-1.69474e+38")


@pytest.mark.parametrize(
    ("platform", "openmp"),
    [
        ("Linux", "-fopenmp"),
        ("Darwin", "-Xpreprocessor -fopenmp -I/opt/omp/include -L/opt/omp/lib -lomp"),
    ],
)
def test_flags_by_platform(project: Path, tmp_path: Path, platform: str, openmp: str) -> None:
    """Darwin's OpenMP flags are chosen apart, with Homebrew's library."""
    script(tmp_path / "bin" / "brew", "echo /opt/omp")
    script(tmp_path / "bin" / "pkg-config", "exit 1")
    accepting = script(
        tmp_path / "bin" / "accepting-cc",
        'for word; do last=$output; output=$word; [ "$last" = -o ] && break; done\n'
        'printf "#!/bin/sh\\n" > "$output"; chmod +x "$output"',
    )
    done = run(
        "make",
        "print-flags",
        f"PLATFORM={platform}",
        f"CC={accepting.name}",
        cwd=project,
        PATH=f"{accepting.parent}:{os.environ['PATH']}",
    )
    common = f"{accepting.name} -std=gnu11 -g -Wall -Wextra -Wfatal-errors"
    assert done.stdout.splitlines() == [
        f"mrt: {common} {openmp} -O3 -lm",
        f"try: {common} -O1 -fno-omit-frame-pointer -ftrivial-auto-var-init=pattern"
        " -fsanitize=address,undefined -lm",
    ]


@pytest.mark.parametrize("platform", ["Linux", "Darwin"])
def test_flags_of_a_plain_compiler(project: Path, platform: str) -> None:
    """What the compiler does not take is left out: OpenMP, PNG, the sanitizers."""
    script(project / "bin" / "plain-cc", "exit 1")
    path = f"{project / 'bin'}:{os.environ['PATH']}"
    done = run("make", "print-flags", f"PLATFORM={platform}", "CC=plain-cc", cwd=project, PATH=path)
    assert done.stdout.splitlines() == [
        "mrt: plain-cc -std=gnu11 -g -Wall -Wextra -Wfatal-errors -O3 -lm",
        "try: plain-cc -std=gnu11 -g -Wall -Wextra -Wfatal-errors -O1 -fno-omit-frame-pointer -lm",
    ]


def test_clean_keeps_what_a_student_made(project: Path) -> None:
    """`make clean` removes build/ and the program, and nothing else."""
    before = listing(project)
    (project / "core_c" / "sphere.ppm").write_bytes(b"P6")
    assert run("make", "mrt", cwd=project).returncode == 0
    assert run("make", "clean", cwd=project).returncode == 0
    assert listing(project) == sorted([*before, str(project / "core_c" / "sphere.ppm")])


def test_unwritable_folders_name_the_cure(checkout: Path) -> None:
    """Where neither the checkout nor BUILD can be written, one line says what to do."""
    command = ("sh", "grader/setup/environment.sh", "grade")
    done = run(*command, cwd=checkout, ordinary=True, BUILD="/proc/no", MRT_LANG="en")
    assert done.returncode == 1
    assert done.stderr.startswith(f"The Python environment cannot be written in {checkout}")
    assert "make BUILD=DIR" in done.stderr
    assert done.stderr.count("\n") == 1


def test_ci_script_is_sound() -> None:
    """The CI script can be started, and bash can read it."""
    ci = ROOT / ".ci" / "run"
    assert os.access(ci, os.X_OK)
    assert run("bash", "-n", str(ci), cwd=ROOT).returncode == 0

"""Languages are folders of messages/: a toy one of a few sentences, and the rest in English."""

from __future__ import annotations

import json
import os
import shutil
import sys
from pathlib import Path

import pytest

from grader.course.exercises import read_toml
from grader.course.settings import MESSAGES
from grader.sandbox.levels import Level, best
from grader.setup import sentences
from grader.tests.support.shell import ROOT, run

TOY = {
    "help.toml": '[help]\ngrade = "zzz grades"\ndoctor = "zzz \\"doctor\\""\n',
    "setup.toml": """\
[setup]
no_main = "zzz {folder} zzz"
missing = "zzz"
to_install = "zzz gets it"
""",
    "words.toml": """\
[language]
decimal = ","
narrow_before = "?"

[exercise]
"TP1" = "Zzz pictures"
"TP1.1" = "Zzz red"

[report]
graded = "Zzz: {name}"

[page]
summary = "Zzz in short"

[question]
"tp1.fill_red.color" = "Zzz, which colour ?"

[title]
"tp1.fill_red.color" = "Zzz colour"

[class]
title = "Zzz class"
""",
}
BLUE = "void fill_red(color *img) { fill(img, vector_init(0.f, 0.f, 1.f)); }\n"


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of the project, with a folder for the language xx."""
    top = tmp_path_factory.mktemp("zzz") / "project"
    leave = shutil.ignore_patterns("__pycache__", "tests", "mrt", "*.o")
    for name in ("core_c", "grader"):
        shutil.copytree(ROOT / name, top / name, ignore=leave)
    (top / "reference").symlink_to(ROOT / "reference")
    for name in ("Makefile", "pyproject.toml"):
        shutil.copy(ROOT / name, top)
    folder = top / "grader" / "course" / "messages" / "xx"
    folder.mkdir()
    for name, text in TOY.items():
        (folder / name).write_text(text, encoding="utf-8")
    main = (top / "core_c" / "main.c").read_text(encoding="utf-8")
    start, _, rest = main.partition("void fill_red(color *img) {")
    assert rest
    text = start + BLUE + rest.partition("\n}\n")[2]
    (top / "core_c" / "main.c").write_text(text, encoding="utf-8")
    return top


def make(project: Path, *words: str, **settings: str) -> str:
    """Run make in the toy language; return what it printed."""
    given = {"MRT_LANG": "xx", "MRT_ENV": sys.prefix, **settings}
    done = run("make", *words, *(f"{name}={each}" for name, each in given.items()), cwd=project)
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


def test_make_help_is_in_it(project: Path) -> None:
    """Each target once; in English where the language says nothing."""
    lines = make(project, "help").splitlines()
    told = dict(line.split(maxsplit=2)[1:] for line in lines)
    assert (told["grade"], told["doctor"]) == ("zzz grades", 'zzz "doctor"')
    assert told["watch"].startswith("grades at each save")
    assert len(told) == len(lines)


@pytest.mark.long
def test_make_grade_is_in_it(project: Path) -> None:
    """The terminal, results.json and the page: its own words, its comma, English ones else."""
    said = make(project, "grade", "TP=1", "K=fill_red")
    assert "Zzz: core_c" in said
    assert "TP1 - Zzz pictures" in said
    assert "Zzz red" in said
    assert "Zzz, which colour ?" in said
    assert "Next step: TP1.1" in said
    folder = project / "build" / "grade" / "partial"
    content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    assert (content["language"], content["exercises"][0]["title"]) == ("xx", "Zzz red")
    assert "Zzz colour" in [each["title"] for each in content["checks"]]
    html = (folder / "report.html").read_text(encoding="utf-8")
    assert '<html lang="xx"' in html
    assert "Zzz in short" in html
    assert "Zzz, which colour\N{NARROW NO-BREAK SPACE}?" in html


@pytest.mark.long
def test_the_report_is_made_again_in_it(project: Path) -> None:
    """After a grade in French."""
    done = run(
        *("make", "grade", "TP=1", "K=fill_red"), cwd=project, MRT_LANG="fr", MRT_ENV=sys.prefix
    )
    assert done.returncode == 0
    assert "Zzz" not in done.stdout
    said = make(project, "report", RESULTS="build/grade/partial")
    assert "Zzz, which colour ?" in said


@pytest.mark.long
def test_the_class_page_is_in_it(project: Path, tmp_path: Path) -> None:
    """And the student's page on it."""
    if best().level is not Level.STRONG:
        assert not os.environ.get("MRT_CI"), "CI must have bubblewrap"
        pytest.skip("bubblewrap is missing")
    shutil.copytree(project / "core_c", tmp_path / "class" / "Ada")
    where = {"SUBMISSIONS": str(tmp_path / "class"), "OUT": str(tmp_path / "out")}
    make(project, "batch", PUBLIC="1", **where)
    html = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert "<h1>Zzz class</h1>" in html
    assert "Zzz red" in html
    (page,) = (tmp_path / "out" / "students").glob("*/report.html")
    assert "Zzz in short" in page.read_text(encoding="utf-8")


def test_the_tools_before_any_package_speak_it(project: Path) -> None:
    """A shell script, and the doctor, a tool in Python alone."""
    done = run("make", "mrt", "SRC=no where", cwd=project, MRT_LANG="xx")
    assert done.stderr.splitlines()[0] == "zzz no where zzz"
    done = run(
        *(sys.executable, "-m", "grader.setup.doctor"), cwd=project, MRT_LANG="xx", PATH="/nowhere"
    )
    assert "zzz     gcc         builds your C → zzz gets it" in done.stdout


@pytest.mark.parametrize("language", ["fr", "en"])
def test_plain_files_are_read_as_toml_has_them(language: str) -> None:
    """By Python without packages; all that setup.toml holds."""
    content = read_toml(MESSAGES / language / "setup.toml")
    assert [*content] == ["setup"]
    assert sentences._read(language) == content["setup"]


@pytest.mark.parametrize("language", ["fr", "en"])
def test_scripts_say_what_python_says(language: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Quotes, and values that a shell or a pattern would take for its own."""
    monkeypatch.setenv("MRT_LANG", language)
    values = {"name": "a & b\\1 \"c\" $HOME `id` 'd' *", "ids": "{x} = y/z"}
    command = '. grader/setup/sentences.sh; sentence setup.call_unknown "$@"'
    words = [f"{name}={value}" for name, value in values.items()]
    done = run("sh", "-c", command, "sh", *words, cwd=ROOT, MRT_LANG=language)
    assert done.stdout == sentences.say("setup.call_unknown", **values) + "\n"


def test_a_lost_sentence_is_its_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As after an update that was cut off: the tool that mends it still runs."""
    monkeypatch.setattr(sentences, "MESSAGES", tmp_path)
    sentences._sentences.cache_clear()
    assert sentences.say("setup.unwritable", reason="x") == "setup.unwritable x"
    sentences._sentences.cache_clear()
    (tmp_path / "grader").mkdir()
    command = f'cd {tmp_path}; . {ROOT}/grader/setup/sentences.sh; sentence "$@"'
    done = run("sh", "-c", command, "sh", "setup.no_main", "folder=x", cwd=ROOT)
    assert done.stdout == "setup.no_main folder=x\n"

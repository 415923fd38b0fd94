"""`make submit`: what is sent is told, and the grader takes what was written."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from grader.build.builder import BuildError
from grader.commands import submit
from grader.course import exercises
from grader.intake.records import Submission
from grader.intake.submission import read_submission
from grader.tests.support.outputs import outputs

Write = Callable[..., Path]
Hand = Callable[..., tuple[int, list[str], list[str]]]
AUTHORS = "Nom, Prénom, numéro : Lovelace, Ada, 21905678\nGroupe : B2\n"
STUBS = ("raytracer.c", "octree.c")
MAIN_TIME = 1_700_000_000


@pytest.fixture
def hand(
    tmp_path: Path, cache: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Hand:
    """Return a function that hands a folder in; it returns the code and the lines printed."""
    monkeypatch.delenv("MRT_LANG", raising=False)
    build = outputs(tmp_path / "build", cache)

    def run(folder: Path, *words: str) -> tuple[int, list[str], list[str]]:
        places = ["--source", str(folder), "--build", str(build)]
        if "--out" not in words:
            places += ["--out", str(tmp_path / "out")]
        code = submit.main([*places, *words])
        said = capsys.readouterr()
        return code, said.out.splitlines(), said.err.splitlines()

    return run


@pytest.fixture
def work(submission: Write) -> Path:
    """Write what a student may have in core_c/, their own files and others."""
    stubs = {name: (exercises.CORE / name).read_text(encoding="utf-8") for name in STUBS}
    return submission(
        files={
            **stubs,
            "AUTEURS.txt": AUTHORS,
            "bvh.c": '#include "raytracer.h"\n',
            "my_tests.c": "int main(void) { return 0; }\n",
            "notes.txt": "mine\n",
            "sphere.ppm": "P6",
            "été.c": "int summer;\n",
        }
    )


def test_just_the_students_files_are_sent(work: Path, hand: Hand, tmp_path: Path) -> None:
    """Their files with their dates, what is left out and why, who, and the archive's name."""
    os.utime(work / "main.c", (MAIN_TIME, MAIN_TIME))
    code, said, errors = hand(work)
    assert (code, errors) == (0, [])
    path = tmp_path / "out" / "rendu-Lovelace.zip"
    names = ["main.c", "raytracer.c", "raytracer.h", "octree.c", "bvh.c"]
    with zipfile.ZipFile(path) as archive:
        assert sorted(archive.namelist()) == sorted([*names, "AUTEURS.txt"])
        assert archive.read("main.c") == (work / "main.c").read_bytes()
        assert archive.getinfo("main.c").date_time[:3] == (2023, 11, 14)
    rows = {row.split()[0]: row for row in said if row.startswith("  ")}
    assert set(rows) == {*names, "AUTEURS.txt"}
    size = (work / "main.c").stat().st_size
    assert rows["main.c"].split()[1:] == [str(size), "octets", "modifié", "le", "2023-11-14"]
    assert rows["bvh.c"].endswith("modifié à l'instant")
    assert said[0] == "À rendre :"
    assert [row for row in said if not row.startswith("  ")][1:] == [
        "Fait par Ada Lovelace, numéro 21905678",
        "Groupe : B2",
        "Non lu : été.c (nom inhabituel : lettres sans accent, chiffres et _ seulement,"
        " puis .c ou .h).",
        "Tout compile.",
        "Ces fichiers n'ont pas encore été jugés tels quels : make grade",
        f"{path} est prête. C'est ce fichier que vous déposez.",
    ]


def test_the_grader_takes_the_archive(work: Path, hand: Hand, tmp_path: Path) -> None:
    """What is read back is what the folder holds, file by file."""
    assert hand(work)[0] == 0
    sent = read_submission(tmp_path / "out" / "rendu-Lovelace.zip")
    here = read_submission(work)
    assert (sent.files, sent.missing, sent.refused) == (here.files, (), ())


def test_the_mark_of_these_very_files_is_recalled(work: Path, hand: Hand, tmp_path: Path) -> None:
    """The last full run's mark is told when it judged the same bytes, and only then."""
    here = read_submission(work).files.items()
    files = {name: hashlib.sha256(content).hexdigest() for name, content in here}
    content = {"submission": {"files": files}, "score": 42.5, "max_score": 100}
    results = tmp_path / "build" / "grade" / "results.json"
    results.parent.mkdir()
    results.write_text(json.dumps(content), encoding="utf-8")
    assert "Total provisoire de ces fichiers : 42,5 / 100." in hand(work)[1]
    with (work / "main.c").open("a", encoding="utf-8") as file:
        file.write("/* later */\n")
    assert "Ces fichiers n'ont pas encore été jugés tels quels : make grade" in hand(work)[1]
    results.write_text("{broken", encoding="utf-8")
    assert hand(work)[0] == 0


def test_nobody_named_is_refused_kindly(work: Path, hand: Hand, tmp_path: Path) -> None:
    """A blank AUTEURS.txt: nothing is written, and how to fill it is told; --force does without."""
    (work / "AUTEURS.txt").write_text("Nom, Prénom, numéro :\n", encoding="utf-8")
    code, _, errors = hand(work)
    assert (code, len(errors)) == (2, 1)
    assert "Lovelace, Ada, 21905678" in errors[0]
    assert not (tmp_path / "out").exists()
    (work / "AUTEURS.txt").unlink()
    assert hand(work)[0] == 2
    assert hand(work, "--force")[0] == 0
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["rendu-sans-nom.zip"]


def test_what_is_doubtful_in_the_names_is_told(work: Path, hand: Hand) -> None:
    """A missing number stops nothing."""
    (work / "AUTEURS.txt").write_text("Lovelace, Ada\n", encoding="utf-8")
    code, said, _ = hand(work)
    assert code == 0
    assert "AUTEURS.txt : ligne 1, il manque le numéro de Ada Lovelace." in said


def test_archives_do_not_pile_up(work: Path, hand: Hand, tmp_path: Path) -> None:
    """The last one has the name; the one before is kept, once; the same content is written once."""
    contents = []
    for text in ("/* 1 */\n", "/* 2 */\n", "/* 2 */\n", "/* 3 */\n"):
        (work / "bvh.c").write_text(text, encoding="utf-8")
        os.utime(work / "bvh.c", (MAIN_TIME, MAIN_TIME))
        code, said, _ = hand(work)
        assert code == 0
        contents.append((tmp_path / "out" / "rendu-Lovelace.zip").read_bytes())
    assert said[-2] == "L'archive d'avant est gardée, une seule fois : rendu-Lovelace.avant.zip."
    found = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    assert found == {
        "rendu-Lovelace.avant.zip": contents[1],
        "rendu-Lovelace.zip": contents[3],
    }


def test_an_archive_has_a_name_in_the_language(
    work: Path, hand: Hand, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Either is read alike, and git leaves both alone."""
    assert hand(work)[0] == 0
    monkeypatch.setenv("MRT_LANG", "en")
    assert hand(work)[0] == 0
    paths = [tmp_path / "out" / f"{name}-Lovelace.zip" for name in ("rendu", "submission")]
    first, second = (read_submission(path) for path in paths)
    assert first.files == second.files
    ignored = (exercises.ROOT / ".gitignore").read_text(encoding="utf-8").splitlines()
    assert {"/rendu-*.zip", "/submission-*.zip"} <= {*ignored}


def test_the_last_line_says_what_is_missing(work: Path, hand: Hand) -> None:
    """A renamed function, a file that does not compile, one that is not there; all at once."""
    assert hand(work)[1][-1].endswith("est prête. C'est ce fichier que vous déposez.")
    main = (work / "main.c").read_text(encoding="utf-8")
    (work / "main.c").write_text(main.replace("void fill_red(", "void paint("), encoding="utf-8")
    (work / "bvh.c").write_text("int broken( {\n", encoding="utf-8")
    (work / "octree.c").unlink()
    code, said, _ = hand(work)
    assert code == 0
    lacks = "pas de octree.c ; bvh.c ne compile pas ; pas de fonction fill_red (renommée"
    assert f"il y manque quelque chose : {lacks}" in said[-1]
    (work / "raytracer.c").write_text('#include "raytracer.h"\n', encoding="utf-8")
    more = "pas de fonctions fill_red, camera_ray, raytrace, intersect_plane, et 18 autres"
    assert more in hand(work)[1][-1]


@pytest.mark.parametrize("folder", ["reference", "core_c"])
def test_no_function_is_missed_where_all_are(folder: str) -> None:
    """However they are written; a name in a comment, a call or a prototype is no function."""
    assert submit.missing_functions(read_submission(exercises.ROOT / folder)) == []
    text = "void f(void) { fill(0); }\n/* void fill(int x) { } */\nvoid fill(int);\n"
    text += 'char *s = "fill() {";'
    known = submit.missing_functions(Submission("x", {"main.c": text.encode()}, ("octree.c",)))
    assert "fill" in known
    assert not {"octree_build", "f"} & {*known}


def test_files_that_do_not_compile_are_sent_all_the_same(work: Path, hand: Hand) -> None:
    """The compiler's first line is told: the student decides."""
    (work / "bvh.c").write_text('#include "raytracer.h"\nint broken( {\n', encoding="utf-8")
    (work / "octree.c").unlink()
    code, said, _ = hand(work)
    assert code == 0
    assert any(row.startswith("Attention, bvh.c ne compile pas encore : bvh.c:2") for row in said)
    assert "Fichier absent du rendu, remplacé par celui du squelette : octree.c." in said
    assert "Tout compile." not in said


def test_files_that_do_not_fit_together(work: Path, hand: Hand) -> None:
    """Without a main the functions can be judged, but nobody says that everything is well."""
    (work / "main.c").write_text('#include "raytracer.h"\n', encoding="utf-8")
    code, said, _ = hand(work)
    assert code == 0
    assert any(row.startswith("La fonction main manque dans vos fichiers") for row in said)
    assert "Tout compile." not in said


def test_a_machine_without_compiler_stops_nobody(
    work: Path, hand: Hand, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether it compiles cannot be told; the archive is written."""

    def missing(*_: object) -> None:
        raise BuildError("machine.no_compiler", tried="no-such-cc")

    monkeypatch.setattr(submit, "build", missing)
    code, said, _ = hand(work)
    assert code == 0
    assert any(row.startswith("Pas de compilateur C (no-such-cc)") for row in said)
    assert "Tout compile." not in said
    assert said[-1].endswith("est prête. C'est ce fichier que vous déposez.")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--source", "nowhere"], "Le dossier nowhere n'existe pas."),
        (["--out", "/proc/no"], "/proc/no/rendu-Lovelace.zip : écriture impossible"),
    ],
)
def test_wrong_places_are_told(work: Path, hand: Hand, words: list[str], message: str) -> None:
    """One line, with the cure."""
    code, _, errors = hand(work, *words)
    assert (code, len(errors)) == (2, 1)
    assert errors[0].startswith(message)


def test_an_archive_cannot_be_handed_in_again(work: Path, hand: Hand, tmp_path: Path) -> None:
    """The source is a folder: an archive given by mistake is named."""
    hand(work)
    code, _, errors = hand(work, "--source", str(tmp_path / "out" / "rendu-Lovelace.zip"))
    assert (code, len(errors)) == (2, 1)
    assert "n'est pas un dossier" in errors[0]


def test_dates_that_no_zip_can_hold(work: Path, hand: Hand, tmp_path: Path) -> None:
    """A clock at 1970, or far ahead, does not stop anybody from handing in."""
    os.utime(work / "main.c", (0, 0))
    os.utime(work / "octree.c", (6e9, 6e9))
    assert hand(work)[0] == 0
    with zipfile.ZipFile(tmp_path / "out" / "rendu-Lovelace.zip") as archive:
        years = [archive.getinfo(name).date_time[0] for name in ("main.c", "octree.c")]
    assert years == [1980, 1980]

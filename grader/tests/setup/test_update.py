"""`make update`: a newer release over a folder where somebody is at work; nothing is lost."""

from __future__ import annotations

import json
import shutil
import stat
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from grader.intake import originals
from grader.setup import release_record, transaction, update
from grader.setup.release_record import RECORD, TOP, HandoutError, Release, digest
from grader.setup.transaction import replace as make
from grader.tests.support.shell import ROOT, run

OWN = ("core_c/main.c", "core_c/raytracer.c", "core_c/AUTEURS.txt", "core_c/my_tests.c")
Files = dict[str, bytes]


def skeletons(version: str) -> Files:
    """Return the student's files of a release: the next one has another exercise."""
    more = b"" if version == "0.1.0" else b"\nvoid blur(void) {\n}\n"
    return {"main.c": b"int main(void) {\n}\n", "raytracer.c": b"/* rays */\n" + more}


def release(version: str, date: int = 100_000, **changes: bytes | None) -> Files:
    """Return the files of a small release; `changes` by path, with __ for / and _dot_ for a dot."""
    files: dict[str, bytes | None] = {
        **{f"core_c/{name}": content for name, content in skeletons(version).items()},
        "core_c/AUTEURS.txt": b"Nom :\n",
        "core_c/my_tests.c": b"/* tests */\n",
        "core_c/scene.c": f"/* scene {version} */\n".encode(),
        "grader/setup/update.py": f"# {version}\n".encode(),
        "grader/intake/originals.zip": originals.packed(skeletons(version)),
        "notebooks/fr/TP1.ipynb": b"{}\n",
        "notebooks/fr/TP2.ipynb": f"{{{version}}}\n".encode(),
        "Makefile": b"all:\n",
        **{path.replace("__", "/").replace("_dot_", "."): each for path, each in changes.items()},
    }
    kept = {path: content for path, content in files.items() if content is not None}
    sums = {path: digest(content) for path, content in kept.items()}
    return {**kept, RECORD: Release(version, date, OWN, sums).as_json()}


def archive(path: Path, files: Mapping[str, bytes]) -> Path:
    """Write an archive as it is handed out."""
    with zipfile.ZipFile(path, "w") as out:
        for name, content in files.items():
            out.writestr(f"{TOP}/{name}", content)
    return path


def unpack(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files into a folder."""
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


def listing(folder: Path) -> Files:
    """Return every file below a folder."""
    found = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in sorted(found)}


# Half of TP3: own code, own files, own notes; a given file changed, a notebook answered.
WORK: Files = {
    "core_c/main.c": b"int main(void) {\n    /* mine */\n}\n",
    "core_c/raytracer.c": b"/* rays */\nvoid mine(void) {\n}\n",
    "core_c/AUTEURS.txt": b"Nom : Lovelace, Ada, 21905678\n",
    "core_c/scene.c": b"/* my scene */\n",
    "core_c/bvh.c": b"/* my own file */\n",
    "core_c/sphere.ppm": b"P6",
    "notebooks/fr/TP1.ipynb": b"{my answers}\n",
    "notebooks/fr/TP2.ipynb": b"{my other answers}\n",
    "notebooks/fr/essai.ipynb": b"{my own notebook}\n",
    "notes.txt": b"my notes",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Make a folder of release 0.1.0 where a student is half-way through TP3."""
    place = tmp_path / "l'été au labo"
    unpack(place, release("0.1.0", grader__old_dot_py=b"# old\n"))
    unpack(place, WORK)
    return place


@pytest.fixture
def newer(tmp_path: Path) -> Path:
    """Make the archive of release 0.2.0."""
    return archive(tmp_path / "nouveau.zip", release("0.2.0", core_c__new_dot_h=b"/* new */\n"))


@pytest.fixture(autouse=True)
def french(monkeypatch: pytest.MonkeyPatch) -> None:
    """Messages are compared in French."""
    monkeypatch.delenv("MRT_LANG", raising=False)


def backup(folder: Path) -> Path:
    """Return the one folder of copies."""
    (found,) = folder.glob("sauvegarde-*")
    return found


def test_what_is_the_students_stays_and_the_rest_is_new(
    folder: Path, newer: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Own files and a notebook without news stay; what else has changed is replaced, and kept."""
    assert update.main([str(newer), "--root", str(folder)]) == 0
    copies = backup(folder)
    said = capsys.readouterr().out
    after = {
        path: content
        for path, content in listing(folder).items()
        if not path.startswith("sauvegarde")
    }
    assert after == {
        **release("0.2.0", core_c__new_dot_h=b"/* new */\n"),
        **{path: each for path, each in WORK.items() if path != "core_c/scene.c"},
        "notebooks/fr/TP2.ipynb": b"{0.2.0}\n",
        "notebooks/fr/TP2-ma-version.ipynb": WORK["notebooks/fr/TP2.ipynb"],
    }
    kept = listing(copies)
    assert "+void blur(void) {" in kept.pop("core_c/raytracer.c.diff").decode()
    mine = [*OWN[:3], "core_c/scene.c", "notebooks/fr/TP1.ipynb", "notebooks/fr/TP2.ipynb"]
    assert kept == {path: WORK[path] for path in mine}
    assert said.splitlines() == [
        "Mise à jour faite (0.1.0 (1970-01-02) -> 0.2.0 (1970-01-02)) : fichiers remplacés : 5,"
        " ajoutés : 1, retirés : 1.",
        "À vous, donc laissés : core_c/AUTEURS.txt, core_c/main.c, core_c/raytracer.c,"
        " notebooks/fr/TP1.ipynb.",
        "core_c/scene.c : vous l'aviez changé ; votre version est dans"
        f" {copies.name}/core_c/scene.c.",
        "notebooks/fr/TP2.ipynb : vous l'aviez changé ; votre version est dans"
        " notebooks/fr/TP2-ma-version.ipynb.",
        "core_c/raytracer.c : le fichier de départ a changé, le vôtre non. Voyez"
        f" {copies.name}/core_c/raytracer.c.diff et reportez-y ce qui manque.",
        f"Copie de sauvegarde : {copies.name}/",
    ]


def test_a_translated_starting_file_is_no_news(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where only comments have changed, there is nothing to carry over."""
    french = release("0.1.0", 200_000, core_c__raytracer_dot_c="/* rayons été */\n".encode())
    assert update.main([str(archive(tmp_path / "fr.zip", french)), "--root", str(folder)]) == 0
    assert "le fichier de départ a changé" not in capsys.readouterr().out
    assert not list(backup(folder).rglob("*.diff"))


def test_folders_that_are_left_empty_go(folder: Path, newer: Path) -> None:
    """With what Python keeps there; where the student has a file, the folder stays."""
    unpack(folder, release("0.1.0", grader__a__b__c_dot_py=b"# c\n", grader__d__e_dot_py=b"# e\n"))
    unpack(folder, WORK)
    mine = {"grader/a/b/__pycache__/c.cpython-311.pyc": b"", "grader/d/notes.txt": b"mine"}
    unpack(folder, mine)
    assert update.main([str(newer), "--root", str(folder)]) == 0
    assert not (folder / "grader" / "a").exists()
    assert listing(folder / "grader" / "d") == {"notes.txt": b"mine"}


def test_again_changes_nothing(folder: Path, newer: Path) -> None:
    """The same archive twice: the second time there is nothing to do."""
    assert update.main([str(newer), "--root", str(folder)]) == 0
    before = listing(folder)
    assert update.main([str(newer), "--root", str(folder)]) == 0
    assert listing(folder) == before


def test_starting_files_nobody_wrote_in_are_replaced(tmp_path: Path, newer: Path) -> None:
    """The student who has not begun gets the new exercise; a git that changed line ends too."""
    place = tmp_path / "neuf"
    unpack(place, release("0.1.0"))
    crlf = skeletons("0.1.0")["raytracer.c"].replace(b"\n", b"\r\n")
    (place / "core_c" / "raytracer.c").write_bytes(crlf)
    (place / "core_c" / "my_tests.c").unlink()
    assert update.main([str(newer), "--root", str(place)]) == 0
    assert listing(place) == release("0.2.0", core_c__new_dot_h=b"/* new */\n")


def test_a_new_file_where_the_student_has_one(folder: Path, tmp_path: Path) -> None:
    """The course's next given file has the name of a student's own: theirs is kept apart."""
    path = archive(tmp_path / "n.zip", release("0.2.0", core_c__bvh_dot_c=b"/* ours */\n"))
    assert update.main([str(path), "--root", str(folder)]) == 0
    assert (folder / "core_c" / "bvh.c").read_bytes() == b"/* ours */\n"
    assert (backup(folder) / "core_c" / "bvh.c").read_bytes() == WORK["core_c/bvh.c"]


def test_an_unpacked_archive_will_do(folder: Path, tmp_path: Path) -> None:
    """Some browsers unpack what they download; what systems put beside is not looked at."""
    unpack(tmp_path / "recu" / TOP, {**release("0.2.0"), ".DS_Store": b""})
    for place in (tmp_path / "recu" / TOP, tmp_path / "recu"):
        assert update.prepare(place, folder).new.version == "0.2.0"


# ---- Refusals and failures ----------------------------------------------------------------------


def link(name: str) -> zipfile.ZipInfo:
    """Return the entry of a symbolic link."""
    entry = zipfile.ZipInfo(name)
    entry.create_system, entry.external_attr = 3, (stat.S_IFLNK | 0o777) << 16
    return entry


def spoil(path: Path) -> None:
    """Change a byte in the middle of a file of the archive."""
    content = bytearray(path.read_bytes())
    content[content.find(b"/* scene") + 3] ^= 1
    path.write_bytes(content)


def add(path: Path, entry: str | zipfile.ZipInfo) -> None:
    """Add an entry to an archive."""
    with zipfile.ZipFile(path, "a") as out:
        out.writestr(entry, b"/etc/passwd")


def forged(path: Path) -> None:
    """Make an archive whose own record names a path outside."""
    archive(path, release("0.2.0", __up=b""))


@pytest.mark.parametrize(
    ("harm", "words"),
    [
        (lambda path: path.unlink(), "n'existe pas"),
        (lambda path: path.write_bytes(b"not a zip"), "abîmée"),
        (lambda path: path.write_bytes(path.read_bytes()[:900]), "pas en entier"),
        (lambda path: path.write_bytes(path.read_bytes()[:-9]), "abîmée"),
        (spoil, "abîmée"),
        (lambda path: add(path, f"{TOP}/../../up"), "(miniraytracer/../../up)"),
        (lambda path: add(path, "/etc/cron.d/x"), "(/etc/cron.d/x)"),
        (lambda path: add(path, f"{TOP}/C:\\x"), "(miniraytracer/C:\\x)"),
        (lambda path: add(path, f"{TOP}/extra"), "(extra)"),
        (lambda path: add(path, link(f"{TOP}/link")), "(miniraytracer/link)"),
        (forged, "(miniraytracer//up)"),
        (lambda path: archive(path, {"Makefile": b""}), "n'est pas une archive du sujet"),
        (lambda path: archive(path, release("0.0.9")), "plus ancienne"),
        (lambda path: archive(path, release("0.1.0", date=99_999)), "plus ancienne"),
        (lambda path: archive(path, {RECORD: b"[]"}), "abîmée"),
        (lambda path: archive(path, {RECORD: b"\xff"}), "abîmée"),
    ],
)
def test_an_archive_that_is_not_right_is_refused(
    folder: Path,
    newer: Path,
    harm: Callable[[Path], object],
    words: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Missing, damaged, unsafe, somebody else's, older: one line, and nothing has changed."""
    before = listing(folder)
    harm(newer)
    assert update.main([str(newer), "--root", str(folder)]) == 1
    said = capsys.readouterr().err
    assert words in said
    assert str(newer) in said
    assert said.count("\n") == 1
    assert listing(folder) == before


def test_a_bomb_is_not_unpacked(folder: Path, tmp_path: Path) -> None:
    """More bytes than any release has are refused by what the archive announces."""
    path = tmp_path / "bombe.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        for number in range(3):
            out.writestr(f"{TOP}/{number}", bytes(release_record.MAX_BYTES // 2))
    with pytest.raises(HandoutError, match="trop de fichiers"):
        update.prepare(path, folder)


def test_a_release_whose_date_is_not_known(folder: Path, tmp_path: Path) -> None:
    """Made outside of git, a release has no date: its version alone tells which is newer."""
    path = archive(tmp_path / "n.zip", release("0.3.0", date=0))
    assert update.prepare(path, folder).new.title == "0.3.0"


def test_going_back_must_be_asked_for(folder: Path, tmp_path: Path) -> None:
    """FORCE=1 installs an older release."""
    path = archive(tmp_path / "vieux.zip", release("0.0.9"))
    assert update.main([str(path), "--root", str(folder), "--force"]) == 0
    assert json.loads((folder / RECORD).read_bytes())["version"] == "0.0.9"


def test_a_folder_that_was_not_handed_out_is_left_alone(
    newer: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The project itself, where the solution is, is never updated."""
    assert not (ROOT / RECORD).exists()
    assert update.main([str(newer)]) == 1
    assert "n'est pas un dossier distribué" in capsys.readouterr().err


def test_no_archive_given(capsys: pytest.CaptureFixture[str]) -> None:
    """`make update` alone says what to give."""
    assert update.main([]) == 1
    assert capsys.readouterr().err == "Donnez l'archive : make update ARCHIVE=chemin/nom.zip\n"


@pytest.mark.parametrize("failing", [*range(1, 15)])
def test_a_write_that_fails_changes_nothing(
    folder: Path, newer: Path, failing: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk at any write: one line, every file as before, and no copy left behind."""
    before, count = listing(folder), 0
    write = Path.write_bytes

    def full(path: Path, content: bytes) -> int:
        nonlocal count
        count += 1
        if count == failing:
            write(path, content[:1])
            raise OSError(28, "No space left on device")
        return write(path, content)

    plan = update.prepare(newer, folder)
    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(HandoutError, match=r"possible : [\w/-]+\.\w.* \(No space left"):
        make(plan, folder)
    assert listing(folder) == before


@pytest.mark.parametrize("failing", [*range(1, 7)])
def test_a_rename_that_fails_is_undone(
    folder: Path, newer: Path, failing: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file that an editor of Windows holds: named, and every other one put back."""
    before, count = listing(folder), 0
    rename = Path.replace

    def held(path: Path, target: Path) -> Path:
        nonlocal count
        count += 1
        if count == failing:
            raise PermissionError(13, "Permission denied", str(path), None, str(target))
        return rename(path, target)

    plan = update.prepare(newer, folder)
    monkeypatch.setattr(Path, "replace", held)
    with pytest.raises(
        HandoutError,
        match=r"^Écriture impossible : [\w/]+\.\w+ \(Permission denied\)\. Rien n'a changé",
    ):
        make(plan, folder)
    assert listing(folder) == before


class KilledError(BaseException):
    """Stands for the death of the process: nothing is tidied up."""


@pytest.mark.parametrize("failing", [*range(1, 7)])
def test_killed_at_any_rename_it_can_be_run_again(
    folder: Path, newer: Path, failing: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What an interrupted update has left is finished by the next, and nothing is lost."""
    count = 0
    rename = Path.replace

    def killed(path: Path, target: Path) -> Path:
        nonlocal count
        count += 1
        if count >= failing:
            raise KilledError
        return rename(path, target)

    plan = update.prepare(newer, folder)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", killed)
        patch.setattr(transaction, "_put_back", lambda *_: None)
        patch.setattr(transaction, "_discard", lambda *_: None)
        patch.setattr(shutil, "rmtree", lambda *_, **__: None)
        with pytest.raises(KilledError):
            make(plan, folder)
    assert update.main([str(newer), "--root", str(folder)]) == 0
    now = listing(folder)
    expected = release("0.2.0", core_c__new_dot_h=b"/* new */\n")
    theirs = {path: each for path, each in WORK.items() if path != "core_c/scene.c"}
    for path, content in {**expected, **theirs, "notebooks/fr/TP2.ipynb": b"{0.2.0}\n"}.items():
        assert now[path] == content, path
    assert [*WORK["core_c/scene.c"]] in [[*each] for each in now.values()]
    assert WORK["notebooks/fr/TP2.ipynb"] in now.values()
    assert not [path for path in now if path.endswith(".mrt-new")]


def test_an_unfinished_undoing_is_told(
    folder: Path, newer: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """When the disk dies altogether the sentence does not pretend that nothing has changed."""

    def dead(*_: object) -> None:
        raise OSError(5, "Input/output error")

    rename = Path.replace

    def held(path: Path, target: Path) -> Path:
        if target.name == "update.py":
            raise PermissionError(13, "Permission denied", str(path), None, str(target))
        return rename(path, target)

    plan = update.prepare(newer, folder)
    monkeypatch.setattr(Path, "replace", held)
    monkeypatch.setattr(transaction, "_put_back", dead)
    with pytest.raises(HandoutError, match=r"arrêtée en chemin : grader/setup/update\.py "):
        make(plan, folder)
    assert backup(folder).is_dir()


def test_a_closed_folder_is_named() -> None:
    """A read-only core_c/, as an ordinary user: one line, nothing has changed."""
    with tempfile.TemporaryDirectory(prefix="mrt-update-") as top:
        place = Path(top, "l'été au labo")
        unpack(place, {**release("0.1.0"), **WORK})
        newer = archive(Path(top, "nouveau.zip"), release("0.2.0"))
        run("chmod", "-R", "a+rwX", top, cwd=ROOT)
        (place / "core_c").chmod(0o555)
        before = listing(place)
        python = run("sh", "grader/setup/environment.sh", "python", cwd=ROOT).stdout.strip()
        words = ("-m", "grader.setup.update", str(newer), "--root", str(place))
        done = run(python, *words, cwd=ROOT, ordinary=True, MRT_LANG="en")
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
        assert done.stderr.startswith("Cannot write: core_c/scene.c (Permission denied).")
        assert listing(place) == before


def test_a_folder_in_the_way_is_named(
    folder: Path, newer: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A folder, or a link to nothing, where a file must go: the person moves it."""
    (folder / "core_c" / "new.h").mkdir()
    assert update.main([str(newer), "--root", str(folder)]) == 1
    assert capsys.readouterr().err.startswith("core_c/new.h ne peut pas être lu")
    (folder / "core_c" / "new.h").rmdir()
    (folder / "core_c" / "new.h").symlink_to(folder / "nowhere")
    assert update.main([str(newer), "--root", str(folder)]) == 1
    assert "le lien ne mène à rien" in capsys.readouterr().err

"""A class as it hands in: right work, stubs, bad and hostile submissions, broken archives, pairs.

Every submission knows what must come of it. `write(folder, size)` lays a class of that size, always
the same one for the same size.
"""

from __future__ import annotations

import io
import shutil
import tarfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.manifest import CORE, read_toml
from grader.originals import REFERENCE
from grader.tests import test_bad_submissions as bad
from grader.tests.hostile import corpus
from grader.tests.solver import stub
from grader.tests.student import STUDENT_MAIN, main_c

STUDENT = ("main.c", "raytracer.c", "raytracer.h", "octree.c")
NAMES = (
    *("Éloïse d'Été", "Zoë Müller", "O'Neil, Rémi", "Anne-Sophie Lœil", "José María Nuñez"),
    *("李 小龙", "Jean  Double-Espace", "Ægir Øst", "Ada Lovelace", "Grace Hopper"),
)
TP1_MARK = 3.0  # of 20: 15 points of 100
SECRET = Path("/tmp/mrt-no-such-secret")


@dataclass(frozen=True)
class Pupil:
    """One submission of the class; `mark` is what it must get, None when it gets none.

    `least` and `most` bound it where machines may differ (a hostile program that hangs or dies).
    """

    name: str
    kind: str
    least: float | None
    most: float | None
    members: tuple[str, ...] = ()


Maker = Callable[[Path], None]
Kind = Callable[[Path, str, int], Pupil]


def full(folder: Path) -> None:
    """Write the solution: every point, and the bonus."""
    for name in STUDENT:
        shutil.copyfile(REFERENCE / name, folder / name)


def skeleton(folder: Path) -> None:
    """Write what was handed out: nothing is done."""
    for name in STUDENT:
        shutil.copyfile(CORE / name, folder / name)


def first_tp(folder: Path, files: Mapping[str, str] | None = None) -> None:
    """Write a right TP1, and nothing else."""
    corpus.lay(folder, {"main.c": main_c(STUDENT_MAIN), **(files or {})})


def authors(folder: Path, *lines: str) -> None:
    """Write AUTEURS.txt."""
    text = "".join(f"Nom, Prénom, numéro : {line}\n" for line in lines)
    (folder / "AUTEURS.txt").write_text(text, encoding="utf-8")


def zipped(folder: Path, path: Path) -> None:
    """Put a folder into a .zip, and remove it."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for each in sorted(folder.rglob("*")):
            archive.write(each, Path("rendu", each.relative_to(folder)))
    shutil.rmtree(folder)


def tarred(folder: Path, path: Path) -> None:
    """Put a folder into a .tar.gz, and remove it."""
    with tarfile.open(path, "w:gz") as archive:
        archive.add(folder, "rendu")
    shutil.rmtree(folder)


def escaping() -> bytes:
    """Return an archive one entry of which leaves it, beside a right TP1."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        archive.writestr("../../outside.c", "int x;")
        archive.writestr("/absolute.c", "int x;")
        archive.writestr("main.c", main_c(STUDENT_MAIN))
        archive.writestr("raytracer.h", '#include "exercises.h"\n')
    return memory.getvalue()


def write(top: Path, size: int) -> list[Pupil]:
    """Lay a class of that size in a folder; return what must come of each."""
    top.mkdir(parents=True, exist_ok=True)
    pupils: list[Pupil] = []
    kinds = _kinds()
    for number in range(size):
        name = f"{NAMES[number % len(NAMES)]} {number:03d}"
        pupils.append(kinds[number % len(kinds)](top, name, number))
    return pupils


def _folder(
    make: Maker, kind: str, least: float | None, most: float | None
) -> Callable[..., Pupil]:
    def pupil(top: Path, name: str, number: int) -> Pupil:
        folder = top / name / "rendu final"
        folder.mkdir(parents=True)
        make(folder)
        # Nobody's work is anybody else's: a comment of one's own.
        if (folder / "raytracer.h").is_file():
            with (folder / "raytracer.h").open("a", encoding="utf-8", errors="ignore") as file:
                file.write(f"/* {number} */\n")
        return Pupil(name, kind, least, most)

    return pupil


def _packed(
    pack: Callable[[Path, Path], None], suffix: str, make: Maker, mark: float
) -> Callable[..., Pupil]:
    def pupil(top: Path, name: str, number: int) -> Pupil:
        folder = top / f"{number}-work"
        folder.mkdir()
        make(folder)
        with (folder / "raytracer.h").open("a", encoding="utf-8") as file:
            file.write(f"/* {number} */\n")
        pack(folder, top / f"{name}{suffix}")
        return Pupil(name, suffix, mark, mark)

    return pupil


def _pair(top: Path, name: str, number: int) -> Pupil:
    folder = top / name
    folder.mkdir()
    first_tp(folder, {"raytracer.h": f'#include "exercises.h"\n/* {number} */\n'})
    own = "".join("abcdefghij"[int(digit)] for digit in str(number))  # digits are no part of a name
    people = (f"Curie-{own}, Marie, 9{number:07d}", f"Noether-{own}, Emmy, 8{number:07d}")
    authors(folder, *people)
    members = (f"Marie Curie-{own}", f"Emmy Noether-{own}")
    return Pupil(name, "pair", TP1_MARK, TP1_MARK, members)


def _broken(top: Path, name: str, number: int) -> Pupil:
    (top / f"{name}.zip").write_bytes(b"PK\3\4 not an archive at all" + bytes([number % 256]))
    return Pupil(name, "broken archive", None, None)


def _outside(top: Path, name: str, number: int) -> Pupil:
    (top / f"{name}.zip").write_bytes(escaping())
    return Pupil(name, "escaping archive", TP1_MARK, TP1_MARK)


def _empty(top: Path, name: str, number: int) -> Pupil:
    (top / name).mkdir()
    (top / name / "lisez-moi.txt").write_text("rien", encoding="utf-8")
    return Pupil(name, "empty", None, None)


def _twice(top: Path, name: str, number: int) -> Pupil:
    for each in ("v1", "v2"):
        folder = top / name / each
        folder.mkdir(parents=True)
        first_tp(folder, {"raytracer.h": f'#include "exercises.h"\n/* {each} */\n'})
    return Pupil(name, "several", None, None)


def _described(case: str) -> Maker:
    """Return a maker of one of the bad submissions of the grader's own tests."""
    described = read_toml(bad.FOLDER / f"{case}.toml")

    def make(folder: Path) -> None:
        def submission(files: Mapping[str, str | None], **bodies: str) -> Path:
            first_tp(folder)
            (folder / "main.c").write_text(main_c({**STUDENT_MAIN, **bodies}), encoding="utf-8")
            for name, text in files.items():
                if text is not None:
                    (folder / name).write_text(text, encoding="utf-8")
            return folder

        bad.write(described, submission)

    return make


def _hostile(code: str) -> Maker:
    def make(folder: Path) -> None:
        first_tp(folder, {"odd.c": code})

    return make


def _attack(number: int) -> Maker:
    """Return a maker of the programs of the hostile corpus; fill_red runs one of them."""

    def make(folder: Path) -> None:
        corpus.write(folder, SECRET, 1)
        body = f"extern void attack(int, color *); attack({number}, img);"
        text = (folder / "main.c").read_text(encoding="utf-8")
        (folder / "main.c").write_text(
            text.replace(STUDENT_MAIN["fill_red"], body, 1), encoding="utf-8"
        )

    return make


def _kinds() -> list[Kind]:
    """Return makers of every kind; the ordinary ones come again and again, as in a class."""
    ordinary: list[Kind] = [
        _folder(full, "full", 20, 20),
        _folder(skeleton, "skeleton", 0, 0),
        _folder(first_tp, "tp1", TP1_MARK, TP1_MARK),
        _packed(zipped, ".zip", first_tp, TP1_MARK),
        _packed(tarred, ".tar.gz", first_tp, TP1_MARK),
        _pair,
        _broken,
        _outside,
        _empty,
        _twice,
    ]
    odd = [_folder(lambda folder, k=k: stub(folder, k), "stub", 0, 2) for k in range(4)]  # type: ignore[misc]
    odd += [_folder(_described(name), name, 0, TP1_MARK) for name in bad.NAMES]
    odd += [_folder(_hostile(text), name, 0, TP1_MARK) for name, text in corpus.loads()]
    odd += [
        _folder(_hostile(text), name, 0, TP1_MARK) for name, text in corpus.compilations(SECRET)
    ]
    odd += [_folder(_attack(k), name, 0, TP1_MARK) for k, name in enumerate(corpus.attacks())]
    found = []
    for number, each in enumerate(odd):
        found += [ordinary[number % len(ordinary)], each]
    return [*ordinary, *found]

"""A class as it hands in: right work, stubs, bad and hostile submissions, broken archives, pairs.

Every submission knows what must come of it. `write(folder, size)` lays a class of that size, always
the same one for the same size.
"""

from __future__ import annotations

import io
import random
import shutil
import tarfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from grader.authoring.proof.solver import stub
from grader.authoring.specimens import faulty, hostile
from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.course import exercises
from grader.course.exercises import CORE, read_toml
from grader.execution.records import Cause
from grader.intake.originals import REFERENCE

STUDENT = ("main.c", "raytracer.c", "raytracer.h", "octree.c")
NAMES = (
    *("Éloïse d'Été", "Zoë Müller", "O'Neil, Rémi", "Anne-Sophie Lœil", "José María Nuñez"),
    *("李 小龙", "Jean  Double-Espace", "Ægir Øst", "Ada Lovelace", "Grace Hopper"),
)
SIZE = 200  # from this size on, every kind is there
TP1_POINTS = 15.0  # of 100
INSIDE = "rendu final"  # the folder in a student's folder
SECRET = Path("/tmp/mrt-no-such-secret")


@dataclass(frozen=True)
class Pupil:
    """One submission of the class; `points` is what it must get of 100, None when it gets no mark.

    What `hangs` does so on purpose, and is ended by its limits.
    """

    name: str
    kind: str
    points: float | None
    members: tuple[str, ...] = ()
    hangs: bool = False


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
    hostile.lay(folder, {"main.c": main_c(STUDENT_MAIN), **(files or {})})


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


def _folder(make: Maker, kind: str, points: float, hangs: bool = False) -> Kind:
    def pupil(top: Path, name: str, number: int) -> Pupil:
        folder = top / name / INSIDE
        folder.mkdir(parents=True)
        make(folder)
        # Nobody's work is anybody else's: a comment of one's own.
        if (folder / "raytracer.h").is_file():
            with (folder / "raytracer.h").open("a", encoding="utf-8", errors="ignore") as file:
                file.write(f"/* {number} */\n")
        return Pupil(name, kind, points, hangs=hangs)

    return pupil


def _packed(pack: Callable[[Path, Path], None], suffix: str, make: Maker, points: float) -> Kind:
    def pupil(top: Path, name: str, number: int) -> Pupil:
        folder = top / f"{number}-work"
        folder.mkdir()
        make(folder)
        with (folder / "raytracer.h").open("a", encoding="utf-8") as file:
            file.write(f"/* {number} */\n")
        pack(folder, top / f"{name}{suffix}")
        return Pupil(name, suffix, points)

    return pupil


def _pair(top: Path, name: str, number: int) -> Pupil:
    folder = top / name
    folder.mkdir()
    first_tp(folder, {"raytracer.h": f'#include "exercises.h"\n/* {number} */\n'})
    own = "".join("abcdefghij"[int(digit)] for digit in str(number))  # digits are no part of a name
    people = (f"Curie-{own}, Marie, 9{number:07d}", f"Noether-{own}, Emmy, 8{number:07d}")
    authors(folder, *people)
    members = (f"Marie Curie-{own}", f"Emmy Noether-{own}")
    return Pupil(name, "pair", TP1_POINTS, members)


def _broken(top: Path, name: str, number: int) -> Pupil:
    (top / f"{name}.zip").write_bytes(b"PK\3\4 not an archive at all" + bytes([number % 256]))
    return Pupil(name, "broken archive", None)


def _outside(top: Path, name: str, number: int) -> Pupil:
    (top / f"{name}.zip").write_bytes(escaping())
    return Pupil(name, "escaping archive", TP1_POINTS)


def _empty(top: Path, name: str, number: int) -> Pupil:
    (top / name).mkdir()
    (top / name / "lisez-moi.txt").write_text("rien", encoding="utf-8")
    return Pupil(name, "empty", None)


def _twice(top: Path, name: str, number: int) -> Pupil:
    for each in ("v1", "v2"):
        folder = top / name / each
        folder.mkdir(parents=True)
        first_tp(folder, {"raytracer.h": f'#include "exercises.h"\n/* {each} */\n'})
    return Pupil(name, "several", None)


def _described(case: str) -> Kind:
    """Return the kind of one of the bad submissions of the grader's own tests."""
    described = read_toml(faulty.FOLDER / f"{case}.toml")
    outcomes = faulty.expected(described)
    earned = sum(
        check.points
        for exercise in exercises.load().exercises
        for check in exercise.checks
        if outcomes.get(check.id) == "passed"
    )

    def make(folder: Path) -> None:
        def submission(files: Mapping[str, str | None], **bodies: str) -> Path:
            first_tp(folder)
            (folder / "main.c").write_text(main_c({**STUDENT_MAIN, **bodies}), encoding="utf-8")
            for name, text in files.items():
                if text is not None:
                    (folder / name).write_text(text, encoding="utf-8")
            return folder

        faulty.write(described, submission)

    return _folder(make, case, earned / 100)


def _hostile(name: str, code: str, points: float) -> Kind:
    """Return the kind of a right TP1 with one more file, which acts while compiling or loading."""
    hangs = name == "loop" or name.startswith("bomb")
    return _folder(lambda folder: first_tp(folder, {"odd.c": code}), name, points, hangs)


def _attacking(first: int) -> Kind:
    """Return the kind that runs five programs of the hostile corpus, in TP1's five functions."""
    names = hostile.attacks()
    chosen = [(first + k) % len(names) for k in range(len(STUDENT_MAIN))]
    call = "extern void attack(int, color *); attack({}, img);"
    bodies = {name: call.format(k) for name, k in zip(STUDENT_MAIN, chosen, strict=True)}

    def make(folder: Path) -> None:
        hostile.write(folder, SECRET, 1)
        (folder / "main.c").write_text(main_c(bodies), encoding="utf-8")

    hangs = any(Cause.TIMEOUT in hostile.ends_of(names[k]) for k in chosen)
    return _folder(make, f"{names[chosen[0]]}...", 0, hangs)


def _kinds() -> list[Kind]:
    """Return makers of every kind; the ordinary ones come again and again, as in a class."""
    ordinary: list[Kind] = [
        _folder(full, "full", 100),
        _folder(skeleton, "skeleton", 0),
        _folder(first_tp, "tp1", TP1_POINTS),
        _packed(zipped, ".zip", first_tp, TP1_POINTS),
        _packed(tarred, ".tar.gz", first_tp, TP1_POINTS),
        _pair,
        _broken,
        _outside,
        _empty,
        _twice,
    ]
    odd = [_folder(partial(stub, turn=k), "stub", 0) for k in range(4)]
    odd += [_described(name) for name in faulty.NAMES]
    odd += [
        _hostile(name, text, TP1_POINTS if name in hostile.OVERRULED else 0)
        for name, text in hostile.loads()
    ]
    odd += [_hostile(name, text, TP1_POINTS) for name, text in hostile.compilations(SECRET)]
    odd += [_attacking(k) for k in range(0, len(hostile.attacks()), len(STUDENT_MAIN))]
    room = SIZE - len(ordinary) - len(odd)
    rest = [*odd, *(ordinary[k % len(ordinary)] for k in range(room))]
    random.Random(0).shuffle(rest)
    return [*ordinary, *rest]

"""What ./mrt answers: one line and status 2 to what it cannot do, a whole picture otherwise."""

from __future__ import annotations

import functools
import os
import pty
import re
import resource
import select
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest
from PIL import Image

from grader.course.exercises import CORE
from grader.tests.build.test_compile import PROGRAM, copy_sources, need
from grader.tests.setup.program.program import (
    HEIGHT,
    REFERENCE,
    WATCHED,
    WIDTH,
    Done,
    assert_refused,
    build,
    build_mrt,
    listing,
    make_mrt,
    need_libpng,
    need_sanitizers,
    read_ppm,
    run,
    size_flags,
)
from grader.tests.support.shell import script

FRENCH = {"MRT_LANG": "fr"}
WRITE = ("cannot write the picture", "impossible d'écrire l'image")
TEXTURE = ("unreadable texture", "texture illisible")
VALUE = ("missing or bad value", "valeur manquante ou incorrecte")
OPTION = ("unknown option", "option inconnue")
NUMBER = ("bad scene number", "numéro de scène incorrect")
EXTRA = ("one argument too many, or empty", "argument en trop ou vide")

WRONG_USES: list[tuple[list[str], tuple[str, str], str]] = [
    ([], ("the scene's number is missing", "il manque le numéro de la scène"), ""),
    (["16"], ("unknown scene", "scène inconnue"), ""),
    (["2147483647", "x"], ("unknown scene", "scène inconnue"), ""),
    (["2147483648", "x"], NUMBER, "2147483648"),
    (["9" * 50, "x"], NUMBER, "9999"),
    (["abc"], NUMBER, "abc"),
    (["1.5"], NUMBER, "1.5"),
    (["3x"], NUMBER, "3x"),
    (["+3"], NUMBER, "+3"),
    ([" 3"], NUMBER, " 3"),
    ([""], NUMBER, ""),
    (["-1"], OPTION, "-1"),
    (["1", "-"], OPTION, "-"),
    (["1", "x", "--"], OPTION, "--"),
    (["1", "x", "--no-shadow"], OPTION, "--no-shadow"),
    (["1", "x", "--samples=3"], OPTION, "--samples=3"),
    (["1", "x", "--samples"], VALUE, "--samples"),
    (["1", "x", "--samples", "0"], VALUE, "--samples"),
    (["1", "x", "--samples", "65"], VALUE, "--samples"),
    (["1", "x", "--samples", "2.5"], VALUE, "--samples"),
    (["1", "x", "--samples", ""], VALUE, "--samples"),
    (["1", "x", "--max-depth"], VALUE, "--max-depth"),
    (["1", "x", "--max-depth", "-1"], VALUE, "--max-depth"),
    (["1", "x", "--max-depth", "1001"], VALUE, "--max-depth"),
    (["1", "x", "--epsilon"], VALUE, "--epsilon"),
    (["1", "x", "--epsilon", ""], VALUE, "--epsilon"),
    (["1", "x", "--epsilon", "nan"], VALUE, "--epsilon"),
    (["1", "x", "--epsilon", "inf"], VALUE, "--epsilon"),
    (["1", "x", "--epsilon", "1e99"], VALUE, "--epsilon"),
    (["1", "x", "--epsilon", "-1"], VALUE, "--epsilon"),
    (["1", "x", "--epsilon", "1e-4x"], VALUE, "--epsilon"),
    (["1", ""], EXTRA, ""),
    (["1", "x", "y"], EXTRA, "y"),
    (["1", "x", ""], EXTRA, ""),
    (["1", "missing/x"], WRITE, "missing/x"),
    (["1", "folder"], WRITE, "folder"),
    (["1", "n" * 10_000], WRITE, "n" * 60 + "..."),
    (["1", "é" * 5_000], WRITE, "é" * 30 + "..."),
    (["1", "x" + "é" * 5_000], WRITE, "x" + "é" * 29 + "..."),
    (["1", "missing/a\nb\t\x1b[31mc\x7f"], WRITE, "missing/a?b??[31mc?"),
]

PPM = b"P6\n2 1\n255\n" + bytes(6)
TEXTURES = {
    "empty": b"",
    "not-a-picture": b"hello\n",
    "plain-ppm": PPM.replace(b"P6", b"P3"),
    "grey": PPM.replace(b"P6", b"P5"),
    "no-blank": PPM.replace(b"P6\n", b"P6"),
    "header-only": b"P6\n2 1\n255",
    "header-cut": b"P6\n2",
    "no-width": b"P6\n\n\n255\n",
    "zero-width": PPM.replace(b"2 1", b"0 1"),
    "negative": PPM.replace(b"2 1", b"-2 1"),
    "too-wide": PPM.replace(b"2 1", b"4097 1"),
    "overflowing": PPM.replace(b"2 1", b"4294967298 1"),
    "endless-number": PPM.replace(b"2 1", b"9" * 100_000 + b" 1"),
    "endless-comment": b"P6\n#" + b"x" * 100_000,
    "not-a-number": PPM.replace(b"2 1", b"two 1"),
    "sixteen-bits": PPM.replace(b"255", b"65535"),
    "ten-bits": PPM.replace(b"255", b"1023"),
    "no-levels": PPM.replace(b"255", b"0"),
    "truncated": PPM[:-1],
    "huge-and-truncated": PPM.replace(b"2 1", b"4096 4096"),
}


def earlier_pictures(folder: Path) -> dict[str, bytes]:
    """Put earlier pictures in a folder; return what is in it."""
    for suffix in ("ppm", "png"):
        (folder / f"x.{suffix}").write_bytes(b"an earlier picture")
        (folder / f"output.{suffix}").write_bytes(b"an earlier picture")
    return listing(folder)


# ---- Wrong use -------------------------------------------------------------------------------


@pytest.mark.parametrize("language", [0, 1], ids=["en", "fr"])
def test_wrong_use_is_one_line(mrt: Path, tmp_path: Path, language: int) -> None:
    """Each wrong command line says what and about what; earlier pictures stay, no file is new."""
    (tmp_path / "folder.ppm").mkdir()
    before = earlier_pictures(tmp_path)
    for words, sentences, about in WRONG_USES:
        done = run([mrt, *words], tmp_path, {"MRT_LANG": ("en", "fr")[language]})
        assert_refused(done, f"mrt: {sentences[language]}", about)
        assert len(done.stderr) < 250
    assert listing(tmp_path) == before


@pytest.mark.parametrize("flag", ["--help", "-h"])
def test_help_is_on_stdout(mrt: Path, tmp_path: Path, flag: str) -> None:
    """Help says on stdout, in both languages, every option there is, and draws nothing."""
    english = run([mrt, "1", "x", flag], tmp_path)
    french = run([mrt, flag], tmp_path, FRENCH)
    options = set(re.findall(r'"(--[a-z-]+)"', (CORE / "utils.h").read_text(encoding="utf-8")))
    assert len(options) == 10
    for done, word in ((english, "Usage: ./mrt SCENE"), (french, "Usage : ./mrt SCÈNE")):
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith(word)
        assert [each for each in options if each not in done.stdout] == []
    assert listing(tmp_path) == {}


# ---- Pictures --------------------------------------------------------------------------------


def test_every_option_is_taken(mrt: Path, tmp_path: Path) -> None:
    """All the options together, on both sides of the scene and the name, draw a picture."""
    switches = ["shading", "shadows", "reflections", "fresnel", "refraction", "octree"]
    options = [f"--no-{each}" for each in switches]
    values = ["--samples", "2", "--max-depth", "0", "--epsilon", "0.001"]
    done = run([mrt, *options, "5", *values, "all"], tmp_path)
    assert (done.stderr, done.returncode) == ("", 0)
    assert done.stdout.startswith("all.ppm")  # what it has written
    assert read_ppm(tmp_path / "all.ppm")[:2] == (WIDTH, HEIGHT)


@pytest.mark.long
def test_the_size_is_the_builds(mrt: Path, tmp_path: Path) -> None:
    """`make mrt WIDTH=64 HEIGHT=36` draws 64x36, with its flags even when built again otherwise."""
    assert run([mrt, 1], tmp_path).returncode == 0
    assert read_ppm(tmp_path / "output.ppm")[:2] == (WIDTH, HEIGHT)
    other = make_mrt(tmp_path / "build", "reference", WIDTH="33", HEIGHT="20")
    assert run([other, 1], tmp_path).returncode == 0
    assert read_ppm(tmp_path / "output.ppm")[:2] == (33, 20)


@pytest.mark.parametrize("scene", [1, 4, 9, 11, 15])
def test_the_png_is_the_ppm(mrt: Path, tmp_path: Path, scene: int) -> None:
    """NAME.png has the pixels of NAME.ppm."""
    need_libpng(tmp_path)
    assert run([mrt, scene, "picture"], tmp_path).returncode == 0
    width, height, pixels = read_ppm(tmp_path / "picture.ppm")
    with Image.open(tmp_path / "picture.png") as png:
        assert (png.mode, png.size) == ("RGB", (width, height))
        assert png.tobytes() == pixels
    assert len(set(pixels)) > 3


@pytest.mark.parametrize("name", ["été", "a b", "a\nb", "%s%n", "n" * 240])
def test_a_picture_takes_any_name(mrt: Path, tmp_path: Path, name: str) -> None:
    """What the file system takes as a name is taken, and written over."""
    (tmp_path / f"{name}.ppm").write_bytes(b"an earlier picture")
    done = run([mrt, 0, name], tmp_path)
    assert (done.stderr, done.returncode) == ("", 0)
    assert done.stdout.startswith(f"{name}.ppm")
    assert set(listing(tmp_path)) - {f"{name}.png"} == {f"{name}.ppm"}
    assert read_ppm(tmp_path / f"{name}.ppm")[2] == b"\xff\0\0" * (WIDTH * HEIGHT)


def test_the_skeleton_says_once_what_is_to_do(skeleton_mrt: Path, tmp_path: Path) -> None:
    """The exercises met go to stderr in one line, in the handout's order; not behind an error."""
    done = run([skeleton_mrt, 3, "x"], tmp_path, FRENCH)
    assert done.returncode == 0
    assert done.stdout.startswith("x.ppm")
    assert done.stderr == "Encore à écrire : TP1.3 TP1.4 TP1.5\n"
    done = run([skeleton_mrt, 5, "x"], tmp_path)
    assert done.stderr.startswith("Still to write: TP2.2")
    assert done.stderr.count("\n") == 1
    assert_refused(run([skeleton_mrt, 3, "missing/x"], tmp_path), WRITE[0])


# ---- The texture and the scene ---------------------------------------------------------------


@pytest.fixture
def without_texture(mrt: Path, tmp_path: Path) -> Path:
    """Return the program alone in a folder."""
    folder = tmp_path / "alone"
    folder.mkdir()
    return Path(shutil.copy(mrt, folder))


def assert_no_texture(mrt: Path) -> None:
    """Hold that the scenes with a texture are refused in both languages, and nothing is written."""
    before = earlier_pictures(mrt.parent)
    for scene in (11, 15):
        for language, sentence in zip(("en", "fr"), TEXTURE, strict=True):
            done = run([mrt, scene, "x"], mrt.parent, {"MRT_LANG": language})
            assert_refused(done, f"mrt: {sentence}", ": texture.ppm\n")
    assert listing(mrt.parent) == before


@pytest.mark.parametrize("kind", TEXTURES)
def test_a_bad_texture_is_refused(without_texture: Path, kind: str) -> None:
    """A malformed, truncated or huge texture is one line; earlier pictures stay."""
    (without_texture.parent / "texture.ppm").write_bytes(TEXTURES[kind])
    assert_no_texture(without_texture)


def test_a_missing_texture_is_refused(without_texture: Path) -> None:
    """No texture, or a folder of that name: the scenes that need it say so, the others do not."""
    assert_no_texture(without_texture)
    (without_texture.parent / "texture.ppm").mkdir()
    assert_no_texture(without_texture)
    assert run([without_texture, 12, "x"], without_texture.parent).returncode == 0


def test_the_texture_stands_beside_the_program(mrt: Path, tmp_path: Path) -> None:
    """The texture is found from any folder, and one of a single texel is enough."""
    done = run([mrt, 11, "far"], tmp_path)
    assert (done.stderr, done.returncode) == ("", 0)
    alone = Path(shutil.copy(mrt, tmp_path))
    (tmp_path / "texture.ppm").write_bytes(b"P6 # one texel\n1 1\n1\n\x01\x00\x00")
    assert run([alone, 11, "near"], tmp_path).returncode == 0
    assert read_ppm(tmp_path / "far.ppm") != read_ppm(tmp_path / "near.ppm")


@pytest.mark.long
def test_a_full_scene_is_an_error(tmp_path: Path) -> None:
    """With room for 100 objects, the scenes that have more say so; the others are drawn."""
    need_sanitizers(tmp_path)
    flags = [*WATCHED, "-DSCENE_SIZE=100", *size_flags(16, 9)]
    mrt = build_mrt(tmp_path / "mrt", flags, CORE, REFERENCE)
    before = earlier_pictures(tmp_path)
    for scene in (8, 13, 14, 15):
        assert_refused(run([mrt, scene, "x"], tmp_path), "the scene is full", "SCENE_SIZE=")
        assert_refused(run([mrt, scene, "x"], tmp_path, FRENCH), "la scène est pleine")
    assert listing(tmp_path) == before
    for scene in (5, 6, 7, 9, 10, 11, 12):
        assert run([mrt, scene, "x"], tmp_path).returncode == 0


# ---- Folders and disks -----------------------------------------------------------------------


def test_a_locked_folder_is_an_error(mrt: Path, tmp_path: Path) -> None:
    """A folder without the right to write is one line."""
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o555)
    drop: list[str] = []
    if os.geteuid() == 0:  # root may write anywhere until it drops that right
        need(shutil.which("setpriv") is not None, "setpriv")
        drop = ["setpriv", "--inh-caps=-all", "--bounding-set=-all"]
    for language, sentence in zip(("en", "fr"), WRITE, strict=True):
        done = run([*drop, mrt, 1, "x"], locked, {"MRT_LANG": language})
        assert_refused(done, f"mrt: {sentence}", "(Permission denied): x\n")
    assert listing(locked) == {}


@pytest.mark.parametrize("limit", [0, 16, 4096])
def test_a_file_too_large_is_an_error(mrt: Path, tmp_path: Path, limit: int) -> None:
    """Where no file may exceed a limit, as with a quota, the earlier picture stays, alone."""
    before = earlier_pictures(tmp_path)
    done = subprocess.run(
        [mrt, "8", "x"],
        cwd=tmp_path,
        env={**os.environ, "MRT_LANG": "en"},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        restore_signals=False,  # Python ignores SIGXFSZ: writing then fails instead of killing
        preexec_fn=functools.partial(resource.setrlimit, resource.RLIMIT_FSIZE, (limit, limit)),
    )
    assert_refused(done, f"mrt: {WRITE[0]}", "(File too large): x\n")
    assert listing(tmp_path) == before


MOUNT = """set -e
mount -t tmpfs -o size="$1" none disk
cd disk
echo earlier >x.ppm
if [ "$2" = ro ]; then mount -o remount,ro none "$PWD"; fi
shift 2
"$@" && status=0 || status=$?
for file in *; do echo "$file $(wc -c <"$file")"; done
exit $status
"""


def on_small_disk(folder: Path, size: str, mode: str, command: Sequence[object]) -> Done:
    """Run a command on a disk of its own that holds an earlier x.ppm; stdout lists its files."""
    need(shutil.which("unshare") is not None, "unshare")
    private = ["unshare", "--mount", *([] if os.geteuid() == 0 else ["--map-root-user"])]
    (folder / "disk").mkdir()
    mount = script(folder / "mount.sh", MOUNT)
    if run([*private, mount, size, mode, "true"], folder).returncode != 0:
        pytest.skip("this machine lets nobody mount a small disk")
    return run([*private, mount, size, mode, *command], folder)


@pytest.mark.parametrize(
    ("size", "mode", "cause", "left"),
    [
        ("4k", "rw", "No space left on device", "x.ppm 8\n"),
        ("8k", "rw", "No space left on device", "x.ppm 8\n"),
        ("12k", "rw", "No space left on device", f"x.ppm {13 + 3 * WIDTH * HEIGHT}\n"),
        ("64k", "ro", "Read-only file system", "x.ppm 8\n"),
    ],
    ids=["nothing-fits", "ppm-does-not-fit", "png-does-not-fit", "read-only"],
)
def test_a_full_disk_is_an_error(
    mrt: Path, tmp_path: Path, size: str, mode: str, cause: str, left: str
) -> None:
    """No half picture is left: what stood there stays until a whole new one is written."""
    if size == "12k":
        need_libpng(tmp_path)
    done = on_small_disk(tmp_path, size, mode, [mrt, 8, "x"])
    assert done.stdout == left
    done.stdout = ""
    assert_refused(done, f"mrt: {WRITE[0]}", f"({cause}): x\n")


def test_a_tree_that_takes_time_is_seen(tmp_path: Path) -> None:
    """At a terminal, before the picture has begun: who subdivides without end knows where."""
    folder = tmp_path / "endless"
    folder.mkdir()
    copy_sources(folder, CORE, REFERENCE)
    tree = folder / "octree.c"
    head = "octree_node *octree_build(const object *objects, int count) {"
    text = tree.read_text(encoding="utf-8")
    assert text.count(head) == 1
    # Each tick of the timer ends a pause.
    waits = f"{head}\n    while (count >= 0) {{\n        pause();\n    }}"
    tree.write_text(text.replace(head, waits), encoding="utf-8")
    build(folder / "mrt", ["-include", "unistd.h", *size_flags(WIDTH, HEIGHT)], PROGRAM, folder)
    reading, writing = pty.openpty()
    said = b""
    with subprocess.Popen(["./mrt", "8"], cwd=folder, stderr=writing, text=False) as running:
        try:
            while b"octree..." not in said and select.select([reading], [], [], 30)[0]:
                said += os.read(reading, 999)
        finally:
            running.kill()
    os.close(writing)
    os.close(reading)
    assert said.endswith(b"\roctree...")

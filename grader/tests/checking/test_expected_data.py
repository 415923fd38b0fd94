"""Expected data: written and read, refused when it is not whole; and how answers are compared."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

from grader.authoring.expected import command, mistake_bank
from grader.authoring.expected.pictures import lineup, make
from grader.authoring.specimens import mistakes
from grader.checking import describe
from grader.checking.comparison import Answers, Wrong, far, unit
from grader.checking.expected_data import FOLDER, SIZE, Answer, Batch, ExpectedError, encode, read
from grader.evaluation import recognition
from grader.evaluation.recognition import BANK, KnownMistake
from grader.execution.session import Array, Library, open_core
from grader.tests.support.sampling import sampled

ROOT = Path(__file__).resolve().parents[3]
SUITE = "intersect_sphere.front"


@pytest.fixture(scope="module")
def core(cache: Path) -> Iterator[Library]:
    """Return the reference, at the size of the data."""
    with open_core(ROOT / "reference", *SIZE, cache=cache) as core:
        yield core


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """Return a copy of the expected data that a test may spoil."""
    folder = tmp_path / "données"
    shutil.copytree(FOLDER, folder)
    return folder


def test_the_stored_data_is_what_the_reference_gives() -> None:
    """Nothing has drifted: inputs are the same, answers as close as rounding allows."""
    assert command.main(["--check"]) == 0


@pytest.mark.long
def test_drift_is_told(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Another seed's inputs, and a suite that nothing makes any more, are named."""
    (copy / "autre.npz").write_bytes(b"")
    assert command.main(["--check", "--out", str(copy), "--seed", "3"]) == 1
    said = capsys.readouterr().out
    assert f"{SUITE}.npz has drifted from the reference; run make expected" in said
    assert "autre.npz: not in the manifest" in said


@pytest.mark.long
def test_another_seed_gives_other_data_and_the_same_suites(tmp_path: Path) -> None:
    """It can be made anywhere, and made twice it is the same to the byte."""
    folders = [tmp_path / name for name in ("un", "deux")]
    words = ["--seed", "3", "--without-bank", "--without-views"]
    for folder in folders:
        assert command.main([*words, "--out", str(folder)]) == 0
    paths = [path for path in FOLDER.rglob("*") if path.is_file() and path.name != BANK]
    names = sorted(str(path.relative_to(FOLDER)) for path in paths)
    made = [path for path in folders[0].rglob("*") if path.is_file()]
    assert sorted(str(path.relative_to(folders[0])) for path in made) == names
    for name in names:
        assert (folders[0] / name).read_bytes() == (folders[1] / name).read_bytes()
    assert (folders[0] / f"{SUITE}.npz").read_bytes() != (FOLDER / f"{SUITE}.npz").read_bytes()


def contents(folder: Path) -> dict[str, bytes]:
    """Return every file of a folder of expected data."""
    paths = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


@pytest.mark.parametrize("name", ["camera_ray.anywhere", "populate_spheres.any", "octree.hits"])
def test_a_suite_is_made_alone(copy: Path, name: str) -> None:
    """Byte for byte what is stored, also where it was gone; no other file changes."""
    before = contents(copy)
    manifest = json.loads(before["manifest.json"])
    (copy / f"{name}.npz").unlink()
    del manifest["files"][f"{name}.npz"]
    (copy / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    assert command.main(["--out", str(copy), "--suite", name]) == 0
    assert contents(copy) == before


@pytest.mark.long
def test_a_suite_that_changes_takes_its_mistakes_along(
    copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The bank's mistakes of its exercise are put to it again; those of the others are not."""
    asked: list[str] = []

    def answers(mistake: mistakes.Mistake, *_: object) -> KnownMistake:
        asked.append(mistake.id)
        return bank[mistake.id]

    bank = recognition.read(copy)
    monkeypatch.setattr(mistake_bank, "answers", answers)
    manifest = json.loads((copy / "manifest.json").read_text(encoding="utf-8"))
    manifest["seed"] = 3
    (copy / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    assert command.main(["--out", str(copy), "--suite", "camera_ray.middle"]) == 0
    assert asked == [each.id for each in mistakes.load() if each.exercise == "TP2.1"]
    assert mistake_bank.main(["--check", "--out", str(copy)]) == 0
    changed = {
        name for name, content in contents(copy).items() if content != contents(FOLDER)[name]
    }
    assert changed == {"camera_ray.middle.npz", "manifest.json"}


@pytest.mark.long
@pytest.mark.parametrize("name", sampled(["scene7", "scene1", "scene3.fresnel"], ["scene7"]))
def test_a_picture_is_made_alone(copy: Path, name: str) -> None:
    """Byte for byte what is stored, also where it was spoilt; no other file changes."""
    before = contents(copy)
    for path in (copy / "pictures").glob(f"{name}.*"):
        if path.stem.removeprefix(f"{name}.") in ("maps", "light") or path.stem == name:
            path.write_bytes(b"")
    assert command.main(["--out", str(copy), "--picture", name]) == 0
    assert contents(copy) == before


def test_a_picture_in_which_no_mistake_shows_has_no_file_of_them(
    copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that was there goes, from the manifest too; nothing else changes."""
    monkeypatch.setattr(lineup, "files", lambda folder, picture: ({}, {}))
    monkeypatch.setattr(make, "picture_files", lambda picture: ({}, {}))
    before = contents(copy)
    assert command.main(["--out", str(copy), "--picture", "scene1.flat"]) == 0
    after, gone = contents(copy), "scene1.flat.mistakes.npz"
    assert before.keys() - after.keys() == {f"pictures/{gone}"}
    index = "pictures/manifest.json"
    assert {name for name in after if after[name] != before[name]} == {index}
    files = json.loads(before[index])["files"]
    del files[gone]
    assert json.loads(after[index])["files"] == files


@pytest.mark.parametrize(
    ("option", "name", "near"),
    [
        ("suite", "camera_ray.anywere", "camera_ray.anywhere"),
        ("picture", "scene4.shadow", "scene4.shadows"),
        ("picture", "4", "scene4"),
        ("mistake", "sphere_far_rot", "sphere_far_root"),
    ],
)
def test_an_unknown_name_is_told(
    copy: Path, capsys: pytest.CaptureFixture[str], option: str, name: str, near: str
) -> None:
    """In one line with the nearest one; nothing changes."""
    assert command.main(["--out", str(copy), f"--{option}", name]) == 2
    said = capsys.readouterr().err
    assert said == f"{option.upper()}={name}: there is none; the nearest is {near}\n"
    assert contents(copy) == contents(FOLDER)


def test_the_manifest_tells_where_the_data_comes_from() -> None:
    """Command, compiler; of each file its sum, its tolerance, and the reason for it."""
    manifest = json.loads((FOLDER / "manifest.json").read_text(encoding="utf-8"))
    assert (
        manifest["command"] == f"python -m grader.authoring.expected.command --seed {command.SEED}"
    )
    assert manifest["size"] == list(SIZE)
    assert manifest["compiler"]
    for name, rules in manifest["files"].items():
        assert (FOLDER / name).exists()
        assert rules["calls"] > 0
        assert 0 <= rules["tolerance"] < 0.05
        assert rules["reason"]


def test_what_is_written_is_read_again(core: Library, tmp_path: Path) -> None:
    """Structs with a union, globals, several answers: nothing changes on the way."""
    (batch, *_) = read(FOLDER, "trace_ray.object", core)
    again = encode([batch])
    assert again == encode([batch])
    assert batch.globals["scene"].dtype == core.dtype("object")
    assert len(batch.answers) > 1
    assert batch.count == len(batch.args["r"]) == len(batch.answers[4].out["r"])


@pytest.mark.parametrize("spoil", ["changed", "gone", "manifest", "malformed"])
def test_data_that_is_not_whole_is_refused(core: Library, copy: Path, spoil: str) -> None:
    """One line names the file and the cure."""
    path = copy / ("manifest.json" if spoil in ("manifest", "malformed") else f"{SUITE}.npz")
    if spoil == "changed":
        path.write_bytes(path.read_bytes() + b"x")
    elif spoil == "malformed":
        path.write_text("{}", encoding="utf-8")
    else:
        path.unlink()
    with pytest.raises(ExpectedError, match="make expected") as error:
        read(copy, SUITE, core)
    assert path.name in str(error.value)
    assert "\n" not in str(error.value)


def test_data_of_other_structs_is_refused(core: Library, copy: Path) -> None:
    """Bytes of a struct of another size are not read as if they were ours."""
    (batch,) = read(FOLDER, SUITE, core)
    short = Batch(batch.function, {**batch.args, "obj": np.zeros((3, 8), np.uint8)}, {})
    content = encode([short])
    (copy / f"{SUITE}.npz").write_bytes(content)
    manifest = json.loads((copy / "manifest.json").read_text(encoding="utf-8"))
    manifest["files"][f"{SUITE}.npz"]["sha256"] = hashlib.sha256(content).hexdigest()
    (copy / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    with pytest.raises(ExpectedError, match="made for other structs"):
        read(copy, SUITE, core)


def test_a_folder_that_cannot_be_written_is_wrong_use(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line, exit code 2."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert command.main(["--out", str(tmp_path / "file" / "data")]) == 2
    assert capsys.readouterr().err.endswith("choose another --out\n")


def test_a_nan_is_far_from_everything() -> None:
    """The tolerance grows with answers above 1; a NaN or an infinity is never within it."""
    expected = np.array([[100, 0, 0], [0, 0, 0.5], [1, 1, 1], [1, 1, 1]], np.float32)
    got = np.array([[100.05, 0, 0], [0, 0.002, 0.5], [np.nan, 1, 1], [np.inf, 1, 1]], np.float32)
    np.testing.assert_array_equal(far(got, expected, 1e-3), [False, True, True, True])
    assert np.isnan(unit(np.zeros((1, 3), np.float32))).all()


def numbers(values: list[float]) -> Array:
    """Return floats."""
    return np.array(values, np.float32)


def asked(got: list[float], *accepted: list[float]) -> Answers:
    """Return a trial of reflectance, with answers of several conventions."""
    args = {"n1": numbers([2.37, 1, 3]), "n2": numbers([1.16, 3, 1.14])}
    answers = tuple(Answer(numbers(each), {}) for each in accepted)
    batch = Batch("reflectance", args, {}, answers, 1e-3)
    return Answers(batch, Answer(numbers(got), {}))


def test_any_one_convention_will_do() -> None:
    """All the answers of one must fit: not some of one and some of another."""
    asked([1, 2, 3], [4, 5, 6], [1, 2, 3]).expect("result")
    with pytest.raises(Wrong):
        asked([1, 2, 6], [4, 5, 6], [1, 2, 3]).expect("result")


def test_the_simplest_wrong_case_is_shown() -> None:
    """Of several wrong answers, the one whose inputs are easiest to follow."""
    with pytest.raises(Wrong) as error:
        asked([0, 0, 0], [1, 2, 3]).expect("result")
    assert error.value.message.key == "failure.result"
    values = {"call": "reflectance(n1 = 1, n2 = 3)", "got": "0", "expected": "2"}
    assert error.value.message.values == values


def test_the_simplest_is_the_least_complex(core: Library) -> None:
    """Found quickly among many calls, it is what comparing all of them one by one would find."""
    suites = (SUITE, "shade.both", "intersect_cone.caps", "camera_ray.anywhere", "shade.lobe")
    for batch in chain.from_iterable(read(FOLDER, suite, core) for suite in suites):
        complexities = [describe.complexity(batch, case) for case in range(batch.count)]
        for step in (1, 7):
            cases = np.arange(0, batch.count, step)
            assert describe.simplest(batch, cases) == min(cases, key=complexities.__getitem__)


def test_calls_are_told_by_what_matters(core: Library) -> None:
    """What is only written, what is zero, and what the function does not read are left out."""
    (batch,) = read(FOLDER, SUITE, core)
    assert describe.call(batch, 0, ["it"]) == (
        "intersect_sphere(r = {orig (0, 0, 5), dir (0, 0, -1)}, it,"
        " obj = {SPHERE, center (0, 0, 0), radius 1})"
    )
    (sky, *_) = read(FOLDER, "mirror_color.sky", core)
    told = describe.call(sky, 0)
    assert "ks (1, 1, 1)" in told
    assert "kd" not in told
    assert told.endswith("[options.fresnel = false]")

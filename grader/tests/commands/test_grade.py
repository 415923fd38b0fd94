"""`python -m grader grade`, from a submission's folder to the table and results.json."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from grader.authoring.skeleton import skeleton
from grader.authoring.specimens import mistakes
from grader.authoring.specimens.student import EVERY_PIXEL
from grader.build import toolchain
from grader.course import exercises
from grader.tests.support import grading
from grader.tests.support.grading import Graded

ROOT = Path(__file__).resolve().parents[3]
Write = Callable[..., Path]
Grade = Callable[..., Graded]

WRONG = "sphere_normal_from_zero"


@pytest.fixture
def grade(cache: Path, tmp_path: Path) -> Grade:
    """Return a function that grades a folder, TP1 unless told else; builds are kept."""

    def run(
        folder: Path, *words: str, root: Path = ROOT, whole: bool = False, **settings: str
    ) -> Graded:
        words = words if whole or "-k" in words or "--tp" in words else (*words, "--tp", "1")
        build = tmp_path / "build"
        return grading.grade(folder, build, cache, *words, root=root, settings=settings)

    return run


def full_points() -> dict[str, float]:
    """Return what every check of TP1 is worth."""
    checks = exercises.load().checks().items()
    return {name[4:]: each.points / 100 for name, each in checks if name.startswith("tp1.")}


def test_the_reference_has_every_point(grade: Grade) -> None:
    """The solution passes every check, and the report says so."""
    done = grade(ROOT / "reference", whole=True)
    assert (done.code, done.err) == (0, "")
    assert {each["outcome"] for each in done.results["checks"]} == {"passed"}
    keys = ("score", "max_score", "bonus", "max_bonus")
    assert [done.results[key] for key in keys] == [100, 100, 20, 20]
    assert "Total provisoire : 100 / 100" in done.out
    assert "Bonus : 20 / 20" in done.out


@pytest.mark.long
def test_what_is_done_side_by_side_changes_nothing(grade: Grade, tmp_path: Path) -> None:
    """With one thing at a time or four, a wrong program's checks say the same, in their order."""
    folder = tmp_path / "rendu"
    folder.mkdir()
    for name, text in next(each for each in mistakes.load() if each.id == WRONG).files().items():
        (folder / name).write_text(text, encoding="utf-8")
    alone, together = (
        grade(folder, "--jobs", str(jobs), whole=True).results["checks"] for jobs in (1, 4)
    )
    for each in (*alone, *together):
        del each["seconds"]
    assert "failed" in {each["outcome"] for each in alone}
    assert alone == together


def test_the_skeleton_has_none_and_a_calm_list(grade: Grade, tmp_path: Path) -> None:
    """Untouched, all is to do: no point, no failure, no question, no picture, exit code 0."""
    folder = tmp_path / "core_c"
    folder.mkdir()
    arguments = ["--reference", str(ROOT / "reference"), "--out", str(folder)]
    assert skeleton.main(arguments) == 0
    done = grade(folder, whole=True)
    assert (done.code, done.err) == (0, "")
    assert (done.results["score"], done.results["bonus"]) == (0, 0)
    assert {each["outcome"] for each in done.results["checks"]} == {"todo"}
    assert not any(each["images"] for each in done.results["checks"])
    assert "TP2 - Rayons lumineux et objets : à venir, 30 points" in done.out
    assert "Tout est encore à écrire" in done.out
    assert "Prochaine étape : TP1.1, la fonction fill_red dans main.c" in done.out
    assert "?" not in done.out
    assert len(done.out.splitlines()) < 30


def test_the_handouts_naive_code_has_every_point(grade: Grade, submission: Write) -> None:
    """Distances truncated to integers, H - 1 for H, every pixel visited: all of it is right."""
    assert grade(submission()).points() == full_points()


def test_other_conventions_have_every_point(grade: Grade, submission: Write) -> None:
    """The row's middle, a half-open rectangle, a box around the disc, square roots."""
    done = grade(
        submission(
            fill_red="fill(img, vector_init(1, 0, 0));",
            horizontal_gradient="""
                for (int k = 0; k < WIDTH * HEIGHT; k++) {
                    double t = (k / WIDTH + 0.5) / HEIGHT;
                    img[k].x = c1.x * t + c2.x * (1 - t);
                    img[k].y = c1.y * t + c2.y * (1 - t);
                    img[k].z = c1.z * t + c2.z * (1 - t); }""",
            fill_rect="""
                point3 a = vector_min(p1, p2), b = vector_max(p1, p2);
                for (int j = a.y < 0 ? 0 : a.y; j < b.y && j < HEIGHT; j++)
                    for (int i = a.x < 0 ? 0 : a.x; i < b.x && i < WIDTH; i++)
                        img[j * WIDTH + i] = c;""",
            fill_circle="""
                for (int j = center.y - radius; j <= center.y + radius; j++)
                    for (int i = center.x - radius; i <= center.x + radius; i++) {
                        vec3 d = vector_init(i - center.x, j - center.y, 0);
                        if (i >= 0 && i < WIDTH && j >= 0 && j < HEIGHT && vector_norm(d) < radius)
                            img[j * WIDTH + i] = c; }""",
        )
    )
    assert done.points() == full_points()


def test_common_mistakes_lose_their_own_points(grade: Grade, submission: Write) -> None:
    """Upside down, corners in one order only, a rim too many: the rest of the points stay."""
    done = grade(
        submission(
            fill_red=f"{EVERY_PIXEL} img[j * WIDTH + i] = vector_init(0, 0, 1);",
            fill="for (int k = 0; k < WIDTH * HEIGHT - 1; k++) img[k] = c;",
            horizontal_gradient=f"""{EVERY_PIXEL} {{ float t = j / (float)HEIGHT;
                img[j * WIDTH + i] = vector_add(vector_float_mul(t, c2),
                                                vector_float_mul(1 - t, c1)); }}""",
            fill_rect=f"""{EVERY_PIXEL} if (i >= p1.x && i <= p2.x && j >= p1.y && j <= p2.y)
                img[j * WIDTH + i] = c;""",
            fill_circle=f"""{EVERY_PIXEL} {{ float dx = i - center.x, dy = j - center.y;
                if (dx * dx + dy * dy <= radius * radius) img[j * WIDTH + i] = c; }}""",
        )
    )
    points = full_points()
    lost = {
        "fill_red.color",
        "fill_red.every_pixel",
        "fill_color.every_pixel",
        "horizontal_gradient.direction",
        "fill_rect.corner_order",
        "fill_circle.rim",
    }
    assert done.points() == {name: each for name, each in points.items() if name not in lost}
    assert done.check("fill_color.every_pixel")["message"].startswith(
        "Après fill(img, c = (0.25, 0.5, 0.75)) dans une image de 320 x 180, le pixel (319, 179)"
    )
    assert (
        "la ligne 178 vaut (0.9889, 0.9889, 1)"
        in done.check("horizontal_gradient.direction")["message"]
    )
    # Each failure shows what was expected beside what came; what is right shows nothing.
    for name in lost:
        pictures = done.check(name)["images"]
        drawn = name not in ("fill_rect.corner_order",)  # where nothing was
        assert set(pictures) == ({"expected", "got", "difference", "detail"} if drawn else set())
    assert done.check("fill_rect.inside")["images"] == {}
    assert done.check("fill_circle.rim")["hint"] == (
        "Un pixel dont la distance au centre est exactement le rayon du disque en fait-il partie ?"
    )


@pytest.mark.long
def test_wrong_tables_crash_at_their_line(grade: Grade, submission: Write) -> None:
    """H for W, no clipping, a loop, an exit, a NaN: each has its outcome and its sentence."""
    done = grade(
        submission(
            fill_red=f"{EVERY_PIXEL} img[i * WIDTH + j] = vector_init(1, 0, 0);",
            fill=f"float nan = 0; nan /= nan; {EVERY_PIXEL} img[j * WIDTH + i].x = nan;",
            horizontal_gradient="exit(0);",
            fill_rect="for (volatile int k = 0;; k ^= 1) { }",
            fill_circle="""
                for (int j = center.y - radius; j <= center.y + radius; j++)
                    for (int i = center.x - radius; i <= center.x + radius; i++)
                        if ((i - center.x) * (i - center.x) + (j - center.y) * (j - center.y)
                            < radius * radius) img[j * WIDTH + i] = c;""",
        )
    )
    assert done.code == 0
    assert done.outcomes() == {
        "fill_red": "crashed",
        "fill": "failed",
        "horizontal_gradient": "crashed",
        "fill_rect": "timeout",
        "fill_circle": "failed",
    }
    assert set(done.points()) == {"fill_circle.inside", "fill_circle.exact", "fill_circle.rim"}
    assert "a mis fin au programme (code 0)" in done.out
    assert "ne se termine pas : arrêt après 2 s" in done.out
    # Column -1 is the end of the row below: in the table, and yet not in the picture.
    assert "le pixel (316, 20) vaut (1, 1, 0)" in done.check("fill_circle.clipped")["message"]
    if toolchain.sanitizer_runtime(toolchain.find_compiler()):
        assert done.check("fill_red.every_pixel")["location"] == "main.c:11"
        assert "ou que malloc a donné, dans fill_red (main.c:11)." in done.out


def test_stubs_and_constants_earn_nothing(grade: Grade, submission: Write) -> None:
    """Doing nothing, without a marker, passes no negative check: its twin fails."""
    done = grade(
        submission(
            fill_red="", fill="", horizontal_gradient="", fill_rect="", fill_circle="fill(img, c);"
        )
    )
    assert done.points() == {}
    assert done.check("fill_rect.off_screen")["outcome"] == "blocked"


def test_a_marker_left_in_right_code_is_a_note(grade: Grade, submission: Write) -> None:
    """Right is right, with advice; wrong with its own marker is to do; no other excuses."""
    done = grade(
        submission(
            fill='MRT_TODO("TP1.2"); for (int k = 0; k < WIDTH * HEIGHT; k++) img[k] = c;',
            fill_red='MRT_TODO("TP1.1"); abort();',
            fill_rect='MRT_TODO("TP1.3");',
        )
    )
    assert done.outcomes() == {
        "fill_red": "todo",
        "fill": "passed",
        "horizontal_gradient": "passed",
        "fill_rect": "failed",
        "fill_circle": "passed",
    }
    assert 'effacez la ligne MRT_TODO("TP1.2")' in done.out


def test_what_a_function_prints_is_shown_and_judges_nothing(
    grade: Grade, submission: Write
) -> None:
    """A forged verdict is but a line of text, under the function's own."""
    done = grade(submission(fill='printf("passed 2 / 2\\n");'))
    assert "fill_color.every_pixel" not in done.points()
    assert "    passed 2 / 2\n" in done.out


def test_a_missing_function_fails_alone(grade: Grade, submission: Write) -> None:
    """The others keep their points."""
    folder = submission()
    main = folder / "main.c"
    main.write_text(
        main.read_text(encoding="utf-8").replace("void fill_red(", "void paint("), "utf-8"
    )
    done = grade(folder)
    assert set(full_points()) - set(done.points()) == {"fill_red.color", "fill_red.every_pixel"}
    assert "La fonction fill_red est introuvable" in done.out


def test_files_that_do_not_compile_show_the_compiler_first(grade: Grade, submission: Write) -> None:
    """No point, exit code 0, the message at the student's line before the table."""
    done = grade(submission(fill="img[0] = 1 +;"))
    assert (done.code, done.results["score"]) == (0, 0)
    assert done.results["build"]["ok"] is False
    assert done.out.index("main.c:12:") < done.out.index("TP1 - Images")


@pytest.mark.long
def test_a_part_can_be_asked_for(grade: Grade, submission: Write) -> None:
    """A name or a TP selects checks, with the twin that they need, into a folder of their own.

    Points are told of whole exercises only.
    """
    done = grade(submission(), "-k", "fill_rect.off_screen")
    assert set(done.points()) == {"fill_rect.inside", "fill_rect.off_screen"}
    assert done.results["partial"] is True
    assert done.results["exercises"][0]["part"] == {"run": 2, "of": 5}
    assert "fill_rect  vérifications faites : 2 sur 5" in done.out
    assert "TP1.4 : vérifications qui n'ont pas été faites : 3" in done.out
    assert "Total" not in done.out
    whole = grade(submission(), "-k", "fill_rect")
    assert "Total provisoire : 4 / 4" in whole.out
    assert "part" not in whole.results["exercises"][0]
    other = grade(submission(), "--tp", "2")
    assert {each["tp"] for each in other.results["checks"]} == {2}


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["-k", "a or b"], "K= prend un nom, ou plusieurs"),
        (["-k", "draw"], "draw : la machine ne juge pas cela"),
        (["--tp", "TP9"], "Il n'y a pas de TP9"),
    ],
)
def test_wrong_words_are_wrong_use(
    grade: Grade, submission: Write, words: list[str], sentence: str
) -> None:
    """One line, exit code 2."""
    done = grade(submission(), *words)
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith(sentence)
    assert done.err.count("\n") == 1


def test_a_name_that_is_nothing_is_told_before_anything_is_compiled(
    grade: Grade, submission: Write
) -> None:
    """The functions are listed by TP, on a machine that could not compile."""
    done = grade(submission(), "-k", "miniraytracer", CC="no-such-compiler")
    assert done.code == 2
    assert done.err.startswith("Rien ne s'appelle « miniraytracer » ici.")
    assert "\n  TP1  fill_red, fill, horizontal_gradient" in done.err


def test_no_folder_is_wrong_use(grade: Grade, tmp_path: Path) -> None:
    """The sentence comes in the language that is asked for, by MRT_LANG or --lang."""
    folder = tmp_path / "absent"
    assert (
        grade(folder).err
        == f"Le dossier {folder} n'existe pas. Vérifiez le chemin donné à SUBMISSION.\n"
    )
    english = f"There is no folder {folder}. Check the path given as SUBMISSION.\n"
    assert grade(folder, MRT_LANG="en_GB").err == english
    done = grade(folder, "--lang", "en")
    assert (done.code, done.err) == (2, english)


def test_a_machine_without_compiler_is_not_a_zero(grade: Grade, submission: Write) -> None:
    """Exit code 3, and the way to get one."""
    done = grade(submission(), CC="no-such-compiler")
    assert (done.code, done.results) == (3, {})
    assert "Pas de compilateur C (no-such-compiler)" in done.err


def test_a_fault_of_the_grader_is_never_a_zero(
    grade: Grade, submission: Write, tmp_path: Path
) -> None:
    """A worker that cannot start leaves the checks unjudged, the report incomplete, exit code 3."""
    copy = tmp_path / "copie du correcteur"
    shutil.copytree(ROOT / "grader", copy / "grader", ignore=shutil.ignore_patterns("tests"))
    shutil.copytree(ROOT / "core_c", copy / "core_c")
    (copy / "grader" / "worker" / "__main__.py").write_text(
        "raise SystemExit(1)\n", encoding="utf-8"
    )
    done = grade(submission(), root=copy)
    assert (done.code, done.results["incomplete"]) == (3, True)
    assert {each["outcome"] for each in done.results["checks"]} == {"error"}
    assert "Rapport incomplet" in done.out


def test_without_sanitizers_the_grading_goes_on(
    grade: Grade, submission: Write, tmp_path: Path
) -> None:
    """It is said once; guard pages still see a write past the picture."""
    compiler = tmp_path / "cc-without-asan"
    answer = '-print-file-name=*) echo "${1#*=}" ;; *) exec gcc "$@" ;;'
    compiler.write_text(f'#!/bin/sh\ncase "$1" in {answer} esac\n', encoding="utf-8")
    compiler.chmod(0o755)
    folder = submission(fill="for (int k = 0; k < WIDTH * HEIGHT + 99; k++) img[k] = c;")
    # Nobody, as who a sandbox compiles when root asks, cannot read a test's folder.
    done = grade(folder, "--isolation", "portable", CC=str(compiler))
    assert set(full_points()) - set(done.points()) == {
        "fill_color.color",
        "fill_color.every_pixel",
        "fill_color.as_it_is",
    }
    assert done.check("fill_color.every_pixel")["outcome"] == "crashed"
    assert done.out.count("Sans AddressSanitizer") == 1

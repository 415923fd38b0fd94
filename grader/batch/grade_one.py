"""One submission, graded: a function of its task alone, wherever it runs."""

from __future__ import annotations

import contextlib
import ctypes
import errno
import os
import resource
import shutil
import tempfile
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

from grader.batch import fresh_inputs, gallery
from grader.batch.records import GradedFiles, Settings, Task
from grader.build import substitution
from grader.checking import expected_data
from grader.course import exercises
from grader.course.message import UserError
from grader.course.sizes import sizes_for
from grader.course.texts import Texts
from grader.evaluation.pipeline import report_of, run_checks
from grader.evaluation.records import Report
from grader.execution.libraries import Libraries
from grader.files import closed_folder, write_whole
from grader.intake import originals
from grader.intake.records import Submission
from grader.report import page, results
from grader.sandbox import scratch
from grader.sandbox.levels import Level, using

JOBS = 2  # for one submission; others are graded beside it
LEAST_BYTES = 50_000_000  # free on the disk, before and after a submission
_ONE = threading.Lock()  # pytest and the level of isolation are the process's


@dataclass
class BuildFolder:
    """Where builds are made; what a submission leaves there is removed after it."""

    folder: Path
    _kept: set[Path] = field(default_factory=set)

    def warm(self) -> None:
        """Build what every submission needs once: the given files, and the solution's."""
        if self._kept or not originals.has_solution():
            return
        with Libraries(substitution.reference(), sizes_for(None), self.folder) as libraries:
            assert libraries.builds
        self._kept = set(self.folder.rglob("*"))

    def forget(self) -> None:
        """Remove everything of the last submission."""
        for path in sorted(set(self.folder.rglob("*")) - self._kept, reverse=True):
            with contextlib.suppress(OSError):  # a folder that is not empty: it is kept
                path.rmdir() if path.is_dir() and not path.is_symlink() else path.unlink()


@cache
def _own_place() -> BuildFolder:
    """Return a place that lasts as long as the process: on a machine of a cluster."""
    place = BuildFolder(scratch.own_folder() / "builds")
    place.folder.mkdir()
    return place


def grade(task: Task, place: BuildFolder | None = None) -> GradedFiles:
    """Grade a submission. Never raises: what goes wrong is the bundle's `failure`."""
    with _ONE, contextlib.ExitStack() as stack:
        start, cpu = time.monotonic(), cpu_seconds()
        where = place or _own_place()
        if place is None:
            stack.enter_context(scratch.files_in(where.folder.parent))
        try:
            _verify_room(where)
            bundle = _graded(task, where)
            _verify_room(where)
        except UserError as error:
            sentence = error.sentence(Texts(task.settings.language))
            bundle = GradedFiles(task.name, failure=sentence)
        except Exception as error:  # whatever it is, it is the grader's fault, and never a mark
            bundle = GradedFiles(task.name, failure=f"{type(error).__name__}: {error}"[:500])
        finally:
            where.forget()
            _give_back()
        seconds = time.monotonic() - start
        return replace(bundle, seconds=seconds, cpu=cpu_seconds() - cpu)


def _give_back() -> None:
    """Return to the system the memory that is free: pieces of it would add up over a class."""
    with contextlib.suppress(OSError, AttributeError):  # glibc's own
        ctypes.CDLL(None).malloc_trim(0)


def _verify_room(place: BuildFolder) -> None:
    """Raise OSError where the disk is as good as full: the compiler would blame the student."""
    for folder in (place.folder, Path(tempfile.gettempdir())):
        if shutil.disk_usage(folder).free < LEAST_BYTES:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))


def _graded(task: Task, place: BuildFolder) -> GradedFiles:
    rules, settings = exercises.load(), task.settings
    submission = Submission(name=task.label, files=task.files, **task.submission)
    with using(Level(settings.isolation)):
        place.warm()
        with Libraries(submission, sizes_for(None), place.folder, jobs=JOBS) as libraries:
            folder, fresh = _expected(settings), _fresh(settings)
            findings = run_checks(libraries, rules, None, folder=folder, fresh=fresh)
            texts = Texts(settings.language)
            judged = report_of(libraries, rules, findings, texts, settings.hint)
            shown = dict(gallery.pictures(libraries)) if settings.gallery else {}
    return _bundled(task, replace(judged, isolation=settings.isolation), texts, shown)


def _expected(settings: Settings) -> Path:
    return Path(settings.expected) if settings.expected else expected_data.FOLDER


def _fresh(settings: Settings) -> Path | None:
    """Return the folder of inputs that no student has seen: another machine makes its own."""
    if settings.seed < 0:
        return None
    folder = Path(settings.fresh)
    return folder if folder.is_dir() else _made_here(settings.seed)


@cache
def _made_here(seed: int) -> Path:
    folder = scratch.own_folder() / fresh_inputs.FOLDER
    closed_folder(folder)
    fresh_inputs.make(seed, folder / str(seed))
    return folder / str(seed)


def _bundled(task: Task, judged: Report, texts: Texts, shown: Mapping[str, bytes]) -> GradedFiles:
    """Return the files of the student's folder; `shown` are pictures that go there too."""
    content = results.as_json(judged, texts)
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        results.write_images(folder, judged.checks)
        results.write(folder / "results.json", content)
        write_whole(folder / page.NAME, page.render(content, folder))
        paths = sorted(path for path in folder.rglob("*") if path.is_file())
        files = {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}
    return GradedFiles(task.name, {**files, **shown}, incomplete=content["incomplete"])


def cpu_seconds() -> float:
    """Return the CPU seconds of this process and of what it has run and waited for.

    A sandbox counts once its first process is buried: see isolation/orphans.py.
    """
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)

"""OUT, the folder of results: what is known of each submission, and what must be graded.

    students/NAME/      results.json, report.html, images/
    state/NAME.json     what that result depends on, and a summary of it, written last
    inputs/             those that no student has seen, and their seed
    work/               unpacked archives and builds, removed at the end
    batch.json          says that the folder is a batch's, of which class, and the key of pseudonyms

A result counts only when its state agrees with it: whatever the moment at which a batch is killed,
the submission is either done or graded again.
"""

from __future__ import annotations

import base64
import contextlib
import fcntl
import hashlib
import hmac
import json
import os
import secrets
import shutil
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import IO, Any

from grader.batch import alike_list, fresh_inputs
from grader.batch.last_run import is_same
from grader.batch.records import BatchError, GradedFiles, Settings
from grader.course.texts import Texts
from grader.files import closed_folder
from grader.report import again, page
from grader.report.results import Row, laid_out, write

NAME = "batch.json"
SCHEMA = 1
STUDENTS, STATE, WORK = "students", "state", "work"
OWN_FILES = (
    *("grades.csv", "marks.xlsx", "changes.csv", "marks.json", "index.html"),
    *(alike_list.NAME, alike_list.PAGE, NAME),
)
OWN_FOLDERS = (STUDENTS, STATE, WORK, fresh_inputs.FOLDER, "moodle")


@dataclass(frozen=True)
class StoredResult:
    """What is kept of a graded submission: `parts` are the hashes of what its result depends on."""

    parts: Mapping[str, str]
    summary: Row
    seconds: float
    cpu: float
    fresh: bool  # the files are those that were written
    settled: bool = False  # what could not be judged counts as failed


class ResultsFolder:
    """The folder, open for one batch; a context manager. Raises BatchError."""

    def __init__(self, out: Path) -> None:
        self.out = out.absolute()
        self.work = self.out / WORK
        self._lock: IO[str] | None = None
        self._open = False

    def __enter__(self) -> ResultsFolder:
        with self.writing(self.out):
            if self.out.exists() and not is_batch(self.out) and any(self.out.iterdir()):
                raise BatchError("batch.not_ours", path=self.out)
            self.out.mkdir(parents=True, exist_ok=True)
            lock = (self.out / f".{NAME}.lock").open("w")
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                lock.close()
                raise BatchError("batch.busy", path=self.out) from error
            self._lock = lock
            content = _content(self.out)
            write(self.out / NAME, {**content, "key": content["key"] or secrets.token_hex(16)})
            shutil.rmtree(self.work, ignore_errors=True)  # of a batch that was killed
            for name in (STUDENTS, STATE, WORK):
                (self.out / name).mkdir(exist_ok=True)
            closed_folder(self.work)  # submissions, and what is built of them and of the solution
        self._open = True
        return self

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self.work, ignore_errors=True)
        if self._lock:
            self._lock.close()

    @contextlib.contextmanager
    def writing(self, path: Path) -> Iterator[None]:
        """Turn what goes wrong while writing into a sentence."""
        try:
            yield
        except OSError as error:
            if self._open:
                self.verify()
            place = error.filename or path
            raise BatchError("batch.cannot_write", path=place, error=error.strerror) from error

    def verify(self) -> None:
        """Raise BatchError when the folder is not there any more."""
        if not (self.out / NAME).is_file():
            raise BatchError("batch.gone", path=self.out)

    def claim(self, people: Sequence[Mapping[str, str]]) -> None:
        """Note which class the folder is for. Raises BatchError when it is another one's."""
        content = _content(self.out)
        before = content["people"]
        common = sum(any(is_same(one, other) for other in people) for one in before)
        if 2 * common < min(len(before), len(people)):
            raise BatchError("batch.other_class", path=self.out, name=before[0]["name"])
        with self.writing(self.out / NAME):
            write(self.out / NAME, {**content, "people": list(people)})

    def pseudonyms(self, names: Iterable[str]) -> dict[str, str]:
        """Return a name that says nothing for each submission, the same from run to run.

        It comes of a key that is drawn once: neither the order nor the name can be read from it.
        """
        key = bytes.fromhex(_content(self.out)["key"])
        found: dict[str, str] = {}
        for name in sorted(set(names)):
            digest = hmac.new(key, name.encode(), hashlib.sha256).digest()
            text = base64.b32encode(digest).decode()
            length = next(k for k in range(4, len(text)) if text[:k] not in found.values())
            found[name] = text[:length]
        return found

    def folder(self, name: str) -> Path:
        """Return the folder of a student."""
        return self.out / STUDENTS / name

    def known(self, name: str) -> StoredResult | None:
        """Return what is kept of a submission; None when it was never graded, or cannot be read."""
        try:
            state = json.loads(self._state(name).read_text(encoding="utf-8"))
            summary = _shared(state["summary"])
            done = hashlib.sha256((self.folder(name) / "results.json").read_bytes()).hexdigest()
            fresh = done == state["results"] and (self.folder(name) / "report.html").is_file()
            used = state["seconds"], state["cpu"]
            return StoredResult(state["parts"], summary, *used, fresh, state["settled"])
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return None

    def save(
        self, bundle: GradedFiles, parts: Mapping[str, str], settled: bool = False
    ) -> StoredResult:
        """Write a student's folder, then its state. Raises BatchError.

        What could not be judged is not kept, unless it is `settled`: it is tried again.
        """
        self.verify()
        content = bundle.files["results.json"]
        summary = _shared(summarised(json.loads(content)))
        with self.writing(self.folder(bundle.name)):
            part = Path(tempfile.mkdtemp(dir=self.work))
            for name, data in bundle.files.items():
                (part / name).parent.mkdir(exist_ok=True)
                (part / name).write_bytes(data)
            part.chmod(0o755)
            self._replace(part, self.folder(bundle.name))
            state = {
                "parts": dict(parts),
                "results": hashlib.sha256(content).hexdigest(),
                "summary": summary,
                "seconds": round(bundle.seconds, 3),
                "cpu": round(bundle.cpu, 3),
                "settled": settled,
            }
            if settled or not bundle.incomplete:
                write(self._state(bundle.name), state)
        return StoredResult(parts, summary, bundle.seconds, bundle.cpu, True, settled)

    def tell_again(
        self, name: str, known: StoredResult, parts: Mapping[str, str], settings: Settings
    ) -> StoredResult:
        """Write a result that is kept in today's words: nothing is graded. Raises BatchError."""
        folder = self.folder(name)
        with self.writing(folder):
            content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
            told = again.told(content, Texts(settings.language), settings.hint)
            paths = [path for path in folder.rglob("*") if path.is_file()]
            files = {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}
            files["results.json"] = laid_out(told).encode(errors="replace")
            files[page.NAME] = page.render(told, folder).encode(errors="replace")
        bundle = GradedFiles(name, files, known.seconds, known.cpu, incomplete=told["incomplete"])
        return self.save(bundle, parts, known.settled)

    def _replace(self, part: Path, place: Path) -> None:
        if place.exists():
            old = Path(tempfile.mkdtemp(dir=self.work)) / "old"
            os.replace(place, old)
        os.replace(part, place)

    def forget_others(self, names: set[str]) -> None:
        """Remove the results of submissions that are not there any more."""
        with self.writing(self.out):
            for place in (self.out / STUDENTS).iterdir():
                if place.name not in names:
                    shutil.rmtree(place)
            for place in (self.out / STATE).iterdir():
                if place.stem not in names:
                    place.unlink()

    def _state(self, name: str) -> Path:
        return self.out / STATE / f"{name}.json"


def _content(out: Path) -> dict[str, Any]:
    """Return what batch.json says; of a new folder nothing."""
    empty: dict[str, Any] = {"schema": SCHEMA, "key": "", "people": []}
    if not is_batch(out):
        return empty
    content = json.loads((out / NAME).read_text(encoding="utf-8"))
    known = isinstance(content.get("key"), str) and isinstance(content.get("people"), list)
    return {**empty, **content} if known else empty


def is_batch(out: Path) -> bool:
    """Say whether a folder is one of results."""
    try:
        content = json.loads((out / NAME).read_text(encoding="utf-8"))
        return bool(content["schema"] == SCHEMA)
    except (OSError, ValueError, KeyError, TypeError):
        return False


def summarised(content: Row) -> dict[str, Any]:
    """Return what marks and the class page need of results.json: little, since classes are big."""
    kept = ("score", "max_score", "bonus", "max_bonus", "incomplete", "tps", "learnt")
    return {
        **{key: content[key] for key in kept},
        "compiles": content["build"]["ok"],
        "rejected": sorted(content["build"]["rejected"]),
        "exercises": {
            each["id"]: [each["outcome"], each["points"], each["max_points"]]
            for each in content["exercises"]
        },
        "checks": {each["id"]: each["outcome"] for each in content["checks"]},
        "mistakes": sorted({name for each in content["checks"] for name in each["mistakes"]}),
    }


def _shared(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return a summary whose texts and rows are kept once for all: most are everybody's."""
    checks, exercises = summary["checks"], summary["exercises"]
    return {
        **summary,
        "rejected": [sys.intern(name) for name in summary["rejected"]],
        "checks": {sys.intern(key): sys.intern(value) for key, value in checks.items()},
        "exercises": {sys.intern(key): _row(*value) for key, value in exercises.items()},
    }


@lru_cache(maxsize=None, typed=True)
def _row(*values: object) -> tuple[object, ...]:
    return values

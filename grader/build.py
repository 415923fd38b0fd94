"""From the C files of a submission to shared libraries.

A submission's own files are copied, with our given files, into a clean folder of the cache; each
file is compiled for each target, as many at once as there are cores; the objects and the shim are
linked. A file that does not compile gives way to the skeleton's, so that the others are judged.

    results = build(read_submission(Path("core_c")), [Target(320, 180)], Path("build/cache"))
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Container, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path

from grader import course, manifest, originals, toolchain
from grader.job import LANGUAGES, BuildError, Job, Object, key_of
from grader.records import BuildResult, Submission, Target
from grader.toolchain import Compiler

__all__ = ["BuildError", "build"]

_CHANGED = re.compile("error: conflicting types for")


def build(
    submission: Submission, targets: Sequence[Target], cache: Path, compiler: Compiler | None = None
) -> list[BuildResult]:
    """Build the submission for each target, in parallel; the results stand in the targets' order.

    A file that does not compile is left out, the skeleton's standing in, until the rest does.
    Raises BuildError (or another error of Told, or a BindError) when the machine is at fault.
    """
    compiler = compiler or toolchain.find_compiler()
    kept = dict(submission.files)
    rejected: dict[str, str] = {}
    try:
        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            while True:
                sources = _clean_folder(kept, submission.in_place, cache)
                jobs = [Job(sources, target, compiler, cache) for target in targets]
                shims = [pool.submit(job.bind) for job in jobs]
                objects = _compile_all(jobs, kept, pool)
                wrong = _to_leave_out(jobs, objects, kept)
                if not wrong:
                    break
                rejected |= wrong
                kept = {name: kept[name] for name in kept if name not in wrong}
            return [
                job.link(objects[job], *shim.result(), rejected)
                for job, shim in zip(jobs, shims, strict=True)
            ]
    except OSError as error:
        raise BuildError(
            "machine.cannot_write", path=error.filename or cache, error=error.strerror
        ) from error


def _compile_all(
    jobs: Sequence[Job], own: Container[str], pool: Executor
) -> dict[Job, dict[str, Object]]:
    """Compile every file of every job; those of the submission as C++ where C does not do.

    When the files that are not C are all C++, the others are built as C++ too wherever they can:
    functions that they share have other names there.
    """
    names = jobs[0].units()
    ours = [name for name in names if name not in own]
    theirs = [name for name in names if name in own]
    first, second = LANGUAGES if course.load().dialect == "c" else LANGUAGES[::-1]
    done = _compiled(jobs, ours, "c", pool)
    tried = _compiled(jobs, theirs, first, pool)
    broken = [key for key, each in tried.items() if each.errors]
    # In C++ a changed signature would be another function of the same name.
    if broken and not any(_CHANGED.search(tried[key].errors) for key in broken):
        # The broken ones alone first: most often they are no C++ either.
        names_of = list(dict.fromkeys(name for _, name in broken))
        other = _compiled(jobs, names_of, second, pool)
        if not any(each.errors for each in other.values()):
            other = _compiled(jobs, theirs, second, pool)
            tried |= {key: each for key, each in other.items() if not each.errors}
    done |= tried
    return {job: {name: done[job, name] for name in names} for job in jobs}


def _compiled(
    jobs: Sequence[Job], names: Sequence[str], language: str, pool: Executor
) -> dict[tuple[Job, str], Object]:
    keys = [(job, name) for job in jobs for name in names]
    return dict(
        zip(keys, pool.map(lambda key: key[0].compile(key[1], language), keys), strict=True)
    )


def _to_leave_out(
    jobs: Sequence[Job], objects: Mapping[Job, Mapping[str, Object]], kept: Mapping[str, bytes]
) -> dict[str, str]:
    """Return the submission's files that keep the rest from compiling, with what is said of them.

    A header of the submission's own comes first: it may be all that is wrong with the others.
    Raises BuildError when a given file is in error.
    """
    broken = {
        name: each.errors for job in jobs for name, each in objects[job].items() if each.errors
    }
    for name in manifest.load().given:
        if name in broken:
            raise BuildError("machine.given_broken", name=name, log=broken[name])
    headers = {name: _alone(jobs[0], name) for name in kept if broken and name.endswith(".h")}
    headers = {name: errors for name, errors in headers.items() if errors}
    files = {name: errors for name, errors in broken.items() if name in kept}
    # The skeleton's own files fail with a header that compiles by itself, at worst.
    return headers or files or {name: "".join(broken.values()) for name in kept if broken}


def _alone(job: Job, header: str) -> str:
    """Return the errors of a header by itself, "" when it compiles in one language at least."""
    tried = [job.compile(header, language).errors for language in LANGUAGES]
    return tried[0] if all(tried) else ""


def _clean_folder(files: Mapping[str, bytes], in_place: bool, cache: Path) -> Path:
    """Lay the submission's files and what was handed out side by side; return the folder."""
    files = {**originals.read(in_place), **files}
    folder = cache / "sources" / key_of(sorted(files.items()))
    if not folder.is_dir():
        folder.parent.mkdir(parents=True, exist_ok=True)
        part = Path(tempfile.mkdtemp(dir=folder.parent))
        part.chmod(0o755)
        for name, content in files.items():
            (part / name).write_bytes(content)
        try:
            part.rename(folder)
        except OSError:
            # Another run was quicker: its folder has the same content.
            shutil.rmtree(part)
            if not folder.is_dir():
                raise
    return folder

"""The end of `grade`: the checks of a submission that is being built, its results and their page.

A module of its own, which the command line imports once the compiler runs: numpy, pytest and the
page's templates take as long to load as a file takes to compile.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from typing import Any

from grader.build.compiler_run import BuildError
from grader.commands import sketch
from grader.course.exercises import EXPECTED, Manifest
from grader.course.texts import Texts
from grader.evaluation.pipeline import report_of, run_checks
from grader.evaluation.records import Report
from grader.execution.libraries import Libraries
from grader.files import write_whole
from grader.intake import originals
from grader.report import at_lines, brief, history, junit, page, results, terminal
from grader.sandbox.levels import Isolation


def grade(
    libraries: Libraries,
    rules: Manifest,
    chosen: Collection[str],
    options: argparse.Namespace,
    isolation: Isolation,
    texts: Texts,
) -> dict[str, Any]:
    """Judge, write the results and show them; return the content of results.json.

    Raises what run_checks does, and BuildError.
    """
    findings = run_checks(libraries, rules, options.tp, chosen, options.expected)
    partial = options.tp is not None or bool(options.keyword)
    judged = report_of(libraries, rules, findings, texts, options.hint, partial)
    content = results.as_json(replace(judged, isolation=isolation.level.value), texts)
    if options.brief:
        terminal.put(brief.lines(content, texts))
    else:
        _tell(content, judged, options, texts)
    if options.sketch:
        sketch.show(libraries)
    return content


def _tell(
    content: dict[str, Any], judged: Report, options: argparse.Namespace, texts: Texts
) -> None:
    """Write the results, and show them."""
    folder = options.build / "grade" / ("partial" if content["partial"] else "")
    terminal.show(content, _write(folder, content, judged), texts)
    if originals.has_solution() and options.expected == EXPECTED and not content["partial"]:
        sys.stdout.write(f"{texts.say('batch.on_public')}\n")
    if options.annotate:
        terminal.list_lines(at_lines.lines(content, options.annotate))


def _write(folder: Path, content: dict[str, Any], judged: Report) -> Path:
    """Write the results; return the path of the page."""
    path = folder / "results.json"
    try:
        history.update(folder, content)
        results.write_images(folder, judged.checks)
        results.write(path, content)
        write_whole(folder / "junit.xml", junit.as_xml(content))
        write_whole(folder / page.NAME, page.render(content, folder))
    except OSError as error:
        raise BuildError("machine.cannot_write", path=path, error=error.strerror) from error
    return folder / page.NAME

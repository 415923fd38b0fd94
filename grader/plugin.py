"""The pytest plugin that turns the tests of `checks/` into findings.

pytest finds, selects and runs the tests; what became of each is read from its exception.
"""

from __future__ import annotations

import contextlib
import io
import os
import time
from collections.abc import Generator
from pathlib import Path

import pytest

from grader import course, deaths
from grader.diagnosis import named
from grader.expected import FOLDER, ExpectedError
from grader.grading import conclude
from grader.judge import Fatal, Student, Wrong
from grader.manifest import PACKAGE, Manifest
from grader.process import Died, Missing
from grader.records import Cause, Death, Evidence, Finding, Outcome, Verdict
from grader.retrial import retried
from grader.texts import Texts
from grader.workshop import NotBuilt, Workshop

CHECKS = PACKAGE / "checks"
MAX_OUTPUT = 1000  # characters of what a check's code printed that go into the report
_PRINTING = (Outcome.FAILED, Outcome.TIMEOUT, Outcome.CRASHED)
_STUDENT = pytest.StashKey[Student]()


class SelectionError(Exception):
    """The keyword cannot be read (`malformed`), or no check matches it."""

    def __init__(self, malformed: bool) -> None:
        super().__init__(malformed)
        self.malformed = malformed


class PytestError(Exception):
    """pytest itself failed: the grader's fault."""


def run_checks(
    workshop: Workshop,
    rules: Manifest,
    tp: int | None,
    keyword: str,
    folder: Path = FOLDER,
) -> list[Finding]:
    """Run the checks of a TP (None: of those that count) whose names match pytest's expression.

    `folder` is that of the expected data. Raises SelectionError, PytestError.
    """
    # Neither a plugin that happens to be installed nor the project's own settings have a say here.
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    plugin = GraderPlugin(workshop, rules, tp, folder)
    arguments = ["-c", os.devnull, "--rootdir", str(CHECKS), "--strict-markers", "-W", "ignore"]
    arguments += ["-p", "no:terminal", "-p", "no:cacheprovider", "--import-mode=importlib"]
    arguments += ["-k", keyword] if keyword else []
    with contextlib.redirect_stderr(io.StringIO()) as said:
        status = pytest.main([*arguments, str(CHECKS)], plugins=[plugin])
    if status == pytest.ExitCode.USAGE_ERROR:
        raise SelectionError(malformed=True)
    if status == pytest.ExitCode.INTERRUPTED and not plugin.failure:
        raise KeyboardInterrupt
    if plugin.failure or status == pytest.ExitCode.INTERNAL_ERROR:
        raise PytestError(plugin.failure or f"pytest ended with {status}: {said.getvalue()}")
    if keyword and not plugin.findings:
        raise SelectionError(malformed=False)
    findings = retried(plugin.findings, rules, workshop, folder, plugin.again)
    try:
        return named(findings, rules, folder)
    except ExpectedError as error:
        raise PytestError(str(error)) from error


class GraderPlugin:
    """Hooks of one run."""

    def __init__(
        self,
        workshop: Workshop,
        rules: Manifest,
        tp: int | None,
        folder: Path,
        texts: Texts | None = None,
    ) -> None:
        self.findings: list[Finding] = []
        self.failure = ""
        self._workshop, self._rules, self._tp = workshop, rules, tp
        self._folder = folder
        self._texts = texts  # in which pytest's own report tells what is wrong
        self._items: dict[str, pytest.Function] = {}

    def pytest_configure(self, config: pytest.Config) -> None:
        """Declare the marker that ties a test to its check."""
        # What became of a test is read from its exception: its traceback would take seconds.
        config.option.tbstyle = "no"
        config.addinivalue_line("markers", "check(id): the check of exercises.toml that a test is")

    @pytest.hookimpl(wrapper=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> Generator[None]:
        """Keep what is asked for, and the twins without which it could earn nothing.

        Pictures come last: what loops is known by then.
        """
        everything = list(items)
        yield
        checks = self._rules.checks()
        wanted = {_check_id(item) for item in items}
        wanted |= {checks[each].twin for each in wanted}
        items[:] = [
            item
            for item in sorted(
                everything, key=lambda each: _check_id(each).split(".")[1] == "scene"
            )
            if _check_id(item) in wanted
            and self._is_asked(self._rules.exercise(checks[_check_id(item)].exercise).tp)
        ]
        self._items = {_check_id(each): each for each in items if isinstance(each, pytest.Function)}

    def _is_asked(self, tp: int) -> bool:
        return course.load().is_counted(tp) if self._tp is None else tp == self._tp

    @pytest.fixture
    def student(self, request: pytest.FixtureRequest) -> Student:
        """Return the submission under judgement, for one check."""
        check = self._rules.checks()[_check_id(request.node)]
        exercise = self._rules.exercise(check.exercise)
        student = self._workshop.student(exercise.file, self._folder, exercise.functions)
        request.node.stash[_STUDENT] = student
        return student

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Note what became of a test."""
        report = yield
        if call.when == "call" or (call.when == "setup" and call.excinfo is not None):
            error = call.excinfo.value if call.excinfo else None
            self.findings.append(_finding(item, error, call.duration))
            if report.failed and self._texts:
                report.longrepr = self._told(self.findings[-1])
        return report

    def again(self, check: str, student: Student) -> Finding:
        """Run a check again, on another build of the submission."""
        item = self._items[check]
        item.stash[_STUDENT] = student
        error: Exception | None = None
        start = time.perf_counter()
        try:
            item.obj(student)
        except Exception as raised:  # as with pytest, whatever it is becomes the finding
            error = raised
        return _finding(item, error, time.perf_counter() - start)

    def _told(self, finding: Finding) -> str:
        """Return the sentence and the question that the student's report would have."""
        assert self._texts is not None
        ((result,), _) = conclude([finding], self._rules, self._texts)
        lines = (result.note, result.message, result.hint)
        return "\n".join([f"{result.function}: {result.outcome.value}", *filter(None, lines)])

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Note that a file of checks cannot be read."""
        if report.failed:
            self.failure = report.longreprtext

    def pytest_internalerror(self, excrepr: object) -> None:
        """Note that pytest has failed."""
        self.failure = str(excrepr)


def _check_id(item: pytest.Item) -> str:
    marker = item.get_closest_marker("check")
    if marker is None:
        raise PytestError(f"{item.nodeid} has no check marker")
    return str(marker.args[0])


def _finding(item: pytest.Item, error: BaseException | None, seconds: float) -> Finding:
    student = item.stash.get(_STUDENT, None)
    outcome, verdict, location = _outcome(error)
    document = getattr(getattr(item, "function", None), "__doc__", None) or item.name
    return Finding(
        check=_check_id(item),
        title=document.strip().splitlines()[0],
        outcome=outcome,
        verdict=verdict,
        location=location,
        todo=student.todo if student else frozenset(),
        output=student.output[:MAX_OUTPUT] if student and outcome in _PRINTING else "",
        seconds=seconds,
        evidence=error.evidence if isinstance(error, (Wrong, Fatal)) else Evidence(),
        remarks=tuple(student.remarks) if student else (),
        testimony=student.testimony.parts if student else {},
    )


def _outcome(error: BaseException | None) -> tuple[Outcome, Verdict | None, str]:
    """Say what a check's exception means; whatever is not known is the grader's own fault."""
    if error is None:
        return Outcome.PASSED, None, ""
    if isinstance(error, Wrong):
        return Outcome.FAILED, error.verdict, ""
    if isinstance(error, Fatal):
        return _death(error.death, error.call)
    if isinstance(error, Died):  # before any call: while loading
        return _death(error.death, "")
    if isinstance(error, Missing):
        return Outcome.FAILED, Verdict("failure.missing", {"name": error.name}), ""
    if isinstance(error, NotBuilt):
        return Outcome.FAILED, error.verdict, ""
    detail = f"{type(error).__name__}: {error}".splitlines()[0][:300]
    return Outcome.ERROR, Verdict("failure.error", {"detail": detail}), ""


def _death(death: Death, call: str) -> tuple[Outcome, Verdict, str]:
    outcome = Outcome.TIMEOUT if death.cause is Cause.TIMEOUT else Outcome.CRASHED
    return outcome, deaths.verdict(death, call), death.location

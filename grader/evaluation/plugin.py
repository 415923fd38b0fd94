"""The pytest plugin that turns the tests of `checks/` into findings.

pytest finds, selects and runs the tests; what became of each is read from its exception.
"""

from __future__ import annotations

import contextlib
import io
import os
import time
from collections.abc import Collection, Generator
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from grader.checking.expected_data import FOLDER
from grader.checking.records import Evidence
from grader.checking.student import SIZES, CallDied, Student, Wrong
from grader.course import exercises, settings
from grader.course.exercises import PACKAGE, Manifest
from grader.course.message import Message
from grader.course.texts import Texts, preferred
from grader.evaluation.attempts import Attempts
from grader.evaluation.grading import grade
from grader.evaluation.outcomes import outcome_of, remarks_on, told_with_acts
from grader.evaluation.prefetch import Prefetch, RunResult
from grader.evaluation.records import Finding, Outcome, PytestError
from grader.evaluation.rules import DONE_WRONG
from grader.execution.libraries import Libraries
from grader.intake.submission import read_submission

CHECKS = PACKAGE / "checks"
MAX_OUTPUT = 1000  # characters of what a check's code printed that go into the report
# Parts of pytest that would only take time here: they look after tests that print, warn, assert.
_UNUSED = (
    *("assertion", "cacheprovider", "capture", "doctest", "faulthandler", "junitxml", "logging"),
    *("pastebin", "recwarn", "setuponly", "setupplan", "stepwise", "subtests", "terminal"),
    *("threadexception", "tmpdir", "unittest", "unraisableexception"),
)
_PRINTING = (Outcome.FAILED, Outcome.TIMEOUT, Outcome.CRASHED)
_STUDENT = pytest.StashKey[Student]()
_CHECK = pytest.StashKey[str]()
_UNSEEN = pytest.StashKey[bool]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options of `pytest grader/checks`, a run without the command line."""
    group = parser.getgroup("grader")
    group.addoption("--submission", type=Path, default=exercises.CORE, metavar="PATH")
    group.addoption("--expected", type=Path, default=FOLDER, metavar="DIR")


def pytest_configure(config: pytest.Config) -> None:
    """Build the submission and hand it to the checks, unless the command line has done so."""
    if any(isinstance(each, GraderPlugin) for each in config.pluginmanager.get_plugins()):
        return
    submission = read_submission(config.getoption("submission"))
    libraries = Libraries(submission, SIZES, exercises.ROOT / "build" / "cache")
    config.add_cleanup(libraries.close)
    folder = config.getoption("expected")
    plugin = GraderPlugin(libraries, exercises.load(), None, folder, Texts(preferred()))
    config.pluginmanager.register(plugin, "grader")


def run(plugin: GraderPlugin) -> list[Finding]:
    """Run the checks that a plugin chooses, under pytest. Raises PytestError."""
    # Neither a plugin that happens to be installed nor the project's own settings have a say here.
    for name in [each for each in os.environ if each.startswith("PYTEST_")]:
        del os.environ[name]
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    arguments = ["-c", os.devnull, "--rootdir", str(CHECKS), "--confcutdir", str(CHECKS)]
    arguments += ["--strict-markers", "-W", "ignore", "--import-mode=importlib"]
    arguments += [f"-pno:{name}" for name in _UNUSED]
    with contextlib.redirect_stderr(io.StringIO()) as said, contextlib.closing(plugin.ahead):
        status = pytest.main([*arguments, str(CHECKS)], plugins=[plugin])
    if status == pytest.ExitCode.INTERRUPTED and not plugin.failure:
        raise KeyboardInterrupt
    failed = (pytest.ExitCode.INTERNAL_ERROR, pytest.ExitCode.USAGE_ERROR)
    if plugin.failure or status in failed:
        raise PytestError(plugin.failure or f"pytest ended with {status}: {said.getvalue()}")
    return plugin.findings


class GraderPlugin:
    """Hooks of one run."""

    def __init__(
        self,
        libraries: Libraries,
        rules: Manifest,
        tp: int | None,
        folder: Path,
        texts: Texts | None = None,
        chosen: Collection[str] | None = None,
        fresh: Path | None = None,
    ) -> None:
        self.findings: list[Finding] = []
        self.failure = ""
        self._libraries, self._rules, self._tp = libraries, rules, tp
        self._folder, self._chosen = folder, chosen
        self._texts = texts  # in which pytest's own report tells what is wrong
        self._items: dict[str, pytest.Function] = {}
        self.ahead = Prefetch(rules, self._run_ahead, libraries.jobs - 1)
        self._attempts = Attempts(fresh)

    def pytest_configure(self, config: pytest.Config) -> None:
        """Declare the marker that ties a test to its check."""
        # What became of a test is read from its exception: its traceback would take seconds.
        config.option.tbstyle = "no"
        config.addinivalue_line("markers", "check(id, counts=False): its check in exercises.toml")

    @pytest.hookimpl(wrapper=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> Generator[None]:
        """Keep what is asked for, and the twins without which it could earn nothing."""
        everything = list(items)
        yield
        checks = self._rules.checks()
        wanted = {name for item in items if self._is_chosen(name := _check_id(item))}
        wanted |= {checks[each].twin for each in wanted}
        self._items = {
            _check_id(item): item
            for item in everything
            if isinstance(item, pytest.Function)
            and _check_id(item) in wanted
            and self._is_asked(self._rules.exercise(checks[_check_id(item)].exercise).tp)
        }
        counting = {checks[name].exercise for name in filter(self._counts, self._items)}
        pictures = any(checks[name].is_picture for name in self._items)
        if counting or pictures:
            self._libraries.prepare_plain(pictures)
        for exercise in counting:
            self._libraries.prepare_counted(self._rules.exercise(exercise).file)
        in_order = [name for name in checks if name in self._items]
        items[:] = [self._items[name] for name in self.ahead.order(in_order)]

    def _is_chosen(self, check: str) -> bool:
        return self._chosen is None or check in self._chosen

    def _is_asked(self, tp: int) -> bool:
        return settings.load().is_counted(tp) if self._tp is None else tp == self._tp

    @pytest.fixture
    def student(self, request: pytest.FixtureRequest) -> Student:
        """Return the submission under judgement, for one check."""
        self.ahead.result(_check_id(request.node))
        return self._student(request.node)

    def _student(self, item: pytest.Item) -> Student:
        """Return the submission that an item judges; another in each run."""
        if (known := item.stash.get(_STUDENT, None)) is not None:
            return known
        exercise = self._rules.exercise(self._rules.checks()[_check_id(item)].exercise)
        library_set = self._libraries.lend(exercise.file, exercise.functions)
        student = Student(library_set, self._folder, exercise.functions)
        item.stash[_STUDENT] = student
        return student

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> pytest.TestReport:
        """Note what became of a test. Its traceback, which nobody reads, is not made."""
        assert call.when != "collect"  # which makes another kind of report
        told = ""
        if call.when == "call" or (call.when == "setup" and call.excinfo is not None):
            error = call.excinfo.value if call.excinfo else None
            ran = self.ahead.result(_check_id(item))
            finding = _finding(item, error, ran.seconds if ran else call.duration)
            self.findings.append(finding)
            self.ahead.heard(finding.check, finding.outcome)
            if error and self._texts:
                told = self._told(finding)
        return pytest.TestReport(
            nodeid=item.nodeid,
            location=item.location,
            keywords={},
            outcome="failed" if call.excinfo else "passed",
            longrepr=told or None,
            when=call.when,
            duration=call.duration,
        )

    def _counts(self, check: str) -> bool:
        """Say whether a check counts how often objects are tested."""
        marker = self._items[check].get_closest_marker("check")
        return marker is not None and bool(marker.kwargs.get("counts"))

    def again(self, check: str, student: Student) -> Finding:
        """Run a check again, on another build of the submission."""
        item = self._items[check]
        item.stash[_STUDENT] = student
        start = time.perf_counter()
        return _finding(item, self._raised(item), time.perf_counter() - start)

    @pytest.hookimpl(tryfirst=True)
    def pytest_pyfunc_call(self, pyfuncitem: pytest.Function) -> bool:
        """Run a check, unless that was done ahead."""
        ran = self.ahead.result(_check_id(pyfuncitem))
        if error := ran.error if ran else self._raised(pyfuncitem):
            raise error
        return True

    def _run_ahead(self, check: str) -> RunResult:
        """Run a check; for another thread."""
        start = time.perf_counter()
        try:
            self._student(self._items[check])
            error = self._raised(self._items[check])
        except Exception as raised:  # it is met again in the check's turn
            error = raised
        return RunResult(error, time.perf_counter() - start)

    def _raised(self, item: pytest.Function) -> Exception | None:
        """Run a check; return what it raises."""
        act = partial(item.obj, **item.callspec.params) if hasattr(item, "callspec") else item.obj
        made = self._attempts.made(act, item.stash[_STUDENT])
        item.stash[_STUDENT], item.stash[_UNSEEN] = made.student, made.unseen
        return made.error

    def _told(self, finding: Finding) -> str:
        """Return the sentence and the question that the student's report would have."""
        assert self._texts is not None
        ((result,), _) = grade([finding], self._rules, self._texts)
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
    if _CHECK not in item.stash:
        marker = item.get_closest_marker("check")
        if marker is None:
            raise PytestError(f"{item.nodeid} has no check marker")
        item.stash[_CHECK] = str(marker.args[0])
    return item.stash[_CHECK]


def _finding(item: pytest.Item, error: BaseException | None, seconds: float) -> Finding:
    student = item.stash.get(_STUDENT, None)
    outcome, message, location = outcome_of(error)
    acts = student.acts if student else []
    evidence = error.evidence if isinstance(error, (Wrong, CallDied)) else Evidence()
    told, location = told_with_acts(outcome, message, location, acts)
    if told is not None and told is not message and not told.then:
        evidence = replace(evidence, spots=())  # the worst pixel has nothing to add
    remarks = (*student.remarks, *remarks_on(acts)) if student else ()
    unseen = item.stash.get(_UNSEEN, False)
    if unseen and outcome in DONE_WRONG:
        remarks = (*remarks, Message("note.other_inputs"))
    document = getattr(getattr(item, "function", None), "__doc__", None) or item.name
    return Finding(
        check=_check_id(item),
        title=document.strip().splitlines()[0],
        outcome=outcome,
        message=told,
        location=location,
        todo=student.todo if student else frozenset(),
        output=student.output[:MAX_OUTPUT] if student and outcome in _PRINTING else "",
        seconds=seconds,
        evidence=evidence,
        remarks=remarks,
        unseen=unseen,
        pictures=tuple(student.observations.pictures) if student else (),
        candidates=tuple(student.observations.candidates) if student else (),
        observations=student.observations.parts if student else {},
    )

"""What the checks are written with: calling the student's functions, and comparing in the parent.

A check gets a `Student`, runs cases in its sessions, and raises `Wrong` when an answer is not
right. TP1's checks draw on a `Canvas`, case by case from the simplest on; those of TP2 to TP5 put
stored inputs to a function, all in one message (`Student.trials`), or do more on a `Bench`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from grader.checking import expected_data, reproducer
from grader.checking.bench import UNIT_LIMITS, Bench, without_answers
from grader.checking.canvas import Canvas
from grader.checking.comparison import Answers, Wrong
from grader.checking.expected_data import Array, Batch
from grader.checking.observations import Observations
from grader.checking.records import Evidence
from grader.checking.shapes import Image, Size
from grader.course import exercises, sizes
from grader.course.message import Message
from grader.execution import death_messages
from grader.execution.library_set import LibrarySet
from grader.execution.loops import LOOPS, Loop
from grader.execution.records import OUT_OF_TIME, Act, Death
from grader.execution.session import Died, Library, Limits, Session

__all__ = ["Answers", "Bench", "CallDied", "Student", "Wrong", "without_answers"]

T = TypeVar("T")
Begin = Callable[[Session, Library], None]
Start = Callable[[Limits], contextlib.AbstractContextManager[Session]]

SIZES = sizes.DRAWN
PICTURE_SIZE = sizes.PICTURE
PICTURE_LIMITS = Limits(cpu=10.0)
SMOOTH_LIMITS = Limits(cpu=20.0)  # many rays a pixel: on a busy machine, built with -O0
_LOADING = ""  # in the place of a function's name


class CallDied(Exception):
    """The student's code did not come back from a call; `evidence` holds it as a program.

    `location` is the line to look at, "file:line" or "".
    """

    def __init__(self, death: Death, call: str, evidence: Evidence, location: str) -> None:
        super().__init__(call)
        self.death, self.call, self.evidence, self.location = death, call, evidence, location


class Student:
    """The submission, as one check sees it: sessions by picture size, and what they left behind."""

    def __init__(
        self,
        libraries: LibrarySet,
        folder: Path = expected_data.FOLDER,
        own: Collection[str] = (),
        is_lent: bool = False,
    ) -> None:
        """`is_lent`: its processes may have served other checks, and are renewed."""
        self._libraries = libraries
        self._own = own  # functions that the check is about
        self._is_lent = is_lent
        self.folder = folder  # of the expected data
        self.has_inputs = False  # whether it was judged on stored calls or pictures
        self.todo: frozenset[str] = frozenset()
        self.output = ""  # what was printed in the first session that printed something
        self.remarks: list[Message] = []  # what to tell besides, whatever the outcome
        self.acts: list[Act] = []  # what isolation may refuse, in the first session that tried it
        self.observations = Observations()  # what was wrong in the answers

    def anew(self) -> Student:
        """Return the submission for the same check, as if that had not begun."""
        return self.with_inputs(self.folder)

    def with_inputs(self, folder: Path) -> Student:
        """Return the submission for the same check, on another folder of expected data."""
        return Student(self._libraries, folder, self._own)

    def lent(self) -> Student | None:
        """Return the submission for the same check, in processes that serve several.

        None for one in which functions of the reference stand: what is judged so has failed before.
        """
        if self._libraries.is_mixed:
            return None
        return Student(self._libraries, self.folder, self._own, is_lent=True)

    @property
    def own(self) -> tuple[str, ...]:
        """The functions that the check is about."""
        return (*self._own,)

    @property
    def is_begun(self) -> bool:
        """Whether the marker of the exercise that the check is about has not been met."""
        rules = exercises.load()
        return all(rules.exercise(each).functions != (*self._own,) for each in self.todo)

    @property
    def is_told(self) -> bool:
        """Whether what is wrong is for the student: not where it is seen again, nor of a stub."""
        return not self._is_lent and self.is_begun

    @property
    def meets_stubs(self) -> bool:
        """Whether markers were met, of functions in whose place no other stands."""
        return bool(self.todo) and not self._libraries.is_mixed

    @contextlib.contextmanager
    def unnoted(self) -> Iterator[None]:
        """Note nothing of what is wrong inside: it is asked for another reason."""
        noted, self.observations = self.observations, Observations()
        try:
            yield
        finally:
            self.observations = noted

    @contextlib.contextmanager
    def canvas(self, size: Size) -> Iterator[Canvas]:
        """Start a session in which pictures of that size are drawn."""
        with self._session(size) as session:
            yield Canvas(self.guard, self.observations, session, size)

    @contextlib.contextmanager
    def bench(self) -> Iterator[Bench]:
        """Start a session for functions that are not TP1's."""
        with self._session(expected_data.SIZE) as session:
            yield Bench(self, session, self._libraries.unit(expected_data.SIZE))

    @contextlib.contextmanager
    def probe(self) -> Iterator[Bench]:
        """Start a session in which the probe stands in the place of trace_ray. Raises NotBuilt."""
        core = self._libraries.probed(expected_data.SIZE)
        with self._open(core, UNIT_LIMITS) as session:
            yield Bench(self, session, core)

    @contextlib.contextmanager
    def counting(self) -> Iterator[Bench]:
        """Start a session whose library counts the tests of objects (mrt_object_tests)."""
        core = self._libraries.counter()
        with self._open(core, PICTURE_LIMITS) as session:
            yield Bench(self, session, core)

    def batches(self, suite: str) -> list[Batch]:
        """Return the stored calls of a suite, with the answers that are accepted."""
        self.has_inputs = True
        return expected_data.read(self.folder, suite, self._libraries.unit(expected_data.SIZE))

    def trials(self, suite: str) -> list[Answers]:
        """Put a suite to the submission: all its calls, in one session."""

        def put(student: Student) -> list[Answers]:
            with student.bench() as bench:
                return [bench.trial(batch) for batch in student.batches(suite)]

        if not self._is_lent:
            return put(self)
        seen = self.observations
        found = self.once(suite, put)
        return [replace(each, name=seen.next_batch(), observations=seen) for each in found]

    def once(self, what: str, act: Callable[[Student], T]) -> T:
        """Have something done at which several checks look: once for all, where that will do."""
        if not self._is_lent:
            return act(self)
        kept, key = self._libraries.kept, (self.folder, what)
        first = (
            kept[key][0]
            if key in kept
            else Student(self._libraries, self.folder, self._own, is_lent=True)
        )
        try:
            found: T = kept[key][1] if key in kept else act(first)
            kept[key] = first, found
            return found
        finally:
            self.has_inputs = self.has_inputs or first.has_inputs
            self._add(first.todo, first.output, first.acts)

    def _add(self, todo: frozenset[str], output: str, acts: list[Act]) -> None:
        """Note what a session has left."""
        self.todo |= todo
        self.output = self.output or output
        self.acts = self.acts or acts

    def picture(
        self, scene: int, texels: Array | None = None, begin: Begin | None = None, **settings: Any
    ) -> Image:
        """Draw a scene with the optimised build; `settings` are fields of `options`.

        `texels` are those of scene_texture; `begin` lays the scene out otherwise. Returns shape
        (180, 320, 3), float32, row 0 at the bottom, as it was left. Raises CallDied.
        """
        self.has_inputs = True
        text = ", ".join([f"scene {scene}", *(f"{key} = {each}" for key, each in settings.items())])
        limits = SMOOTH_LIMITS if settings.get("samples", 1) > 1 else PICTURE_LIMITS
        with self.stage(limits, texels, **settings) as (session, core):

            def draw() -> None:
                if begin:
                    begin(session, core)
                else:
                    session.call("setup_scene", scene)  # builds the octree
                session.call("raytrace")

            # A picture would only take longer to loop in the same place.
            loops = self._libraries.loops
            looping = (name for name in self._own if loops.of(name, chances=1))
            self.guard(
                next(looping, "raytrace"),
                lambda case: f"raytrace() ({text})",
                draw,
                lambda case: "" if begin else reproducer.of_picture(scene, settings, PICTURE_SIZE),
                chances=1,
            )
            flat = session.get("output_image")
        return flat.reshape(PICTURE_SIZE[1], PICTURE_SIZE[0], 3)

    @contextlib.contextmanager
    def stage(
        self, limits: Limits, texels: Array | None = None, **settings: Any
    ) -> Iterator[tuple[Session, Library]]:
        """Start a session of the optimised build, with a texture and fields of `options` set."""
        core = self._libraries.renderer()
        with self._open(core, limits) as session:
            options = session.get("options")
            for name, value in settings.items():
                options[name] = value
            session.set("options", options)
            expected_data.lend_texture(session, core, texels)
            yield session, core

    def guard(
        self,
        name: str,
        call: Callable[[int], str],
        act: Callable[[], T],
        program: Callable[[int], str],
        chances: int = LOOPS,
    ) -> T:
        """Run code that calls a function.

        `call` gives the text of its calls by their number, and `program` each as a C program.
        Raises CallDied when it does not come back; at once, with the call that did not, when its
        loops are known.
        """
        loops = self._libraries.loops
        if known := loops.of(name, chances):
            raise self._fatal(known)
        try:
            answer = act()
        except Died as error:
            case = error.death.case
            found = Loop(error.death, call(case), program(case))
            if error.death.cause in OUT_OF_TIME:
                loops.add(name, found)
            raise self._fatal(found) from error
        loops.come_back(name)
        return answer

    def _fatal(self, found: Loop) -> CallDied:
        others = {name for each in exercises.load().exercises for name in each.functions}
        location = death_messages.shown(found.death, self._own, others.difference(self._own))
        return CallDied(found.death, found.call, Evidence(reproducer=found.program), location)

    @contextlib.contextmanager
    def _session(self, size: Size) -> Iterator[Session]:
        core = self._libraries.unit(size)
        with self._open(core, UNIT_LIMITS, core.lent if self._is_lent else None) as session:
            yield session

    @contextlib.contextmanager
    def _open(self, core: Library, limits: Limits, start: Start | None = None) -> Iterator[Session]:
        with contextlib.ExitStack() as stack:
            session = self._loaded(stack, start or core.session, limits)
            try:
                yield session
            finally:
                self._add(session.todo(), session.output(), session.acts())

    def _loaded(self, stack: contextlib.ExitStack, start: Start, limits: Limits) -> Session:
        """Start a session. Raises Died; at once when loading has run out of time before."""
        if known := self._libraries.loops.of(_LOADING):
            raise Died(known.death)
        try:
            return stack.enter_context(start(limits))
        except Died as error:
            if error.death.cause in OUT_OF_TIME:
                self._libraries.loops.add(_LOADING, Loop(error.death, "", ""))
            raise

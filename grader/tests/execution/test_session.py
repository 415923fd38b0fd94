"""Calling a submission's functions in another process, and the ways that it can die."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grader.execution.dtypes import Types
from grader.execution.records import Cause, Death
from grader.execution.session import (
    Address,
    Array,
    Died,
    Library,
    Limits,
    MachineError,
    Missing,
    Session,
    open_core,
)
from grader.execution.worker_process import start_worker
from grader.sandbox.levels import Level, using
from grader.worker import frames

Write = Callable[..., Path]
SHORT = Limits(cpu=1)
PIXELS = np.zeros((96 * 64, 3), np.float32)


def test_inline_functions_and_constructors_are_called(reference: Library) -> None:
    """vec3 is returned by value; an object, which cffi cannot return, comes through the shim."""
    with reference.session() as s:
        np.testing.assert_array_equal(s.call("vector_add", (1, 2, 3), (4, 5, 6)).result, [5, 7, 9])
        plane = s.call("init_plane", 0, 2, 0, 0.5, reference.zeros("material")).result
        assert (plane["type"], plane["dist"]) == (reference.constants["PLANE"], 0.5)
        np.testing.assert_array_equal(plane["normal"], [0, 1, 0])
        assert s.call("add_object", plane).result
        assert s.get("object_count") == 1
        assert s.get("scene", 1)[0]["type"] == plane["type"]


def test_many_calls_give_columns(reference: Library) -> None:
    """One request makes n calls: results and written structs come back with n as first axis."""
    rays = reference.zeros("ray", 3)
    rays["orig"] = [(0, 0, 5), (0, 3, 5), (0, 0, -5)]
    rays["dir"] = (0, 0, -1)
    rays["tmax"] = 100
    with reference.session() as s:
        ball = s.call("init_sphere", 0, 0, 0, 1, reference.zeros("material")).result
        hits = reference.zeros("intersection", 3)
        reply = s.call_many("intersect_sphere", 3, rays, hits, ball)
    np.testing.assert_array_equal(reply.result, [True, False, False])
    np.testing.assert_array_equal(reply.args["r"]["tmax"], [4, 100, 100])
    np.testing.assert_array_equal(reply.args["it"]["normal"][0], [0, 0, 1])
    assert rays["tmax"][0] == 100


def test_globals_pictures_and_addresses(reference: Library) -> None:
    """A scene is set, drawn and read; memory of the session is reached by address."""
    with reference.session() as s:
        assert s.call("setup_scene", 0).result
        s.call("raytrace")
        picture = s.get("output_image")
        assert picture.shape == (96 * 64, 3)
        assert np.isfinite(picture).all()
        assert picture.std() > 0.05
        texels = s.buffer(np.ones((2, 3), np.float32))
        image = reference.zeros("texture")
        image["width"], image["height"], image["texels"] = 2, 1, texels
        s.set("scene_texture", image)
        np.testing.assert_array_equal(s.peek(texels, "color", 2), 1)
        assert s.get("scene_texture")["texels"] == texels
        tree = s.call("octree_build", s.get("scene", 5), 5).result
        assert isinstance(tree, Address)
        assert s.peek(tree, "octree_node")["bounds"]["min"].shape == (3,)


def test_constants_are_known_without_a_session(submission: Write, cache: Path) -> None:
    """The headers' numbers, for the size of the build."""
    with student(submission(), cache) as core:
        assert (core.constants["WIDTH"], core.constants["SPHERE"]) == (96, 1)


def test_a_layout_that_differs_is_refused(
    submission: Write, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bytes that C and numpy would read differently are never exchanged."""
    monkeypatch.setattr(Types, "layout", (12, 0, 4, 9))
    refused = pytest.raises(MachineError, match="layout")
    with student(submission(), cache) as core, refused, core.session():
        pass


def test_sessions_do_not_share_their_memory(reference: Library) -> None:
    """Each session starts from the library as it was built."""
    with reference.session() as first:
        first.set("object_count", 7)
    with reference.session() as second:
        assert second.get("object_count") == 0


@pytest.mark.parametrize(
    "ask",
    [
        lambda s: s.call("no_such_function"),
        lambda s: s.call("vector_add", (1, 2, 3)),
        lambda s: s.call("vector_add", (1, 2), (3, 4)),
        lambda s: s.get("no_such_variable"),
        lambda s: s.get("lights", 4),
        lambda s: s.get("object_count", 1),
    ],
)
def test_mistakes_of_the_caller_are_value_errors(
    reference: Library, ask: Callable[[Session], object]
) -> None:
    """What makes no sense is refused before the library sees it, and the session goes on."""
    with reference.session() as s:
        with pytest.raises(ValueError, match=r"."):
            ask(s)
        assert s.call("vector_norm", (3, 4, 0)).result == 5


@contextlib.contextmanager
def student(folder: Path, cache: Path, sanitized: bool = False) -> Iterator[Library]:
    """Open a submission at 96x64."""
    with open_core(folder, 96, 64, sanitized=sanitized, cache=cache) as core:
        yield core


def death_of(core: Library, name: str, *args: object, pixels: Array = PIXELS) -> Death:
    """Call a function that must not come back; return how it died."""
    with core.session(SHORT) as s, pytest.raises(Died) as caught:
        s.call(name, pixels, *args)
    return caught.value.death


def test_plain_deaths_name_their_cause(submission: Write, cache: Path) -> None:
    """A signal, a write past either end of the picture, an exit and a loop are told apart."""
    folder = submission(
        fill_red="*(volatile int *)0 = 1;",
        fill="img[WIDTH * HEIGHT] = c;",
        horizontal_gradient="img[-1] = c1;",
        fill_rect='printf("bye"); fflush(stdout); exit(3);',
        fill_circle="for (volatile int k = 0;; k ^= 1) { }",
    )
    zero = (0, 0, 0)
    with student(folder, cache) as core:
        segv = Death(Cause.SIGNAL, "SIGSEGV")
        assert death_of(core, "fill_red") == Death(
            Cause.SIGNAL, "null-pointer", location="main.c:11", function="fill_red"
        )
        assert death_of(core, "fill", zero) == replace(segv, location="main.c:12", function="fill")
        # Not a whole number of pages, so the guard page is not right before the table.
        stray = death_of(core, "horizontal_gradient", zero, zero, pixels=PIXELS[1:])
        assert stray == Death(Cause.STRAY_WRITE)
        left = death_of(core, "fill_rect", zero, zero, zero)
        assert left == Death(Cause.EXIT, code=3, text="bye")
        endless = Death(Cause.TIMEOUT, location="main.c:15", function="fill_circle")
        assert death_of(core, "fill_circle", 1, zero, zero) == endless


def test_the_worker_outlives_its_sessions(submission: Write, cache: Path) -> None:
    """After a crash a new session of the same core answers; the dead one says that it is over."""
    with student(submission(fill_red="abort();"), cache) as core:
        with core.session() as s:
            with pytest.raises(Died):
                s.call("fill_red", PIXELS)
            with pytest.raises(ValueError, match="over"):
                s.call("fill", PIXELS, (1, 1, 1))
        with core.session() as s:
            assert s.call("fill", PIXELS, (1, 1, 1)).args["img"].all()


def test_sanitized_deaths_name_the_line(submission: Write, cache: Path) -> None:
    """With the sanitizers the report's word and the student's own line are known."""
    folder = submission(
        fill_red="img[WIDTH * HEIGHT].x = 1;",
        fill="int big = 2147483647; output_image[0].x = (float)(big + (int)c.x);",
        horizontal_gradient="output_image[WIDTH * HEIGHT + (int)c1.x] = c2;",
    )
    one = (1, 1, 1)
    with student(folder, cache, sanitized=True) as core:
        past = death_of(core, "fill_red")
        overflow = death_of(core, "fill", one)
        outside = death_of(core, "horizontal_gradient", (0, 0, 0), one)
    assert (past.word, past.location) == ("heap-buffer-overflow", "main.c:11")
    assert overflow.word.startswith("runtime error: signed integer overflow")
    assert overflow.location == "main.c:12"
    assert outside.location == "main.c:13"


@pytest.mark.parametrize("sanitized", [False, True], ids=["plain", "sanitized"])
def test_what_uses_up_the_stack_is_known(submission: Write, cache: Path, sanitized: bool) -> None:
    """By its calls without end, or by a table; a pointer to nowhere is neither, nor NULL."""
    folder = submission(
        fill="if (c.x > 0.f) { fill(img, c); fill(img, c); }",
        fill_red="color table[WIDTH * HEIGHT * 300]; table[0] = img[0];"
        " img[0] = table[(int)img[1].x];",
        horizontal_gradient="*(char *)((size_t)1 << 60 | (size_t)c1.x) = (char)c2.x;",
    )
    with student(folder, cache, sanitized) as core:
        endless, table = death_of(core, "fill", (1, 1, 1)), death_of(core, "fill_red")
        nowhere = death_of(core, "horizontal_gradient", (0, 0, 0), (0, 0, 0))
    assert (endless.word, table.word) == ("stack-overflow", "stack-overflow")
    assert [name for name, _ in endless.callers].count("fill") > 5
    assert table.callers == ()
    assert nowhere.word == ("SEGV" if sanitized else "SIGSEGV")


def test_the_calls_that_led_to_a_death_are_known(submission: Write, cache: Path) -> None:
    """From the inside out, with their lines, whoever reports it; ours among them are left out."""
    steps = """#include "raytracer.h"
bool intersect_sphere(ray *r, intersection *it, const object *obj) {
    it->position = r->orig; it->mat = obj->mat; return true;
}
void inner(color *img, int k);
void inner(color *img, int k) {
    img[WIDTH * HEIGHT + k].x = 1.f;
}
"""
    folder = submission(
        fill_red="extern void inner(color *img, int k); inner(img, 1);",
        fill="ray r; object ball = {0}; ball.type = SPHERE; ray_init(&r, c, c);"
        " intersect_object(&r, (intersection *)(size_t)c.x, &ball);",
        files={"steps.c": steps},
    )
    with student(folder, cache, sanitized=True) as core:
        past, null = death_of(core, "fill_red"), death_of(core, "fill", (0, 0, 0))
    assert (past.function, past.location) == ("inner", "steps.c:7")
    assert past.callers == (("fill_red", "main.c:11"),)
    assert (null.function, null.location) == ("intersect_sphere", "steps.c:3")
    assert null.callers == (("fill", "main.c:12"),)


def test_the_case_that_kills_is_known(submission: Write, cache: Path) -> None:
    """In a batch, the number of the call that was running survives the crash."""
    folder = submission(fill_circle="if (radius > 2) abort();")
    with student(folder, cache) as core, core.session() as s, pytest.raises(Died) as caught:
        s.call_many("fill_circle", 5, PIXELS, np.arange(5), (0, 0, 0), (0, 0, 0))
    assert caught.value.death.case == 3


def test_markers_survive_a_crash(submission: Write, cache: Path) -> None:
    """The ids of MRT_TODO are read from a page that outlives the process."""
    folder = submission(fill_red='MRT_TODO("TP1.1"); MRT_TODO("TP4.B1"); abort();')
    with student(folder, cache) as core, core.session() as s:
        assert s.todo() == frozenset()
        with pytest.raises(Died):
            s.call("fill_red", PIXELS)
        assert s.todo() == {"TP1.1", "TP4.B1"}


def test_a_missing_function_is_named(submission: Write, cache: Path) -> None:
    """A function that is not written fails when it is called, and by itself."""
    with student(submission(), cache) as core, core.session() as s:
        with pytest.raises(Missing) as caught:
            s.call("trace_ray", core.zeros("ray"))
        assert caught.value.name == "trace_ray"
        assert s.call("vector_norm", (3, 4, 0)).result == 5


def test_a_missing_global_cannot_be_loaded(submission: Write, cache: Path) -> None:
    """The library is refused by the loader, whose message is kept."""
    folder = submission(files={"main.c": '#include "raytracer.h"\n'})
    with student(folder, cache) as core, pytest.raises(Died) as caught, core.session():
        pass
    assert caught.value.death.cause is Cause.LOAD
    assert "undefined symbol" in caught.value.death.text


def test_globals_with_the_names_of_the_c_library_are_their_own(
    submission: Write, cache: Path
) -> None:
    """A student's `glob` or `error` binds to the student's, not to the interpreter's."""
    names = "int glob = 1; int error = 1; int paint(void) { return ++glob * ++error; }"
    folder = submission(
        fill_red="extern int paint(void); img[0].x = (float)paint();", files={"names.c": names}
    )
    with student(folder, cache) as core, core.session() as s:
        assert s.call("fill_red", PIXELS).args["img"][0, 0] == 4


def test_much_output_neither_blocks_nor_fills_the_disk(submission: Write, cache: Path) -> None:
    """What is printed is cut; the call returns as if all had been written."""
    body = 'for (int k = 0; k < 200000; k++) printf("%100d\\n", k); fflush(stdout);'
    with student(submission(fill_red=body), cache) as core, core.session() as s:
        assert s.call("fill_red", PIXELS).args["img"].shape == PIXELS.shape


def test_a_forged_answer_gains_nothing(submission: Write, cache: Path) -> None:
    """A reply written by the code itself has not the length that is due: the session is over."""
    forge = r"""
        #include <unistd.h>
        void forge(void) {
            static const char reply[] = "\x0e\0\0\0\0\0\0\0\0\0\0\0{\"is\": \"done\"}";
            for (int fd = 3; fd < 64; fd++)
                if (write(fd, reply, sizeof reply - 1) < 0) continue;
            _exit(0);
        }"""
    folder = submission(fill_red="extern void forge(void); forge();", files={"forge.c": forge})
    with student(folder, cache) as core:
        assert death_of(core, "fill_red").cause is Cause.EXIT


def test_nothing_is_left_behind(submission: Write, cache: Path) -> None:
    """What the code has started is gone soon after its session, even where it may start anything.

    That is a child, and one that has left for a session of its own and lost its parent.
    """
    start = """
        #include <sys/wait.h>
        #include <unistd.h>
        int start(void), leave(void);
        int start(void) { int pid = fork(); while (pid == 0) pause(); return pid; }
        int leave(void) {
            int way[2], pid, middle;
            if (pipe(way) != 0) return 0;
            if ((middle = fork()) == 0) {
                setsid();
                pid = start();
                _exit(write(way[1], &pid, sizeof pid) != sizeof pid);
            }
            waitpid(middle, NULL, 0);
            return read(way[0], &pid, sizeof pid) == sizeof pid ? pid : 0;
        }"""
    folder = submission(
        fill_red="extern int start(void), leave(void);"
        " img[0].x = (float)start(); img[1].x = (float)leave();",
        files={"start.c": start},
    )
    with using(Level.PORTABLE), student(folder, cache) as core:
        with core.session() as s:
            pids = [int(each) for each in s.call("fill_red", PIXELS).args["img"][:2, 0]]
            assert all(pid > 0 and _runs(pid) for pid in pids)
        deadline = time.monotonic() + 5
        while any(map(_runs, pids)):
            assert time.monotonic() < deadline
            time.sleep(0.01)


def _runs(pid: int) -> bool:
    """Whether the process exists and is not merely waiting to be buried."""
    try:
        return " Z " not in Path(f"/proc/{pid}/stat").read_text(encoding="ascii")
    except FileNotFoundError:
        return False


def test_a_worker_that_does_not_answer_is_the_machines_fault(
    reference: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker that has gone, for whatever reason, is no verdict on anybody."""
    library = reference.library.library
    monkeypatch.setattr("grader.sandbox.bubblewrap.interpreter", lambda: "/usr/bin/false")
    with start_worker() as process:
        process.declare(library, "int f(void);", sanitized=False)
        with pytest.raises(MachineError, match="does not start"), process.fork(library, SHORT):
            pass


STAYING = Limits(cpu=1, each_call=True)
LOOP = "for (volatile int k = 0;; k ^= 1) { }"


def test_a_session_that_stays_has_its_seconds_for_each_call(submission: Write, cache: Path) -> None:
    """Calls that together take longer than one may are all answered; one that does alone is not."""
    busy = "clock_t end = clock() + CLOCKS_PER_SEC * 3 / 4; while (clock() < end) { }"
    folder = submission(
        fill_red=busy,
        fill=LOOP,
        files={"raytracer.h": '#include "exercises.h"\n#include <time.h>\n'},
    )
    with student(folder, cache) as core, core.session(STAYING) as s:
        for _ in range(3):
            s.call("fill_red", PIXELS)
        with pytest.raises(Died) as caught:
            s.call("fill", PIXELS, (0, 0, 0))
    assert (caught.value.death.cause, caught.value.death.function) == (Cause.TIMEOUT, "fill")


def test_what_is_printed_comes_by_and_by(submission: Write, cache: Path) -> None:
    """Each time only what is new; more than a file may hold, and in the end what a crash left."""
    folder = submission(
        fill_red='static int k; printf("%d", k++);',
        fill='for (int k = 0; k < 9000; k++) printf("%100d", k);',
        fill_circle='fprintf(stderr, "here"); abort();',
    )
    with student(folder, cache) as core, core.session(STAYING) as s:
        assert s.printed_since() == ""
        for k in range(3):
            s.call("fill_red", PIXELS)
            assert s.output() == s.printed_since() == str(k)
            s.call("fill", PIXELS, (0, 0, 0))
            assert s.printed_since().split()[:3] == ["0", "1", "2"]
        with pytest.raises(Died):
            s.call("fill_circle", PIXELS, 1, (0, 0, 0), (0, 0, 0))
        assert s.printed_since() == "here"


@contextlib.contextmanager
def stop_button(seconds: float) -> Iterator[None]:
    """Raise KeyboardInterrupt in this thread after a while."""
    old = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, old)


def test_a_call_is_stopped_by_hand(submission: Write, cache: Path) -> None:
    """The stop button cuts the call short; where it was is told, and a new session answers."""
    with student(submission(fill_red=LOOP), cache) as core:
        with core.session(STAYING) as s:
            with pytest.raises(KeyboardInterrupt), stop_button(0.2):
                s.call("fill_red", PIXELS)
            with pytest.raises(ValueError, match="interrupted"):
                s.call("fill", PIXELS, (1, 1, 1))
            death = s.interrupt()
            assert (death.function, death.location) == ("fill_red", "main.c:11")
            assert s.interrupt() == death
        with core.session(STAYING) as s:
            assert s.call("fill", PIXELS, (1, 1, 1)).args["img"].all()


def test_a_call_is_stopped_by_another_thread(submission: Write, cache: Path) -> None:
    """What waits for the call hears that it has died, and where."""
    with student(submission(fill_red=LOOP), cache) as core, core.session(Limits()) as s:
        stop = threading.Timer(0.2, s.interrupt)
        stop.start()
        with pytest.raises(Died) as caught:
            s.call("fill_red", PIXELS)
        stop.join()
    assert caught.value.death.location == "main.c:11"


def test_what_is_printed_before_a_crash_is_kept_apart_from_its_report(
    submission: Write, cache: Path
) -> None:
    """Both outputs are shown, a line that is not ended too; the tools' own words are not."""
    said = 'printf("out"); fprintf(stderr, "err\\n");'
    folder = submission(
        fill_red=f"{said} img[WIDTH * HEIGHT].x = 1;",
        fill=f"{said} int big = 2147483647; img[0].x = (float)(big + (int)c.x);",
        horizontal_gradient=f"{said} trace_ray(0);",
        # Notes of UBSan's beside its error, and ASan's warning with its calls.
        fill_rect=f"{said} img[0].x = *(float *)((size_t)c.x + 1);",
        fill_circle=f"{said} extern void *malloc(size_t); *(int *)malloc((size_t)1 << 60) = 1;",
    )
    for sanitized in (False, True):
        one = (1, 1, 1)
        calls: dict[str, tuple[object, ...]] = {"fill_red": (), "fill": (one,)}
        calls["horizontal_gradient"] = (one, one)
        if sanitized:
            calls |= {"fill_rect": (one, one, one), "fill_circle": (1, one, one)}
        with student(folder, cache, sanitized) as core:
            for name, args in calls.items():
                with core.session(SHORT) as s:
                    with contextlib.suppress(Died):
                        s.call(name, PIXELS, *args)
                    assert s.output() == "outerr\n"


def test_a_worker_that_speaks_at_once_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its memory can be bounded only by who knows its number, however late the parent listens."""
    start = subprocess.Popen
    with start_worker():
        pass  # what has to be found out once is known from here on

    def quick(command: list[str], *, pass_fds: list[int], **settings: Any) -> Any:
        os.write(pass_fds[0], frames.frame({"is": "ready"}))
        return start(["true"], **settings)

    monkeypatch.setattr(subprocess, "Popen", quick)
    with start_worker() as process:
        assert process._control.pid() == os.getpid()

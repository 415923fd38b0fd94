"""What a submission of a class can learn of the others, of the solution and of what is expected.

Nothing at all, not even that it is there: an attempt on a path ends as one on a path that does not
exist, while compiling and while running; and the memory of the process holds no word of it.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

import pytest

from grader.authoring.specimens import classroom
from grader.authoring.specimens.student import STUDENT_MAIN, main_c
from grader.course.exercises import ROOT
from grader.sandbox.levels import Level, best
from grader.tests.batch.test_class import batch

SECRET = "victim-secret-0451"
VICTIM, SPY = "Ada Lovelace", "Eve"
# Compares how attempts end; looks through the memory for words that it holds in disguise only.
RUNNING = r"""
#define _GNU_SOURCE
#pragma GCC optimize "O2"
#include "raytracer.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>
extern char **environ;
/* Each letter stands for the one before it. */
static const char *paths[] = {@PATHS@};
static const char *words[] = {@WORDS@};
#define COUNT(table) (sizeof(table) / sizeof *(table))

static int attempt(int way, const char *path)
{
    struct stat seen;
    char target[64];
    errno = 0;
    switch (way) {
    case 0: return open(path, O_RDONLY) >= 0 ? 0 : errno;
    case 1: return open(path, O_PATH) >= 0 ? 0 : errno;
    case 2: return stat(path, &seen) == 0 ? 0 : errno;
    case 3: return lstat(path, &seen) == 0 ? 0 : errno;
    case 4: return access(path, F_OK) == 0 ? 0 : errno;
    case 5: return mkdir(path, 0700) == 0 ? 0 : errno;
    case 6: return open(path, O_CREAT | O_EXCL | O_WRONLY, 0600) >= 0 ? 0 : errno;
    case 7: return readlink(path, target, sizeof target) >= 0 ? 0 : errno;
    case 8: return opendir(path) != NULL ? 0 : errno;
    case 9: return chdir(path) == 0 ? 0 : errno;
    case 10: return rename(path, "/mrt/other") == 0 ? 0 : errno;
    case 11: return unlink(path) == 0 ? 0 : errno;
    default: return execl(path, path, (char *)NULL) == 0 ? 0 : errno;
    }
}

void spy(void);
void spy(void)
{
    char place[512], path[1024];
    for (size_t k = 0; k < COUNT(paths); k++)
        for (int way = 0; way < 13; way++) {
            size_t length = strlen(paths[k]);
            for (size_t i = 0; i <= length; i++)
                path[i] = i < length ? (char)(paths[k][i] - 1) : 0;
            int there = attempt(way, path);
            strcpy(path + length, "-no-such");
            if (attempt(way, path) != there)
                printf("SEEN %zu %d\n", k, way);
        }
    if (getcwd(place, sizeof place) != NULL)
        printf("HERE %s\n", place);
    for (char **each = environ; *each; each++)
        printf("SET %s\n", *each);
    printf("DONE\n");
    fflush(stdout);
}

/* The sanitizer must not watch. */
static char at(const char *place)
{
#ifdef __x86_64__
    char byte;
    __asm__ volatile("movb (%1), %0" : "=q"(byte) : "r"(place));
    return byte;
#else
    return *place;
#endif
}

static bool stands(const char *word, const char *place, size_t room)
{
    size_t i = 0;
    while (i < room && word[i] && at(place + i) == word[i] - 1)
        i++;
    return word[i] == 0;
}

static bool begins[256]; /* a word does, with this letter */

static void look_through(uintptr_t start, size_t size)
{
    for (size_t page = 0; page < size; page += 4096) {
        const char *place = (const char *)(start + page);
        errno = 0;
        if (syscall(SYS_openat, AT_FDCWD, place, O_RDONLY) < 0 && errno == EFAULT)
            continue; /* no memory there */
        for (size_t i = 0; i < 4096; i++)
            for (size_t k = 0; begins[(unsigned char)at(place + i)] && k < COUNT(words); k++)
                if (stands(words[k], place + i, 4096 - i))
                    printf("MEMORY %zu\n", k);
    }
}

void look(void);
void look(void)
{
    for (size_t k = 0; k < COUNT(words); k++)
        begins[words[k][0] - 1] = true;
    /* Around what malloc gives, by size, since the sanitizer's keeps each size apart; and around
     * what the system gives, as Python has it too. */
    for (size_t size = 32; size <= 4096; size *= 2)
        look_through(((uintptr_t)malloc(size) & ~(uintptr_t)4095) - (1 << 18), 1 << 19);
    void *mapped = mmap(NULL, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    look_through((uintptr_t)mapped - (48 << 20), 96 << 20);
    printf("DONE\n");
    fflush(stdout);
}
"""


def hidden(top: Path) -> list[Path]:
    """Return the paths of what nobody may know of."""
    return [
        ROOT / "reference" / "raytracer.c",
        ROOT / "reference" / "expected" / "manifest.json",
        ROOT / "grader" / "checking" / "student.py",
        top / "in" / VICTIM / "main.c",
        top / "out" / "students" / VICTIM,
        top / "out" / "state" / f"{VICTIM}.json",
        top / "out" / "batch.json",
    ]


def disguised(text: str) -> str:
    """Return a C string whose letters are each the one after."""
    return '"' + "".join(f"\\{ord(letter) + 1:03o}" for letter in text) + '"'


def spies(top: Path) -> dict[str, str]:
    """Return the files of the spy: those that try while compiling, and the one that runs."""
    paths = hidden(top)
    probes = [f'#if __has_include("{each}")\n#error SEEN {each}\n#endif\n' for each in paths]
    tries = [*paths, paths[3].with_name("no-such.c")]
    files = {
        "has.c": "".join(probes),
        "incbin.c": "".join(f'__asm__(".incbin \\"{each}\\"");\n' for each in tries),
        "dependency.c": "".join(f'#pragma GCC dependency "{each}"\n' for each in tries),
        "include0.c": f'#include "{paths[0]}"\n',
        "include1.c": f'#include "{tries[-1]}"\n',
    }
    # The last one is there: who looks must find it.
    words = [SECRET, f"{top}/out", "reference/expected", VICTIM, "/mrt/inbox/mrt-"]
    quoted = [", ".join(map(disguised, names)) for names in (map(str, paths), words)]
    bodies = {
        "fill_red": "extern void spy(void); spy(); (void)img;",
        "fill": "extern void look(void); look(); (void)img, (void)c;",
    }
    return {
        **files,
        "running.c": RUNNING.replace("@PATHS@", quoted[0]).replace("@WORDS@", quoted[1]),
        "main.c": main_c({**STUDENT_MAIN, **bodies}),
    }


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """Grade the spy beside its victim; return the folder and the spy's results."""
    if best().level is not Level.STRONG:
        assert not os.environ.get("MRT_CI"), "CI must have bubblewrap"
        pytest.skip("bubblewrap is missing")
    top = tmp_path_factory.mktemp("spied")
    header = f'#include "exercises.h"\nstatic const char own[] = "{SECRET}";\n'
    classroom.first_tp(top / "in" / VICTIM, {"raytracer.h": header})
    classroom.first_tp(top / "in" / SPY, spies(top))
    done = batch(top / "in", top / "out", "--jobs", "2")
    assert done.status == 0, done.errors
    folder = top / "out" / "students" / SPY
    return top, json.loads((folder / "results.json").read_text(encoding="utf-8"))


@pytest.mark.long
def test_compiling_tells_nothing(results: tuple[Path, dict[str, Any]]) -> None:
    """No path is found, and the compiler says the same of those that exist and of one that not."""
    top, content = results
    said = "\n".join([content["build"]["log"], *content["build"]["warnings"]])
    assert "SEEN" not in said
    told = {
        "include0.c:1:10: fatal error: PATH: No such file or directory",
        "include1.c:1:10: fatal error: PATH: No such file or directory",
        "asm.s:LINE: Error: file not found: PATH",
        "dependency.c:1:1: fatal error: PATH: No such file or directory",
    }
    for name in [*map(str, hidden(top)), str(top / "in" / VICTIM / "no-such.c")]:
        said = said.replace(name, "PATH")
    lines = {re.sub(r"s:\d+:", "s:LINE:", line) for line in said.splitlines() if "rror: " in line}
    assert lines == told
    assert str(top) not in said


def test_running_tells_nothing(results: tuple[Path, dict[str, Any]]) -> None:
    """Attempts end alike; folder, settings and memory hold no word of anything hidden."""
    top, content = results
    said = {each["function"]: each["output"] for each in content["checks"] if each["output"]}
    assert "DONE" in said["fill_red"]
    assert "SEEN" not in said["fill_red"]
    assert "HERE" not in said["fill_red"] or "HERE /mrt" in said["fill_red"]
    assert str(ROOT) not in said["fill_red"]
    assert str(top) not in said["fill_red"]
    assert {*said["fill"].split("\n")} == {"MEMORY 4", "DONE", ""}

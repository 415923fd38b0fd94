"""The system calls that a submission may make, by architecture; see lockdown.py.

It may use its memory and the files that it has open, read files, look at the clock, and end.
"""

from __future__ import annotations

from typing import NamedTuple


class Architecture(NamedTuple):  # a dataclass takes a worker 5 ms to import
    """An architecture: the kernel's constant for it, and its system calls' numbers by their names.

    A test compares the numbers with the kernel's own headers, for both architectures on either.
    """

    audit: int
    allowed: dict[str, int]
    opens: dict[str, tuple[int, int]]  # for reading only: number, and which argument says so
    to_itself: dict[str, int]  # signals: the first argument must be its own process
    limits: dict[str, int]  # of itself only: the first argument must be 0


X86_64 = Architecture(
    audit=0xC000003E,
    allowed={
        **{"read": 0, "write": 1, "close": 3, "fstat": 5, "poll": 7, "lseek": 8},
        **{"mmap": 9, "mprotect": 10, "munmap": 11, "brk": 12, "mremap": 25, "madvise": 28},
        **{"rt_sigaction": 13, "rt_sigprocmask": 14, "rt_sigreturn": 15, "sigaltstack": 131},
        **{"pread64": 17, "writev": 20, "sched_yield": 24, "nanosleep": 35, "getpid": 39},
        **{"sendto": 44, "recvfrom": 45, "exit": 60, "exit_group": 231, "gettid": 186},
        **{"futex": 202, "gettimeofday": 96, "time": 201, "clock_gettime": 228},
        **{"clock_getres": 229, "clock_nanosleep": 230, "getrusage": 98, "sched_getaffinity": 204},
        **{"newfstatat": 262, "getrandom": 318},
    },
    opens={"openat": (257, 2), "open": (2, 1)},  # the second is of the sanitizers' runtime
    to_itself={"kill": 62, "tgkill": 234},
    limits={"prlimit64": 302},
)
AARCH64 = Architecture(
    audit=0xC00000B7,
    allowed={
        **{"read": 63, "write": 64, "close": 57, "fstat": 80, "ppoll": 73, "lseek": 62},
        **{"mmap": 222, "mprotect": 226, "munmap": 215, "brk": 214, "mremap": 216, "madvise": 233},
        **{"rt_sigaction": 134, "rt_sigprocmask": 135, "rt_sigreturn": 139, "sigaltstack": 132},
        **{"pread64": 67, "writev": 66, "sched_yield": 124, "nanosleep": 101, "getpid": 172},
        **{"sendto": 206, "recvfrom": 207, "exit": 93, "exit_group": 94, "gettid": 178},
        **{"futex": 98, "gettimeofday": 169, "clock_gettime": 113},
        **{"clock_getres": 114, "clock_nanosleep": 115, "getrusage": 165, "sched_getaffinity": 123},
        **{"newfstatat": 79, "getrandom": 278},
    },
    opens={"openat": (56, 2)},
    to_itself={"kill": 129, "tgkill": 131},
    limits={"prlimit64": 261},
)
ARCHITECTURES = {"x86_64": X86_64, "aarch64": AARCH64}

"""The system calls that a submission may make, by architecture; see lockdown.py.

It may use its memory and the files that it has open, read files, look at the clock, and end.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Architecture:
    """An architecture: the kernel's constant for it, and the numbers of its system calls."""

    audit: int
    allowed: tuple[int, ...]
    opens: tuple[tuple[int, int], ...]  # for reading only: number, and which argument says so
    to_itself: tuple[int, ...]  # signals: the first argument must be its own process
    prlimit: int  # of itself only: the first argument must be 0


X86_64 = Architecture(
    audit=0xC000003E,
    allowed=(
        *(0, 1, 3, 5, 7, 8),  # read write close fstat poll lseek
        *(9, 10, 11, 12, 25, 28),  # mmap mprotect munmap brk mremap madvise
        *(13, 14, 15, 131),  # rt_sigaction rt_sigprocmask rt_sigreturn sigaltstack
        *(17, 20, 24, 35, 39),  # pread64 writev sched_yield nanosleep getpid
        *(44, 45),  # sendto recvfrom
        *(60, 231, 186, 202),  # exit exit_group gettid futex
        *(96, 201, 228, 229, 230),  # gettimeofday time clock_gettime clock_getres clock_nanosleep
        *(98, 204, 262, 318),  # getrusage sched_getaffinity newfstatat getrandom
    ),
    opens=((257, 2), (2, 1)),  # openat; open, which the sanitizers' runtime uses
    to_itself=(62, 234),  # kill tgkill
    prlimit=302,
)
AARCH64 = Architecture(
    audit=0xC00000B7,
    allowed=(
        *(63, 64, 57, 80, 73, 62),  # read write close fstat ppoll lseek
        *(222, 226, 215, 214, 216, 233),  # mmap mprotect munmap brk mremap madvise
        *(134, 135, 139, 132),  # rt_sigaction rt_sigprocmask rt_sigreturn sigaltstack
        *(67, 66, 124, 101, 172),  # pread64 writev sched_yield nanosleep getpid
        *(206, 207),  # sendto recvfrom
        *(93, 94, 178, 98),  # exit exit_group gettid futex
        *(169, 113, 114, 115),  # gettimeofday clock_gettime clock_getres clock_nanosleep
        *(165, 123, 79, 278),  # getrusage sched_getaffinity newfstatat getrandom
    ),
    opens=((56, 2),),
    to_itself=(129, 131),
    prlimit=261,
)
ARCHITECTURES = {"x86_64": X86_64, "aarch64": AARCH64}

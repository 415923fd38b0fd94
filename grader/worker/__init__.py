"""The process in which a submission's code runs: standard library and cffi only, nothing of numpy.

`python -m grader.worker DESCRIPTOR` reads requests on a socket, and forks a fresh child for each
session; the child alone loads the library, so that a crash harms nothing else. Nothing that is
expected of the code comes here, and no verdict leaves. These files need nothing else of the
grader, and are all of it that stands beside a submission's code:

frames    what the sockets carry, for the parent too
shared    the memory that a child shares with the parent
session   the child's side: one loaded library
syscalls  the system calls that a submission may make
lockdown  what a process gives up before it runs a submission
__main__  the loop that forks children and buries them
"""

"""Shutting in other people's code, while it is compiled and while it runs.

bubble     bubblewrap's command lines
levels     strong, medium, portable: which one this machine can give
stage      the folder with everything that a worker may read
compiling  the compiler and the linker, shut in
trace      from addresses in a library to functions and lines
canary     proves a level by trying what must be refused
orphans    closes the grader's own process, and ends what is left behind
"""

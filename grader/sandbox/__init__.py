"""Shutting in other people's code, while it is compiled and while it runs.

bubblewrap    its command lines
levels        strong, medium, portable: which one this machine can give
leftovers     what submissions leave where no sandbox keeps it from them
scratch       temporary files that end with their process
surroundings  what programs read from the environment: none of it reaches them
staging       the folder with everything that a worker may read
tools         the compiler and the linker, shut in
orphans       closes the grader's own process, and ends what is left behind
"""

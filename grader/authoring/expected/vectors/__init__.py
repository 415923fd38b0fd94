"""The inputs of the expected data: seeded random ones, with the simple ones and the edges first.

One module for each TP; each says how its suites are made, each from random numbers of its own: a
suite that is added or changed leaves the files of the others as they are. What the reference
answers is put beside the inputs by `grader.authoring.expected.command`.
"""

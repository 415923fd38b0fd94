"""The inputs of the expected data: seeded random ones, with the simple ones and the edges first.

One module for each TP; each gives its suites. What the reference answers to them is put beside them
by `grader.authoring.expected.command`.
"""

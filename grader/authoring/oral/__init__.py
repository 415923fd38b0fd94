"""`make oral`: five questions on a person's own code for a talk of five minutes, with answers.

A known mistake (reference/mistakes/) is put into a line of their code that has it right; the code
so changed is graded and drawn, which gives the answer.
"""

from grader.authoring.oral.command import main

__all__ = ["main"]

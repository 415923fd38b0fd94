"""The checks by which students are graded, one file per TP; run by `python -m grader grade`."""

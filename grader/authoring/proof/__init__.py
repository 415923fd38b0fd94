"""The proof of the grader, `make prove`: mistakes lose points, right programs none, always."""

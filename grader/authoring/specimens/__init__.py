"""Submissions of every kind, with what must come of each: for the tests and the benchmarks."""

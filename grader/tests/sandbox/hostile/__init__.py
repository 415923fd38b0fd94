"""Hostile programs, and the tests that none of them gets anywhere."""

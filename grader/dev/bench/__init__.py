"""The rendering benchmarks."""

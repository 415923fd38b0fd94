"""A library loaded in a worker, calls with numpy arrays, and how a process ended."""

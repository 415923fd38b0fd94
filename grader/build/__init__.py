"""From C files to libraries: compiler, headers, targets, others' functions in their place."""

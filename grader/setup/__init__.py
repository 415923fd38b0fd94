"""What runs before any package is there, on the standard library: environment, doctor, update."""

"""expected."""

"""Makes and calibrates the expected pictures, from the reference and accepted readings of it."""

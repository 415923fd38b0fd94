"""What checks are written with: the submission, expected data, comparison, pictures, evidence."""

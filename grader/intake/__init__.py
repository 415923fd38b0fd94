"""From a path to a submission: archives, encodings, authors, and what was handed out."""

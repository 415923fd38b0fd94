"""From checks to results: pipeline.py is the list of the steps."""

"""`pytest grader/checks --submission PATH`: the checks alone, with pytest's own report.

Under `python -m grader` the plugin is there already, with a submission of its own.
"""

pytest_plugins = ["grader.evaluation.plugin"]

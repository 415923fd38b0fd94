"""The workbook's grader: builds a submission, runs it in a separate process, judges it, reports."""

__version__ = "0.1.0"

"""`python -m grader`."""

import sys

from grader.cli import main
from grader.isolation import orphans

orphans.guard()
try:
    sys.exit(main())
finally:
    orphans.sweep()

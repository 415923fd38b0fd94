"""`python -m grader`."""

import gc
import os
import sys

# Its threads would only wait, and take time to start: no matrix here is large.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from grader.commands import main
from grader.sandbox import orphans

gc.set_threshold(20_000)  # little of what a grade makes is garbage
orphans.guard()
try:
    sys.exit(main())
finally:
    orphans.sweep()

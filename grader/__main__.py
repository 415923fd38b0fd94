"""`python -m grader`."""

import gc
import os
import sys

from grader.sandbox import surroundings

surroundings.drop()
# Its threads would only wait, and take time to start: no matrix here is large.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from grader.commands import main  # noqa: E402  # begins again, maybe, before it is loaded
from grader.sandbox import orphans, scratch  # noqa: E402

gc.set_threshold(20_000)  # little of what a grade makes is garbage
orphans.guard()
scratch.use()
try:
    sys.exit(main())
finally:
    orphans.sweep()

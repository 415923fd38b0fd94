"""Becomes a command that reads and writes in named places only: see confined.py.

`python launch.py --read=PATH ... --write=PATH ... -- COMMAND...`, run from the stage, where the
worker's modules and cffi's compiled part are. Nothing is printed but by the command.
"""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

from grader.worker.lockdown import Lock


def main(words: list[str]) -> None:
    """Lock this process, then run the command in its place."""
    end = words.index("--")
    places = [word.partition("=") for word in words[:end]]
    names: dict[str, object] = {}
    exec(Path(__file__).with_name("lock_abi.py").read_bytes(), names)
    lock = Lock(names["ffi"])
    lock.hide()
    lock.only_files(
        [path for option, _, path in places if option == "--read"],
        [path for option, _, path in places if option == "--write"],
    )
    for each in (signal.SIGPIPE, signal.SIGXFSZ):  # Python's own doing, which would be inherited
        signal.signal(each, signal.SIG_DFL)
    os.execvp(words[end + 1], words[end + 1 :])


if __name__ == "__main__":
    main(sys.argv[1:])

"""JupyterLab while it runs: what it would tell the terminal goes to a file, and a few words stay.

Its own words are many, in English, and hide the address.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from grader.lab.display.words import say
from grader.setup.folding import put

SECONDS = 0.1  # between two looks for its address
# What it says of a cause that has a cure: a key of [lab] in messages/.
CAUSES = {
    "disk_full": ("No space left on device", "Disk quota exceeded"),
    "ports_taken": ("no available port could be found", "started because port"),
}
LAST_LINES = 5  # of what it said, when it does not start


def serve(
    line: Sequence[str], environment: Mapping[str, str], log: Path, path: str, *, quiet: bool
) -> int:
    """Run the command line of JupyterLab until it ends; return its exit code.

    `path` is what to open of it; `quiet`: it opens no browser itself. Raises OSError.
    """
    _tell("preparing")
    # Ctrl+C reaches JupyterLab too, which ends; so do we then. An ignored one would be inherited.
    asked: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: asked.append(number))
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("wb") as out:
        child = subprocess.Popen(line, env=environment, stdout=out, stderr=subprocess.STDOUT)
    signal.signal(signal.SIGTERM, lambda *_: child.terminate())
    runtime = Path(environment["JUPYTER_RUNTIME_DIR"]) / f"jpserver-{child.pid}.json"
    address = _address(child, runtime, path)
    if address:
        _tell("ready_quiet" if quiet else "ready", address=address)
        child.wait()
    if address or asked:
        _tell("closed")
        return 0 if asked else child.returncode
    said = log.read_text(encoding="utf-8", errors="replace")
    told = "\n  ".join(said.splitlines()[-LAST_LINES:])
    _tell("not_started", path=log, told=told)
    for key, words in CAUSES.items():
        if any(each in said for each in words):
            _tell(key)
    return child.returncode or 1


def _tell(key: str, **values: object) -> None:
    put(say(key, **values), sys.stdout)
    sys.stdout.flush()


def _address(child: subprocess.Popen[bytes], runtime: Path, path: str) -> str:
    """Return where it answers, with the key to it, as soon as it does; "" when it ends before."""
    while child.poll() is None:
        try:
            known = json.loads(runtime.read_text(encoding="utf-8"))
            key = f"?token={known['token']}" if known["token"] else ""
            return f"{known['url']}{path}{key}"
        except (OSError, ValueError):  # not there yet, or half of it
            time.sleep(SECONDS)
    return ""

"""What changed since the last full run: history.json, beside results.json.

Partial runs are not kept, nor those in which the grader failed. The file is a help, never a
condition: one that cannot be read is set aside under another name, and a new one begun.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from grader.evaluation.records import Outcome
from grader.report.results import Row, write

NAME = "history.json"
SCHEMA = 1
MOST = 50  # runs that are kept
_FIELDS: dict[str, type | tuple[type, ...]] = {
    "submission": str,
    "graded_at": str,
    "score": (int, float),
    "max_score": (int, float),
    "bonus": (int, float),
    "files": dict,
    "exercises": dict,
}


def update(folder: Path, content: dict[str, Any]) -> None:
    """Put `history`, `changes` and `same_files_as` into the content of results.json; keep the run.

    A partial run, whose folder lies in that of the full ones, is told what they found, `earlier`.
    Raises OSError when the file cannot be written.
    """
    if content["incomplete"]:
        return
    run = _run(content)
    runs = read(folder.parent if content["partial"] else folder)
    earlier = [each for each in runs if each["submission"] == run["submission"]]
    if content["partial"]:
        if earlier:
            found = earlier[-1]["exercises"].items()
            content["earlier"] = {name: each["outcome"] for name, each in found}
        return
    content["changes"] = changes(earlier, run)
    if earlier and earlier[-1]["files"] == run["files"]:
        content["same_files_as"] = earlier[-1]["graded_at"]
    kept = ("graded_at", "score", "max_score", "bonus")
    content["history"] = [{key: each[key] for key in kept} for each in (*earlier, run)]
    write(folder / NAME, {"schema": SCHEMA, "runs": [*runs, run][-MOST:]})


def read(folder: Path) -> list[Row]:
    """Return the runs that are kept in a folder, the oldest first; none when there is no file."""
    path = folder / NAME
    try:
        return _runs(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return []
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        path.replace(path.with_suffix(".unreadable"))
        return []


def changes(earlier: Sequence[Row], run: Row) -> list[dict[str, Any]]:
    """Return what is otherwise in a run, exercise by exercise, than in the runs before it.

    `kind` is "fixed" (it passes, and did not the last time), "broken" (it passed in an earlier run:
    at `before` for the last time; from `since` on it did not), "up" or "down" (of its points).
    """
    if not earlier:
        return []
    found = (_change(name, [*earlier, run]) for name in run["exercises"])
    return [each for each in found if each]


def _change(name: str, runs: Sequence[Row]) -> dict[str, Any] | None:
    known = [each for each in runs if name in each["exercises"]]
    now = known[-1]["exercises"][name]
    if len(known) < 2:
        return None
    last = known[-2]["exercises"][name]
    passed = Outcome.PASSED.value
    right = [k for k, each in enumerate(known) if each["exercises"][name]["outcome"] == passed]
    change: dict[str, Any] = {"exercise": name, "points": now["points"], "was": last["points"]}
    if now["outcome"] == passed:
        return None if last["outcome"] == passed else {**change, "kind": "fixed"}
    if right:
        moments = {"before": known[right[-1]], "since": known[right[-1] + 1]}
        times = {key: each["graded_at"] for key, each in moments.items()}
        return {**change, "kind": "broken", **times}
    if now["points"] == last["points"]:
        return None
    return {**change, "kind": "up" if now["points"] > last["points"] else "down"}


def _run(content: Mapping[str, Any]) -> Row:
    submission = content["submission"]
    # Two folders may have one name; where their files are tells them apart.
    places = [Path(each["path"]).parent.as_posix() for each in submission["sources"][:1]]
    return {
        "submission": " ".join([submission["name"], *places]),
        **{key: content[key] for key in ("graded_at", "score", "max_score", "bonus")},
        "files": submission["files"],
        "exercises": {
            each["id"]: {"outcome": each["outcome"], "points": each["points"]}
            for each in content["exercises"]
        },
    }


def _runs(data: Any) -> list[Row]:
    """Return the runs of a file's content. Raises TypeError, KeyError, ValueError."""
    if data["schema"] != SCHEMA:
        raise ValueError("another version")
    for run in data["runs"]:
        if any(not isinstance(run[key], kind) for key, kind in _FIELDS.items()):
            raise TypeError("malformed")
        for each in run["exercises"].values():
            if not isinstance(each["outcome"], str) or each["points"] != each["points"] + 0.0:
                raise TypeError("malformed")
    return list(data["runs"])

"""The flow goes one way: a later stage may import an earlier one, never the reverse."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

from grader.manifest import PACKAGE, ROOT

# From the first stage to the last; a module may import what stands on a line before its own.
STAGES = [
    ["__init__"],
    ["files", "npz", "records", "sizes"],
    ["manifest"],
    ["course", "originals", "archives", "authors", "diagnostics"],
    ["texts", "intake"],
    ["usage"],
    ["worker", "worker.frames"],
    ["worker.shared", "worker.syscalls"],
    ["worker.session"],
    ["worker.lockdown"],
    ["worker.__main__"],
    ["abi"],
    ["isolation", "isolation.bubble", "isolation.launch", "isolation.orphans"],
    ["isolation.levels", "isolation.stage"],
    ["isolation.confined"],
    ["isolation.trace"],
    ["channel", "offswitches"],
    ["control"],
    ["toolchain", "bind"],
    ["declared"],
    ["job", "dtypes", "process"],
    ["arguments", "build"],
    ["runner", "shapes", "substitute", "isolation.canary"],
    ["expected"],
    ["show", "testimony"],
    ["literals"],
    ["reproducer"],
    ["compare"],
    ["bounces", "canvas"],
    ["judge"],
    ["pictures", "pictures.plan", "pictures.measure", "pictures.neighbours"],
    ["pictures.stored", "pictures.whole", "pictures.views"],
    ["pictures.regions", "pictures.worst", "pictures.suspects"],
    ["pictures.causes"],
    ["pictures.judging"],
    ["replay", "replay.nodes", "replay.desk"],
    ["replay.maps", "replay.probe"],
    ["replay.case"],
    ["replay.search", "replay.bouncing"],
    ["replay.lighting", "replay.meeting", "replay.sampling"],
    ["replay.faults"],
    ["workshop", "checks", "checks.common"],
    ["checks.fresnel"],
    [
        *(f"checks.test_tp{tp}" for tp in range(1, 6)),
        "checks.test_tp2_bonus",
        "checks.test_tp5_bonus",
        "checks.test_scenes",
    ],
    ["deaths"],
    ["grading"],
    ["diagnosis", "retrial", "replay.pinpoint"],
    ["ahead", "outcomes"],
    ["plugin"],
    ["checks.conftest", "report", "notes"],
    ["history", "junit", "summary"],
    ["page.markup", "view"],
    ["page"],
    ["page.__main__"],
    ["lab.words", "lab.card"],
    ["lab.vectors", "lab.place", "lab.stopped", "lab.contracts"],
    ["lab.values", "lab.store", "lab.complaints"],
    ["lab.engine", "lab.picture"],
    ["lab.calls", "lab.comparing", "lab.making", "lab.scene"],
    ["lab.core", "lab.predictions", "lab.sliders", "lab.sources"],
    ["lab.plots", "lab.__main__"],
    ["lab.counting"],
    ["lab.inspector.looking"],
    ["lab.inspector.rows", "lab.inspector.space"],
    ["lab.inspector.widget"],
    ["lab.inspector"],
    ["lab.inspector.jump"],
    ["lab.checks"],
    ["lab.standing"],
    ["lab.tp1", "lab.tp2", "lab.tp3", "lab.tp4", "lab.tp4_octree", "lab.tp5"],
    ["lab"],
    ["terminal"],
    ["evaluation"],
    ["batch", "batch.records"],
    ["batch.gallery", "batch.temporary"],
    ["batch.unpacking", "batch.sheets", "batch.bundle", "batch.members", "batch.progress"],
    ["batch.finding", "batch.worker", "batch.crew", "batch.cluster", "batch.desk"],
    ["batch.reading", "batch.manual", "batch.marks", "batch.moodle", "batch.grades", "batch.purge"],
    ["batch.statistics"],
    ["batch.classpage"],
    ["batch.outputs"],
    ["batch.command"],
    ["handin"],
    ["grade"],
    ["cli"],
    ["__main__"],
]
# They stand beside the flow and run before any package is there.
APART = ["bilingual", "doctor", "environment", "handout", "install", "replace", "update"]


def modules() -> dict[str, Path]:
    """Return the grader's modules, but for its tests and generators, by their names within it."""
    found = {}
    for path in PACKAGE.rglob("*.py"):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        if parts[0] not in ("tests", "dev"):
            package = parts[-1] == "__init__" and len(parts) > 1
            found[".".join(parts[:-1] if package else parts)] = path
    return found


def imported(path: Path) -> set[str]:
    """Return the names of the grader's modules that a module imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("grader"):
            inside = (node.module or "").removeprefix("grader").lstrip(".")
            candidates = {f"{inside}.{each.name}".lstrip(".") for each in node.names}
            known = candidates & set(modules())
            names |= known or {inside or "__init__"}
        elif isinstance(node, ast.Import):
            names |= {
                each.name[7:] or "__init__" for each in node.names if each.name[:6] == "grader"
            }
    return names


def test_every_module_has_its_stage() -> None:
    """A new module must be given its place in the flow."""
    assert set(modules()) == {name for stage in STAGES for name in stage} | set(APART)


def test_no_stage_imports_a_later_one() -> None:
    """Each import goes to a line above."""
    rank = {name: number for number, stage in enumerate(STAGES) for name in stage}
    rank |= dict.fromkeys(APART, len(STAGES))
    for name, path in modules().items():
        for other in imported(path):
            if name not in APART:
                assert rank[other] < rank[name], f"{name} imports {other}"


def test_the_worker_needs_neither_numpy_nor_the_rest_of_the_grader() -> None:
    """What stands beside a submission's code is small, and knows nothing that is expected of it."""
    code = (
        "import sys; import grader.worker.__main__;"
        "print(*sorted(n for n in sys.modules if n.split('.')[0] in ('grader', 'numpy', 'pytest')))"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=True)
    modules = ["__main__", "frames", "lockdown", "session", "shared", "syscalls"]
    files = ["grader", "grader.worker", *(f"grader.worker.{each}" for each in modules)]
    assert done.stdout.split() == files

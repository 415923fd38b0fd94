"""Tells what this machine has for the workbook, and how to get what is missing.

Run by `make doctor` on any Python from 3.10 on: standard library only, nothing written here.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from grader.setup.sentences import say

ROOT = Path(__file__).resolve().parent.parent.parent
SECONDS = 30
TOOLS = ("apt", "dnf", "brew")
CONTAINERS = re.compile("docker|podman|libpod|kubepods|containerd|lxc|systemd-nspawn")

# What to install, by the system's package tool; a tool that is not named has no such package.
PACKAGES: dict[str, dict[str, str]] = {
    "gcc": {"apt": "gcc", "dnf": "gcc", "brew": "gcc"},
    "g++": {"apt": "g++", "dnf": "gcc-c++", "brew": "gcc"},
    "clang": {"apt": "clang", "dnf": "clang", "brew": "llvm"},
    "make": {"apt": "make", "dnf": "make", "brew": "make"},
    "sanitizers": {"apt": "gcc libc6-dev", "dnf": "libasan libubsan", "brew": "llvm"},
    "OpenMP": {"apt": "gcc", "dnf": "gcc libgomp", "brew": "libomp"},
    "libpng": {
        "apt": "libpng-dev pkg-config",
        "dnf": "libpng-devel pkgconf",
        "brew": "libpng pkgconf",
    },
    "venv": {"apt": "python3-venv", "dnf": "python3", "brew": "python"},
    "uv": {"dnf": "uv", "brew": "uv"},
    "bubblewrap": {"apt": "bubblewrap", "dnf": "bubblewrap"},
    "valgrind": {"apt": "valgrind", "dnf": "valgrind"},
    "gdb": {"apt": "gdb", "dnf": "gdb"},
    "addr2line": {"apt": "binutils", "dnf": "binutils", "brew": "binutils"},
}


@dataclass(frozen=True)
class Symptom:
    """One line of the report.

    Attributes
    ----------
    name
        What was looked for: a key of PACKAGES.
    detail
        Its version or its use here; empty when it is missing or does not work.
    purpose
        What it serves for, shown when it is missing.
    cure
        How to get it, when installing its package is not the answer.
    """

    name: str
    detail: str
    purpose: str
    cure: str = ""


def attempt(
    command: list[str], folder: Path | None = None
) -> subprocess.CompletedProcess[str] | None:
    """Run a command, in this folder or in another; None when it is not there or does not end."""
    try:
        return subprocess.run(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=SECONDS,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return None


def first_line(command: list[str]) -> str:
    """Return the first line that a command prints, empty when it fails or is not there."""
    done = attempt(command)
    if done is None or done.returncode != 0:
        return ""
    lines = [line.strip() for line in done.stdout.splitlines() if line.strip()]
    return lines[0] if lines else ""


def compiler() -> str:
    """Return the C compiler that the workbook uses: CC, else the first of cc, gcc, clang."""
    chosen = os.environ.get("CC", "").split()
    return chosen[0] if chosen else next(filter(shutil.which, ("cc", "gcc", "clang")), "cc")


def builds(flags: list[str], source: str = "int main(void) { return 0; }") -> str:
    """Return the flags, as text, when a tiny program builds with them and runs; else nothing."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "probe"
        program.with_suffix(".c").write_text(source + "\n", encoding="ascii")
        command = [compiler(), f"{program}.c", *flags, "-o", str(program)]
        try:
            for step in (command, [str(program)]):
                subprocess.run(
                    step,
                    stdin=subprocess.DEVNULL,
                    capture_output=True,
                    timeout=SECONDS,
                    check=True,
                )
        except (OSError, subprocess.SubprocessError):
            return ""
    return " ".join(flags)


def compilers() -> list[Symptom]:
    """Look for the compilers and make."""
    purpose = {
        "gcc": say("setup.use_gcc"),
        "g++": say("setup.use_gxx"),
        "clang": say("setup.use_clang"),
        "make": say("setup.use_make"),
    }
    return [Symptom(name, first_line([name, "--version"]), purpose[name]) for name in purpose]


def compiler_features() -> list[Symptom]:
    """Try what the compiler can do: sanitizers, OpenMP, PNG files."""
    sanitizers = builds(["-fsanitize=address,undefined"])
    openmp = ["-fopenmp"] if sys.platform != "darwin" else ["-Xpreprocessor", "-fopenmp", "-lomp"]
    png = first_line(["pkg-config", "--modversion", "libpng"])
    return [
        Symptom(
            "sanitizers",
            sanitizers,
            say("setup.use_sanitizers"),
        ),
        Symptom("OpenMP", builds(openmp), say("setup.use_openmp")),
        Symptom("libpng", png, say("setup.use_libpng")),
    ]


def python_tools() -> list[Symptom]:
    """Look for what makes the Python environment."""
    venv = importlib.util.find_spec("ensurepip") is not None
    return [
        Symptom("Python", f"{platform.python_version()} ({sys.executable})", ""),
        Symptom(
            "venv",
            "ensurepip" if venv else "",
            say("setup.use_venv"),
        ),
        Symptom(
            "uv",
            first_line(["uv", "--version"]),
            say("setup.use_uv"),
            cure="pip install --user uv",
        ),
    ]


def canary() -> str:
    """Return what the strongest isolation has failed to refuse, as sentences; "" when nothing.

    The canary runs as a submission does, so it needs the packages: without them nothing is said.
    """
    done = canary_run("strong")
    # It ends with 1 when something was permitted; with a trace of Python when it could not run.
    if done is None or done.returncode != 1:
        return ""
    return " ".join(done.stdout.splitlines()[1:])


def canary_run(*level: str) -> subprocess.CompletedProcess[str] | None:
    """Run the canary at a level, or at the best one that is possible here."""
    folders = [os.environ.get("MRT_ENV", ""), str(ROOT / ".venv")]
    pythons = [f"{folder}/bin/python" for folder in folders if folder]
    python = next(filter(shutil.which, pythons), sys.executable)
    return attempt([python, "-B", "-m", "grader.execution.canary", *level], ROOT)


def isolation() -> Symptom:
    """Try bubblewrap, which shuts in other people's code while it is graded."""
    purpose = say("setup.use_bubblewrap")
    if shutil.which("bwrap") is None:
        return Symptom("bubblewrap", "", purpose)
    user = [] if os.geteuid() == 0 else ["--unshare-user"]
    walls = [*user, "--unshare-pid", "--unshare-net", "--ro-bind", "/", "/"]
    if first_line(["bwrap", *walls, "echo", "ok"]) == "ok":
        permitted = canary()
        detail = "" if permitted else first_line(["bwrap", "--version"])
        return Symptom("bubblewrap", detail, purpose, permitted)
    cure = say("setup.no_namespaces")
    return Symptom("bubblewrap", "", purpose, cure)


def container(root: Path = Path("/")) -> str:
    """Return what kind of container this is; "" on a machine of its own, virtual or not."""
    for name, kind in ((".dockerenv", "docker"), ("run/.containerenv", "podman")):
        if (root / name).exists():
            return kind
    if "KUBERNETES_SERVICE_HOST" in os.environ:
        return "kubernetes"
    for name in ("run/systemd/container", "proc/1/cgroup"):
        with contextlib.suppress(OSError):
            found = CONTAINERS.search((root / name).read_text(encoding="utf-8", errors="replace"))
            if found:
                return found[0]
    return os.environ.get("container", "")  # noqa: SIM112 - systemd and podman write it so


def level() -> list[Symptom]:
    """Say which isolation submissions get here, by the canary; nothing without the packages."""
    done = canary_run()
    if done is None or done.returncode not in (0, 1) or not done.stdout:
        return []
    purpose = say("setup.not_shut_in")
    said = done.stdout.splitlines()
    shown = said[0].partition(":")[2].strip().rstrip(".")
    return [Symptom("isolation", shown if done.returncode == 0 else "", purpose, " ".join(said))]


def debuggers() -> list[Symptom]:
    """Look for the tools that find a fault in a program."""
    uses = {
        "valgrind": say("setup.use_valgrind"),
        "gdb": say("setup.use_gdb"),
        "addr2line": say("setup.use_addresses"),
    }
    return [Symptom(name, first_line([name, "--version"]), uses[name]) for name in uses]


def cure(finding: Symptom) -> str:
    """Return how to get what is missing, with this system's package tool."""
    if finding.cure:
        return finding.cure
    tool = next(filter(shutil.which, TOOLS), None)
    if tool is None:
        return say("setup.to_install")
    package = PACKAGES[finding.name].get(tool)
    if package is None:
        return say("setup.not_available")
    return f"{'' if tool == 'brew' else 'sudo '}{tool} install {package}"


def line(finding: Symptom) -> str:
    """Return a finding as one line of text."""
    if finding.detail:
        return f"OK      {finding.name:<11} {finding.detail}"
    missing = say("setup.missing")
    return f"{missing:<7} {finding.name:<11} {finding.purpose} → {cure(finding)}"


def main() -> int:
    """Print the report; return 0, whatever is missing."""
    groups: list[Callable[[], list[Symptom]]] = [
        compilers,
        compiler_features,
        python_tools,
        lambda: [isolation()],
        level,
        debuggers,
    ]
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # not every terminal has all of French
    kind = container()
    where = say("setup.container", kind=kind) if kind else "machine"
    print(f"{platform.system()} {platform.machine()} ({where})")
    for group in groups:
        for finding in group():
            print(line(finding))
    return 0


if __name__ == "__main__":
    sys.exit(main())

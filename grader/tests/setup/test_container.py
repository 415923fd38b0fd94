"""The container: its recipe, the command that builds it, and what the doctor says in one."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from grader.authoring import release
from grader.setup import doctor
from grader.tests.support.shell import ROOT, run, script

FOLDER = ROOT / ".devcontainer"
RELEASE = "bookworm"
KNOWN = {"FROM", "ARG", "ENV", "SHELL", "RUN", "COPY", "USER", "WORKDIR", "EXPOSE", "CMD"}


def instructions() -> list[tuple[str, str]]:
    """Return the Dockerfile's instructions with their arguments, in their order."""
    text = re.sub(r"^#.*\n", "", (FOLDER / "Dockerfile").read_text("utf-8"), flags=re.MULTILINE)
    lines = re.sub(r"\\\n", " ", text).splitlines()
    return [(each.split(" ", 1)[0], each.split(" ", 1)[1]) for each in lines if each.strip()]


def test_the_recipe_is_made_of_known_instructions() -> None:
    """Its files are there and may enter; it ends as an ordinary user, with a command in JSON."""
    found = instructions()
    assert found[0] == ("FROM", f"debian:{RELEASE}-slim")
    assert {name for name, _ in found} == KNOWN
    ignored = (ROOT / ".dockerignore").read_text("utf-8").splitlines()
    allowed = [each[1:] for each in ignored if each.startswith("!")]
    for sources in (words.split()[:-1] for name, words in found if name == "COPY"):
        for each in sources:
            assert (ROOT / each).is_file()
            assert any(Path(each).match(pattern) for pattern in allowed), each
    assert [words for name, words in found if name == "USER"] == ["student"]
    assert found[-1][0] == "CMD"
    assert json.loads(found[-1][1])[0] == "jupyter"


def packages() -> list[str]:
    """Return Debian's packages that the image has."""
    (line,) = (words for name, words in instructions() if "apt-get install" in words)
    words = line.partition("apt-get install")[2].partition("&&")[0].split()
    return [each for each in words if not each.startswith("-")]


@pytest.mark.long
def test_the_packages_are_debian_s() -> None:
    """The doctor's are among them: those of every tool that it looks for there, but uv."""
    wanted = {name for each in doctor.PACKAGES.values() for name in each.get("apt", "").split()}
    assert wanted - {"binutils"} <= {*packages()}  # gcc brings binutils
    if not shutil.which("apt-cache") or not run("apt-cache", "policy", "gcc", cwd=ROOT).stdout:
        pytest.skip("no apt, or no lists of packages here")
    known = run("apt-cache", "pkgnames", cwd=ROOT).stdout.split()
    assert [each for each in packages() if each not in known] == []


def test_the_editor_s_container_is_that_one() -> None:
    """With the extensions that the editor recommends elsewhere, as its ordinary user."""
    content = json.loads((FOLDER / "devcontainer.json").read_text("utf-8"))
    build = content["build"]
    assert (FOLDER / build["dockerfile"]).is_file()
    assert (FOLDER / build["context"]).resolve() == ROOT.resolve()
    assert ("USER", content["remoteUser"]) in instructions()
    advised = json.loads((ROOT / ".vscode" / "extensions.json").read_text("utf-8"))
    assert content["customizations"]["vscode"]["extensions"] == advised["recommendations"]


# ---- make image ---------------------------------------------------------------------------------


@pytest.mark.parametrize("language", ["fr", "en"])
@pytest.mark.parametrize("engines", [(), ("docker",), ("docker", "podman")])
def test_without_an_engine_that_answers_a_line_says_so(
    engines: tuple[str, ...], language: str, tmp_path: Path
) -> None:
    """It names which ones are there, and what to do; for an ordinary user."""
    for name in engines:
        script(tmp_path / name, "exit 1")
    tmp_path.chmod(0o755)
    done = run(
        *("/bin/sh", "grader/setup/image.sh"),
        cwd=ROOT,
        ordinary=True,
        PATH=str(tmp_path),
        MRT_LANG=language,
    )
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
    assert "make image" in done.stderr
    assert all(name in done.stderr for name in engines or ("docker", "podman"))


def test_the_engine_that_answers_builds_the_image(tmp_path: Path) -> None:
    """Docker has no service here, podman works; names and versions travel as one word."""
    script(tmp_path / "docker", "exit 1")
    script(tmp_path / "podman", f'printf "%s\\n" "$@" >{shlex.quote(str(tmp_path / "asked"))}')
    command = ("/bin/sh", "grader/setup/image.sh")
    done = run(*command, cwd=ROOT, PATH=str(tmp_path), IMAGE="my image", HUB="5.1.0")
    assert (done.returncode, done.stderr) == (0, "")
    asked = (tmp_path / "asked").read_text().splitlines()
    assert asked == [
        *("build", "--file", ".devcontainer/Dockerfile", "--tag", "my image"),
        *("--build-arg", "JUPYTERHUB=5.1.0", "."),
    ]
    assert (ROOT / asked[2]).is_file()


# ---- The doctor ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content", "kind"),
    [
        (".dockerenv", "", "docker"),
        ("run/.containerenv", "", "podman"),
        ("run/systemd/container", "lxc\n", "lxc"),
        ("proc/1/cgroup", "0::/kubepods/besteffort/pod1\n", "kubepods"),
        ("proc/1/cgroup", "12:cpu:/docker/0a1b\n", "docker"),
        ("proc/1/cgroup", "0::/init.scope\n", ""),
        ("etc/hostname", "machine\n", ""),
    ],
)
def test_the_doctor_tells_a_container_from_a_machine(
    name: str, content: str, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the files that engines leave."""
    for variable in ("container", "KUBERNETES_SERVICE_HOST"):
        monkeypatch.delenv(variable, raising=False)
    (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / name).write_text(content, encoding="utf-8")
    assert doctor.container(tmp_path) == kind


@pytest.mark.parametrize(
    ("code", "said", "detail", "cure"),
    [
        (0, "Isolation: medium (seccomp).\nwhy\n", "medium (seccomp)", None),
        (1, "Isolation: limits.\nIt can write.\n", "", "Isolation: limits. It can write."),
        (2, "", None, None),
    ],
)
def test_the_doctor_says_which_isolation_is_proved(
    code: int, said: str, detail: str | None, cure: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the canary has tried; without the packages, nothing."""
    done = subprocess.CompletedProcess(["canary"], code, said, "")
    monkeypatch.setattr(doctor, "canary_run", lambda *_: done)
    found = doctor.level()
    assert [each.detail for each in found] == ([] if detail is None else [detail])
    if cure:
        assert doctor.cure(found[0]) == cure


# ---- The recipe, run ----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def root() -> Iterator[Path]:
    """Return a bare Debian of the image's release, in a folder."""
    if os.geteuid() != 0 or not shutil.which("mmdebstrap") or not shutil.which("bwrap"):
        pytest.skip("needs root, mmdebstrap and bubblewrap")
    top = Path(tempfile.mkdtemp(prefix="mrt-image-"))
    words = ["mmdebstrap", "--variant=apt", RELEASE, str(top / "root")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=900, check=False)
    if done.returncode:
        pytest.skip(f"no Debian to be had: {done.stderr.splitlines()[-1]}")
    yield top / "root"
    shutil.rmtree(top)


def inside(root: Path, command: str, variables: Mapping[str, str], user: int = 0) -> str:
    """Run a command in the root, with this machine's network; return what it prints."""
    binds = ["--bind", str(root), "/", "--dev", "/dev", "--ro-bind", "/proc", "/proc"]
    binds += ["--ro-bind", os.path.realpath("/etc/resolv.conf"), "/etc/resolv.conf"]
    settings = {"PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin", **variables}
    if certificate := os.environ.get("PIP_CERT"):  # of a network with its own
        binds += ["--ro-bind", certificate, "/opt/certificate.crt"]
        settings["PIP_CERT"] = "/opt/certificate.crt"
    drop = ["setpriv", f"--reuid={user}", f"--regid={user}", "--clear-groups"] if user else []
    sets = [word for name, value in settings.items() for word in ("--setenv", name, value)]
    walls = ["bwrap", *binds, "--clearenv", *sets, "--cap-add", "ALL"]
    done = subprocess.run(
        [*walls, *drop, "/bin/sh", "-e", "-c", command],
        capture_output=True,
        text=True,
        timeout=1500,
        check=False,
    )
    assert done.returncode == 0, (command, done.stdout[-2000:], done.stderr[-2000:])
    return done.stdout


@pytest.mark.exhaustive
def test_the_recipe_makes_a_room_in_which_work_is_graded(root: Path) -> None:
    """Each RUN in its order; then a student's archive is graded there, by an ordinary user."""
    variables: dict[str, str] = {}
    for name, words in instructions():
        if name in ("ARG", "ENV"):
            found = dict(each.split("=", 1) for each in shlex.split(words))
            variables |= found
        elif name == "COPY":
            *sources, place = words.split()
            (root / place[1:]).mkdir(parents=True, exist_ok=True)
            for each in sources:
                shutil.copy(ROOT / each, root / place[1:])
        elif name == "RUN":
            inside(root, words, variables)
    home = root / "home" / "student"
    for path, data in release.handed_out(ROOT).items():
        (home / "tp" / path).parent.mkdir(parents=True, exist_ok=True)
        (home / "tp" / path).write_bytes(data)
    inside(root, "chown -R student: /home/student", {})
    variables |= {"HOME": "/home/student", "MRT_LANG": "en"}

    def student(command: str) -> str:
        return inside(root, f"cd /home/student/tp; {command}", variables, 1000)

    (root / ".dockerenv").touch()
    said = student("make doctor").splitlines()
    assert said[0].endswith("(docker container)")
    # Where the walls of bubblewrap cannot be built, as in most containers, the other level is told.
    missing = [line.split()[1] for line in said if line.startswith("missing")]
    assert {*missing} <= {"uv", "bubblewrap"}, said
    level = "medium" if "bubblewrap" in missing else "strong"
    assert any(line.startswith(f"OK      isolation   {level}") for line in said)
    assert "0 / 100" in student("make grade")
    student("cd notebooks/fr; python -c 'from grader.lab import Core'")
    assert student("jupyter lab --version")
    assert student("jupyterhub-singleuser --version")

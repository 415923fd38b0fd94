"""The measures: paired runs of ours and of its peers, counts, and octree against plain list."""

from __future__ import annotations

import statistics
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from grader.authoring.bench import programs, scenes
from grader.authoring.bench.programs import BenchError, Cost, Phase

SIZE = (1280, 720)
ROUNDS = 3
PEERS = ("povray", "tachyon")
# Without the octree every ray tries every object: pictures as small as the scene is large.
PLAIN_SIZES = {"small": (64, 36), "flake4": (64, 36), "flake5": (32, 18), "flake6": (16, 9)}
WORKLOAD = tuple(PLAIN_SIZES)
HANDOUT_SIZE = (320, 180)
# Rounds of octree against plain list; scene 3 has 1,024 spheres, and is slow without the tree.
HANDOUT_ROUNDS = {"0": 21, "1": 21, "2": 21, "3": 3, "4": 21}


@dataclass(frozen=True)
class Counts:
    """What one picture takes; bytes are those that octree.c asked malloc for."""

    objects: int
    rays: int  # of the camera, reflected and towards a light, as POV-Ray counts them
    tests: float  # of spheres, cylinders and cones per ray that is followed
    plane_tests: float
    octree_bytes: int
    build_bytes: int  # the most while building

    @property
    def bytes_per_object(self) -> float:
        """Bytes of the finished octree per object."""
        return self.octree_bytes / self.objects


@dataclass(frozen=True)
class Measured:
    """All about one scene: `costs` by program, round by round; ours is "mrt"."""

    name: str
    counts: Counts
    plain_tests: float  # per ray without the octree, counted on a smaller picture
    plain_seconds: float  # per million rays, without the octree, on that picture
    same_picture: bool  # with and without the octree, bit for bit
    costs: dict[str, list[Cost]]

    def median(self, program: str, phase: Phase) -> float:
        """Return the median of a program's rounds, CPU seconds."""
        return statistics.median(cost.seconds(phase) for cost in self.costs[program])

    def ratio(self, peer: str, phase: Phase) -> float:
        """Return the median of ours / the peer's, of the same round."""
        pairs = zip(self.costs["mrt"], self.costs[peer], strict=True)
        # A clock of a millisecond may say 0.
        return statistics.median(a.seconds(phase) / max(b.seconds(phase), 1e-3) for a, b in pairs)


def measure_all(folder: Path) -> tuple[list[Measured], dict[str, float]]:
    """Measure the workload's scenes; then the time with / without octree of scenes 0 to 4."""
    driver = programs.build_driver(folder, "driver", SIZE)
    counter = programs.build_driver(folder, "counter", SIZE, counting=True)
    peers = programs.installed(PEERS)
    measured = []
    for name in WORKLOAD:
        _tell(f"{name} ...")
        costs = _paired(driver, name, peers)
        measured.append(_measure(folder, counter, name, costs))
    _tell("scenes 0 to 4 ...")
    small = programs.build_driver(folder, "handout", HANDOUT_SIZE)
    return measured, {name: _octree_ratio(small, name) for name in HANDOUT_ROUNDS}


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _paired(driver: Path, name: str, peers: list[str]) -> dict[str, list[Cost]]:
    """Run ours and the peers in turn, so that a slow minute of the machine is shared by all."""
    draw: dict[str, Callable[[], Cost]] = {"mrt": lambda: programs.draw_ours(driver, name)}
    folder = driver.parent
    scene = programs.list_scene(driver, name)
    aspect = SIZE[0] / SIZE[1]
    if "povray" in peers:
        with (folder / "scene.pov").open("w", encoding="ascii") as out:
            scenes.write_povray(scene, out, aspect)
        draw["povray"] = lambda: programs.draw_povray(folder / "scene.pov", SIZE)
    if "tachyon" in peers:
        with (folder / "scene.dat").open("w", encoding="ascii") as out:
            scenes.write_tachyon(scene, out, aspect)
        draw["tachyon"] = lambda: programs.draw_tachyon(folder / "scene.dat", SIZE)
    costs: dict[str, list[Cost]] = {program: [] for program in draw}
    for _ in range(ROUNDS):
        for program, once in draw.items():
            costs[program].append(once())
    return costs


def _measure(folder: Path, counter: Path, name: str, costs: dict[str, list[Cost]]) -> Measured:
    size = PLAIN_SIZES[name]
    label = f"plain{size[0]}"
    drawer = programs.build_driver(folder, label, size)
    plain_counter = programs.build_driver(folder, f"{label}-counter", size, counting=True)
    plain = _numbers(drawer, name, "--plain")
    counts = count(_numbers(plain_counter, name, "--plain"))
    return Measured(
        name,
        count(_numbers(counter, name)),
        counts.tests,
        1e6 * plain["render_seconds"][0] / counts.rays,
        plain["picture"] == _numbers(drawer, name)["picture"],
        costs,
    )


def _numbers(driver: Path, *arguments: str) -> dict[str, list[float]]:
    return programs.parse_numbers(programs.run([driver, *arguments], driver.parent).text)


def count(numbers: dict[str, list[float]]) -> Counts:
    """Return the counts of a driver that counts. Raises BenchError when it says none."""
    try:
        followed = sum(numbers["rays"])
        cast = ("camera_rays", "reflected_rays", "shadow_rays")
        return Counts(
            int(numbers["objects"][0]),
            int(sum(sum(numbers[each]) for each in cast)),
            sum(numbers["tests"]) / followed,
            sum(numbers["plane_tests"]) / followed,
            int(numbers["octree_bytes"][0]),
            int(numbers["build_bytes"][0]),
        )
    except (KeyError, ZeroDivisionError) as error:
        raise BenchError(f"the counting driver says nothing of {error}") from None


def _octree_ratio(driver: Path, name: str) -> float:
    numbers = _numbers(driver, name, "--compare", str(HANDOUT_ROUNDS[name]))
    pairs = zip(numbers["octree"], numbers["plain"], strict=True)
    return statistics.median(octree / plain for octree, plain in pairs)

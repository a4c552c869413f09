"""The recordings that are checked: shipped, simulated, made here, and real ones where they are."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import program
import scenes
import writing
from program import Crosscut, Ran


@dataclass(frozen=True)
class Flight:
    name: str
    path: Path
    walls: tuple[int, ...] | None = None  # of each scan, where the scenes are made to be clear


@dataclass(frozen=True)
class Outcome:
    """What a run with the paper's settings made."""

    ran: Ran
    lines: list[dict]
    rrd: Path


SCENARIO = "tee"
CLEAR_SCENES = 100


class Flights:
    def __init__(self, root: Path, crosscut: Crosscut, work: Path):
        self.crosscut = crosscut
        self.work = work
        self.data = root / "../shared/data"
        self._shipped = root / "recordings"
        work.mkdir(parents=True, exist_ok=True)

    @cache
    def all(self) -> list[Flight]:
        return [*self.shipped(), self.simulated(seed=11), self.simulated(seed=12), self.clear(), *self.real()]

    @cache
    def shipped(self) -> list[Flight]:
        return [Flight(path.stem, path) for path in sorted(self._shipped.glob("*.mcap"))]

    @cache
    def real(self) -> list[Flight]:
        """Real corridors; none where they are not on this machine."""
        return [Flight(path.stem, path) for path in sorted(self.data.glob("corridor_*.mcap"))]

    @cache
    def bags(self) -> list[Path]:
        """Real bags of ROS 1; none where they are not on this machine."""
        return sorted(self.data.glob("*.bag"))

    @cache
    def simulated(self, seed: int) -> Flight:
        path = self.work / f"{SCENARIO}_{seed}.mcap"
        self.crosscut("simulate", SCENARIO, "--seed", seed, "--out", path).expect(0)
        return Flight(path.stem, path)

    @cache
    def clear(self) -> Flight:
        path = self.work / "clear_junctions.mcap"
        made = scenes.clear_junctions(CLEAR_SCENES, seed=5)
        writing.write_ros2(path, made)
        return Flight(path.stem, path, tuple(scene.walls for scene in made))

    @cache
    def outcome(self, flight: Flight) -> Outcome:
        rrd = self.work / f"{flight.name}.rrd"
        ran = self.crosscut.results(flight.path, "--save", rrd).expect(0)
        return Outcome(ran, program.lines(ran.stdout), rrd)

"""Real scans of SICK lidars, 180° wide and up to 82 m far, of corridors and offices: CARMEN logs, written as laser scans
here, go through the program. Nobody has labelled what is seen in them, but a vehicle that stands sees the same walls."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

import writing
from flights import Flights
from program import lines
from verdicts import Verdicts

# The messages of a FLASER tell no geometry: half a turn, as SICK lidars see.
FIRST_RAD, STEP_RAD = -np.pi / 2, np.pi / 180
LEAST_ALIKE = 0.7


@dataclass(frozen=True)
class Scan:
    first_rad: float
    step_rad: float
    range_max_m: float
    ranges_m: np.ndarray
    pose: tuple[str, ...]  # of the vehicle, as it is written; the same as before where it stands


def check(flights: Flights, verdicts: Verdicts):
    logs = sorted(flights.data.glob("*.clf"))
    if not logs:
        verdicts.skipped("CARMEN logs", f"not in {flights.data}")
        return
    folder = flights.work / "carmen"
    folder.mkdir(exist_ok=True)
    alike, pairs = 0, 0
    for log in logs:
        scans = list(scans_of(log))
        path = folder / f"{log.stem}.mcap"
        writing.write_scans(path, ((s.first_rad, s.step_rad, s.range_max_m, s.ranges_m) for s in scans))
        results = lines(flights.crosscut.results(path, preset="default").expect(0).stdout)
        told = [scan.ranges_m < scan.range_max_m for scan in scans]
        right = [np.array_equal(np.array(line["labels"]) != -1, seen) for line, seen in zip(results, told)]
        verdicts.that(
            len(results) == len(scans) and all(right),
            log.stem,
            f"{len(scans)} scans of {min(map(len, told))} to {max(map(len, told))} beams, a label where one came back",
        )
        stands = [before.pose == after.pose for before, after in pairwise(scans)]
        same = [a["junctions"] == b["junctions"] for a, b in pairwise(results)]
        alike += sum(s and still for s, still in zip(same, stands))
        pairs += sum(stands)
    share = alike / pairs
    verdicts.that(share >= LEAST_ALIKE, "a standing vehicle counts alike", f"{share:.0%} of {pairs} pairs of scans")


def scans_of(log: Path) -> Iterator[Scan]:
    messages = [line.split() for line in log.read_text().splitlines()]
    # A FLASER does not tell the range limit: it is what beams tell that met nothing.
    told_m = (float(m) for kind, *fields in messages if kind == "FLASER" for m in fields[1 : 1 + int(fields[0])])
    range_max_m = max(told_m, default=np.inf)
    for kind, *fields in messages:
        if kind == "FLASER":
            count = int(fields[0])
            ranges_m = np.array(fields[1 : 1 + count], dtype=np.float64)
            yield Scan(FIRST_RAD, STEP_RAD, range_max_m, ranges_m, tuple(fields[1 + count : 4 + count]))
        elif kind == "ROBOTLASER1":
            first_rad, _, step_rad, farthest_m = map(float, fields[1:5])
            count = int(fields[7])
            ranges_m = np.array(fields[8 : 8 + count], dtype=np.float64)
            remissions = int(fields[8 + count])
            pose = fields[9 + count + remissions :][:3]
            yield Scan(first_rad, step_rad, farthest_m, ranges_m, tuple(pose))

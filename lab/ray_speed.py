"""Times an archive on Ray beside plain processes, as many at a time: `lab/run ray_speed FLIGHT...`.

Both run the same flights by the same function, in turn; a round of each goes first. Times are from the first task to the table,
in a cluster on this machine that has started. The ratio of the least times is what Ray adds.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import ray

import crosscut.ray
from crosscut._program import COMMAND

REPETITIONS = 5
FLIGHTS = 12
WORKERS = os.cpu_count() or 1


def side_by_side(work: list[tuple[Any, ...]]) -> Iterable[dict[str, Any]]:
    """As the tasks of the cluster, in threads that wait for their processes."""
    with ThreadPoolExecutor(WORKERS) as pool:
        yield from pool.map(lambda arguments: crosscut.ray._process(*arguments), work)


def seconds(flights: list[Path], rows: Any) -> float:
    with tempfile.TemporaryDirectory() as out:
        start = time.perf_counter()
        table = crosscut.ray._gather(flights, Path(out), list(COMMAND), [], rows)
        elapsed_s = time.perf_counter() - start
    assert table["code"].to_pylist() == [0] * len(flights), table["error"]
    return elapsed_s


def main(recordings: list[str]) -> None:
    ray.init("local", num_cpus=WORKERS, include_dashboard=False, log_to_driver=False)
    print(f"{FLIGHTS} flights, {WORKERS} at a time, {REPETITIONS} times")
    for recording in recordings:
        with tempfile.TemporaryDirectory() as folder:
            flights = [Path(folder) / f"flight{number}.mcap" for number in range(FLIGHTS)]
            for flight in flights:
                flight.symlink_to(Path(recording).absolute())
            pairs = [(seconds(flights, side_by_side), seconds(flights, crosscut.ray._on_ray(None)))
                     for _ in range(REPETITIONS + 1)][1:]
        plain_s, on_ray_s = (min(times) for times in zip(*pairs, strict=True))
        ratios = ", ".join(f"{ratio:.3f}" for ratio in sorted(on_ray_s / plain_s for plain_s, on_ray_s in pairs))
        print(f"{Path(recording).name}: processes {plain_s / FLIGHTS:.3f} s a flight, Ray {on_ray_s / FLIGHTS:.3f} s, "
              f"{on_ray_s / plain_s:.3f} times; of each pair {ratios}; load {os.getloadavg()[0]:.1f}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

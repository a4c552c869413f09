"""scikit-learn's SpectralClustering and crosscut on the same scans, in turn, in one run. Started by `lab/run speed`.

crosscut: from returns to junctions, by its bench of one revolution (one thread, no input or output); scikit-learn: from the same
returns to labels, k given. They take turns, as a machine is slower at one moment than at the next, and each has its least time:
of every revolution, then the median of each family. scikit-learn's is processor time: what takes longer than a turn of the
scheduler would be charged for the others'.

`lab/run speed cloud` times preset 3d and scikit-learn on the points of the same clouds, once for each number of points: with a W of 10
neighbours, and with a dense W of 4,096 of the points. Its clusters of points are no ways on, whose number is given to it."""

import argparse
import csv
import io
import json
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
from sklearn.cluster import SpectralClustering

import oracle
import program
import scans

ROOT = Path(__file__).parents[1]
FAMILIES = [
    "clean6", "clean35", "sparse", "wet", "narrow", "dust", "rough", "offcentre", "dense720", "view255", "view180",
    "pillars", "flight_tunnel", "flight_mine",
]  # fmt: skip
REVOLUTIONS = 100
PASSES = 7
SIGMA_PER_M2 = 1.5
# The time of a dense W grows with the third power of the number of points.
MOST_DENSE = 4096


def main() -> int:
    parser = argparse.ArgumentParser(prog="lab/run speed", description=__doc__)
    parser.add_argument("families", nargs="*", default=FAMILIES)
    args = parser.parse_args()
    if args.families == ["cloud"]:
        return clouds()
    crosscut = program.Crosscut(ROOT / "target/release/crosscut")
    work = ROOT / "target/foreign/work/speed"
    print(f"{'family':<14}{'returns':>8}{'sklearn ms':>12}{'crosscut ms':>13}{'ratio':>8}{'floor ms':>10}{'x floor':>9}")
    for family in args.families or FAMILIES:
        crosscut("simulate", "--suite", family, "--split", "dev", "--out", work).expect(0)
        (recording,) = work.glob(f"**/{family}*.mcap")
        problems = posed(crosscut, recording)
        benches, theirs_s = [], []
        for _ in range(PASSES):
            benches.append(bench(recording))
            theirs_s.append([seconds_of_sklearn(*problem) for problem in problems])
        theirs_ms = 1e3 * np.median(np.min(theirs_s, axis=0))
        returns = np.median([len(points_m) for points_m, _ in problems])
        rows = min(benches, key=lambda rows: float(rows["default"]["total_us"]))
        default, floor = rows["default"], rows["floor"]
        ours_ms, steps = float(default["total_us"]) / 1e3, ("affinity_us", "spectral_us", "kmeans_us")
        least_us = float(floor["affinity_us"]) + float(floor["spectral_us"])
        print(
            f"{family:<14}{returns:>8.0f}{theirs_ms:>12.2f}{ours_ms:>13.3f}{theirs_ms / ours_ms:>8.0f}"
            f"{least_us / 1e3:>10.3f}{sum(float(default[step]) for step in steps) / least_us:>9.1f}",
            flush=True,
        )
    return 0


def clouds() -> int:
    command = ["cargo", "run", "--quiet", "--release", "-p", "crosscut-affinity", "--example", "directions_speed"]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    print(f"{'points':>7}{'ways':>6}{'crosscut ms':>13}{'sklearn sparse ms':>19}{'sklearn dense ms':>18}")
    for count, ways, ours_ms in (map(float, line.split()) for line in done.stdout.splitlines()[1:]):
        points_m = crossing(int(count) // 512)
        dense_ms = 1e3 * seconds_of_sklearn(points_m[:: len(points_m) // MOST_DENSE], int(ways))
        sparse_ms = 1e3 * seconds_of_sklearn(points_m, int(ways), affinity="nearest_neighbors", n_neighbors=10)
        print(f"{count:>7.0f}{ways:>6.0f}{ours_ms:>13.1f}{sparse_ms:>19.0f}{dense_ms:>18.0f}", flush=True)
    return 0


def crossing(rings: int) -> np.ndarray:
    """The points of the example directions_speed."""
    elevation_rad = (np.repeat(np.arange(rings), 512) + 0.5) / rings * np.pi - np.pi / 2
    bearing_rad = np.tile(np.arange(512), rings) / 512 * 2 * np.pi
    towards = np.stack([np.cos(elevation_rad) * np.cos(bearing_rad), np.cos(elevation_rad) * np.sin(bearing_rad), np.sin(elevation_rad)])
    sides_m = 2 / np.maximum(np.abs(towards[:2]).min(axis=0), 1e-9)
    return (towards * np.minimum(np.minimum(sides_m, 1.5 / np.abs(towards[2])), 80)).T


def bench(recording: Path) -> dict[str, dict[str, str]]:
    """Rows of the bench by method."""
    command = ["cargo", "bench", "--quiet", "-p", "crosscut-detector", "--bench", "revolution", "--"]
    done = subprocess.run([*command, "default", "floor", recording], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    rows = csv.reader(io.StringIO(done.stdout))
    header, *rows = [[cell.strip() for cell in row] for row in rows if row]
    return {row[1]: dict(zip(header, row)) for row in rows}


def posed(crosscut: program.Crosscut, recording: Path) -> list[tuple[np.ndarray, int]]:
    """Points and k of the revolutions that the bench takes."""
    results = crosscut.results(recording, preset="default").expect(0).stdout
    lines, read = [json.loads(line) for line in results.splitlines()], scans.read(recording)
    step = -(-len(read) // REVOLUTIONS)
    return [(oracle.points_of(scan), max(1, line["junctions"])) for scan, line in list(zip(read, lines))[::step]]


def seconds_of_sklearn(points_m: np.ndarray, k: int, **settings: str | int) -> float:
    settings = {"affinity": "rbf", "gamma": SIGMA_PER_M2, **settings}
    method = SpectralClustering(n_clusters=k, eigen_solver="arpack", n_init=1, random_state=0, **settings)
    start = time.process_time()
    method.fit(points_m)
    return time.process_time() - start


if __name__ == "__main__":
    warnings.filterwarnings("ignore")  # a graph that is nearly not connected, which is the point
    sys.exit(main())

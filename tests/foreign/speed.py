"""scikit-learn's SpectralClustering and crosscut on the same scans, in turn, in one run. Started by `run speed`.

crosscut: from returns to junctions, by its bench of one revolution (one thread, no input or output); scikit-learn: from the same
returns to labels, k given. Of every revolution the least of several times, then the median of each
family. scikit-learn's is processor time: what takes longer than a turn of the scheduler would be charged for the others'."""

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

FAMILIES = [
    "clean6", "clean35", "sparse", "wet", "narrow", "dust", "rough", "offcentre", "dense720", "view255", "view180",
    "pillars", "flight_tunnel", "flight_mine",
]  # fmt: skip
REVOLUTIONS = 100
PASSES = 7
SIGMA_PER_M2 = 1.5


def main() -> int:
    parser = argparse.ArgumentParser(prog="tests/foreign/run speed", description=__doc__)
    parser.add_argument("--root", type=Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("families", nargs="*", default=FAMILIES)
    args = parser.parse_args()
    args.root = args.root.resolve()
    crosscut = program.Crosscut(args.root / "target/release/crosscut")
    work = args.root / "target/foreign/work/speed"
    print(f"{'family':<14}{'returns':>8}{'sklearn ms':>12}{'crosscut ms':>13}{'ratio':>8}{'floor ms':>10}{'x floor':>9}")
    for family in args.families or FAMILIES:
        crosscut("simulate", "--suite", family, "--split", "dev", "--out", work).expect(0)
        (recording,) = work.glob(f"**/{family}*.mcap")
        rows = bench(args.root, recording)
        theirs_ms, returns = sklearn_ms(crosscut, recording)
        default, floor = rows["default"], rows["floor"]
        ours_ms, steps = float(default["total_us"]) / 1e3, ("affinity_us", "spectral_us", "kmeans_us")
        least_us = float(floor["affinity_us"]) + float(floor["spectral_us"])
        print(
            f"{family:<14}{returns:>8.0f}{theirs_ms:>12.2f}{ours_ms:>13.3f}{theirs_ms / ours_ms:>8.0f}"
            f"{least_us / 1e3:>10.3f}{sum(float(default[step]) for step in steps) / least_us:>9.1f}",
            flush=True,
        )
    return 0


def bench(root: Path, recording: Path) -> dict[str, dict[str, str]]:
    """Rows of the bench by method."""
    command = ["cargo", "bench", "--quiet", "-p", "crosscut-pipeline", "--bench", "revolution", "--"]
    done = subprocess.run([*command, "default", "floor", recording], cwd=root, stdout=subprocess.PIPE, text=True, check=True)
    rows = csv.reader(io.StringIO(done.stdout))
    header, *rows = [[cell.strip() for cell in row] for row in rows if row]
    return {row[1]: dict(zip(header, row)) for row in rows}


def sklearn_ms(crosscut: program.Crosscut, recording: Path) -> tuple[float, float]:
    """Median over revolutions of the least time, and of the number of returns."""
    results = crosscut.results(recording, preset="default").expect(0).stdout
    lines, read = [json.loads(line) for line in results.splitlines()], scans.read(recording)
    step = -(-len(read) // REVOLUTIONS)
    least_ms, returns = [], []
    for scan, line in list(zip(read, lines))[::step]:
        points_m, k = oracle.points_of(scan), max(1, line["junctions"])
        method = SpectralClustering(
            n_clusters=k, affinity="rbf", gamma=SIGMA_PER_M2, eigen_solver="arpack", n_init=1, random_state=0
        )
        times_s = []
        for _ in range(PASSES):
            start = time.process_time()
            method.fit(points_m)
            times_s.append(time.process_time() - start)
        least_ms.append(1e3 * min(times_s))
        returns.append(len(points_m))
    return float(np.median(least_ms)), float(np.median(returns))


if __name__ == "__main__":
    warnings.filterwarnings("ignore")  # a graph that is nearly not connected, which is the point
    sys.exit(main())

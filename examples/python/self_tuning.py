"""A self-tuning affinity (Zelnik-Manor and Perona, 2004) against `default` and `paper`, over simulated scenes with truth.

    python examples/python/self_tuning.py [SUITE|FLIGHT.mcap]...      suites are those of `crosscut simulate --list`
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

NEIGHBOUR = 7  # whose distance is the scale of a return, as in their paper
LEAST_M = 0.01


def self_tuning(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """W_ij = exp(-d_ij² / (s_i s_j)), s_i the distance of return i to its seventh neighbour."""
    distance_m = np.sqrt(np.square(points[:, None] - points).sum(axis=2))
    scale_m = np.sort(distance_m, axis=0)[min(NEIGHBOUR, len(points) - 1)]
    scale_m = np.maximum(scale_m, LEAST_M)
    return np.exp(-np.square(distance_m) / np.outer(scale_m, scale_m))


# The command line finds the function by its module and name. Its eigenvalues lie elsewhere than those of the paper's
# affinity, so its zero tolerance does too.
MINE = "self_tuning=paper,affinity.kind=python:self_tuning.self_tuning,spectral.zero_tolerance=1e-3"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=["clean35", "dust", "pillars"])
    crosscut = [sys.executable, "-m", "crosscut"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        flights = []
        for scenes in parser.parse_args().scenes:
            if not Path(scenes).exists():
                subprocess.run([*crosscut, "simulate", "--suite", scenes, "--out", folder / scenes, "--quiet"], check=True)
            flights.append(folder / scenes if not Path(scenes).exists() else Path(scenes).resolve())
        configurations = ["--with", "default", "--with", "paper", "--with", MINE]
        found_here = os.environ | {"PYTHONPATH": os.pathsep.join([str(Path(__file__).resolve().parent), *sys.path])}
        subprocess.run([*crosscut, "compare", *flights, *configurations], check=True, cwd=folder, env=found_here)


if __name__ == "__main__":
    main()

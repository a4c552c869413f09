"""The lowest eigenvalues of one scan by hand with numpy, equal to those of preset `paper`.

    python examples/python/by_hand.py [FLIGHT.bag [SCAN]]
"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import numpy as np

import crosscut

SHIPPED = Path(__file__).parents[2] / "recordings" / "tee.mcap"
SIGMA_PER_M2 = 1.5
ZERO = 1e-7


def main(path: Path = SHIPPED, number: int = 80) -> None:
    engine = crosscut.Engine("paper", keep=("W", "L"))
    scan = next(itertools.islice(engine.read(path), number, None))
    result = engine.process(scan)

    # Equation (1): the affinity of two returns falls with their distance.
    x = scan.points
    w = np.exp(-SIGMA_PER_M2 * np.square(x[:, None] - x).sum(axis=2))
    # Equation (2): the normalised Laplacian.
    degrees = w.sum(axis=0)
    laplacian = np.eye(len(x)) - w / np.sqrt(np.outer(degrees, degrees))
    # Equation (3): its eigenvalues; as many are zero as there are walls.
    eigenvalues = np.linalg.eigvalsh(laplacian)
    walls = int((eigenvalues < ZERO).sum())

    print(f"scan {result.seq} of {path.name}: {len(x)} returns")
    print(f"W differs by {np.abs(w - result.W).max():.0e}, L by {np.abs(laplacian - result.L).max():.0e}")
    lowest = eigenvalues[: len(result.eigenvalues)]
    print(f"eigenvalues differ by {np.abs(lowest - result.eigenvalues).max():.0e}: {lowest[: walls + 1]}")
    print(f"walls: {walls} by hand, {result.k} by crosscut")


if __name__ == "__main__":
    main(*(kind(text) for kind, text in zip((Path, int), sys.argv[1:])))

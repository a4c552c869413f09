"""Stages for the tests, also by name."""

from __future__ import annotations

import itertools
import sys
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]

NO_FUNCTION = 3


def rbf(points: Matrix) -> Matrix:
    """Equation (1) of the paper."""
    return np.exp(-1.5 * np.square(points[:, None] - points).sum(axis=2))


def sparse(points: Matrix) -> Any:
    """The same, without what is nearly 0."""
    from scipy.sparse import csr_array

    w = rbf(points)
    return csr_array(np.where(w > 1e-12, w, 0.0))


def eigen(w: Matrix) -> tuple[Matrix, Matrix]:
    """Equations (2) and (3)."""
    scale = 1.0 / np.sqrt(w.sum(axis=0))
    eigenvalues, vectors = np.linalg.eigh(np.eye(len(w)) - scale[:, None] * w * scale)
    return eigenvalues, vectors[:, : int((eigenvalues < 1e-7).sum())]


def nearest_row(u: Matrix, k: int) -> NDArray[np.int64]:
    """Rows of one direction are of one cluster."""
    unit = u / np.linalg.norm(u, axis=1, keepdims=True)
    alike = np.abs(unit @ unit.T) > 0.9
    return alike.argmax(axis=1)


def failing(points: Matrix) -> Matrix:
    """Fails on the eighth call."""
    if next(calls) == 8:
        raise ValueError("seven were enough")
    return rbf(points)


def hanging(points: Matrix) -> Matrix:
    """Never returns on the eighth call, and says so."""
    if next(calls) == 8:
        print("hanging", file=sys.stderr, flush=True)
        while True:
            pass
    return rbf(points)


calls = itertools.count(1)
"""The next call of either; threads share it."""


def slow_rows(u: Matrix, k: int) -> NDArray[np.int64]:
    """Takes a while."""
    time.sleep(0.03)
    return nearest_row(u, k)


def slower_rows(u: Matrix, k: int) -> NDArray[np.int64]:
    """Takes longer than an interrupted interpreter waits for its children; file ``begun`` has a byte for each call."""
    with open("begun", "a") as begun:
        begun.write(".")
    time.sleep(0.6)
    return nearest_row(u, k)

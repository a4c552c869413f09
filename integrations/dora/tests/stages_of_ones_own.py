"""Stages in Python for the tests, by name."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


def rbf(points: Matrix) -> Matrix:
    """Equation (1) of the paper."""
    return np.exp(-1.5 * np.square(points[:, None] - points).sum(axis=2))


def nearest_row(u: Matrix, k: int) -> NDArray[np.int64]:
    """Rows of one direction are of one cluster."""
    unit = u / np.linalg.norm(u, axis=1, keepdims=True)
    alike = np.abs(unit @ unit.T) > 0.9
    return alike.argmax(axis=1)


def slow_rows(u: Matrix, k: int) -> NDArray[np.int64]:
    """Takes a while."""
    time.sleep(0.03)
    return nearest_row(u, k)

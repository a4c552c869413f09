"""Tests for stages of one's own: what the rest of the program relies on.

    def test_my_affinity() -> None:
        crosscut.testing.check_affinity(my_affinity)

Each raises an ``AssertionError`` that says what is wrong. Inputs are random and the same in every run.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from . import _native
from ._engine import Engine
from ._errors import StageError

__all__ = ["check_affinity", "check_kmeans", "check_spectral"]


def check_affinity(affinity: Callable[..., Any]) -> None:
    """Holds ``affinity(points) -> W`` to the tests that every affinity of the program passes.

    W is (n, n) and symmetric to the last bit, 0 <= W_ij <= 1, W_ii = 1, for few points and for points in one place too, and
    the same points give the same bits whatever was seen before.
    """
    _native.check_affinity(affinity)
    print("ok: shape (n, n), symmetric to the bit, 0 <= W <= 1, W_ii = 1, repeatable; for 0 to 80 points")


def check_spectral(spectral: Callable[..., Any]) -> None:
    """Holds ``spectral(W) -> (eigenvalues, U)`` to shapes, finite numbers and repeated answers; n from 1 to 60."""
    _check(lambda: Engine("paper", spectral=spectral, keep=("U",)))


def check_kmeans(kmeans: Callable[..., Any]) -> None:
    """Holds ``kmeans(U, k) -> labels`` to a whole number for each row, and repeated answers; n from 1 to 60."""
    _check(lambda: Engine("paper", kmeans=kmeans, keep=("U",)))


def _check(make: Callable[[], Engine]) -> None:
    random = np.random.default_rng(1)
    used = make()
    for n in (1, 2, 3, 40, 60, 20):
        points = random.uniform(-10.0, 10.0, (n, 2)).round(0 if n == 40 else 3)  # some of the 40 in one place
        try:
            answers = [used.process(points), used.process(points), make().process(points)]
        except StageError as error:
            raise AssertionError(f"of {n} returns: {error}") from error
        if not answers[0] == answers[1] == answers[2]:  # an assert is left out by python -O
            raise AssertionError(f"of {n} returns: the same returns gave another answer")

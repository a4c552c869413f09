"""The paper's Algorithm 1 in numpy and scikit-learn, after the contract and not after the program's source."""

from dataclasses import dataclass

import numpy as np
from sklearn.cluster import KMeans

from scans import Scan

EPSILON = np.finfo(float).eps


@dataclass(frozen=True)
class Spectrum:
    laplacian: np.ndarray  # n×n
    eigenvalues: np.ndarray  # n, ascending
    vectors: np.ndarray  # n×n, columns
    tolerance: float

    @property
    def n(self) -> int:
        return len(self.eigenvalues)

    @property
    def k(self) -> int:
        return int(np.sum(self.eigenvalues < self.tolerance))

    @property
    def u(self) -> np.ndarray:
        return self.vectors[:, : self.k]

    @property
    def rounding(self) -> float:
        """What two backward stable solvers may differ by, with room."""
        return 100 * self.n * EPSILON

    @property
    def k_is_beyond_doubt(self) -> bool:
        return bool(np.all(np.abs(self.eigenvalues - self.tolerance) > self.rounding))

    @property
    def margin_decades(self) -> float:
        return margin_decades(self.eigenvalues, self.n, self.k, self.tolerance)


def margin_decades(eigenvalues, n: int, k: int, tolerance: float) -> float | None:
    """The contract's margin; `None` at n = 0."""
    sides = []
    if k > 0:
        sides.append(np.log10(tolerance / max(eigenvalues[k - 1], n * EPSILON)))
    if k < n:
        sides.append(np.log10(eigenvalues[k] / tolerance))
    return min(sides, default=None)


def returns_of(scan: Scan) -> np.ndarray:
    """Which beams came back from something: finite, above 0, and within the sensor's own limits. A range that only
    rounding to f32 keeps below range_max is at range_max."""
    r = scan.ranges_m
    with np.errstate(invalid="ignore"):
        return np.isfinite(r) & (r > 0) & (r >= scan.range_min_m) & (r < scan.range_max_m * (1 - 1e-6))


def points_of(scan: Scan) -> np.ndarray:
    """The returns in the sensor's frame, n×2, metres, formed in f64 from the f32 values on the wire."""
    seen = returns_of(scan)
    angle_rad = scan.angle_min_rad + np.arange(len(scan.ranges_m)) * scan.angle_increment_rad
    r, angle_rad = scan.ranges_m[seen], angle_rad[seen]
    return np.column_stack([r * np.cos(angle_rad), r * np.sin(angle_rad)])


def affinity_of(points_m: np.ndarray, sigma_per_m2: float) -> np.ndarray:
    """Equation (1)."""
    difference = points_m[:, None, :] - points_m[None, :, :]
    return np.exp(-sigma_per_m2 * np.sum(difference**2, axis=-1))


def laplacian_of(affinity: np.ndarray) -> np.ndarray:
    """Equation (2): L = I - D^-1/2 W D^-1/2."""
    scale = 1 / np.sqrt(affinity.sum(axis=1))
    return np.eye(len(affinity)) - scale[:, None] * affinity * scale[None, :]


def spectrum_of(points_m: np.ndarray, sigma_per_m2: float, tolerance: float) -> Spectrum:
    """Equation (3), by LAPACK."""
    laplacian = laplacian_of(affinity_of(points_m, sigma_per_m2))
    eigenvalues, vectors = np.linalg.eigh(laplacian)
    return Spectrum(laplacian, eigenvalues, vectors, tolerance)


def clusters_of(u: np.ndarray) -> np.ndarray:
    """Equation (4): scikit-learn's k-means on the rows of U as they are."""
    return KMeans(n_clusters=u.shape[1], n_init=10, random_state=0).fit(u).labels_


def inertia_of(u: np.ndarray, labels: np.ndarray) -> float:
    """f(C, U) of equation (4) for the centroids of these clusters."""
    return sum(float(np.sum((part - part.mean(axis=0)) ** 2)) for part in (u[labels == c] for c in np.unique(labels)))


def same_partition(a: np.ndarray, b: np.ndarray) -> bool:
    """Equal up to renaming."""
    pairs = set(zip(a.tolist(), b.tolist()))
    return len(pairs) == len({x for x, _ in pairs}) == len({y for _, y in pairs})

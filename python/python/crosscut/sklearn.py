"""The method as an estimator of scikit-learn: clusters are counted, not given."""

from __future__ import annotations

import numbers
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._engine import Engine
from ._extras import importing
from ._native import Scan
from ._results import laplacian

with importing("crosscut.sklearn"):
    from scipy import linalg, sparse
    from scipy.spatial.distance import cdist
    from sklearn.base import BaseEstimator, ClusterMixin
    from sklearn.utils import Tags
    from sklearn.utils.validation import validate_data

__all__ = ["SpectralJunctions"]


class SpectralJunctions(ClusterMixin, BaseEstimator):  # type: ignore[misc]
    """Spectral clustering that counts the clusters: as many as eigenvalues of the normalised Laplacian are zero.

    Parameters
    ----------
    affinity : "rbf", "precomputed", the name of a kind, or a callable ``affinity(X) -> W``
        "rbf" is ``exp(-sigma * ||x_i - x_j||^2)``. W is (n_samples, n_samples), symmetric, 0 <= W_ij <= 1, W_ii = 1. Other
        kinds, such as "knn", are those of the program and take points in the plane or in space alone.
    sigma : float
        Of "rbf", in 1 over the square of the unit of X.
    zero_tolerance : float
        Eigenvalues below count as zero.
    n_clusters : int or None
        None counts them; a number, up to n_samples, takes as many eigenvectors, whatever their eigenvalues are.
    kmeans : str or a callable ``kmeans(U, k) -> labels``
        How the rows of U are clustered: "kmeans++", the name of another kind, or a callable.
    settings : mapping or None
        Further settings, such as ``{"kmeans.restarts": 20}``.

    Attributes
    ----------
    labels_ : int array (n_samples,), the cluster of each sample, numbered by first sample.
    n_clusters_ : int, the number of zero eigenvalues.
    eigenvalues_ : float array, ascending: those that were computed.
    affinity_matrix_ : W, an array or a sparse matrix.
    embedding_ : float array (n_samples, n_clusters_), U.
    n_features_in_ : int.

    Examples
    --------
    >>> import numpy as np
    >>> from crosscut.sklearn import SpectralJunctions
    >>> x = np.arange(0, 4, 0.2)
    >>> walls = np.concatenate([np.column_stack([x, np.full(20, y)]) for y in (-3.0, 3.0)])
    >>> int(SpectralJunctions().fit(walls).n_clusters_)
    2
    """

    def __init__(
        self,
        affinity: str | Callable[..., Any] = "rbf",
        *,
        sigma: float = 1.5,
        zero_tolerance: float = 1e-7,
        n_clusters: int | None = None,
        kmeans: str | Callable[..., Any] = "kmeans++",
        settings: Mapping[str, object] | None = None,
    ) -> None:
        self.affinity = affinity
        self.sigma = sigma
        self.zero_tolerance = zero_tolerance
        self.n_clusters = n_clusters
        self.kmeans = kmeans
        self.settings = settings

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()
        tags.input_tags.pairwise = self.affinity == "precomputed"
        return tags

    def fit(self, X: Any, y: Any = None) -> SpectralJunctions:  # noqa: N803
        """Clusters ``X`` (n_samples, n_features); ``y`` is not used."""
        X = validate_data(self, X, dtype=np.float64)  # noqa: N806
        self._check(X)
        engine, points = self._engine(X)
        result = engine.process(points)
        self.labels_ = result.clusters
        self.n_clusters_ = result.k
        self.eigenvalues_ = result.eigenvalues
        self.affinity_matrix_ = result.W
        self.embedding_ = result.U
        return self

    def _check(self, X: NDArray[np.float64]) -> None:  # noqa: N803
        k, n = self.n_clusters, len(X)
        if k is not None and not (isinstance(k, numbers.Integral) and not isinstance(k, bool) and 1 <= k <= n):
            raise ValueError(f"n_clusters is None or a whole number from 1 to n_samples={n}, not {k!r}")
        if not (isinstance(self.sigma, numbers.Real) and 0.0 < self.sigma < np.inf):
            raise ValueError(f"sigma is a number above 0, not {self.sigma!r}")
        if self.affinity == "precomputed" and X.shape != (n, n):
            raise ValueError(f"a precomputed X is W, of shape (n_samples, n_samples), not {X.shape}")

    def _engine(self, X: NDArray[np.float64]) -> tuple[Engine, Scan]:  # noqa: N803
        """An engine whose affinity knows ``X``, and points for it."""
        affinity: Any = self.affinity
        points = X
        if affinity in ("rbf", "precomputed") or callable(affinity):
            w = self._weights(X)
            affinity = lambda _: w  # noqa: E731
            # The engine is for points in space, and X may have any number of features.
            points = np.column_stack([np.arange(len(X)), np.ones(len(X))])
        elif X.shape[1] not in (2, 3):
            raise ValueError(f"affinity {affinity!r} takes points with 2 or 3 coordinates, not {X.shape[1]}")
        sections: dict[str, Any] = {"affinity": affinity, "kmeans": self.kmeans}
        if self.n_clusters is None:
            sections["spectral"] = {"zero_tolerance": self.zero_tolerance}
        else:
            sections["spectral"] = self._first_eigenvectors
        return Engine("paper", settings=self.settings, keep=("W", "U"), **sections), Scan._without_beams(points)

    def _weights(self, X: NDArray[np.float64]) -> Any:  # noqa: N803
        if callable(self.affinity):
            return self.affinity(X)
        if self.affinity == "precomputed":
            return X
        return np.exp(-self.sigma * cdist(X, X, "sqeuclidean"))

    def _first_eigenvectors(self, w: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        w = w.toarray() if sparse.issparse(w) else w
        eigenvalues, vectors = linalg.eigh(laplacian(w, w.sum(axis=0)))
        return eigenvalues, vectors[:, : self.n_clusters]

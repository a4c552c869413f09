"""The estimator of scikit-learn."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from sklearn.cluster import SpectralClustering
from sklearn.datasets import make_moons
from sklearn.metrics import adjusted_rand_score
from sklearn.utils.estimator_checks import parametrize_with_checks

import crosscut
from crosscut.sklearn import SpectralJunctions


@parametrize_with_checks([SpectralJunctions(), SpectralJunctions(n_clusters=3)])  # type: ignore[untyped-decorator]
@pytest.mark.filterwarnings("ignore")
def test_it_is_an_estimator(estimator: SpectralJunctions, check: Callable[[SpectralJunctions], None]) -> None:
    check(estimator)


def walls() -> NDArray[np.float64]:
    x = np.arange(0, 4, 0.2)
    return np.concatenate([np.column_stack([x, np.full(20, y)]) for y in (-6.0, 0.0, 6.0)])


def test_it_counts_and_labels_as_the_engine_does() -> None:
    found = SpectralJunctions().fit(walls())
    result = crosscut.Engine("paper", keep=("W",)).process(crosscut.Scan._without_beams(walls()))
    assert found.n_clusters_ == result.k == 3
    assert np.array_equal(found.labels_, np.repeat([0, 1, 2], 20)) and np.array_equal(result.clusters, found.labels_)
    assert np.allclose(found.affinity_matrix_, result.W, rtol=1e-14)
    assert np.allclose(found.eigenvalues_, result.eigenvalues, atol=1e-12)
    assert found.embedding_.shape == (60, 3)


def test_a_given_number_of_clusters_is_as_right_as_that_of_scikit_learn() -> None:
    points, truth = make_moons(200, noise=0.03, random_state=1)
    mine = SpectralJunctions(sigma=40.0, n_clusters=2).fit_predict(points)
    theirs = SpectralClustering(2, gamma=40.0, random_state=1).fit_predict(points)
    assert adjusted_rand_score(mine, truth) == adjusted_rand_score(theirs, truth) == 1.0


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"n_clusters": -1}, "n_clusters is None or a whole number from 1 to n_samples=60, not -1"),
        ({"n_clusters": 0}, "not 0"),
        ({"n_clusters": 61}, "not 61"),
        ({"n_clusters": 2.5}, "not 2.5"),
        ({"n_clusters": True}, "not True"),
        ({"sigma": 0.0}, "sigma is a number above 0, not 0.0"),
        ({"sigma": float("nan")}, "not nan"),
        ({"affinity": "precomputed"}, r"of shape \(n_samples, n_samples\), not \(60, 2\)"),
    ],
)
def test_wrong_parameters_are_refused(settings: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        SpectralJunctions(**settings).fit(walls())


def test_kinds_and_callables_are_affinities() -> None:
    kind = SpectralJunctions(affinity="threshold").fit(walls())
    function = SpectralJunctions(affinity=lambda x: np.eye(len(x))).fit(walls())
    assert (kind.n_clusters_, function.n_clusters_) == (3, 60)
    with pytest.raises(ValueError, match="takes points with 2 or 3 coordinates, not 4"):
        SpectralJunctions(affinity="threshold").fit(np.zeros((5, 4)))
    with pytest.raises(crosscut.StageError, match="not symmetric"):
        SpectralJunctions(affinity="precomputed").fit([[1.0, 0.5], [0.2, 1.0]])

"""Stages in Python."""

from __future__ import annotations

import gc
import itertools
import signal
import subprocess
import sys
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import stages_of_ones_own as own

import crosscut
from crosscut import testing

HERE = Path(__file__).resolve().parent


@pytest.fixture(scope="module")
def scans() -> list[crosscut.Scan]:
    return list(crosscut.read(HERE.parents[1] / "recordings" / "tee.mcap", every=5))


@pytest.mark.parametrize(
    "stages",
    [
        {"affinity": own.rbf},
        {"affinity": own.sparse},
        {"spectral": own.eigen},
        {"kmeans": own.nearest_row},
        {"affinity": own.rbf, "spectral": own.eigen, "kmeans": own.nearest_row},
    ],
    ids=lambda stages: "+".join(stages),
)
def test_stages_in_numpy_give_the_labels_of_the_paper(scans: list[crosscut.Scan], stages: dict[str, Any]) -> None:
    mine = crosscut.Engine("paper", **stages)
    for scan in scans[:25:5]:
        expected, found = crosscut.Engine("paper").process(scan), mine.process(scan)
        assert (found.k, found.openings) == (expected.k, expected.openings)
        assert np.array_equal(found.labels, expected.labels)
        assert np.allclose(found.eigenvalues[:4], expected.eigenvalues[:4], atol=1e-11)


def change(w: Any, at: tuple[int, int], value: float) -> Any:
    w[at] = value
    return w


@pytest.mark.parametrize(
    ("stage", "function", "text"),
    [
        ("affinity", lambda p: own.rbf(p)[:-1], r"returned a W of shape \(\d+, \d+\) for \d+ returns"),
        ("affinity", lambda p: change(own.rbf(p), (2, 5), 0.5), r"not symmetric: W\[2, 5\] = 0.5 and W\[5, 2\]"),
        ("affinity", lambda p: change(own.rbf(p), (3, 3), 0.5), r"diagonal is not 1: W\[3, 3\] = 0.5"),
        ("affinity", lambda p: change(own.rbf(p), (0, 1), np.nan), r"not finite: W\[0, 1\] = NaN"),
        ("affinity", lambda p: change(own.rbf(p), (0, 1), -0.5), r"outside 0 to 1: W\[0, 1\] = -0.5"),
        ("affinity", lambda p: change(own.sparse(p).tolil(), (0, 1), 0.5), r"not symmetric: W\[0, 1\] = 0.5"),
        ("affinity", lambda p: None, "returned what cannot be read: NoneType is not an array of two dimensions"),
        ("affinity", lambda p: own.rbf(p) + 0j, r"ndarray of shape \(\d+, \d+\) has complex numbers, not real ones"),
        ("affinity", lambda p: "W", "str is not an array of two dimensions"),
        ("affinity", lambda: None, "takes 0 positional arguments"),
        ("affinity", lambda p: 1 // 0, "raised ZeroDivisionError"),
        ("spectral", lambda w: own.eigen(w)[0], r"ndarray of shape \(\d+,\) is not a pair of eigenvalues and U"),
        ("spectral", lambda w: (own.eigen(w)[0], own.eigen(w)[1] * 1j), "has complex numbers"),
        ("spectral", lambda w: (own.eigen(w)[0] + 0j, own.eigen(w)[1]), "has complex numbers"),
        ("spectral", lambda w: (own.eigen(w)[0][::-1], own.eigen(w)[1]), "eigenvalues that do not ascend"),
        ("spectral", lambda w: (own.eigen(w)[0] - 1, own.eigen(w)[1]), r"an eigenvalue below 0.*eigenvalues\[0\] = -(1|0\.99)"),
        ("spectral", lambda w: (own.eigen(w)[0] * np.nan, own.eigen(w)[1]), r"not finite: eigenvalues\[0\] = NaN"),
        ("spectral", lambda w: (own.eigen(w)[0], own.eigen(w)[1][:-1]), r"a U of shape \(\d+, \d\) for \d+ returns"),
        ("spectral", lambda w: (own.eigen(w)[0][:1], own.eigen(w)[1]), "1 eigenvalues for"),
        ("kmeans", lambda u, k: np.zeros(len(u) - 1), r"returned \d+ labels for \d+ returns"),
        ("kmeans", lambda u, k: np.full(len(u), -2), r"labels\[0\] = -2, which is less than -1"),
        ("kmeans", lambda u, k: u, "not an array of one dimension"),
        ("kmeans", lambda u, k: np.full(len(u), 0.9), r"labels\[0\] = 0.9 is no whole number"),
        ("kmeans", lambda u, k: [0.0, -0.5] + [0.0] * (len(u) - 2), r"labels\[1\] = -0.5 is no whole number"),
        ("kmeans", lambda u, k: np.full(len(u), np.nan), r"labels\[0\] = NaN is no whole number"),
    ],
)
def test_nonsense_is_refused_with_its_stage_and_scan(
    scans: list[crosscut.Scan], stage: str, function: Callable[..., Any], text: str
) -> None:
    with pytest.raises(crosscut.StageError, match=f"(?s)^{stage} failed on revolution 80: test_stages.*{text}"):
        crosscut.Engine("paper", **{stage: function}).process(scans[16])  # type: ignore[arg-type]


def test_whole_numbers_are_labels_whatever_their_type(scans: list[crosscut.Scan]) -> None:
    expected = crosscut.Engine("paper", kmeans=own.nearest_row).process(scans[0])
    for convert in (np.uint16, np.float64, list):
        found = crosscut.Engine("paper", kmeans=lambda u, k: convert(own.nearest_row(u, k))).process(scans[0])
        assert np.array_equal(found.labels, expected.labels), convert


def test_an_exception_is_the_cause_and_what_came_before_is_kept(scans: list[crosscut.Scan]) -> None:
    for workers in (1, 2):
        own.calls = itertools.count(1)
        done = []
        with pytest.raises(crosscut.StageError, match="own.failing raised ValueError: seven were enough") as caught:
            for result in crosscut.Engine("paper", affinity=own.failing).process_many(scans, workers=workers):
                done.append(result)
        assert isinstance(caught.value.__cause__, ValueError)
        assert workers > 1 or len(done) == 7  # several threads count the calls together
        assert done == [crosscut.Engine("paper", affinity=own.rbf).process(scan) for scan in scans[: len(done)]]


def test_an_engine_that_failed_goes_on_with_the_next_scan(scans: list[crosscut.Scan]) -> None:
    own.calls = itertools.count(8)
    engine = crosscut.Engine("paper", affinity=own.failing)
    with pytest.raises(crosscut.StageError):
        engine.process(scans[0])
    assert engine.process(scans[0]) == crosscut.Engine("paper", affinity=own.rbf).process(scans[0])


def test_an_engine_inside_its_own_stage_is_refused(scans: list[crosscut.Scan]) -> None:
    engine = crosscut.Engine("paper", affinity=lambda points: engine.process(scans[0]).W)
    with pytest.raises(crosscut.StageError, match="this engine is busy"):
        engine.process(scans[0])


HANGING = """
import crosscut, stages_of_ones_own as own
engine = crosscut.Engine("paper", affinity=own.hanging)
before = []
try:
    for result in engine.process_many(crosscut.read("recordings/tee.mcap"), workers={workers}):
        before.append(result.seq)
except KeyboardInterrupt:
    print(before, "interrupted")
"""


# Where the tests run in the background, a shell has them ignore the signal, and Python then has no handler of its own.
INTERRUPTED = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"


@pytest.mark.parametrize("workers", [1, 2])
def test_an_interrupt_ends_a_stage_that_never_returns(workers: int) -> None:
    run = subprocess.Popen(
        [sys.executable, "-c", f"{INTERRUPTED}; import sys; sys.path.insert(0, {str(HERE)!r})" + HANGING.format(workers=workers)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=HERE.parents[1],
    )
    assert run.stderr is not None
    assert run.stderr.readline() == "hanging\n"
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=60)
    assert run.returncode == 0, err
    # Of several workers, the one that hangs may have the first batch or the second.
    assert out in [f"{list(range(before))} interrupted\n" for before in ([7] if workers == 1 else range(17))]


def test_conformance_accepts_what_is_right() -> None:
    testing.check_affinity(own.rbf)
    testing.check_affinity(own.sparse)
    testing.check_spectral(own.eigen)
    testing.check_kmeans(own.nearest_row)


OWNS_AN_ENGINE = """
import crosscut, crosscut.testing, stages_of_ones_own as own
def owner(points, engine=crosscut.Engine("paper", affinity=own.rbf)):
    return own.rbf(points)
crosscut.testing.check_affinity(owner)
del owner
crosscut.testing.check_affinity(own.rbf)
print("checked")
"""


def test_a_checked_stage_that_owns_an_engine_does_not_deadlock() -> None:
    run = subprocess.run([sys.executable, "-c", OWNS_AN_ENGINE], capture_output=True, text=True, cwd=HERE, timeout=120)
    *checks, end = run.stdout.splitlines()
    assert (end, len(checks)) == ("checked", 2) and all(line.startswith("ok: ") for line in checks), run.stderr


def test_a_checked_stage_is_not_kept() -> None:
    stage: Callable[..., Any] = lambda points: own.rbf(points)  # noqa: E731
    kept = weakref.ref(stage)
    testing.check_affinity(stage)
    del stage
    gc.collect()
    assert kept() is None


def test_an_unstable_stage_is_found_without_assert_statements() -> None:
    script = "import numpy, crosscut.testing as t; t.check_kmeans(lambda u, k: numpy.random.randint(0, 2, len(u)))"
    run = subprocess.run([sys.executable, "-O", "-c", script], capture_output=True, text=True)
    assert "AssertionError: of " in run.stderr and "another answer" in run.stderr


@pytest.mark.parametrize(
    ("check", "stage", "text"),
    [
        (testing.check_affinity, lambda p: np.ones((len(p), len(p))) * 0.5, "diagonal is not 1"),
        (testing.check_affinity, lambda p: own.rbf(p) if len(p) > 3 else None, "NoneType is not an array"),
        (testing.check_affinity, lambda p: own.rbf(p / np.ptp(p, axis=0).max()), "not finite"),
        (testing.check_spectral, lambda w: (np.zeros(3), np.zeros((3, 3))), "of 1 returns"),
        (testing.check_kmeans, lambda u, k: np.random.randint(0, 2, len(u)), "another answer"),
    ],
)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_conformance_says_what_is_wrong(check: Callable[..., None], stage: Callable[..., Any], text: str) -> None:
    with pytest.raises(AssertionError, match=text):
        check(stage)

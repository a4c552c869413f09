"""Nothing that a stage returns or a caller passes takes the process down."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import sparse

import crosscut

SCAN = crosscut.Scan(np.full(60, 2.0), -np.pi, np.pi / 30)


def damaged(form: str, part: str, value: int) -> Callable[[Any], Any]:
    """An affinity that returns the identity in this format of scipy, with one number of a part of it replaced."""

    def affinity(points: Any) -> Any:
        w = sparse.eye_array(len(points), format=form).copy()
        array = np.array(getattr(w, part))
        array.ravel()[1] = value
        setattr(w, part, array)
        return w

    return affinity


@pytest.mark.parametrize("value", [10**6, -1, 2**31 - 1, -(2**31)])
@pytest.mark.parametrize(
    ("form", "part"),
    [("csr", "indptr"), ("csr", "indices"), ("csc", "indptr"), ("csc", "indices"), ("coo", "row"), ("coo", "col"),
     ("bsr", "indptr"), ("bsr", "indices")],
)
def test_a_sparse_matrix_with_wrong_indices_is_refused(form: str, part: str, value: int) -> None:
    with pytest.raises(crosscut.StageError, match="is damaged|W that is|diagonal|more than|axis 1 index"):
        crosscut.Engine("paper", affinity=damaged(form, part, value)).process(SCAN)


@pytest.mark.parametrize("dtype", ["float32", "float64", "int64"])
def test_what_a_mask_hides_is_no_return(dtype: str) -> None:
    ranges = np.ma.masked_array(np.full(360, 2, dtype), mask=[False] * 200 + [True] * 160)
    plain = np.where(ranges.mask, np.nan, 2.0)
    masked, of_plain = (crosscut.count(given, -np.pi, np.pi / 180) for given in (ranges, plain))
    assert masked.returns == 200 and masked.labels.tolist() == of_plain.labels.tolist()
    with pytest.raises(ValueError, match="point 0 is not finite"):
        crosscut.Engine().process(np.ma.masked_less([[0.0, 1.0]], 0.5))


@pytest.mark.parametrize("label", [2**64 - 1, 2**63])
def test_a_label_that_is_too_large_is_refused(label: int) -> None:
    engine = crosscut.Engine("paper", kmeans=lambda u, k: np.full(len(u), label, np.uint64))
    with pytest.raises(crosscut.StageError, match=rf"labels\[0\] = {label} is larger"):
        engine.process(SCAN)


@pytest.mark.parametrize("part", ["indptr", "indices", "data"])
@pytest.mark.parametrize("form", ["csr", "csc", "bsr"])
def test_a_sparse_matrix_that_is_cut_is_refused(form: str, part: str) -> None:
    def cut(points: Any) -> Any:
        w = sparse.eye_array(len(points), format=form).copy()
        setattr(w, part, getattr(w, part)[:-3])
        return w

    with pytest.raises(crosscut.StageError, match="is damaged|cannot be read"):
        crosscut.Engine("paper", affinity=cut).process(SCAN)


@pytest.mark.parametrize("form", ["csr", "csc", "coo", "bsr", "lil", "dok", "dia"])
def test_every_format_of_scipy_gives_the_same_answer(form: str) -> None:
    def affinity(points: Any) -> Any:
        w = np.exp(-np.square(points[:, None] - points).sum(axis=2))
        return np.where(w > 0.1, w, 0.0)

    expected = crosscut.Engine("paper", affinity=affinity).process(SCAN)
    found = crosscut.Engine("paper", affinity=lambda points: sparse.csr_array(affinity(points)).asformat(form)).process(SCAN)
    assert (found.k, found.labels.tolist()) == (expected.k, expected.labels.tolist())


def test_entries_of_one_place_are_added() -> None:
    def halves(points: Any) -> Any:
        n = np.arange(len(points))
        return sparse.coo_array((np.full(2 * len(n), 0.5), (np.tile(n, 2), np.tile(n, 2))), shape=(len(n), len(n)))

    result = crosscut.Engine("paper", affinity=halves, keep=("W",)).process(SCAN)
    assert (result.W.toarray() == np.eye(60)).all()


HUGE = np.lib.stride_tricks.as_strided(np.ones(1), (1 << 20, 1 << 20), (0, 0))
LONG = np.lib.stride_tricks.as_strided(np.ones(1), (1 << 40,), (0,))


@pytest.mark.parametrize(
    "use",
    [
        lambda: crosscut.Engine("paper", affinity=lambda points: HUGE).process(SCAN),
        lambda: crosscut.Engine("paper", spectral=lambda w: (LONG, HUGE)).process(SCAN),
        lambda: crosscut.Engine("paper", spectral=lambda w: (LONG[:2], HUGE)).process(SCAN),
        lambda: crosscut.Engine("paper", kmeans=lambda u, k: LONG).process(SCAN),
        lambda: crosscut.Engine("paper", affinity=lambda points: sparse.coo_array((1 << 40, 1 << 40))).process(SCAN),
        lambda: crosscut.Scan(LONG, 0.0, 0.1),
        lambda: crosscut.Scan.from_points(HUGE),
        lambda: crosscut.Scan.from_points(LONG.reshape(-1, 2)),
    ],
)
def test_what_is_huge_is_refused_before_it_is_copied(use: Callable[[], Any]) -> None:
    with pytest.raises((crosscut.StageError, ValueError), match="shape|more than|columns"):
        use()


FORKED = """
import os, numpy as np, crosscut
scan = crosscut.Scan(np.full(360, 2.0), -np.pi, np.pi / 180)
results = crosscut.Engine().process_many([scan] * 200, workers=2)
next(results)
child = os.fork()
if child == 0:
    try:
        list(results)
    except crosscut.Error as error:
        print(error, flush=True)
    os._exit(7)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), len(list(results)), flush=True)
"""


def test_a_fork_amid_process_many_is_refused_in_the_child() -> None:
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", FORKED], capture_output=True, text=True, timeout=60)
    assert "begun before this process was forked" in done.stdout, done.stderr
    assert done.stdout.splitlines()[-1] == "7 199"


UNREAD = """
import sys, numpy as np, crosscut
scan = crosscut.Scan(np.full(360, 2.0), -np.pi, np.pi / 180)
def w(points): return np.exp(-1.5 * ((points[:, None] - points) ** 2).sum(axis=2))
results = crosscut.Engine("paper", affinity=w).process_many([scan] * 5000, workers=2)
print(next(results).junctions, flush=True)
sys.exit(3)
"""


def test_a_script_that_is_over_ends_the_threads_whose_results_nobody_reads() -> None:
    for _ in range(6):
        done = subprocess.run([sys.executable, "-c", UNREAD], capture_output=True, text=True, timeout=60)
        assert (done.returncode, done.stderr) == (3, ""), done.stdout


DOCUMENTED = (TypeError, ValueError, crosscut.Error)

ODD: list[Any] = [
    None, -1, 0, 1, 1 << 70, 10**400, 1.5, float("nan"), float("inf"), True, "x", "", b"", b"\0\1\0\0", (), [], {}, {"a": 1}, object(), print,
    [[1, 2]], [[[1]]], np.zeros(3), np.zeros((2, 2)), np.zeros((0, 2)), np.full((3, 2), np.nan), np.array(["a"]), np.array([None]),
    np.zeros((2, 2), complex), np.array(7), sparse.eye_array(3), sparse.coo_array(np.ones(3)), HUGE, LONG, SCAN, crosscut.Engine,
]


def uses(a: Any, b: Any, c: Any) -> list[Callable[[], Any]]:
    return [
        lambda: crosscut.Scan(a, b, c),
        lambda: crosscut.Scan([1.0], 0.0, 0.1, range_min=a, range_max=b, stamp_ns=c, seq=a, frame_id=b),
        lambda: crosscut.Scan.from_points(a, stamp_ns=b, seq=c),
        lambda: crosscut.Scan.from_message(a, b, encoding=c),
        lambda: crosscut.Scan.from_message(a),
        lambda: crosscut.Engine(a),
        lambda: crosscut.Engine(settings=a, keep=b),
        lambda: crosscut.Engine(affinity=a, vehicle=b, kmeans=c) and None,
        lambda: crosscut.Engine().process(a),
        lambda: crosscut.Engine("paper", affinity=lambda points: a).process(SCAN),
        lambda: crosscut.Engine("paper", spectral=lambda w: (a, b)).process(SCAN),
        lambda: crosscut.Engine("paper", spectral=lambda w: a).process(SCAN),
        lambda: crosscut.Engine("paper", kmeans=lambda u, k: a).process(SCAN),
        lambda: list(crosscut.Engine().process_many([SCAN, a, SCAN], workers=2)),
        lambda: crosscut.Engine().process_many([SCAN], workers=a),
        lambda: crosscut.count(a, b, c),
        lambda: crosscut.Flight(a),
        lambda: crosscut.Flight().process(a, b),
        lambda: crosscut.Flight().process(SCAN, a),
        lambda: crosscut.Navigator(None, a, speed_max_m_s=b, turn_rate_max_rad_s=c),
        lambda: crosscut.Navigator().step(SCAN, a),
        lambda: crosscut.read("absent.mcap", a, read_as=b, from_s=c),
    ]


@pytest.mark.filterwarnings("ignore")
def test_odd_arguments_raise_what_is_documented() -> None:
    chance = random.Random(int(os.environ.get("CROSSCUT_SEED", "1")))
    for _ in range(int(os.environ.get("CROSSCUT_ODD_ARGUMENTS", "600"))):
        a, b, c = (chance.choice(ODD) for _ in range(3))
        use = chance.choice(uses(a, b, c))
        try:
            use()
        except DOCUMENTED:
            pass

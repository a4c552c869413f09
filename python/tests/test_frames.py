"""Stages one at a time, on columns of numpy."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import crosscut
from crosscut import frames


def test_stages_one_at_a_time_give_the_results_of_the_flight(tee: Path) -> None:
    engine = crosscut.Engine()
    scans = list(engine.read(tee, every=10))
    columns = frames.of_scans(engine, scans)
    for stage in frames.STAGES:
        columns |= frames.run(engine, stage, columns)
    lines, failure = frames.finish(crosscut.Flight(engine), columns)
    flight = crosscut.Flight(engine)
    assert failure is None
    assert [json.loads(line) for line in lines.splitlines()] == [flight.process(scan).to_dict() for scan in scans]


def test_what_was_changed_between_two_stages_counts(tee: Path) -> None:
    engine = crosscut.Engine("paper")
    columns = frames.of_scans(engine, [next(iter(engine.read(tee)))])
    columns |= frames.run(engine, "affinity", columns)
    starts, weights = columns["w_value"]
    n = len(columns["points_m"][1]) // 3
    whole = frames.run(engine, "spectral", columns)["k"][0]
    cut = weights.reshape(n, n).copy()
    cut[: n // 2, n // 2 :] = cut[n // 2 :, : n // 2] = 0.0  # two halves without an edge between them
    halves = frames.run(engine, "spectral", columns | {"w_value": (starts, cut.ravel())})["k"][0]
    assert halves > whole


def test_columns_that_do_not_fit_are_refused(tee: Path) -> None:
    engine = crosscut.Engine()
    columns = frames.of_scans(engine, [next(iter(engine.read(tee)))])
    with pytest.raises(KeyError, match="w_row_start"):
        frames.run(engine, "spectral", columns)
    with pytest.raises(ValueError, match="return_of_beam"):
        of_beam = columns["return_of_beam"]
        frames.run(engine, "affinity", columns | {"return_of_beam": (of_beam[0], np.full_like(of_beam[1], 10**6))})
    with pytest.raises(ValueError, match="a stage is affinity, spectral or kmeans"):
        frames.run(engine, "report", columns)

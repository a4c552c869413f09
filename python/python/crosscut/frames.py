"""Stages one at a time: to look into one, to change what lies between two, to run each in a process of its own.

>>> columns = crosscut.frames.of_scans(engine, scans)
>>> for stage in crosscut.frames.STAGES:
...     columns |= crosscut.frames.run(engine, stage, columns)
>>> flight = crosscut.Flight(engine)
>>> lines, failure = crosscut.frames.finish(flight, columns)

Frames are columns: a dictionary with arrays of numpy by name, of which row i belongs to frame i. They hold all that later stages
read, to the last bit, so that the lines are those of ``crosscut run``. A column of lists is a pair: where the list of each row
starts, int32, with the end of the last, and the values of all rows, one after the other. A text is a list of its bytes in
UTF-8. Other columns are passed over.

========================================================= ======================================================================
of the scan
--------------------------------------------------------- ----------------------------------------------------------------------
``seq``, ``stamp_ns`` uint64, ``frame_id`` text           its number in its topic, the stamp by the sensor's clock, the frame
``points_m`` lists of 3 float64                           n returns: x forward, y left, z up
``has_beams`` bool                                        False for a cloud, whose columns of beams are empty
``ranges_m`` lists of float32                             as on the wire
``bearings_rad`` lists of float64                         of each beam of the turn
``return_of_beam`` lists of int32                         its index in points_m; -1: nothing in range, -2: nothing is known
``step_rad``, ``range_max_m`` float64                     angle between beams, the longest range
``full_turn`` bool, ``missing_beams`` uint64              how many beams are missing between the last and the first of a full turn
``wire_geometry`` 4 float32 a row                         angle_min, angle_increment, range_min, range_max
``odometry`` lists of float64                             x_m, y_m, and the cosine and sine of the yaw; empty: not known
--------------------------------------------------------- ----------------------------------------------------------------------
of the work on it
--------------------------------------------------------- ----------------------------------------------------------------------
``notes`` lists of texts                                  what was dropped, repaired or replaced
``timings_ns`` 5 uint64 a row                             of ingest, affinity, spectral, kmeans and report
``failed_step``, ``failure`` text, ``panicked`` bool      empty, or the stage that failed, with which the flight ends
--------------------------------------------------------- ----------------------------------------------------------------------
of affinity
--------------------------------------------------------- ----------------------------------------------------------------------
``w_row_start`` lists of uint64, ``w_column`` of uint32,  W, n x n: row i has the entries from w_row_start[i] to w_row_start[i + 1].
``w_value`` of float64                                    With all its entries, it has no row starts and no columns
``verdict_returns`` lists of 2 uint32                     what was decided at the gaps between two returns, by kinds that do so
``verdict_is_opening`` of bool, ``verdict_room_ratio`` of whether a vehicle can pass, the room there, the probability (NaN where
float64, ``verdict_p`` of float64, ``verdict_reason`` of  too little is seen), and why
texts
--------------------------------------------------------- ----------------------------------------------------------------------
of spectral
--------------------------------------------------------- ----------------------------------------------------------------------
``eigenvalues`` lists of float64, ``k`` uint64            ascending, at least the k zeros
``zero_tolerance`` float64                                eigenvalues below it count as zero
``margin_decades`` float64                                NaN where there is none
``u_row_start``, ``u_column``, ``u_value``                U, n x k, as W
--------------------------------------------------------- ----------------------------------------------------------------------
of kmeans
--------------------------------------------------------- ----------------------------------------------------------------------
``clusters`` lists of int32                               equal for returns of one wall, -1 for one that is left out
========================================================= ======================================================================
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeAlias

from ._engine import STAGES, Engine, as_scan
from ._flight import Flight

__all__ = ["STAGES", "Columns", "finish", "of_scans", "run"]

Columns: TypeAlias = "dict[str, Any]"


def of_scans(engine: Engine, scans: Iterable[Any], first_seq: int = 0) -> Columns:
    """Scans as frames before the first stage; those without a number are numbered from ``first_seq``."""
    return engine._native.frames([as_scan(scan) for scan in scans], first_seq)


def run(engine: Engine, stage: str, columns: Columns) -> Columns:
    """The columns that "affinity", "spectral" or "kmeans" makes or changes. Where it fails on a frame, its ``failed_step`` says so.

    A column that is missing is a ``KeyError``, one that does not fit the others a ``ValueError``.
    """
    return engine._native.run_stage(stage, columns)


def finish(flight: Flight, columns: Columns) -> tuple[bytes, str | None]:
    """The report on frames after kmeans, which become a part of the flight: their lines of results, as ``crosscut run`` writes
    them, up to the first frame that failed, and why it did."""
    return flight._engine.report(columns, flight._native)

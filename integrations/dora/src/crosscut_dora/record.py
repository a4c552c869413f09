"""Frames as a recording for the Rerun viewer; needs rerun-sdk.

Entities have the names that ``crosscut run --save`` gives them, whose recordings hold more.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import crosscut
import numpy as np
import pyarrow as pa
import rerun as rr
from crosscut import frames as stages
from numpy.typing import NDArray

from . import arrow


class Recording:
    """A file that is there once it is whole, under another name before. Frames are taken as they are after kmeans, with W and U."""

    def __init__(self, path: Path, engine: crosscut.Engine) -> None:
        self._path, self._unfinished = path, path.with_name(f".{path.name}.unfinished")
        self._engine = engine
        self._stream = rr.RecordingStream("crosscut", recording_id=path.name)
        self._stream.save(self._unfinished)

    def close(self) -> None:
        self._stream.disconnect()
        self._unfinished.replace(self._path)

    def add(self, frames: pa.StructArray) -> None:
        """The frames up to the first that has failed."""
        columns = arrow.columns(frames)
        # Each frame is reported by itself: a flight would add to the line, and is that of the last node.
        lines, _ = stages.finish(crosscut.Flight(self._engine), columns)
        for row, line in enumerate(map(json.loads, lines.splitlines())):
            self._log(line, columns, row)

    def _log(self, line: dict[str, Any], columns: dict[str, Any], row: int) -> None:
        log = self._stream.log
        points_m = _row(columns["points_m"], row, width=3).reshape(-1, 3)
        clusters = _row(columns["clusters"], row)
        ahead = [[2.0 * np.cos(a), 2.0 * np.sin(a), 0.0] for a in (opening["bearing_rad"] for opening in line["openings"])]
        n = len(points_m)
        self._stream.set_time("revolution", sequence=line["seq"])
        self._stream.set_time("stamp", timestamp=np.datetime64(line["stamp_ns"], "ns"))
        log("scan/points", rr.Points3D(points_m, class_ids=clusters + 1))
        for entity, name, shape in (("affinity/W", "w", (n, n)), ("spectral/U", "u", (n, line["k"]))):
            if f"{name}_value" in columns:  # a stage of another's may have left it out
                log(entity, rr.Tensor(_matrix(name, columns, row, shape)))
        log("spectral/eigenvalues", rr.BarChart(line["eigenvalues"]))
        log("kmeans/labels", rr.Tensor(clusters))
        log("report/openings", rr.Arrows3D(vectors=ahead))
        log("report/place", rr.TextDocument(f"{line['place']}: {line['junctions']} walls, {len(ahead)} openings"))


def _row(column: Any, row: int, width: int = 1) -> NDArray[Any]:
    """The list of a row, of entries of ``width`` values."""
    starts, values = column
    of_row: NDArray[Any] = values[width * starts[row] : width * starts[row + 1]]
    return of_row


def _matrix(name: str, columns: dict[str, Any], row: int, shape: tuple[int, int]) -> NDArray[np.float64]:
    """All entries of W or U."""
    starts, of_entry, values = (_row(columns[f"{name}_{part}"], row) for part in ("row_start", "column", "value"))
    if len(starts) == 0:
        return values.reshape(shape)
    matrix = np.zeros(shape)
    entries = [int(end) - int(start) for start, end in zip(starts, starts[1:])]
    matrix[np.repeat(np.arange(shape[0]), entries), of_entry] = values
    return matrix

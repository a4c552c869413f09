"""Frames as a recording for the Rerun viewer; needs rerun-sdk.

Entities are named as in the recordings of ``crosscut run --save``, but these are drawn by the program and hold more.
"""

from __future__ import annotations

import json
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr
from numpy.typing import NDArray

from . import _frames, _native


class Recording:
    """A file that is there once it is whole, under another name before. Frames are taken as they are after kmeans, with W and U."""

    def __init__(self, path: Path, engine: _native.Engine) -> None:
        self._path, self._unfinished = path, path.with_name(f".{path.name}.unfinished")
        self._engine = engine
        self._stream = rr.RecordingStream("crosscut", recording_id=path.name)
        self._stream.save(self._unfinished)

    def __enter__(self) -> Recording:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()

    def close(self) -> None:
        if self._unfinished.exists():
            self._stream.disconnect()
            self._unfinished.replace(self._path)

    def add(self, frames: pa.StructArray) -> None:
        """The frames that have not failed."""
        # Each frame is reported by itself: a flight would add to the line, and is that of the last node.
        lines, _ = self._engine.report(_frames.columns(frames), self._engine.flight_map())
        for row, line in enumerate(map(json.loads, lines.splitlines())):
            self._log(line, {name: frames.field(name)[row] for name in (*_frames.W, *_frames.U, "points_m", "clusters")})

    def _log(self, line: dict[str, Any], columns: dict[str, pa.Scalar]) -> None:
        log = self._stream.log
        points_m = _values(columns["points_m"]).flatten().to_numpy().reshape(-1, 3)
        clusters = _values(columns["clusters"]).to_numpy()
        bearings = [opening["bearing_rad"] for opening in line["openings"]]
        n = len(points_m)
        self._stream.set_time("revolution", sequence=line["seq"])
        self._stream.set_time("stamp", timestamp=np.datetime64(line["stamp_ns"], "ns"))
        log("scan/points", rr.Points3D(points_m, class_ids=clusters + 1))
        log("affinity/W", rr.Tensor(_matrix("w", columns, [n, n]), dim_names=("return", "return")))
        log("spectral/eigenvalues", rr.BarChart(line["eigenvalues"]))
        log("spectral/U", rr.Tensor(_matrix("u", columns, [n, line["k"]]), dim_names=("return", "eigenvector")))
        log("kmeans/labels", rr.Tensor(clusters, dim_names=("return",)))
        log("report/openings", rr.Arrows3D(vectors=[[2.0 * np.cos(a), 2.0 * np.sin(a), 0.0] for a in bearings]))
        log("report/place", rr.TextDocument(f"{line['place']}: {line['junctions']} walls, {len(bearings)} openings"))


def _values(cell: pa.Scalar) -> pa.Array:
    values: pa.Array = cell.values
    return values


def _matrix(name: str, columns: dict[str, pa.Scalar], shape: list[int]) -> NDArray[np.float64]:
    """All entries of W or U."""
    starts, of_entry, values = (_values(columns[f"{name}_{part}"]).to_numpy() for part in ("row_start", "column", "value"))
    if len(starts) == 0:
        return values.reshape(shape)
    matrix = np.zeros(shape)
    matrix[np.repeat(np.arange(shape[0]), np.diff(starts.astype(np.int64))), of_entry] = values
    return matrix

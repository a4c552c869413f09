"""Frames as Arrow: what the stages give each other when each runs in a process of its own.

A message is a struct array, a row for each frame, with the columns of ``crosscut.frames`` that are known so far, which says what
they mean. A stage takes those that it reads, adds its own, and passes on all others, also such as it does not know. W ends at the
spectral stage, U at kmeans; where the flight is recorded, both end there.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from typing import Any, TypeAlias

import crosscut
import numpy as np
import pyarrow as pa
from crosscut import frames as stages

_F64S, _I32S, _U32S, _U64S = (pa.list_(kind) for kind in (pa.float64(), pa.int32(), pa.uint32(), pa.uint64()))

SCAN: dict[str, pa.DataType] = {
    "seq": pa.uint64(),
    "stamp_ns": pa.uint64(),
    "frame_id": pa.string(),
    "points_m": pa.list_(pa.list_(pa.float64(), 3)),
    "has_beams": pa.bool_(),
    "ranges_m": pa.list_(pa.float32()),
    "bearings_rad": _F64S,
    "return_of_beam": _I32S,
    "step_rad": pa.float64(),
    "range_max_m": pa.float64(),
    "full_turn": pa.bool_(),
    "missing_beams": pa.uint64(),
    "wire_geometry": pa.list_(pa.float32(), 4),
    "odometry": _F64S,
}
PROGRESS: dict[str, pa.DataType] = {
    "notes": pa.list_(pa.string()),
    "timings_ns": pa.list_(pa.uint64(), 5),
    "failed_step": pa.string(),
    "failure": pa.string(),
    "panicked": pa.bool_(),
}
W: dict[str, pa.DataType] = {"w_row_start": _U64S, "w_column": _U32S, "w_value": _F64S}
VERDICTS: dict[str, pa.DataType] = {
    "verdict_returns": pa.list_(pa.list_(pa.uint32(), 2)),
    "verdict_is_opening": pa.list_(pa.bool_()),
    "verdict_room_ratio": _F64S,
    "verdict_p": _F64S,
    "verdict_reason": pa.list_(pa.string()),
}
SPECTRUM: dict[str, pa.DataType] = {
    "eigenvalues": _F64S,
    "k": pa.uint64(),
    "zero_tolerance": pa.float64(),
    "margin_decades": pa.float64(),
}
U: dict[str, pa.DataType] = {"u_row_start": _U64S, "u_column": _U32S, "u_value": _F64S}
CLUSTERS: dict[str, pa.DataType] = {"clusters": _I32S}

COLUMNS = {**SCAN, **PROGRESS, **W, **VERDICTS, **SPECTRUM, **U, **CLUSTERS}
READ_LAST_BY = {"affinity": {}, "spectral": W, "kmeans": U}
"""Columns that no later stage reads."""


def of_scans(engine: crosscut.Engine, scans: list[crosscut.Scan], first_seq: int) -> pa.StructArray:
    """Scans as frames before the first stage."""
    return _struct(_arrays(stages.of_scans(engine, scans, first_seq)))


def after(stage: str, engine: crosscut.Engine, frames: pa.StructArray, *, recorded: bool = False) -> pa.StructArray:
    """The frames after a stage, with all columns if they are to be recorded. A stage that fails on a frame leaves that in its
    ``failed_step``."""
    made = stages.run(engine, stage, columns(frames))
    kept = frames if recorded else without(READ_LAST_BY[stage], frames)
    return _struct({**_fields(kept), **_arrays(made)})


def without(names: Collection[str], frames: pa.StructArray) -> pa.StructArray:
    """The frames without these columns."""
    return _struct({name: array for name, array in _fields(frames).items() if name not in names})


def columns(frames: pa.StructArray) -> dict[str, Any]:
    """As ``crosscut.frames`` takes them: arrays of numpy; of lists and texts, the starts beside the values."""
    if not pa.types.is_struct(frames.type):
        raise ValueError(f"frames are a struct array, not {frames.type}")
    try:
        return _read(frames)
    except _NotPlain:
        return _read(_plain(frames))


def _fields(frames: pa.StructArray) -> dict[str, pa.Array]:
    return {field.name: frames.field(at) for at, field in enumerate(frames.type)}


def _struct(arrays: dict[str, pa.Array]) -> pa.StructArray:
    return pa.StructArray.from_arrays(list(arrays.values()), list(arrays))


def _arrays(made: dict[str, Any]) -> dict[str, pa.Array]:
    return {name: _array(COLUMNS[name], column) for name, column in made.items()}


def _array(kind: pa.DataType, column: Any) -> pa.Array:
    if pa.types.is_string(kind):
        starts, utf8 = column
        return pa.StringArray.from_buffers(len(starts) - 1, pa.py_buffer(starts), pa.py_buffer(utf8))
    if pa.types.is_list(kind):
        starts, values = column
        return pa.ListArray.from_arrays(pa.array(starts), _array(kind.value_type, values))
    if pa.types.is_fixed_size_list(kind):
        return pa.FixedSizeListArray.from_arrays(_array(kind.value_type, column), kind.list_size)
    return pa.array(column)


# Frames are read by all of their buffers at once, with readers that are made once: array by array it takes three times as
# long, which is a good part of a hop.

Buffers: TypeAlias = "Iterator[pa.Buffer | None]"


class _NotPlain(Exception):
    """A column is unknown, of another type, or may have nulls, or the rows are a part of longer arrays."""


_READERS_OF: list[tuple[pa.DataType, dict[str, Callable[[Buffers, int], Any]]]] = []
"""The readers of each type of frames that has arrived: a few, as each stage has its own."""

_ALL_VALID = pa.py_buffer(b"\xff" * 2**20)


def _read(frames: pa.StructArray) -> dict[str, Any]:
    kind = frames.type
    readers = next((readers for known, readers in _READERS_OF if known == kind), None)
    if readers is None:
        fields = [kind.field(at) for at in range(kind.num_fields)]
        if any(COLUMNS.get(field.name) != field.type for field in fields):
            raise _NotPlain
        readers = {field.name: _reader(field.type) for field in fields}
        _READERS_OF.append((kind, readers))
    if frames.offset:
        raise _NotPlain
    buffers, rows = iter(frames.buffers()), len(frames)
    _skip_validity(buffers)
    return {name: read(buffers, rows) for name, read in readers.items()}


def _reader(kind: pa.DataType) -> Callable[[Buffers, int], Any]:
    """What makes arrays of numpy of the buffers of a column with this many values."""

    def read_text(buffers: Buffers, length: int) -> Any:
        return _starts(buffers, length), _numbers(next(buffers), np.uint8)

    def read_lists(buffers: Buffers, length: int) -> Any:
        starts = _starts(buffers, length)
        return starts, of_values(buffers, int(starts[-1]))

    def read_entries(buffers: Buffers, length: int) -> Any:
        _skip_validity(buffers)
        return of_values(buffers, kind.list_size * length)

    def read_bits(buffers: Buffers, length: int) -> Any:
        _skip_validity(buffers)
        bits = np.unpackbits(_numbers(next(buffers), np.uint8), bitorder="little")
        return bits[:length].view(np.bool_)

    def read_numbers(buffers: Buffers, length: int) -> Any:
        _skip_validity(buffers)
        return _numbers(next(buffers), of_numpy)[:length]

    if pa.types.is_string(kind):
        return read_text
    if pa.types.is_boolean(kind):
        return read_bits
    if pa.types.is_primitive(kind):
        of_numpy = kind.to_pandas_dtype()
        return read_numbers
    of_values = _reader(kind.value_type)
    return read_lists if pa.types.is_list(kind) else read_entries


def _starts(buffers: Buffers, length: int) -> Any:
    _skip_validity(buffers)
    starts = _numbers(next(buffers), np.int32)
    return starts[: length + 1] if len(starts) else np.zeros(1, np.int32)


def _numbers(buffer: pa.Buffer | None, kind: Any) -> Any:
    return np.frombuffer(buffer or b"", kind)


def _skip_validity(buffers: Buffers) -> None:
    validity = next(buffers)
    if validity is not None and not validity.equals(_ALL_VALID.slice(0, validity.size)):
        raise _NotPlain


def _plain(frames: pa.StructArray) -> pa.StructArray:
    """The known columns in arrays of their own, each of its type and without nulls."""
    arrays = {}
    for name, array in _fields(frames).items():
        if (kind := COLUMNS.get(name)) is None:
            continue
        if array.type != kind:
            try:
                array = array.cast(kind)
            except (pa.ArrowInvalid, pa.ArrowNotImplementedError) as error:
                raise ValueError(f"frames: column {name} is {array.type}, not {kind}: {error}") from None
        if _has_nulls(array):
            raise ValueError(f"frames: column {name} has nulls")
        arrays[name] = array
    batch = pa.RecordBatch.from_struct_array(_struct(arrays))
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, batch.schema) as stream:
        stream.write_batch(batch)
    return pa.ipc.open_stream(sink.getvalue()).read_next_batch().to_struct_array()


def _has_nulls(array: pa.Array) -> bool:
    is_list = pa.types.is_list(array.type) or pa.types.is_fixed_size_list(array.type)
    return array.null_count > 0 or (is_list and _has_nulls(array.flatten()))

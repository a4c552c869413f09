"""Frames as Arrow, and messages that arrive once and in order; without dora."""

from __future__ import annotations

import json
import random
import subprocess
from collections import deque
from pathlib import Path
from typing import Any

import crosscut
import numpy as np
import pyarrow as pa
import pytest
from conftest import in_wheel, recordings
from crosscut.frames import STAGES, finish

import crosscut_dora
from crosscut_dora import arrow
from crosscut_dora.window import Order, Window


def sent(frames: Any) -> Any:
    """The frames after a way from process to process."""
    batch = pa.RecordBatch.from_arrays([frames], ["frames"])
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, batch.schema) as stream:
        stream.write_batch(batch)
    return pa.ipc.open_stream(sink.getvalue()).read_next_batch().column(0)


def stage_by_stage(engine: crosscut.Engine, scans: list[crosscut.Scan], batch: int) -> tuple[bytes, str | None]:
    """The lines of results by stages that see nothing but Arrow."""
    flight, lines, failure = crosscut.Flight(engine), b"", None
    for first in range(0, len(scans), batch):
        frames = sent(arrow.of_scans(engine, scans[first : first + batch], first))
        for stage in STAGES:
            frames = sent(arrow.after(stage, engine, frames))
        more, failure = finish(flight, arrow.columns(frames))
        lines += more
        if failure:
            break
    return lines, failure


@pytest.mark.filterwarnings("ignore::crosscut.LossWarning")
@pytest.mark.parametrize("preset", ["default", "paper", "dbscan", "breakpoint"])
@pytest.mark.parametrize("recording", recordings())
def test_stages_apart_give_the_bytes_of_the_program(recording: Path, preset: str) -> None:
    every = 10 if preset == "default" else 100
    command: list[str | Path] = [in_wheel(), "run", recording, "--results", "-", "--quiet", "--preset", preset, "--every", str(every)]
    expected = subprocess.run(command, capture_output=True)
    assert expected.returncode in (0, 3), expected.stderr
    engine = crosscut.Engine(preset)
    lines, failure = stage_by_stage(engine, list(engine.read(recording, every=every)), batch=7)
    assert failure is None and lines.count(b"\n") > 0
    assert lines == expected.stdout


def test_frames_are_read_alike_in_whatever_form_they_arrive(tee: Path) -> None:
    engine = crosscut.Engine()
    scans = [scan for _, scan in zip(range(3), crosscut.read(tee))]
    frames = arrow.after("affinity", engine, arrow.of_scans(engine, scans, 0))
    arrays = arrow._fields(frames)
    stamps = arrays["stamp_ns"].buffers()[1]
    forms = {
        "of another process": sent(frames),
        "a part of more": pa.concat_arrays([frames[:2], frames])[2:],
        "sorted otherwise": arrow._struct(dict(reversed(arrays.items()))),
        "with 64-bit starts": arrow._struct({**arrays, "ranges_m": arrays["ranges_m"].cast(pa.large_list(pa.float32()))}),
        "with what is unknown": arrow._struct({"theirs": pa.array([1, 2, 3]), **arrays}),
    }
    for bits in (0xFF, 0x07):  # with those beyond the last row, as dora sends, and without
        validity = pa.Array.from_buffers(pa.uint64(), 3, [pa.py_buffer(bytes([bits])), stamps])
        forms[f"valid by {bits:#x}"] = arrow._struct({**arrays, "stamp_ns": validity})
    for form, arrived in forms.items():
        read = arrow._arrays(arrow.columns(arrived))
        assert set(read) == set(arrays), form
        for name, array in arrays.items():
            assert read[name].equals(array), (form, name)
    empty = arrow.columns(sent(frames[:0]))
    assert all(array.equals(arrays[name][:0]) for name, array in arrow._arrays(empty).items())


def test_a_cloud_and_a_scan_without_returns_travel_too() -> None:
    cloud = np.random.default_rng(1).uniform(-5.0, 5.0, (200, 3))
    scans = [crosscut.Scan.from_points(cloud), crosscut.Scan([np.inf] * 90, 0.0, 0.07), crosscut.Scan.from_points(cloud[:0])]
    for engine in (crosscut.Engine(), crosscut.Engine(affinity="rbf", spectral="components")):
        apart, failure = stage_by_stage(engine, scans, batch=3)
        flight = crosscut.Flight(engine)
        assert failure is None
        whole = [flight.process(scan).to_dict() for scan in scans]
        assert [json.loads(line) for line in apart.splitlines()] == [{**line, "seq": at} for at, line in enumerate(whole)]


def test_a_stage_that_fails_ends_the_flight_after_what_was_before(tee: Path) -> None:
    calls = iter(range(100))

    def fails_on_the_third(points: Any) -> Any:
        if next(calls) == 2:
            raise ValueError("two were enough")
        return np.exp(-np.square(points[:, None] - points).sum(axis=2))

    engine = crosscut.Engine("paper", affinity=fails_on_the_third)
    scans = [scan for _, scan in zip(range(5), engine.read(tee))]
    lines, failure = stage_by_stage(engine, scans, batch=5)
    assert lines.count(b"\n") == 2
    assert failure is not None and "affinity failed on revolution 2" in failure and "two were enough" in failure


def test_columns_of_others_are_checked_and_passed_on(tee: Path) -> None:
    engine = crosscut.Engine()
    frames = arrow.after("affinity", engine, arrow.of_scans(engine, [next(iter(crosscut.read(tee)))], 0))
    arrays = arrow._fields(frames)
    theirs = arrow._struct({**arrays, "theirs": pa.array([7])})
    assert arrow.after("spectral", engine, theirs).field("theirs").to_pylist() == [7]
    n = len(arrays["points_m"][0])
    for column, wrong in {
        "w_value": pa.array([[1.0]]),
        "w_column": pa.array([[n] * len(arrays["w_column"][0])]),
        "w_row_start": pa.array([[0, 5, 3]]),
        "return_of_beam": pa.array([[n]]),
        "seq": pa.array(["a"]),
        "odometry": pa.array([[1.0]]),
        "notes": pa.array([None], pa.list_(pa.string())),
    }.items():
        with pytest.raises(ValueError, match=column.split("_")[0]):
            arrow.after("spectral", engine, arrow._struct({**arrays, column: wrong}))
    del arrays["w_value"]
    with pytest.raises(KeyError, match="w_value"):
        arrow.after("spectral", engine, arrow._struct(arrays))


def test_the_size_of_a_frame_is_that_of_what_is_read_later(tee: Path) -> None:
    engine = crosscut.Engine("paper")
    frames = arrow.of_scans(engine, [next(iter(crosscut.read(tee)))], 0)
    sizes = [frames.nbytes]
    for stage in STAGES:
        frames = arrow.after(stage, engine, frames)
        sizes.append(frames.nbytes)
    n = len(frames.field("points_m")[0])
    assert sizes[1] > 8 * n * n > 20 * max(sizes[0], sizes[2], sizes[3]), sizes


@pytest.mark.parametrize("seed", range(20))
def test_every_message_arrives_once_and_in_order_over_a_way_that_loses_some(seed: int) -> None:
    chance = random.Random(seed)
    now_s, size, count = 0.0, chance.choice([1, 4, 32]), 200
    way: deque[tuple[int, int, str]] = deque()
    acknowledgements: deque[tuple[int, int]] = deque()
    lost_all_until_s = 3.0 if seed % 2 else 0.0

    def is_lost() -> bool:
        return now_s < lost_all_until_s or chance.random() < 0.2

    def send(number: int, transmission: int, message: str) -> None:
        if not is_lost():
            way.append((number, transmission, message))

    window: Window[str] = Window(send, size, lambda: now_s)
    order: Order[str] = Order()
    arrived: list[str] = []
    added = 0
    while added < count or len(window):
        while added < count and window.has_room:
            window.add(f"message {added}")
            added += 1
        assert len(window) <= size and len(way) <= 2 * size, "what is on the way is bounded"
        if way and chance.random() < 0.7:
            number, transmission, message = way.popleft()
            arrived += order.take(number, message)
            assert len(order._early) < size
            if not is_lost():
                acknowledgements.append((number, transmission))
        elif acknowledgements:
            window.acknowledge(*acknowledgements.popleft())
        elif not way:
            now_s += window.patience_s + 1e-9
            window.repeat()
        assert now_s < 2000.0, "it comes to an end"
    assert arrived == [f"message {number}" for number in range(count)]
    assert window.resent > 0


def test_nothing_is_sent_again_where_nothing_is_lost() -> None:
    way: deque[tuple[int, int]] = deque()
    window: Window[None] = Window(lambda number, transmission, _: way.append((number, transmission)), 8, lambda: 0.0)
    for _ in range(100):
        while window.has_room:
            window.add(None)
        window.acknowledge(*way.popleft())
        window.repeat()
    assert window.resent == 0


def test_the_package_is_of_the_version_of_crosscut() -> None:
    assert crosscut_dora.__version__ == crosscut.__version__

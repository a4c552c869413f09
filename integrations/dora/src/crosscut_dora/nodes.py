"""The nodes of a dataflow: each takes the messages of the one before and passes them on."""

from __future__ import annotations

import argparse
import contextlib
import itertools
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pyarrow as pa

from crosscut import Engine, Error, Flight, Recorder
from crosscut import frames as stages

from . import arrow
from .window import Order, Window

DONE, FAILED, WRONG_USAGE, SOMETHING_LOST = 0, 1, 2, 3

STALL_S = 5.0
"""After so long without an acknowledgement, that is reported."""


def source(node: Any, engine: Engine, args: argparse.Namespace) -> int:
    """Sends the scans of a recording as frames, as fast as they are acknowledged."""

    def send(number: int, transmission: int, message: tuple[Any, dict[str, Any]]) -> None:
        value, about = message
        node.send_output("frames", value, {"number": number, "transmission": transmission, **about})

    def messages() -> Iterator[tuple[Any, dict[str, Any]]]:
        recording = engine.read(args.flight, args.topic or None, from_s=args.from_s, to_s=args.to_s, every=args.every)
        waiting_scans = iter(recording)
        about, first = {"ended": True, "failed": ""}, 0
        while True:
            scans = []
            try:
                for scan in itertools.islice(waiting_scans, args.batch):
                    scans.append(scan)
            except Error as error:  # what was read before it counts
                about["failed"] = str(error)
            if scans:
                yield arrow.of_scans(engine, scans, first), {"ended": False, "failed": ""}
                first += len(scans)
            if len(scans) < args.batch:
                break
        yield pa.array(recording.losses, pa.string()), about

    window: Window[tuple[Any, dict[str, Any]]] = Window(send, args.window)
    waiting, stalled, lost = messages(), False, 0
    ended = False
    while not ended or len(window):
        while not ended and window.has_room:
            value, about = next(waiting)
            ended = about["ended"]
            lost = len(value) if ended else 0
            window.add((value, about))
        event = _next(node, window.patience_s)
        if event is None:
            window.repeat()
        elif event["type"] == "STOP":
            raise Error("the dataflow was stopped before its end")
        elif event["type"] == "INPUT":
            about = event["metadata"]
            window.acknowledge(about["number"], about["transmission"])
            if about["failed"]:
                return FAILED  # the last node has said why
        if stalled != (window.silent_s > STALL_S):
            stalled = not stalled
            what = f"no frame has arrived for {STALL_S:.0f} s: is a stage or a daemon down?" if stalled else "frames arrive again"
            print(f"warning: {what}", file=sys.stderr, flush=True)
    print(f"{window.resent} messages sent again", file=sys.stderr)
    return SOMETHING_LOST if lost else DONE


def stage(node: Any, engine: Engine, name: str, recorded: bool) -> int:
    """Runs one stage on all frames that come."""
    for event in _inputs(node):
        value, about = event["value"], event["metadata"]
        if not about["ended"] and not about["failed"]:
            try:
                value = arrow.after(name, engine, value, recorded=recorded)
            except (ValueError, KeyError) as error:  # of a stage of another's
                about["failed"] = f"{name}: {error}"
        node.send_output("frames", value, _own(about))
    return DONE


def record(node: Any, engine: Engine, path: Path) -> int:
    """Records the frames for the viewer, each once, and passes on what the report reads."""
    order, failed, recording = Order[Any](), "", None
    try:
        recording = Recorder(path, engine)
    except (Error, ImportError) as error:
        failed = f"record: {error}"
    for event in _inputs(node):
        value, about = event["value"], event["metadata"]
        for frames, ended in order.take(about["number"], (value, about["ended"] or bool(about["failed"]))):
            if recording is not None:
                try:
                    recording.close() if ended else recording.log_frames(arrow.columns(frames))
                except (Error, ValueError, KeyError) as error:
                    failed, recording = f"record: {error}", None
        about["failed"] = about["failed"] or failed
        if not about["ended"] and not about["failed"]:
            value = arrow.without({**arrow.W, **arrow.U}, value)
        node.send_output("frames", value, _own(about))
    return DONE


def report(node: Any, engine: Engine, args: argparse.Namespace) -> int:
    """The last node: the report and the flight, in order, and the files."""
    flight, order, frames, outcome = Flight(engine), Order[Any](), 0, None
    with contextlib.ExitStack() as opened:
        results = opened.enter_context(_whole(args.results)) if args.results else None
        for event in _inputs(node):
            about = event["metadata"]
            for value, ended, failed in order.take(about["number"], (event["value"], about["ended"], about["failed"])):
                if outcome is not None:
                    continue
                if not failed and not ended:
                    try:
                        lines, failed = stages.finish(flight, arrow.columns(value))
                    except (ValueError, KeyError) as error:  # of a stage of another's
                        lines, failed = b"", f"report: {error}"
                    frames += lines.count(b"\n")
                    if results is not None:
                        results.write(lines)
                        results.flush()
                if failed or ended:
                    opened.close()
                    if args.map:
                        with _whole(args.map) as file:
                            file.write(flight.map.to_json().encode() + b"\n")
                    outcome = _told(frames, flight, failed, value.to_pylist() if ended else [])
            failure = outcome == FAILED
            node.send_output("acks", pa.array([], pa.null()), {**_own(about), "failed": "see the last node" if failure else ""})
        if outcome is None:
            raise Error("the dataflow was stopped before its end")
    return outcome


def _told(frames: int, flight: Flight, failed: str | None, losses: list[str]) -> int:
    """Says how the flight ended; returns the exit code."""
    for loss in losses:
        print(f"warning: {loss}", file=sys.stderr)
    if failed:
        print(f"error: {failed}; saved before it: {frames} revolutions", file=sys.stderr, flush=True)
        return FAILED
    print(f"{frames} revolutions; {flight.map.summary()}", file=sys.stderr, flush=True)
    return SOMETHING_LOST if losses else DONE


@contextlib.contextmanager
def _whole(path: Path) -> Iterator[Any]:
    """A file that is there once it is whole, under another name before."""
    unfinished = path.with_name(f".{path.name}.unfinished")
    with unfinished.open("wb") as file:
        yield file
    unfinished.replace(path)


def _inputs(node: Any) -> Iterator[dict[str, Any]]:
    for event in node:
        if event["type"] == "INPUT":
            yield event
        elif event["type"] == "STOP":
            return


def _next(node: Any, patience_s: float) -> dict[str, Any] | None:
    """The next event; None if there is none for so long."""
    event: dict[str, Any] | None = node.next(timeout=max(patience_s, 0.001))
    if event is None:
        return {"type": "STOP"}
    return None if event["type"] == "ERROR" and "imeout" in event["error"] else event


def _own(about: dict[str, Any]) -> dict[str, Any]:
    """The metadata that are ours; dora adds its own."""
    return {name: about[name] for name in ("number", "transmission", "ended", "failed")}

"""Times frames through dora on this machine: `integrations/dora/run speed`.

Latency: frames leave one node at 40 Hz, with their send time; the next node takes them as arrays of numpy. Beside them, an array
of as many bytes shows what dora alone takes. Throughput: frames of 60 returns, 64 in a message, from node to node with every
message acknowledged (`window.py`).
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

import crosscut
from crosscut_dora import arrow
from crosscut_dora.window import Order, Window

HZ, FRAMES = 40, 400
MESSAGES, BATCH, SMALL, WINDOW = 1000, 64, 60, 32


def frames_of(beams: int, batch: int, stage: bool) -> pa.StructArray:
    """A room, which is seen by this many beams; with W, if the affinity has run."""
    engine = crosscut.Engine()
    scan = crosscut.Scan(np.full(beams, 3.0), -np.pi, 2 * np.pi / beams, range_max=30.0)
    frames = arrow.of_scans(engine, [scan] * batch, 0)
    return arrow.after("affinity", engine, frames) if stage else frames


WHAT = {"bytes": "an array as large as a scan, by dora alone", "scan": "a scan of 360 beams", "W": "a scan of 360 beams with its W"}


def send_in_time(node: Any, frames: pa.Array) -> None:
    start = time.monotonic()
    for number in range(FRAMES):
        time.sleep(max(0.0, start + number / HZ - time.monotonic()))
        node.send_output("frames", frames, {"sent_ns": time.monotonic_ns()})


def take_in_time(node: Any, what: str) -> None:
    latencies_ms = []
    for event in node:
        if event["type"] == "INPUT":
            if what != "bytes":
                arrow.columns(event["value"])
            latencies_ms.append((time.monotonic_ns() - event["metadata"]["sent_ns"]) / 1e6)
    p50, p99 = np.percentile(latencies_ms[HZ:], [50, 99])  # the first second is the engine's start
    print(f"{WHAT[what]}: {event_count(latencies_ms)}, one hop p50 {p50:.2f} ms, p99 {p99:.2f} ms", flush=True)


def event_count(latencies_ms: list[float]) -> str:
    return f"{len(latencies_ms)} of {FRAMES} frames at {HZ} Hz"


def send_fast(node: Any, frames: pa.StructArray) -> None:
    def send(number: int, transmission: int, message: pa.StructArray) -> None:
        node.send_output("frames", message, {"number": number, "transmission": transmission})

    window: Window[pa.StructArray] = Window(send, WINDOW)
    added, start = 0, time.monotonic()
    while added < MESSAGES or len(window):
        while added < MESSAGES and window.has_room:
            window.add(frames)
            added += 1
        event = node.next(timeout=max(window.patience_s, 0.001))
        if event["type"] == "INPUT":
            window.acknowledge(event["metadata"]["number"], event["metadata"]["transmission"])
        else:
            window.repeat()
    seconds = time.monotonic() - start
    rate = MESSAGES * len(frames) / seconds
    print(f"{rate:.0f} frames of {SMALL} returns a second, {len(frames)} in a message, {window.resent} sent again", flush=True)


def take_fast(node: Any) -> None:
    order: Order[Any] = Order()
    for event in node:
        if event["type"] == "INPUT":
            about = {name: event["metadata"][name] for name in ("number", "transmission")}
            for frames in order.take(about["number"], event["value"]):
                arrow.columns(frames)
            node.send_output("acks", pa.array([], pa.null()), about)


def node(role: str, what: str) -> None:
    from dora import Node

    if role == "send" and what.startswith("fast"):
        send_fast(Node(), frames_of(SMALL, int(what.removeprefix("fast")), stage=False))
    elif role == "send":
        frames = frames_of(360, 1, stage=what == "W")
        send_in_time(Node(), pa.array(np.zeros(frames.nbytes, np.uint8)) if what == "bytes" else frames)
    elif what.startswith("fast"):
        take_fast(Node())
    else:
        take_in_time(Node(), what)


def main() -> None:
    program = Path(sys.executable).with_name("dora")
    for what in (*WHAT, f"fast{BATCH}", "fast1"):
        sender = {"id": "send", "path": sys.executable, "args": f"{Path(__file__).resolve()} send {what}",
                  "inputs": {"acks": {"source": "take/acks", "queue_size": 2 * WINDOW}}, "outputs": ["frames"]}
        taker = {"id": "take", "path": sys.executable, "args": f"{Path(__file__).resolve()} take {what}",
                 "inputs": {"frames": {"source": "send/frames", "queue_size": 2 * WINDOW}}, "outputs": ["acks"]}
        import yaml

        with tempfile.TemporaryDirectory() as folder:
            flow = Path(folder) / "flow.yml"
            flow.write_text(yaml.safe_dump({"nodes": [sender, taker]}))
            said = subprocess.run([program, "run", flow, "--log-level", "stdout"], cwd=folder, capture_output=True, text=True)
        print("\n".join(line.split(": ", 1)[1] for line in said.stdout.splitlines() if " stdout " in line) or said.stdout)


if __name__ == "__main__":
    if len(sys.argv) == 3:
        node(*sys.argv[1:])
    else:
        main()

"""Times a live robot on this machine: `lab/run live_speed`.

First messages on their way to this process: they are as long as a scan of 360 beams in CDR and leave another process at 40 Hz, with
their send time. Over Zenoh they go through a router, over DDS straight. Then scans, from there to the line of their results,
without and with a recording beside.
"""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import zenoh

from crosscut import _dds, _zenoh

HZ, MESSAGES, BYTES = 40, 800, 1500
TOPIC, DOMAIN = "crosscut/timed", 61
LOOPBACK = """<CycloneDDS><Domain>
<General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer Address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""


def bus(where: str) -> Any:
    return _dds.Bus(DOMAIN, print) if where == "dds" else _zenoh.Bus(where, 0, None, print)


def send(where: str) -> None:
    robot = bus(where)
    robot.send_text(TOPIC, "0 ")  # DDS tells of a topic at its first message
    time.sleep(2)
    start = time.monotonic()
    for number in range(MESSAGES):
        time.sleep(max(0.0, start + number / HZ - time.monotonic()))
        robot.send_text(TOPIC, f"{time.monotonic_ns()} ".ljust(BYTES, "."))
    time.sleep(1)


def measure(name: str, where: str) -> None:
    latencies_ms = []

    def take(message: bytes, message_type: str, skipped: int | None) -> None:
        arrived_ns = time.monotonic_ns()
        sent = re.search(rb"(\d+) \.", message)
        if sent:
            latencies_ms.append((arrived_ns - int(sent[1])) / 1e6)

    heard = bus(where)
    heard.hear(TOPIC, take, *([] if where == "dds" else ["std_msgs/msg/String"]))
    subprocess.run([sys.executable, __file__, where], check=True)
    heard.close()
    p50, p99 = np.percentile(latencies_ms, [50, 99])
    print(f"{name}: {len(latencies_ms)} of {MESSAGES} at {HZ} Hz, p50 {p50:.2f} ms, p99 {p99:.2f} ms", flush=True)


def send_scans(router: str) -> None:
    from mcap.reader import make_reader

    with (Path(__file__).parents[1] / "recordings/tee.mcap").open("rb") as file:
        scans = [message.data for _, _, message in make_reader(file).iter_messages(topics=["/scan"])]
    robot = zenoh.open(_zenoh._settings(router, None))
    time.sleep(2)
    start = time.monotonic()
    for number in range(MESSAGES):
        time.sleep(max(0.0, start + number / HZ - time.monotonic()))
        scan = bytearray(scans[number % len(scans)])
        scan[4:12] = struct.pack("<II", *divmod(time.time_ns(), 10**9))  # the stamp, behind the four bytes that CDR begins with
        robot.put(TOPIC, bytes(scan))
    time.sleep(2)
    robot.close()


def measure_answers(router: str) -> None:
    """From a scan that is sent to its line of results."""
    with tempfile.TemporaryDirectory() as folder:
        for name, options in (("answers", []), ("answers, recorded", ["--save", f"{folder}/flight.rrd"])):
            command = [str(Path(sys.executable).with_name("crosscut")), "run", f"zenoh://{router}/{TOPIC}", "--as", "sensor_msgs/msg/LaserScan"]
            program = subprocess.Popen([*command, "--quiet", "--out", "-", *options], stdout=subprocess.PIPE)
            robot = subprocess.Popen([sys.executable, __file__, "scans", router])
            latencies_ms: list[float] = []
            reader = threading.Thread(target=take_lines, args=(program.stdout, latencies_ms))
            reader.start()
            robot.wait()
            program.send_signal(signal.SIGINT)
            reader.join()
            program.wait()
            # The first wait for the second in which the program looks at what it hears.
            told = latencies_ms[2 * HZ :]
            p50, p99 = np.percentile(told, [50, 99])
            print(f"{name}: {len(told)} at {HZ} Hz, p50 {p50:.2f} ms, p99 {p99:.2f} ms", flush=True)


def take_lines(lines: Any, latencies_ms: list[float]) -> None:
    for line in lines:
        arrived_ns = time.time_ns()
        latencies_ms.append((arrived_ns - json.loads(line)["stamp_ns"]) / 1e6)


def main() -> None:
    os.environ["CYCLONEDDS_URI"] = LOOPBACK
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("listen/endpoints", f'["tcp/127.0.0.1:{port}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config):
        measure("Zenoh", f"127.0.0.1:{port}")
        measure_answers(f"127.0.0.1:{port}")
    measure("DDS", "dds")


if __name__ == "__main__":
    if sys.argv[2:]:
        send_scans(sys.argv[2])
    elif sys.argv[1:]:
        send(sys.argv[1])
    else:
        main()

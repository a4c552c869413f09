"""Times messages of a live robot on their way to this process, on this machine: `python/run live`.

Messages are as long as a scan of 360 beams in CDR and leave another process at 40 Hz, with their send time. Over Zenoh they go
through a router, over DDS straight.
"""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
import time
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
    measure("DDS", "dds")


if __name__ == "__main__":
    if sys.argv[1:]:
        send(sys.argv[1])
    else:
        main()

"""A robot that is flown over Zenoh: a real router on this machine, and recorded messages on the keys of rmw_zenoh."""

from __future__ import annotations

import struct
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from conftest import ROOT
from test_live import ODOMETRY, SCANS, network, recorded, send, wait_for_subscriber

import crosscut
from crosscut._native import Odometry

EXAMPLE = ROOT / "examples" / "python" / "fly_robot.py"

__all__ = ["network"]


def test_a_robot_on_zenoh_gets_the_commands_of_its_scans(network: tuple[Any, int], tee: Path) -> None:
    session, port = network
    heard: list[tuple[str, bytes, bytes]] = []
    listener = session.declare_subscriber(
        "7/robot1/cmd_vel/**",
        lambda sample: heard.append((str(sample.key_expr), sample.payload.to_bytes(), sample.attachment.to_bytes())),
    )
    topics = ["--odometry", "/robot1/odom", "--command", "/robot1/cmd_vel"]
    robot = subprocess.Popen([sys.executable, EXAMPLE, f"zenoh://127.0.0.1:{port}/robot1/scan?domain=7", *topics])
    try:
        wait_for_subscriber(session, SCANS)
        wait_for_subscriber(session, ODOMETRY)
        # No scan waits for its odometry, however slow this machine is.
        messages = sorted(recorded(tee)[:120], key=lambda message: message[0] == SCANS)
        scans = [data for key, data in messages if key == SCANS]
        send(session, messages, 0.02)
        deadline = time.monotonic() + 30
        while len(heard) < len(scans) and time.monotonic() < deadline:
            time.sleep(0.05)
    finally:
        robot.terminate()
        assert robot.wait(30) == 0
    listener.undeclare()

    odometry = Odometry()
    for key, data in messages:
        if key == ODOMETRY:
            odometry.add(data, "nav_msgs/msg/Odometry")
    navigator = crosscut.Navigator(speed_max_m_s=0.5, turn_rate_max_rad_s=0.8)
    expected = []
    for data in scans:
        scan, pose = odometry.beside(crosscut.Scan.from_message(data))
        assert pose is not None
        command = navigator.step(scan)
        expected.append((command.speed_m_s, 0.0, 0.0, 0.0, 0.0, command.turn_rate_rad_s))
    twists = [struct.unpack("<6d", payload[4:]) for _, payload, _ in heard]
    assert twists[:-1] == expected
    assert twists[-1] == (0.0,) * 6, "it stands when it is told to end"
    assert np.abs(expected).max() > 0.3, "it flies"
    assert all(payload[:4] == b"\0\1\0\0" and len(attached) == 33 for _, payload, attached in heard)
    assert heard[0][0].startswith("7/robot1/cmd_vel/geometry_msgs::msg::dds_::Twist_/RIHS01_")


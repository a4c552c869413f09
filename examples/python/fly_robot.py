"""Flies a robot through all of a mine and home: its scans and odometry in, geometry_msgs/Twist out, over Zenoh.

    python examples/python/fly_robot.py robot.local:7447 --width-m 0.6 --speed-m-s 0.8

The robot turns on the spot, and its base is to stop by itself when commands cease: the network may fail. ROS need not be
installed here; on the robot it speaks rmw_zenoh.
"""

from __future__ import annotations

import argparse
import json
import secrets
import signal
import struct
import time

import zenoh

import crosscut
import crosscut.live

TWIST = "geometry_msgs::msg::dds_::Twist_/RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
"""The type in keys of rmw_zenoh, with the hash of its definition."""


class Base:
    """Sends commands to the base of a robot, each with its number, stamp and sender as rmw_zenoh attaches them."""

    def __init__(self, endpoint: str, key: str) -> None:
        config = zenoh.Config()
        config.insert_json5("mode", '"client"')
        config.insert_json5("connect/endpoints", json.dumps([f"tcp/{endpoint}"]))
        self._session, self._key = zenoh.open(config), key
        self._sender, self._sent = secrets.token_bytes(16), 0

    def drive(self, speed_m_s: float, turn_rate_rad_s: float) -> None:
        """Sends a Twist in CDR, little endian: linear x, y, z in m/s, angular x, y, z in rad/s."""
        self._sent += 1
        attachment = struct.pack("<qqB16s", self._sent, time.time_ns(), 16, self._sender)
        twist = struct.pack("<4s6d", b"\0\1\0\0", speed_m_s, 0, 0, 0, 0, turn_rate_rad_s)
        self._session.put(self._key, twist, attachment=attachment)

    def close(self) -> None:
        """Stops the robot."""
        self.drive(0.0, 0.0)
        self._session.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("endpoint", metavar="HOST:PORT", help="the robot's Zenoh router")
    parser.add_argument("--scan", default="/scan")
    parser.add_argument("--odometry", default="/odom")
    parser.add_argument("--command", default="/cmd_vel")
    parser.add_argument("--domain", type=int, default=0, help="ROS domain [default: 0]")
    parser.add_argument("--planner", default="nearest_frontier")
    parser.add_argument("--width-m", type=float, default=0.6, help="the robot's diameter [default: 0.6]")
    parser.add_argument("--speed-m-s", type=float, default=0.5, help="its largest speed [default: 0.5]")
    parser.add_argument("--turn-rate-rad-s", type=float, default=0.8, help="its largest turn rate [default: 0.8]")
    args = parser.parse_args()
    limits = {"speed_max_m_s": args.speed_m_s, "turn_rate_max_rad_s": args.turn_rate_rad_s}
    navigator = crosscut.Navigator(crosscut.Engine(vehicle={"width_m": args.width_m}), args.planner, **limits)
    address = f"zenoh://{args.endpoint}/{args.scan.strip('/')}"
    base = Base(args.endpoint, f"{args.domain}/{args.command.strip('/')}/{TWIST}")
    try:
        with crosscut.live.Robot(address, odometry=args.odometry, domain=args.domain) as robot:
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, lambda *_: robot.close())
            for scan, pose in robot:
                command = navigator.step(scan, pose)
                base.drive(command.speed_m_s, command.turn_rate_rad_s)
                if command.why or command.done:
                    print(command.end or command.why, flush=True)
                if command.done:
                    robot.close()
    finally:
        base.close()
    print(navigator.flight_map().summary())


if __name__ == "__main__":
    main()

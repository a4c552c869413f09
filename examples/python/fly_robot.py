"""Flies a robot through all of a mine and home: its scans and odometry in, geometry_msgs/Twist or TwistStamped out.

    python examples/python/fly_robot.py zenoh://robot.local:7447/scan --width-m 0.6 --speed-m-s 0.8
    python examples/python/fly_robot.py ros2://0/scan                    over DDS

The robot turns on the spot, and its base is to stop by itself when commands cease: the network may fail. ROS need not be
installed here.
"""

from __future__ import annotations

import argparse
import signal

import crosscut
import crosscut.live


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robot", metavar="ADDRESS", help="zenoh://HOST[:PORT]/TOPIC[?domain=N], or over DDS ros2://DOMAIN/TOPIC")
    parser.add_argument("--odometry", default="/odom")
    parser.add_argument("--command", default="/cmd_vel")
    parser.add_argument("--stamped", action="store_true", help="the base takes TwistStamped")
    parser.add_argument("--planner", default="nearest_frontier")
    parser.add_argument("--width-m", type=float, default=0.6, help="the robot's diameter [default: 0.6]")
    parser.add_argument("--speed-m-s", type=float, default=0.5, help="its largest speed [default: 0.5]")
    parser.add_argument("--turn-rate-rad-s", type=float, default=0.8, help="its largest turn rate [default: 0.8]")
    args = parser.parse_args()
    limits = {"speed_max_m_s": args.speed_m_s, "turn_rate_max_rad_s": args.turn_rate_rad_s}
    navigator = crosscut.Navigator(crosscut.Engine(vehicle={"width_m": args.width_m}), args.planner, **limits)
    with crosscut.live.Robot(args.robot, odometry=args.odometry) as robot:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: robot.stop())
        try:
            for scan, _ in robot:
                command = navigator.step(scan)
                robot.drive(args.command, command.speed_m_s, command.turn_rate_rad_s, stamped=args.stamped)
                if command.why or command.done:
                    print(command.end or command.why, flush=True)
                if command.done:
                    robot.stop()
        finally:
            robot.drive(args.command, 0.0, 0.0, stamped=args.stamped)
    print(navigator.map.summary())


if __name__ == "__main__":
    main()

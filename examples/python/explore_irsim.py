"""The navigator in another simulator, ir-sim: a mine of lines, and a vehicle that must find all of it and come home.

    pip install ir-sim && python examples/python/explore_irsim.py [--show]

Nothing of crosscut is set for it: detector, flight and planner are the defaults.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from pathlib import Path
from typing import Any

import irsim
import numpy as np
import shapely
import yaml

import crosscut

Pose = tuple[float, float, float]

TUNNELS = {
    "drive": ([(0, 0), (26, 0), (40, 1)], 1.8),
    "heading": ([(14, 0), (14, 8), (17, 15)], 1.6),
    "loop": ([(26, 0), (28, -12), (43, -13), (40, 1)], 1.7),
    "stope": ([(40, 1), (55, 8)], 2.0),
}
"""Centrelines and half widths, metres. The vehicle starts at the first place of the first one."""

SIGHTS = {"heading": (17, 15, 7.0), "loop": (35.5, -12.5, 2.0), "stope": (55, 8, 7.0), "drive": (33, 0.5, 2.0)}
"""Each tunnel was seen once the vehicle was this near to this place."""

STEP_S = 0.1
HOME_M = 4.0


def world() -> dict[str, Any]:
    """The walls of the tunnels, rough, as ir-sim has them, and a vehicle with a lidar."""
    rng = np.random.default_rng(1)
    free = shapely.union_all([shapely.LineString(line).buffer(half_m) for line, half_m in TUNNELS.values()])
    walls = []
    for ring in [free.exterior, *free.interiors]:
        line = np.array(shapely.segmentize(ring, 0.7).coords)[:-1]
        line += rng.normal(0, 0.06, line.shape)
        walls.append([*line.tolist(), line[0].tolist()])
    lidar = {"name": "lidar2d", "range_max": 30, "angle_range": math.tau, "number": 360, "noise": True, "std": 0.02}
    return {
        "world": {"width": 75, "height": 45, "offset": [-5, -22], "step_time": STEP_S, "sample_time": STEP_S},
        "robot": {
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": 0.3},
            "state": [0, 0, 0],
            "vel_min": [-1.5, -1.0],
            "vel_max": [1.5, 1.0],
            "sensors": [lidar],
        },
        "obstacle": [{"shape": {"name": "linestring", "vertices": wall}, "state": [0, 0, 0]} for wall in walls],
    }


class Odometry:
    """Dead reckoning: 2 % too long, and off by 0.1 degrees a second."""

    def __init__(self) -> None:
        self.pose: Pose = (0.0, 0.0, 0.0)
        self._true: Pose = (0.0, 0.0, 0.0)

    def moved_to(self, true: Pose) -> Pose:
        (x, y, yaw), (x_m, y_m, yaw_rad) = self._true, self.pose
        ahead_m = 1.02 * ((true[0] - x) * math.cos(yaw) + (true[1] - y) * math.sin(yaw))
        turned_rad = math.remainder(true[2] - yaw, math.tau) + math.radians(0.1) * STEP_S
        self.pose = (x_m + ahead_m * math.cos(yaw_rad), y_m + ahead_m * math.sin(yaw_rad), yaw_rad + turned_rad)
        self._true = true
        return self.pose


def explore(show: bool = False, most_steps: int = 6000) -> tuple[crosscut.Command, set[str], float, int, str]:
    """The last command, the tunnels seen, how far from the start it ended, the steps in contact, and the map in a line."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "mine.yaml")
        path.write_text(yaml.safe_dump(world()))
        simulator = irsim.make(str(path), display=show, log_level="WARNING")
    navigator, odometry = crosscut.Navigator(), Odometry()
    seen: set[str] = set()
    contacts = 0
    for step in range(most_steps):
        scan = simulator.get_lidar_scan()
        ranges = np.where(scan["ranges"] < scan["range_max"], scan["ranges"], np.inf)
        stamp_ns = round(step * STEP_S * 1e9)
        x_m, y_m, yaw_rad = (float(value) for value in simulator.get_robot_state().ravel()[:3])
        revolution = crosscut.Scan(ranges, scan["angle_min"], scan["angle_increment"], range_max=30.0, stamp_ns=stamp_ns)
        command = navigator.step(revolution, odometry.moved_to((x_m, y_m, yaw_rad)))
        if command.why:
            print(f"{step * STEP_S:6.1f} s at ({x_m:5.1f}, {y_m:5.1f}): {command.why}")
        seen |= {name for name, (x, y, near_m) in SIGHTS.items() if math.hypot(x - x_m, y - y_m) < near_m}
        contacts += bool(simulator.robot.collision)
        if command.done:
            break
        simulator.step(np.array([[command.speed_m_s], [command.turn_rate_rad_s]]))
        if show:
            simulator.render()
    simulator.end(0)
    return command, seen, math.hypot(x_m, y_m), contacts, navigator.map.summary()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--show", action="store_true", help="show ir-sim's window")
    command, seen, home_m, contacts, summary = explore(parser.parse_args().show)
    print(f"{command.end}: saw {', '.join(sorted(seen))}; {home_m:.1f} m from the start; {contacts} steps in contact; {summary}")

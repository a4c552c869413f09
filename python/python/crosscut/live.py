"""A live robot: its scans in, the answers out. ROS need not be installed.

>>> import crosscut, crosscut.live
>>> flight = crosscut.FlightMap(crosscut.Engine(keep=("markers",)))
>>> with crosscut.live.Robot("zenoh://robot.local:7447/scan", odometry="/odom") as robot:
...     for scan, pose in robot:
...         result = flight.add(scan, pose)
...         robot.publish("crosscut/results", result)
...         robot.draw("crosscut/markers", result)

Robots whose ROS 2 speaks rmw_zenoh are heard as they are, through their Zenoh router (``zenoh://``, needs eclipse-zenoh);
so are those that speak DDS (``ros2://``, needs cyclonedds). From a shell:

    crosscut run zenoh://robot.local:7447/scan --odometry /odom --publish crosscut --map flight.json
    crosscut run ros2://0/scan --odometry /odom --publish crosscut --map flight.json
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import os
import signal
import sys
import threading
import time
import warnings
from bisect import bisect_left
from collections import deque
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, TypeAlias

from ._engine import Engine
from ._errors import Error, LossWarning, SettingsError
from ._flight_map import FlightMap
from ._native import Scan, poses_of_message
from ._results import Result

XyYaw: TypeAlias = "tuple[float, float, float]"

AHEAD = 16
"""Scans that wait to be taken. A robot must not be answered late: of more, the oldest are left out, and counted."""

SILENCE_S = 2.0
"""After so long without a scan, that is told."""

POSE_WAIT_S = 0.1
"""How long a scan waits for odometry that is as late as it is."""

MOST_POSE_GAP_NS = 500_000_000
"""Poses that are farther apart in time are not interpolated."""

ODOMETRY_FRAME = "odom"
"""The parent frame of the transform that is odometry."""


class Robot:
    """The scans that a robot sends, and their poses, one after the other until :meth:`close`.

    ``address``: "zenoh://HOST:PORT/TOPIC", the robot's Zenoh router (port 7447 if there is none) and the topic of its scans
    in the ROS domain ``domain``; or, with their ``message_type``, a key expression of plain messages in CDR.
    "ros2://DOMAIN/TOPIC" over DDS. ``odometry``: the topic of nav_msgs/Odometry, or "/tf".

    ``missed`` counts the scans that did not arrive or were left out; ``clock_ns`` is how far this computer's clock is ahead
    of the sensor's stamps, the way through the network included.
    """

    def __init__(
        self,
        address: str,
        *,
        odometry: str | None = None,
        domain: int = 0,
        message_type: str | None = None,
    ) -> None:
        self.missed = 0
        self.clock_ns: int | None = None
        self._scans: deque[Scan] = deque()
        self._poses = _Poses()
        self._changed = threading.Condition()
        self._unreadable: str | None = None
        self._closed = False
        scheme, _, rest = address.partition("://")
        host, _, topic = rest.partition("/")
        self._bus = _bus(scheme, host, topic, domain, message_type)
        self._poses.wanted = odometry is not None
        of_type = [] if message_type is None else [message_type]
        self._bus.hear(topic.strip("/"), partial(self._hear_scan, topic), *of_type)
        if odometry is not None:
            self._bus.hear(odometry.strip("/"), partial(self._hear_poses, odometry))

    def __iter__(self) -> Iterator[tuple[Scan, XyYaw | None]]:
        while (scan := self._next()) is not None:
            yield scan, self._pose_at(scan.stamp_ns)

    def publish(self, key: str, what: Result | FlightMap | dict[str, Any]) -> None:
        """Sends a result, a map or anything else that JSON can hold to all who subscribe to ``key``.

        Over DDS it is a std_msgs/String on the topic of that name.
        """
        self._bus.send_text(key.strip("/"), json.dumps(what if isinstance(what, dict) else what.to_dict()))

    def draw(self, topic: str, result: Result) -> None:
        """Sends walls and openings on a topic of ROS, for RViz and Foxglove, as visualization_msgs/MarkerArray.

        The engine has ``keep=("markers",)``.
        """
        if result.markers is None:
            raise ValueError('the result has no markers: the engine needs keep=("markers",)')
        self._bus.send_markers(topic.strip("/"), result.markers)

    def close(self) -> None:
        """Ends the iteration; may be called from another thread."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def __enter__(self) -> Robot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
        self._bus.close()

    def _next(self) -> Scan | None:
        silent_since = time.monotonic()
        with self._changed:
            while not self._scans and not self._closed:
                self._changed.wait(0.1)
                if time.monotonic() - silent_since > SILENCE_S:
                    silent_since = math.inf
                    told = self._unreadable or "is the topic right, and is the robot up?"
                    warnings.warn(f"no scan for {SILENCE_S:.0f} s; {told}", LossWarning, stacklevel=3)
            return None if self._closed else self._scans.popleft()

    def _pose_at(self, stamp_ns: int) -> XyYaw | None:
        with self._changed:
            if self._poses.wanted:
                self._changed.wait_for(lambda: self._closed or self._poses.reach(stamp_ns), POSE_WAIT_S)
            return self._poses.at(stamp_ns)

    def _hear_scan(self, topic: str, message: bytes, message_type: str, skipped: int) -> None:
        arrived_ns = time.time_ns()
        try:
            scan = Scan.from_message(message, message_type)
        except (Error, ValueError) as error:
            self._unreadable = f"what arrives on {topic} cannot be read: {error}"
            return
        with self._changed:
            self.clock_ns = arrived_ns - scan.stamp_ns
            self.missed += skipped
            self._scans.append(scan)
            if len(self._scans) > AHEAD:
                self._scans.popleft()
                self.missed += 1
            self._changed.notify_all()

    def _hear_poses(self, topic: str, message: bytes, message_type: str, _skipped: int) -> None:
        try:
            poses = poses_of_message(message, message_type)
        except (Error, ValueError) as error:
            self._unreadable = f"what arrives on {topic} cannot be read: {error}"
            return
        is_transform = "TFMessage" in message_type
        with self._changed:
            for stamp_ns, parent, _, x_m, y_m, yaw_rad in poses:
                if not is_transform or parent.lstrip("/") == ODOMETRY_FRAME:
                    self._poses.add(_StampedPose(stamp_ns, x_m, y_m, yaw_rad))
            self._changed.notify_all()


def _bus(scheme: str, host: str, topic: str, domain: int, message_type: str | None) -> Any:
    """What hears and sends topics: a ``Bus`` of the module for this kind of network."""
    if scheme == "zenoh":
        if not host or not topic:
            raise SettingsError("zenoh://HOST[:PORT]/TOPIC has a host and a topic")
        from . import _zenoh

        return _zenoh.Bus(host, domain)
    if scheme == "ros2":
        if not host.isdecimal() or not topic:
            raise SettingsError("ros2://DOMAIN/TOPIC has a number and a topic")
        if domain or message_type:
            raise SettingsError("a robot on DDS has its domain in ros2://DOMAIN/TOPIC, and tells its types itself")
        from . import _dds

        return _dds.Bus(int(host))
    raise SettingsError(f"a live robot is zenoh:// or ros2://, not {scheme}://")


class _StampedPose(NamedTuple):
    stamp_ns: int
    x_m: float
    y_m: float
    yaw_rad: float


class _Poses:
    """The latest poses, by stamp."""

    def __init__(self) -> None:
        self.wanted = False
        self._latest: deque[_StampedPose] = deque(maxlen=1000)

    def add(self, pose: _StampedPose) -> None:
        if not self._latest or pose.stamp_ns > self._latest[-1].stamp_ns:
            self._latest.append(pose)

    def reach(self, stamp_ns: int) -> bool:
        return bool(self._latest) and self._latest[-1].stamp_ns >= stamp_ns

    def at(self, stamp_ns: int) -> XyYaw | None:
        """Between the two poses around it; None where they are not there or far apart."""
        after = bisect_left(self._latest, stamp_ns, key=lambda pose: pose.stamp_ns)
        if after == len(self._latest):
            return None
        upper = self._latest[after]
        lower = self._latest[after - 1] if after > 0 else upper
        if upper.stamp_ns == stamp_ns:
            lower = upper
        if upper.stamp_ns - lower.stamp_ns > MOST_POSE_GAP_NS or lower.stamp_ns > stamp_ns:
            return None
        span_ns = upper.stamp_ns - lower.stamp_ns
        share = (stamp_ns - lower.stamp_ns) / span_ns if span_ns else 0.0
        turned_rad = math.remainder(upper.yaw_rad - lower.yaw_rad, math.tau)
        x_m = lower.x_m + share * (upper.x_m - lower.x_m)
        y_m = lower.y_m + share * (upper.y_m - lower.y_m)
        return x_m, y_m, lower.yaw_rad + share * turned_rad


def main(arguments: Sequence[str]) -> int:
    """``crosscut run`` on a live robot; returns the exit code of the program."""
    parser = argparse.ArgumentParser(prog="crosscut run", description="Answers to a live robot, until Ctrl-C.")
    parser.add_argument("robot", metavar="ADDRESS", help="zenoh://HOST[:PORT]/TOPIC, or over DDS ros2://DOMAIN/TOPIC")
    parser.add_argument("--odometry", metavar="TOPIC", help="of nav_msgs/Odometry, or /tf")
    parser.add_argument("--domain", type=int, default=0, help="ROS domain of a robot on Zenoh [default: 0]")
    parser.add_argument("--as", dest="message_type", metavar="TYPE", help="TOPIC is a key of plain messages of this type, CDR")
    parser.add_argument("--publish", metavar="KEY", help="send JSON to KEY/results and KEY/map, a drawing to topic KEY/markers")
    parser.add_argument("--results", metavar="FILE.jsonl", help="one JSON object per scan; - is standard output")
    parser.add_argument("--map", metavar="FLIGHT.json", type=Path, help="the map of the flight, renewed each second")
    parser.add_argument("--preset", default="default")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="changes")
    args = parser.parse_args(arguments)
    warnings.showwarning = lambda message, *_: print(f"warning: {message}", file=sys.stderr)
    warnings.simplefilter("always", LossWarning)
    try:
        flight = FlightMap(Engine.with_changes(args.preset, args.changes, ("markers",) if args.publish else ()))
        with Robot(args.robot, odometry=args.odometry, domain=args.domain, message_type=args.message_type) as robot:
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, lambda *_: robot.close())
            return _answer(robot, flight, args)
    except ImportError as error:
        print(f"error: {error}; pip install 'crosscut[live]' for zenoh://, 'crosscut[dds]' for ros2://", file=sys.stderr)
        return 2
    except Error as error:
        print(f"error: {error}", file=sys.stderr)
        return 2 if isinstance(error, ValueError) else 1


def _answer(robot: Robot, flight: FlightMap, args: argparse.Namespace) -> int:
    answered, mapped_at = 0, time.monotonic()
    with contextlib.ExitStack() as opened:
        lines = None
        if args.results:
            lines = sys.stdout if args.results == "-" else opened.enter_context(open(args.results, "w"))
        for scan, pose in robot:
            result = flight.add(scan, pose)
            answered += 1
            if args.publish:
                robot.publish(f"{args.publish}/results", result)
                robot.draw(f"{args.publish}/markers", result)
            if lines is not None:
                print(json.dumps(result.to_dict()), file=lines, flush=True)
            if time.monotonic() - mapped_at >= 1.0:
                mapped_at = time.monotonic()
                _write_map(robot, flight, args)
    _write_map(robot, flight, args)
    clock = "" if robot.clock_ns is None else f"; this clock is {robot.clock_ns / 1e9:.3f} s ahead of the stamps"
    print(f"{answered} scans answered, {robot.missed} missed{clock}; {flight.summary()}", file=sys.stderr)
    return 3 if robot.missed else 0


def _write_map(robot: Robot, flight: FlightMap, args: argparse.Namespace) -> None:
    if args.publish:
        robot.publish(f"{args.publish}/map", flight)
    if args.map:
        unfinished = args.map.with_name(f".{args.map.name}.{os.getpid()}")
        unfinished.write_text(json.dumps(flight.to_dict()))
        unfinished.replace(args.map)

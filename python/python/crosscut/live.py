"""A live robot: its scans in, the answers out. ROS need not be installed.

>>> import crosscut, crosscut.live
>>> flight = crosscut.Flight(crosscut.Engine(keep=("markers",)))
>>> with crosscut.live.Robot("zenoh://robot.local:7447/scan", odometry="/odom") as robot:
...     for scan, pose in robot:
...         result = flight.process(scan)
...         robot.publish("crosscut/results", result)
...         robot.draw("crosscut/markers", result)

Robots whose ROS 2 speaks rmw_zenoh are heard as they are, through their Zenoh router (``zenoh://``, needs eclipse-zenoh);
so are those that speak DDS (``ros2://``, needs cyclonedds). From a shell:

    crosscut run zenoh://robot.local:7447/scan --set ingest.odometry=/odom --publish crosscut --map flight.json
    crosscut run ros2://0/scan --set ingest.odometry=/odom --publish crosscut --map flight.json
"""

from __future__ import annotations

import json
import math
import os
import statistics
import struct
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterator
from functools import partial
from types import TracebackType
from typing import Any, TypeAlias
from urllib.parse import unquote

from ._errors import Error, LossWarning, SettingsError
from ._extras import importing
from ._flight import Map
from ._native import Odometry, Scan
from ._results import Result

XyYaw: TypeAlias = "tuple[float, float, float]"

AHEAD = 16
"""Scans that wait to be taken. A robot must not be answered late: of more, the oldest are left out, and counted."""

SILENCE_S = 2.0
"""After so long without a scan, that is told."""

POSE_WAIT_S = 0.2
"""How long a scan waits for the odometry up to its end, from when it arrives: one of 0.1 s may be sent as it begins."""

LEAST_INTERVALS = 5
"""Fewer stamps do not show the usual interval."""


class Robot:
    """The scans that a robot sends, and their poses by odometry, one after the other until :meth:`stop` or :meth:`close`.

    A scan brings the odometry around it along: a flight or a navigator that it is added to corrects it for the motion of the
    robot, and knows its pose. The pose beside it is that in the middle of the scan; None where odometry does not tell it.

    ``address``: "zenoh://HOST:PORT/TOPIC", the robot's Zenoh router (port 7447 if there is none) and the topic of its scans;
    or, with their ``message_type``, a key expression of plain messages in CDR. "?domain=N" behind it is a ROS domain other
    than 0, "?config=FILE.json5" a configuration of Zenoh, whose TLS settings and user are taken, and with "zenoh:///TOPIC" also
    its endpoint of the router; "&" joins both. "ros2://DOMAIN/TOPIC" over DDS. ``odometry``: the topic of nav_msgs/Odometry, or
    "/tf".

    ``missed`` counts the scans that did not arrive, where their messages are numbered, or were left out; ``gaps`` counts those
    that are missing by the usual interval of the stamps, where messages are not numbered, as over DDS. ``clock_ns`` is how far
    this computer's clock is ahead of the sensor's stamps, the way through the network included. ``losses`` are the messages that
    cannot be read. Where the network can no longer be heard, the iteration ends with an :class:`Error`.
    """

    def __init__(
        self,
        address: str,
        *,
        odometry: str | None = None,
        message_type: str | None = None,
    ) -> None:
        self.missed = self.gaps = 0
        self.clock_ns: int | None = None
        self._scans: deque[tuple[Scan, float]] = deque()  # and until when each waits for odometry
        self._odometry = None if odometry is None else Odometry()
        self._stamps = _Stamps()
        self._changed = threading.Condition()
        self._unreadable: dict[str, tuple[int, str]] = {}  # by topic: how many, and why the first
        self._failure: BaseException | None = None
        self._stopped = self._closed = False
        self._bus, topic = _bus(address, message_type, self._fail)
        of_type = [] if message_type is None else [message_type]
        self._bus.hear(topic.strip("/"), partial(self._hear_scan, topic), *of_type)
        if odometry is not None:
            self._bus.hear(odometry.strip("/"), partial(self._hear_odometry, odometry))

    def __iter__(self) -> Iterator[tuple[Scan, XyYaw | None]]:
        while (taken := self._next()) is not None:
            yield self._with_odometry(*taken)

    @property
    def losses(self) -> list[str]:
        """What could not be read so far: how many messages of each topic, and why."""
        return [f"{count} messages on {topic} cannot be read; the first: {why}" for topic, (count, why) in self._unreadable.items()]

    def publish(self, key: str, what: Result | Map | dict[str, Any]) -> None:
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
        self._bus.send(topic.strip("/"), "visualization_msgs/MarkerArray", result.markers)

    def drive(
        self, topic: str, speed_m_s: float, turn_rate_rad_s: float, *, stamped: bool = False, frame_id: str = "base_link"
    ) -> None:
        """Sends a command to the base of the robot, as geometry_msgs/Twist on a topic of ROS such as "/cmd_vel".

        ``stamped``: as geometry_msgs/TwistStamped, which newer bases take, in this frame and by the robot's clock as far as it is
        known (``clock_ns``).
        """
        header = b""
        if stamped:
            stamp_ns = time.time_ns() - (self.clock_ns or 0)
            of_frame = frame_id.encode() + b"\0"
            header = struct.pack("<iII", stamp_ns // 10**9, stamp_ns % 10**9, len(of_frame)) + of_frame
            header += bytes(-len(header) % 8)
        twist = b"\0\1\0\0" + header + struct.pack("<6d", speed_m_s, 0, 0, 0, 0, turn_rate_rad_s)
        self._bus.send(topic.strip("/"), "geometry_msgs/TwistStamped" if stamped else "geometry_msgs/Twist", twist)

    def stop(self) -> None:
        """Ends the iteration; may be called from another thread and by a handler of signals. What is sent still arrives."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    def close(self) -> None:
        """Ends the iteration and the connection."""
        self.stop()
        if not self._closed:
            self._closed = True
            self._bus.close()

    def __enter__(self) -> Robot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _next(self) -> tuple[Scan, float] | None:
        silent_since = time.monotonic()
        with self._changed:
            while not self._scans and not self._stopped:
                if self._failure is not None:
                    failure = self._failure
                    raise Error(f"the robot can no longer be heard: {type(failure).__name__}: {failure}") from failure
                self._changed.wait(0.1)
                if time.monotonic() - silent_since > SILENCE_S:
                    silent_since = math.inf
                    told = "; ".join(self.losses) or "is the topic right, and is the robot up?"
                    warnings.warn(f"no scan for {SILENCE_S:.0f} s; {told}", LossWarning, stacklevel=3)
            return None if self._stopped else self._scans.popleft()

    def _with_odometry(self, scan: Scan, until: float) -> tuple[Scan, XyYaw | None]:
        if (odometry := self._odometry) is None:
            return scan, None
        with self._changed:
            self._changed.wait_for(lambda: self._stopped or odometry.reaches(scan), max(0.0, until - time.monotonic()))
        return odometry.beside(scan)

    def _fail(self, failure: BaseException) -> None:
        """Takes the exception with which hearing ended."""
        with self._changed:
            self._failure = failure
            self._changed.notify_all()

    def _lose(self, topic: str, why: Exception) -> None:
        """Counts a message that cannot be read."""
        with self._changed:
            count, first = self._unreadable.get(topic, (0, str(why)))
            self._unreadable[topic] = count + 1, first

    def _hear_scan(self, topic: str, message: bytes, message_type: str, skipped: int | None) -> None:
        arrived_ns = time.time_ns()
        try:
            scan = Scan.from_message(message, message_type)
        except (Error, ValueError) as error:
            self._lose(topic, error)
            return
        with self._changed:
            self.clock_ns = arrived_ns - scan.stamp_ns
            missing = self._stamps.missing_before(scan.stamp_ns)
            if skipped is None:
                self.gaps += missing
            else:
                self.missed += skipped
            self._scans.append((scan, time.monotonic() + POSE_WAIT_S))
            if len(self._scans) > AHEAD:
                self._scans.popleft()
                self.missed += 1
            self._changed.notify_all()

    def _hear_odometry(self, topic: str, message: bytes, message_type: str, _skipped: int | None) -> None:
        assert self._odometry is not None
        try:
            self._odometry.add(message, message_type)
        except (Error, ValueError) as error:
            self._lose(topic, error)
            return
        with self._changed:
            self._changed.notify_all()


def _bus(address: str, message_type: str | None, fail: Callable[[BaseException], None]) -> tuple[Any, str]:
    """What hears and sends topics, a ``Bus`` of the module for this kind of network; and the topic of the scans. Behind the
    ``?`` of an address stand ``%20`` for a blank and ``%26`` for an ``&``, as in any URL."""
    scheme, _, rest = address.partition("://")
    place, _, query = rest.partition("?")
    host, _, topic = place.partition("/")
    options = {unquote(key): unquote(value) for key, _, value in (part.partition("=") for part in query.split("&") if part)}
    if scheme == "zenoh":
        domain, config = options.pop("domain", "0"), options.pop("config", None)
        if not topic or not (host or config) or not domain.isdecimal() or options:
            raise SettingsError("zenoh://HOST[:PORT]/TOPIC has a host and a topic; behind it may be ?domain=N&config=FILE.json5")
        with importing("zenoh://"):
            from . import _zenoh

        return _zenoh.Bus(host, int(domain), config and os.path.expanduser(config), fail), topic
    if scheme == "ros2":
        if not host.isdecimal() or not topic:
            raise SettingsError("ros2://DOMAIN/TOPIC has a number and a topic")
        if options or message_type:
            raise SettingsError("a robot on DDS has its domain in ros2://DOMAIN/TOPIC, and tells its types itself")
        with importing("ros2://"):
            from . import _dds

        return _dds.Bus(int(host), fail), topic
    raise SettingsError(f"a live robot is zenoh:// or ros2://, not {scheme}://")


class _Stamps:
    """Of the last scans."""

    def __init__(self) -> None:
        self._last_ns = 0
        self._intervals_ns: deque[int] = deque(maxlen=25)

    def missing_before(self, stamp_ns: int) -> int:
        """How many scans are missing between the last one and this, by their usual interval."""
        last_ns, self._last_ns = self._last_ns, stamp_ns
        if not 0 < last_ns < stamp_ns:
            return 0
        self._intervals_ns.append(stamp_ns - last_ns)
        usual_ns = statistics.median_low(self._intervals_ns)
        is_known = len(self._intervals_ns) >= LEAST_INTERVALS
        return max(0, round((stamp_ns - last_ns) / usual_ns) - 1) if is_known else 0


class Source:
    """The messages of a robot on their way into the program, which decodes them as those of a recording, and its answers.

    ``options`` are those of ``crosscut run``; ``feed`` takes the messages.
    """

    def __init__(self, address: str, options: dict[str, Any], feed: Any) -> None:
        self._feed, self._publish = feed, options["publish"]
        message_type = options["message_type"]
        self._bus, topic = _bus(address, message_type, self._fail)
        # A key expression of plain messages may stand for several keys, which are one topic here.
        self._bus.hear(topic.strip("/"), partial(self._hear, options["topic"]), *([] if message_type is None else [message_type]))
        for name in options["beside"]:
            self._bus.hear(name.strip("/"), partial(self._hear, name))

    def send(self, name: str, what: str | bytes) -> None:
        """Sends JSON, or a drawing, to those who subscribe to it."""
        topic = f"{self._publish}/{name}".strip("/")
        if isinstance(what, str):
            self._bus.send_text(topic, what)
        else:
            self._bus.send(topic, "visualization_msgs/MarkerArray", what)

    def close(self) -> None:
        self._bus.close()

    def _hear(self, topic: str, message: bytes, message_type: str, skipped: int | None) -> None:
        self._feed.hear(topic, message_type, message, skipped or 0)

    def _fail(self, failure: BaseException) -> None:
        self._feed.fail(f"the robot can no longer be heard: {type(failure).__name__}: {failure}")

"""Topics of a robot on Zenoh, which are heard and sent; ROS 2 names them as rmw_zenoh does."""

from __future__ import annotations

import json
import time
import uuid
from collections.abc import Callable
from typing import Any

import zenoh

from ._errors import Error

MARKERS_HASH = "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf"
"""Of the definition of visualization_msgs/msg/MarkerArray, by REP 2016."""

QOS = "::,10:,:,:,,"
"""Reliable, volatile, the last 10 messages, in the words of rmw_zenoh."""


class Bus:
    """A session at the Zenoh router HOST or HOST:PORT (port 7447 if there is none), in a ROS domain."""

    def __init__(self, endpoint: str, domain: int) -> None:
        host, _, port = endpoint.rpartition(":") if ":" in endpoint else (endpoint, "", "")
        config = zenoh.Config()
        config.insert_json5("mode", '"client"')
        config.insert_json5("connect/endpoints", json.dumps([f"tcp/{host}:{port or 7447}"]))
        try:
            self._session = zenoh.open(config)
        except zenoh.ZError as error:
            text = f"no Zenoh router answers at {endpoint}; is it running (rmw_zenohd), and is the port right?"
            raise Error(text) from error
        self._domain = domain
        self._subscribers: list[Any] = []
        self._markers: dict[str, _Markers] = {}

    def hear(self, topic: str, take: Callable[[bytes, str, int], None], message_type: str | None = None) -> None:
        """Gives ``take`` each message of a topic of ROS, its type, and how many are missing before it.

        With ``message_type``, ``topic`` is a key expression of plain messages of that type.
        """
        last: dict[bytes, int] = {}

        def heard(sample: Any) -> None:
            of_type = message_type or str(sample.key_expr).split("/")[-2]
            take(sample.payload.to_bytes(), of_type, _skipped(sample.attachment, last))

        # A topic as rmw_zenoh names it: domain/topic/type/hash.
        key = topic if message_type else f"{self._domain}/{topic}/*/*"
        self._subscribers.append(self._session.declare_subscriber(key, heard))

    def send_text(self, key: str, text: str) -> None:
        self._session.put(key, text)

    def send_markers(self, topic: str, message: bytes) -> None:
        """Sends a visualization_msgs/msg/MarkerArray in CDR as a node of ROS does."""
        if topic not in self._markers:
            self._markers[topic] = _Markers(self._session, self._domain, topic, len(self._markers) + 1)
        self._markers[topic].send(message)

    def close(self) -> None:
        self._session.close()


class _Markers:
    """A publisher of markers. Its tokens show it to `ros2 topic list`, RViz and Foxglove's bridge."""

    def __init__(self, session: zenoh.Session, domain: int, topic: str, entity: int) -> None:
        of_type = f"visualization_msgs::msg::dds_::MarkerArray_/{MARKERS_HASH}"
        node = f"@ros2_lv/{domain}/{session.info.zid()}/0"
        name = "%" + topic.replace("/", "%")
        self._tokens = [
            session.liveliness().declare_token(token)
            for token in (f"{node}/0/NN/%/%/crosscut", f"{node}/{entity}/MP/%/%/crosscut/{name}/{of_type}/{QOS}")
        ]
        self._publisher = session.declare_publisher(f"{domain}/{topic}/{of_type}")
        self._id = uuid.uuid4().bytes
        self._sent = 0

    def send(self, message: bytes) -> None:
        self._sent += 1
        numbers = self._sent.to_bytes(8, "little") + time.time_ns().to_bytes(8, "little")
        self._publisher.put(message, attachment=numbers + b"\x10" + self._id)


def _skipped(attachment: Any, last: dict[bytes, int]) -> int:
    """How many messages of the same publisher are missing before this one, by the numbers that rmw_zenoh attaches."""
    attached = b"" if attachment is None else attachment.to_bytes()
    if len(attached) < 33:
        return 0
    number, publisher = int.from_bytes(attached[:8], "little", signed=True), attached[17:33]
    before = last.get(publisher)
    last[publisher] = number
    return 0 if before is None else max(0, number - before - 1)

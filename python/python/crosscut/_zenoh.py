"""Topics of a robot on Zenoh, which are heard and sent; ROS 2 names them as rmw_zenoh does."""

from __future__ import annotations

import json
import os
import time
import uuid
from collections.abc import Callable
from typing import Any

import zenoh

from ._errors import Error, SettingsError

NO_HASH = "TypeHashNotSupported"
"""What ROS 2 Humble puts into its keys: its definitions of messages have no hashes."""

HASHES = {
    "geometry_msgs/Twist": "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    "geometry_msgs/TwistStamped": "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
    "visualization_msgs/MarkerArray": "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
}
"""Of the definitions of the messages that are sent, by REP 2016."""

QOS = "::,10:,:,:,,"
"""Reliable, volatile, the last 10 messages, in the words of rmw_zenoh."""


class Bus:
    """A client's session at the Zenoh router HOST or HOST:PORT (port 7447 if there is none), in a ROS domain.

    ``config`` is a file of Zenoh with its TLS settings and user, and with the router's endpoint if there is no HOST. ``fail``
    takes an exception with which hearing ended.
    """

    def __init__(self, endpoint: str, domain: int, config: str | None, fail: Callable[[BaseException], None]):
        settings = _settings(endpoint, config)
        try:
            self._session = zenoh.open(settings)
        except zenoh.ZError as error:
            where = endpoint or "the endpoints of the configuration"
            fits = "" if config is None else f", and do TLS and user of {os.fspath(config)} fit"
            text = f"no Zenoh router answers at {where}; is it running (rmw_zenohd), and is the port right{fits}?"
            raise Error(text) from error
        self._domain, self._fail = domain, fail
        self._with_hashes = True  # as since Iron, until a key without one is heard
        self._subscribers: list[Any] = []
        self._publishers: dict[tuple[str, bool], _Publisher] = {}

    def hear(self, topic: str, take: Callable[[bytes, str, int | None], None], message_type: str | None = None) -> None:
        """Gives ``take`` each message of a topic of ROS, its type, and how many are missing before it; None if it has no number.

        With ``message_type``, ``topic`` is a key expression of plain messages of that type.
        """
        last: dict[bytes, int] = {}

        def heard(sample: Any) -> None:
            try:
                of_type = message_type
                if of_type is None:
                    of_type, of_definition = str(sample.key_expr).split("/")[-2:]
                    self._with_hashes = of_definition != NO_HASH
                take(sample.payload.to_bytes(), of_type, _skipped(sample.attachment, last))
            except BaseException as error:  # Zenoh would drop it
                self._fail(error)

        # A topic as rmw_zenoh names it: domain/topic/type/hash.
        key = topic if message_type else f"{self._domain}/{topic}/*/*"
        self._subscribers.append(self._session.declare_subscriber(key, heard))

    def send_text(self, key: str, text: str) -> None:
        self._session.put(key, text)

    def send(self, topic: str, message_type: str, message: bytes) -> None:
        """Sends a message in CDR as a node of ROS does, of the version of ROS that is heard."""
        key = topic, self._with_hashes
        if key not in self._publishers:
            of_definition = HASHES[message_type] if self._with_hashes else NO_HASH
            entity = len(self._publishers) + 1
            self._publishers[key] = _Publisher(self._session, self._domain, topic, message_type, of_definition, entity)
        self._publishers[key].send(message)

    def close(self) -> None:
        self._session.close()


class _Publisher:
    """A publisher of a topic. Its tokens show it to `ros2 topic list`, RViz and Foxglove's bridge."""

    def __init__(
        self, session: zenoh.Session, domain: int, topic: str, message_type: str, of_definition: str, entity: int
    ) -> None:
        package, name = message_type.split("/")
        of_type = f"{package}::msg::dds_::{name}_/{of_definition}"
        node = f"@ros2_lv/{domain}/{session.info.zid()}/0"
        escaped = "%" + topic.replace("/", "%")
        self._tokens = [
            session.liveliness().declare_token(token)
            for token in (f"{node}/0/NN/%/%/crosscut", f"{node}/{entity}/MP/%/%/crosscut/{escaped}/{of_type}/{QOS}")
        ]
        self._publisher = session.declare_publisher(f"{domain}/{topic}/{of_type}")
        self._id = uuid.uuid4().bytes
        self._sent = 0

    def send(self, message: bytes) -> None:
        self._sent += 1
        numbers = self._sent.to_bytes(8, "little") + time.time_ns().to_bytes(8, "little")
        self._publisher.put(message, attachment=numbers + b"\x10" + self._id)


def _settings(endpoint: str, config: str | None) -> zenoh.Config:
    try:
        settings = zenoh.Config() if config is None else zenoh.Config.from_file(os.fspath(config))
    except zenoh.ZError as error:
        raise SettingsError(f"{os.fspath(config or '')}: no configuration of Zenoh: {error}") from error
    settings.insert_json5("mode", '"client"')
    has_endpoints = settings.get_json("connect/endpoints") not in ("[]", "{}", "null")
    if bool(endpoint) == has_endpoints:
        raise SettingsError("the router is the HOST of zenoh://HOST/TOPIC or, of zenoh:///TOPIC, an endpoint of the configuration of "
                            "Zenoh; one of them")
    if endpoint:
        has_port = ":" in endpoint and not endpoint.endswith("]")  # of an IPv6 address in brackets
        host, _, port = endpoint.rpartition(":") if has_port else (endpoint, "", "")
        settings.insert_json5("connect/endpoints", json.dumps([f"tcp/{host}:{port or 7447}"]))
    return settings


def _skipped(attachment: Any, last: dict[bytes, int]) -> int | None:
    """How many messages of the same publisher are missing before this one, by the numbers that rmw_zenoh attaches, if it does."""
    attached = b"" if attachment is None else attachment.to_bytes()
    if len(attached) < 33:
        return None
    number, publisher = int.from_bytes(attached[:8], "little", signed=True), attached[17:33]
    before = last.get(publisher)
    last[publisher] = number
    return 0 if before is None else max(0, number - before - 1)

"""Topics of a robot on DDS, which are heard and sent; ROS 2 names them as rmw_fastrtps and rmw_cyclonedds do."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable
from typing import Any

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, DcpsEndpoint
from cyclonedds.core import DDSException, InstanceState, Policy, Qos, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import DomainParticipant
from cyclonedds.dynamic import get_types_for_typeid
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.idl.types import float32, float64, int32, uint8, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from ._errors import Error, LossWarning

AT_ONCE = 100
"""Messages that are taken at once."""

KEPT = 1000
"""Messages that DDS keeps until a thread takes them."""

ANY = SampleState.Any | ViewState.Any | InstanceState.Any


class Bus:
    """A participant in a domain. Its network interface, and hosts to look for, are those of $CYCLONEDDS_URI.

    ``fail`` takes an exception with which hearing ended.
    """

    def __init__(self, domain: int, fail: Callable[[BaseException], None]) -> None:
        try:
            self._participant = DomainParticipant(domain)
        except DDSException as error:
            told = "is the number below 233, and is the network that $CYCLONEDDS_URI names there?"
            raise Error(f"DDS does not start in domain {domain}; {told}") from error
        self._fail = fail
        self._closed = threading.Event()
        self._threads: list[threading.Thread] = []
        self._writers: dict[str, DataWriter[Any]] = {}

    def hear(self, topic: str, take: Callable[[bytes, str, None], None]) -> None:
        """Gives ``take`` each message of a topic of ROS in CDR, its type, and None: Cyclone DDS does not tell what is missing,
        as it leaves the status SAMPLE_LOST at 0."""
        thread = threading.Thread(target=self._run, args=(f"rt/{topic}", take), name=f"dds {topic}", daemon=True)
        self._threads.append(thread)
        thread.start()

    def send_text(self, topic: str, text: str) -> None:
        """Sends a std_msgs/msg/String."""
        data = text.encode() + b"\0"
        self.send(topic, "std_msgs/String", b"\0\1\0\0" + len(data).to_bytes(4, "little") + data)

    def send(self, topic: str, message_type: str, message: bytes) -> None:
        """Sends a message in CDR."""
        if topic not in self._writers:
            qos = Qos(
                Policy.Reliability.Reliable(duration(milliseconds=100)),
                Policy.History.KeepLast(10),
                Policy.DataRepresentation(use_cdrv0_representation=True),
            )
            of_topic = Topic(self._participant, f"rt/{topic}", _SENT[message_type])
            self._writers[topic] = DataWriter(self._participant, of_topic, qos)
        sent = _SENT[message_type]()
        sent.cdr = message
        self._writers[topic].write(sent)

    def close(self) -> None:
        self._closed.set()
        for thread in self._threads:
            thread.join()

    def _run(self, name: str, take: Callable[[bytes, str, None], None]) -> None:
        try:
            self._hear(name, take)
        except BaseException as error:  # the thread ends with it
            self._fail(error)

    def _hear(self, name: str, take: Callable[[bytes, str, None], None]) -> None:
        publications = BuiltinDataReader(self._participant, BuiltinTopicDcpsPublication)
        conditions = [ReadCondition(publications, ANY)]
        waiting = WaitSet(self._participant)
        waiting.attach(conditions[0])
        wanted: DcpsEndpoint | None = None
        reader: DataReader[Any] | None = None
        message_type = ""
        while not self._closed.is_set():
            waiting.wait(duration(milliseconds=100))
            for publication in publications.take(AT_ONCE):
                is_of_topic = publication.sample_info.valid_data and publication.topic_name == name
                # A reliable reader does not hear a publisher of best effort.
                if is_of_topic and (reader is None or _reliability(publication) == Policy.Reliability.BestEffort):
                    wanted = publication
            if wanted is not None and (made := self._reader(wanted)) is not None:
                reader, message_type, wanted = made, wanted.type_name, None
                conditions[1:] = [ReadCondition(reader, ANY)]
                waiting.attach(conditions[1])
            for message in [] if reader is None else reader.take(AT_ONCE):
                if message.sample_info.valid_data:
                    take(message.cdr, message_type, None)

    def _reader(self, publication: DcpsEndpoint) -> DataReader[Any] | None:
        """A reader of the bytes that a publisher sends, as reliable as it; None if its type is not known yet."""
        message_type: Any
        if publication.type_id is None:  # then names alone are compared
            message_type = make_idl_struct("Message", publication.type_name.replace("::", "."), {})
        else:
            try:
                message_type, _ = get_types_for_typeid(self._participant, publication.type_id, duration(seconds=1))
            except DDSException as error:
                warnings.warn(f"the robot does not tell what a {publication.type_name} is: {error.msg}", LossWarning)
                return None
        message_type.deserialize = message_type.deserialize_key = _Message
        qos = Qos(_reliability(publication), Policy.History.KeepLast(KEPT))
        return DataReader(self._participant, Topic(self._participant, publication.topic_name, message_type), qos)


class _Message:
    """A message as it arrived; DDS adds ``sample_info``."""

    def __init__(self, cdr: bytes) -> None:
        self.cdr = cdr
        self.sample_info: Any = None


def _reliability(publication: DcpsEndpoint) -> Any:
    return publication.qos[Policy.Reliability]


def _type(ros_name: str, **fields: Any) -> Any:
    """A message type of ROS for what is sent; a message of it already is in CDR."""
    package, name = ros_name.split("/")
    made: Any = make_idl_struct(name, f"{package}.msg.dds_.{name}_", fields, dataclassify=False)
    made.serialize = lambda message, **_: message.cdr
    return made


_SEQUENCE: Any = types.sequence

# Subscribers compare these definitions with their own.
_TIME = _type("builtin_interfaces/Time", sec=int32, nanosec=uint32)
_DURATION = _type("builtin_interfaces/Duration", sec=int32, nanosec=uint32)
_HEADER = _type("std_msgs/Header", stamp=_TIME, frame_id=str)
_COLOR = _type("std_msgs/ColorRGBA", r=float32, g=float32, b=float32, a=float32)
_POINT = _type("geometry_msgs/Point", x=float64, y=float64, z=float64)
_VECTOR = _type("geometry_msgs/Vector3", x=float64, y=float64, z=float64)
_QUATERNION = _type("geometry_msgs/Quaternion", x=float64, y=float64, z=float64, w=float64)
_POSE = _type("geometry_msgs/Pose", position=_POINT, orientation=_QUATERNION)
_IMAGE = _type("sensor_msgs/CompressedImage", header=_HEADER, format=str, data=_SEQUENCE[uint8])
_UV = _type("visualization_msgs/UVCoordinate", u=float32, v=float32)
_MESH = _type("visualization_msgs/MeshFile", filename=str, data=_SEQUENCE[uint8])
_MARKER = _type(
    "visualization_msgs/Marker",
    header=_HEADER,
    ns=str,
    id=int32,
    type=int32,
    action=int32,
    pose=_POSE,
    scale=_VECTOR,
    color=_COLOR,
    lifetime=_DURATION,
    frame_locked=bool,
    points=_SEQUENCE[_POINT],
    colors=_SEQUENCE[_COLOR],
    texture_resource=str,
    texture=_IMAGE,
    uv_coordinates=_SEQUENCE[_UV],
    text=str,
    mesh_resource=str,
    mesh_file=_MESH,
    mesh_use_embedded_materials=bool,
)
_TWIST = _type("geometry_msgs/Twist", linear=_VECTOR, angular=_VECTOR)
_SENT = {
    "std_msgs/String": _type("std_msgs/String", data=str),
    "geometry_msgs/Twist": _TWIST,
    "geometry_msgs/TwistStamped": _type("geometry_msgs/TwistStamped", header=_HEADER, twist=_TWIST),
    "visualization_msgs/MarkerArray": _type("visualization_msgs/MarkerArray", markers=_SEQUENCE[_MARKER]),
}

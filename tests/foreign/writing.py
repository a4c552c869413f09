"""MCAP files as other people's programs write them: made with the Python writers."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.writer import CompressionType, IndexType, Writer
from mcap_ros2.writer import Writer as Ros2Writer
from rosbags.rosbag1 import Reader as BagReader
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.rosbag2 import Writer as Rosbag2Writer
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from scenes import BEAMS, RANGE_MAX_M, Scene

PERIOD_NS = 100_000_000
FIRST_STAMP_NS = 1_700_000_000_000_000_000

LASER_SCAN = "sensor_msgs/msg/LaserScan"
ROS1_LASER_SCAN = "sensor_msgs/LaserScan"
LASER_SCAN_DEFINITION = """\
std_msgs/Header header
float32 angle_min
float32 angle_max
float32 angle_increment
float32 time_increment
float32 scan_time
float32 range_min
float32 range_max
float32[] ranges
float32[] intensities
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
STRING = "std_msgs/msg/String"
STRING_DEFINITION = "string data\n"
# Converts between the encodings of ROS 1 and ROS 2.
ROS2_TYPES = get_typestore(Stores.ROS2_HUMBLE)
ROS1_TYPES = get_typestore(Stores.ROS1_NOETIC)


def message_of(scene: Scene, stamp_ns: int) -> dict:
    return scan_message(-np.pi, 2 * np.pi / BEAMS, RANGE_MAX_M, scene.ranges_m, stamp_ns)


def scan_message(first_rad: float, step_rad: float, range_max_m: float, ranges_m: np.ndarray, stamp_ns: int) -> dict:
    return {
        "header": {"stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}, "frame_id": "lidar"},
        "angle_min": first_rad,
        "angle_max": first_rad + (len(ranges_m) - 1) * step_rad,
        "angle_increment": step_rad,
        "time_increment": 0.0,
        "scan_time": PERIOD_NS / 1e9,
        "range_min": 0.1,
        "range_max": range_max_m,
        "ranges": ranges_m.tolist(),
        "intensities": [],
    }


def write_ros2(
    path: Path,
    scenes: Iterable[Scene],
    compression: CompressionType = CompressionType.ZSTD,
    topics: Iterable[str] = ("/scan",),
    chatter: bool = False,
):
    """The scenes at 10 Hz, the same on every topic, through the ROS 2 writer; `chatter` adds a topic of text."""
    with path.open("wb") as file, Ros2Writer(file, chunk_size=16 * 1024, compression=compression) as writer:
        scan_schema = writer.register_msgdef(LASER_SCAN, LASER_SCAN_DEFINITION)
        text_schema = writer.register_msgdef(STRING, STRING_DEFINITION) if chatter else None
        for i, scene in enumerate(scenes):
            stamp_ns = FIRST_STAMP_NS + i * PERIOD_NS
            if text_schema:
                writer.write_message("/chatter", text_schema, {"data": f"scene {i}"}, log_time=stamp_ns, sequence=i)
            for topic in topics:
                writer.write_message(topic, scan_schema, message_of(scene, stamp_ns), log_time=stamp_ns, sequence=i)


def write_scans(path: Path, scans: Iterable[tuple[float, float, float, np.ndarray]]):
    """Scans of any geometry at 10 Hz, each its first bearing, step, range limit and ranges, through the ROS 2 writer."""
    with path.open("wb") as file, Ros2Writer(file) as writer:
        schema = writer.register_msgdef(LASER_SCAN, LASER_SCAN_DEFINITION)
        for i, scan in enumerate(scans):
            stamp_ns = FIRST_STAMP_NS + i * PERIOD_NS
            writer.write_message("/scan", schema, scan_message(*scan, stamp_ns), log_time=stamp_ns, sequence=i)


@dataclass(frozen=True)
class Message:
    """One message of a recording, undecoded."""

    topic: str
    schema_name: str
    schema_encoding: str
    schema: bytes
    encoding: str
    log_time_ns: int
    sequence: int
    data: bytes


def messages_of(path: Path) -> list[Message]:
    with path.open("rb") as file:
        return [
            Message(
                topic=channel.topic,
                schema_name=schema.name,
                schema_encoding=schema.encoding,
                schema=schema.data,
                encoding=channel.message_encoding,
                log_time_ns=message.log_time,
                sequence=message.sequence,
                data=message.data,
            )
            for schema, channel, message in make_reader(file).iter_messages()
        ]


NO_SUMMARY = {
    "index_types": IndexType.NONE,
    "repeat_channels": False,
    "repeat_schemas": False,
    "use_statistics": False,
    "use_summary_offsets": False,
}


def write_raw(path: Path, messages: Iterable[Message], profile: str = "ros2", **options):
    """These messages, in this order, through the plain writer with these options."""
    with path.open("wb") as file:
        writer = Writer(file, **options)
        writer.start(profile=profile, library="cross-check")
        schemas: dict[str, int] = {}
        channels: dict[str, int] = {}
        for m in messages:
            if m.schema_name not in schemas:
                schemas[m.schema_name] = writer.register_schema(m.schema_name, m.schema_encoding, m.schema)
            if m.topic not in channels:
                channels[m.topic] = writer.register_channel(m.topic, m.encoding, schemas[m.schema_name])
            writer.add_message(channels[m.topic], m.log_time_ns, m.data, m.log_time_ns, m.sequence)
        writer.finish()


def write_bag(bag: BagWriter | Rosbag2Writer, schema: str, typestore: Typestore, timed: Iterable[tuple[int, bytes]]):
    """Messages of one topic, each with its log time, in a bag that is not open yet."""
    with bag:
        topic = bag.add_connection("/scan", schema, typestore=typestore)
        for log_time_ns, data in timed:
            bag.write(topic, log_time_ns, data)


def bag_messages(path: Path) -> list[Message]:
    """All messages of a ROS 1 bag, undecoded, as a converter puts them into an MCAP."""
    with BagReader(path) as bag:
        return [
            Message(
                topic=connection.topic,
                schema_name=connection.msgtype.replace("/msg/", "/"),
                schema_encoding="ros1msg",
                schema=connection.msgdef.data.encode(),
                encoding="ros1",
                log_time_ns=log_time_ns,
                sequence=i,
                data=bytes(data),
            )
            for i, (connection, log_time_ns, data) in enumerate(bag.messages())
        ]


def ros1(scan: Message) -> Message:
    """The same scan in the encoding of ROS 1."""
    data = bytes(ROS2_TYPES.cdr_to_ros1(scan.data, LASER_SCAN))
    return replace(scan, schema_name=ROS1_LASER_SCAN, schema_encoding="ros1msg", schema=b"", encoding="ros1", data=data)


def ros2(scan: Message) -> Message:
    """The same scan of ROS 1 in CDR."""
    data, schema = bytes(ROS2_TYPES.ros1_to_cdr(scan.data, LASER_SCAN)), LASER_SCAN_DEFINITION.encode()
    return replace(
        scan, schema_name=LASER_SCAN, schema_encoding="ros2msg", schema=schema, encoding="cdr", data=data
    )


def big_endian(message: Message) -> Message:
    """The same scan in big-endian CDR. Every field after the header's text is 4 bytes wide, and aligned to 4."""
    header, body = message.data[:4], message.data[4:]
    if header != b"\0\1\0\0":
        raise ValueError("little-endian CDR expected")
    text_bytes = int.from_bytes(body[8:12], "little")
    text, after = body[12 : 12 + text_bytes], 12 + text_bytes + -text_bytes % 4
    swapped = b"".join(part[i : i + 4][::-1] for part in (body[:12],) for i in range(0, 12, 4))
    fields = np.frombuffer(body[after:], dtype="<u4").astype(">u4").tobytes()
    return replace(message, data=b"\0\0\0\0" + swapped + text.ljust(after - 12, b"\0") + fields)

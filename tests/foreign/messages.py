"""The same scans as every message in every encoding and container that can hold it, written by other people's programs:
the same bytes of results. Clouds are compared with clouds."""

import base64
import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan as ProtobufScan
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud as ProtobufCloud
from google.protobuf.json_format import MessageToDict
from mcap_protobuf.writer import Writer as ProtobufWriter
from plyfile import PlyData, PlyElement
from pypcd4 import Encoding as PcdEncoding
from pypcd4 import PointCloud as PcdCloud
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer

import scenes
import writing
from flights import Flights
from program import lines
from verdicts import Verdicts
from writing import Message

SCANS = 5
ROS2_TYPES = writing.ROS2_TYPES
FLOAT32 = 7  # in PackedElementField and in PointField
SCAN, ECHOES, CLOUD = (f"sensor_msgs/msg/{name}" for name in ("LaserScan", "MultiEchoLaserScan", "PointCloud2"))


def check(flights: Flights, verdicts: Verdicts):
    folder = flights.work / "messages"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    base = folder / "flight.mcap"
    writing.write_ros2(base, scenes.clear_junctions(SCANS, seed=9))
    messages = writing.messages_of(base)
    scans = [ROS2_TYPES.deserialize_cdr(m.data, SCAN) for m in messages]
    of_scans = flights.crosscut.results(base).expect(0).stdout
    for name, path in [*ros(folder, messages, SCAN, scans), *ros(folder, messages, ECHOES, list(map(echoes, scans)))]:
        verdict(name, path, of_scans, flights, verdicts)
    of_foxglove = None
    for name, path in foxglove(folder, messages, "LaserScan", [protobuf_scan(scan) for scan in scans]):
        of_foxglove = of_foxglove or flights.crosscut.results(path).expect(0).stdout
        # Bearings are f64 there; walls and openings of clear junctions do not depend on the last bits of f32.
        verdicts.that(counts(of_foxglove) == counts(of_scans), f"{name}: counts", "those of the messages of ROS")
        verdict(name, path, of_foxglove, flights, verdicts)
    of_clouds = None
    clouds = [cloud(scan) for scan in scans]
    packed = foxglove(folder, messages, "PointCloud", [protobuf_cloud(scan, cloud) for scan, cloud in zip(scans, clouds)])
    for name, path in [*ros(folder, messages, CLOUD, clouds), *packed]:
        of_clouds = of_clouds or flights.crosscut.results(path).expect(0).stdout
        verdict(name, path, of_clouds, flights, verdicts)
    expected = timeless(of_clouds)[0]
    for name, path in single_clouds(folder, clouds[0]):
        for read in (path, convert(path, flights)):
            ran = flights.crosscut.results(read)
            holds = ran.code == 0 and timeless(ran.stdout) == [expected]
            verdicts.that(holds, f"{name}, {read.suffix}", f"exit code {ran.code}{ran.words.strip()[:160]}")


def verdict(name: str, path: Path, reference: bytes, flights: Flights, verdicts: Verdicts):
    ran = flights.crosscut.results(path)
    same = "the same bytes of results" if ran.stdout == reference else "other results"
    holds = ran.code == 0 and ran.stdout == reference and [line["returns"] > 0 for line in lines(reference)] == [True] * SCANS
    verdicts.that(holds, name, f"exit code {ran.code}, {same}{ran.words.strip()[:160]}")


def counts(results: bytes) -> list[int]:
    return [line["junctions"] for line in lines(results)]


def timeless(results: bytes) -> list[dict]:
    """The lines without stamps, which files of one cloud do not have, and the notes on them."""
    of_lines = [{name: value for name, value in line.items() if name not in ("stamp_ns", "notes")} for line in lines(results)]
    for opening in (opening for line in of_lines for opening in line["steady"]["openings"]):
        del opening["seen_ns"]
    return of_lines


def single_clouds(folder: Path, cloud) -> Iterator[tuple[str, Path]]:
    points = np.frombuffer(cloud.data.tobytes(), "<f4").reshape(-1, 3)
    for encoding in (PcdEncoding.ASCII, PcdEncoding.BINARY, PcdEncoding.BINARY_COMPRESSED):
        path = folder / f"{encoding.value}.pcd"
        PcdCloud.from_xyz_points(points).save(path, encoding=encoding)
        yield f"PCD, {encoding.value}", path
    vertices = np.array(np.rec.fromarrays(points.T, names="x,y,z"))
    for name, options in (("ascii", {"text": True}), ("little-endian", {"byte_order": "<"}), ("big-endian", {"byte_order": ">"})):
        path = folder / f"{name}.ply"
        PlyData([PlyElement.describe(vertices, "vertex")], **options).write(path)
        yield f"PLY, {name}", path


def convert(path: Path, flights: Flights) -> Path:
    out = path.with_suffix(".mcap")
    flights.crosscut("convert", path, "--out", out).expect(0)
    return out


def ros(folder: Path, messages: list[Message], schema: str, decoded: list) -> Iterator[tuple[str, Path]]:
    """The messages of ROS in MCAP, rosbag2 and bags of ROS 1."""
    short = schema.removeprefix("sensor_msgs/msg/")
    cdr = {
        endian: [bytes(ROS2_TYPES.serialize_cdr(m, schema, little_endian=is_little)) for m in decoded]
        for endian, is_little in (("little-endian", True), ("big-endian", False))
    }
    ros1 = [bytes(ROS2_TYPES.cdr_to_ros1(data, schema)) for data in cdr["little-endian"]]
    for name, encoding, datas in [*(("CDR, " + e, "cdr", d) for e, d in cdr.items()), ("ROS 1", "ros1", ros1)]:
        path = folder / f"{short}_{name}.mcap"
        writing.write_raw(path, as_messages(messages, schema, encoding, datas))
        yield f"MCAP, {short}, {name}", path
    times_ns = [m.log_time_ns for m in messages]
    writing.write_bag(BagWriter(folder / f"{short}.bag"), schema, writing.ROS1_TYPES, zip(times_ns, ros1))
    yield f"ROS 1 bag, {short}, ROS 1", folder / f"{short}.bag"
    for storage in (StoragePlugin.SQLITE3, StoragePlugin.MCAP):
        for endian, datas in cdr.items():
            path = folder / f"{short}_{storage.name.lower()}_{endian}"
            bag = Rosbag2Writer(path, version=9, storage_plugin=storage)
            writing.write_bag(bag, schema, ROS2_TYPES, zip(times_ns, datas))
            yield f"rosbag2 {storage.name.lower()}, {short}, CDR, {endian}", path


def as_messages(messages: list[Message], schema: str, encoding: str, datas: list[bytes]) -> list[Message]:
    schema_encoding = {"cdr": "ros2msg", "ros1": "ros1msg", "json": "jsonschema"}[encoding]
    definition = b"{}" if encoding == "json" else b""
    return [
        replace(m, schema_name=schema, schema_encoding=schema_encoding, schema=definition, encoding=encoding, data=data)
        for m, data in zip(messages, datas)
    ]


def foxglove(folder: Path, messages: list[Message], name: str, decoded: list) -> Iterator[tuple[str, Path]]:
    """The messages of Foxglove, through the protobuf writer and as JSON."""
    path = folder / f"foxglove_{name}_protobuf.mcap"
    with path.open("wb") as file, ProtobufWriter(file) as writer:
        for m, message in zip(messages, decoded):
            writer.write_message("/scan", message, m.log_time_ns, m.log_time_ns, m.sequence)
    yield f"MCAP, foxglove.{name}, protobuf", path
    path = folder / f"foxglove_{name}_json.mcap"
    datas = [json.dumps(as_json(message)).encode() for message in decoded]
    writing.write_raw(path, as_messages(messages, f"foxglove.{name}", "json", datas), profile="")
    yield f"MCAP, foxglove.{name}, JSON", path


def as_json(message: ProtobufScan | ProtobufCloud) -> dict:
    """As Foxglove's own writers: times in two fields, and types as numbers."""
    fields = MessageToDict(
        message, preserving_proto_field_name=True, use_integers_for_enums=True, always_print_fields_with_no_presence=True
    )
    fields["timestamp"] = {"sec": message.timestamp.seconds, "nsec": message.timestamp.nanos}
    if "data" in fields:
        fields["data"] = base64.b64encode(message.data).decode()
    return fields


def echoes(scan):
    types = ROS2_TYPES.types
    echo = types["sensor_msgs/msg/LaserEcho"]
    fields = {name: getattr(scan, name) for name in scan.__dataclass_fields__ if name != "__msgtype__"}
    fields["ranges"] = [echo(echoes=np.array([range_m, 99.0], np.float32)) for range_m in scan.ranges]
    fields["intensities"] = []
    return types[ECHOES](**fields)


def cloud(scan):
    """The returns of a scan in a plane, then those of the same places 0.1 m higher; in 1/1024 m, so that a text has them
    exactly."""
    types = ROS2_TYPES.types
    field = types["sensor_msgs/msg/PointField"]
    bearings_rad = scan.angle_min + np.arange(len(scan.ranges)) * scan.angle_increment
    hit = np.isfinite(scan.ranges)
    across = [scan.ranges[hit] * trig(bearings_rad[hit]) for trig in (np.cos, np.sin)]
    points = np.vstack([np.column_stack([*across, np.full(hit.sum(), z_m)]) for z_m in (0.0, 0.1)])
    points = (np.round(points * 1024) / 1024).astype("<f4")
    return types[CLOUD](
        header=scan.header, height=1, width=len(points),
        fields=[field(name=name, offset=4 * i, datatype=FLOAT32, count=1) for i, name in enumerate("xyz")],
        is_bigendian=False, point_step=12, row_step=12 * len(points),
        data=np.frombuffer(points.tobytes(), np.uint8), is_dense=True,
    )


def protobuf_scan(scan) -> ProtobufScan:
    message = ProtobufScan(
        frame_id=scan.header.frame_id, start_angle=scan.angle_min, end_angle=scan.angle_max, ranges=scan.ranges
    )
    return at_the_time_of(scan, message)


def protobuf_cloud(scan, cloud) -> ProtobufCloud:
    fields = [PackedElementField(name=name, offset=4 * i, type=FLOAT32) for i, name in enumerate("xyz")]
    message = ProtobufCloud(frame_id=scan.header.frame_id, point_stride=12, fields=fields, data=cloud.data.tobytes())
    return at_the_time_of(scan, message)


def at_the_time_of(scan, message):
    message.timestamp.seconds, message.timestamp.nanos = scan.header.stamp.sec, scan.header.stamp.nanosec
    message.pose.orientation.w = 1.0
    return message

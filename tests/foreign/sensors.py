"""A flight as a robot records it: laser scans, transforms, point clouds and a camera, in one MCAP file."""

import io
from pathlib import Path

import numpy as np
from mcap_ros2.writer import Writer
from PIL import Image

import scenes
import writing

SCENES = 40
SPEED_M_PER_S = 1.5
# Where the lidar sits in the vehicle.
LIDAR_FORWARD_M, LIDAR_UP_M, LIDAR_YAW_RAD = 0.2, 0.3, 0.35
CLOUD_POINTS, CLOUD_LATE_NS, CLOUD_HEIGHT_M = 1500, 20_000_000, 2.0

_STAMPED = writing.LASER_SCAN_DEFINITION[writing.LASER_SCAN_DEFINITION.index("=") :]
_RULE = "=" * 80 + "\n"
_TRANSFORMS = (
    "geometry_msgs/TransformStamped[] transforms\n"
    + _RULE + "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n"
    "geometry_msgs/Transform transform\n"
    + _RULE + "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"
    + _RULE + "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    + _RULE + "MSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"
    + _STAMPED
)  # fmt: skip
_CLOUD = (
    "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n"
    "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n"
    + _RULE + "MSG: sensor_msgs/PointField\nuint8 FLOAT32=7\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n"
    + _STAMPED
)  # fmt: skip
_PICTURE = "std_msgs/Header header\nstring format\nuint8[] data\n" + _STAMPED


def write(path: Path):
    """Through a T junction's mouth: the vehicle drives along `map`'s x axis, the lidar is turned in the vehicle."""
    rng = np.random.default_rng(2)
    scene = scenes.junction(3, rng)
    with path.open("wb") as file, Writer(file) as writer:
        scan, moved, cloud, picture = (
            writer.register_msgdef(name, definition)
            for name, definition in (
                (writing.LASER_SCAN, writing.LASER_SCAN_DEFINITION),
                ("tf2_msgs/msg/TFMessage", _TRANSFORMS),
                ("sensor_msgs/msg/PointCloud2", _CLOUD),
                ("sensor_msgs/msg/CompressedImage", _PICTURE),
            )
        )
        for i in range(SCENES):
            t = writing.FIRST_STAMP_NS + i * writing.PERIOD_NS

            def write_at(topic, schema, message, stamp_ns=t):
                writer.write_message(topic, schema, message, log_time=stamp_ns + 3_000_000, publish_time=stamp_ns, sequence=i)

            write_at("/scan", scan, writing.message_of(scene, t))
            along_m = SPEED_M_PER_S * i * writing.PERIOD_NS / 1e9
            write_at("/tf", moved, {"transforms": [_transform(t, "map", "base_link", (along_m, 0.0, 0.0), 0.0)]})
            if i == 0:
                place = (LIDAR_FORWARD_M, 0.0, LIDAR_UP_M)
                write_at("/tf_static", moved, {"transforms": [_transform(t, "base_link", "lidar", place, LIDAR_YAW_RAD)]})
            late_ns = t + CLOUD_LATE_NS
            write_at("/points", cloud, _points(scene, late_ns, rng), late_ns)
            write_at("/camera/compressed", picture, _photo(t, i))


def _header(stamp_ns: int, frame: str) -> dict:
    return {"stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}, "frame_id": frame}


def _transform(stamp_ns: int, parent: str, child: str, at_m: tuple, yaw_rad: float) -> dict:
    x, y, z = at_m
    rotation = {"x": 0.0, "y": 0.0, "z": np.sin(yaw_rad / 2), "w": np.cos(yaw_rad / 2)}
    transform = {"translation": {"x": x, "y": y, "z": z}, "rotation": rotation}
    return {"header": _header(stamp_ns, parent), "child_frame_id": child, "transform": transform}


def _points(scene: scenes.Scene, stamp_ns: int, rng: np.random.Generator) -> dict:
    """What a 3D lidar in the vehicle's own frame sees of the same walls: they stand in the cloud where the scan's are."""
    beams = rng.choice(np.flatnonzero(np.isfinite(scene.ranges_m)), CLOUD_POINTS)
    bearing_rad = scenes.bearings_rad()[beams] + LIDAR_YAW_RAD
    points = np.stack(
        [
            scene.ranges_m[beams] * np.cos(bearing_rad) + LIDAR_FORWARD_M,
            scene.ranges_m[beams] * np.sin(bearing_rad),
            LIDAR_UP_M + rng.uniform(-0.5, 0.5, CLOUD_POINTS) * CLOUD_HEIGHT_M,
        ],
        axis=1,
    ).astype("<f4")
    return {
        "header": _header(stamp_ns, "base_link"),
        "height": 1,
        "width": CLOUD_POINTS,
        "fields": [{"name": name, "offset": 4 * k, "datatype": 7, "count": 1} for k, name in enumerate("xyz")],
        "is_bigendian": False,
        "point_step": 12,
        "row_step": 12 * CLOUD_POINTS,
        "data": points.tobytes(),
        "is_dense": True,
    }


def _photo(stamp_ns: int, i: int) -> dict:
    """A picture with a bar that moves, so that it is seen which revolution it belongs to."""
    pixels = np.full((120, 160, 3), (40, 60, 90), np.uint8)
    pixels[:, 4 * i : 4 * i + 8] = (255, 200, 40)
    content = io.BytesIO()
    Image.fromarray(pixels).save(content, "JPEG")
    return {"header": _header(stamp_ns, "camera"), "format": "jpeg", "data": content.getvalue()}

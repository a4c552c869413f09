"""Laser scans of an MCAP recording, read with the Python readers, in log-time order."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory


@dataclass(frozen=True)
class Scan:
    """Values of the wire (f32), as f64."""

    log_time_ns: int
    stamp_ns: int
    angle_min_rad: float
    angle_increment_rad: float
    range_min_m: float
    range_max_m: float
    ranges_m: np.ndarray


def read(path: Path, topic: str = "/scan") -> list[Scan]:
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return [scan_of(m.message.log_time, m.decoded_message) for m in reader.iter_decoded_messages(topics=[topic])]


def scan_of(log_time_ns: int, message) -> Scan:
    stamp = message.header.stamp
    return Scan(
        log_time_ns=log_time_ns,
        stamp_ns=stamp.sec * 1_000_000_000 + stamp.nanosec,
        angle_min_rad=message.angle_min,
        angle_increment_rad=message.angle_increment,
        range_min_m=message.range_min,
        range_max_m=message.range_max,
        ranges_m=np.array(message.ranges, dtype=np.float64),
    )

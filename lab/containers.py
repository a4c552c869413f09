"""How fast recordings are read, side by side in one run, and in how much memory. Started by `run containers`.

Every file holds the same scans of 1080 beams with intensities, written by other people's programs. crosscut: from the file to
revolutions, and the reader of the crate `mcap` to undecoded messages, both by the bench of ingest. rosbags: from the file to
decoded messages. All in MB of the file per second of processor time, on one core, the best of some passes.

Then a file of GIGABYTES is read as a whole: its peak of memory is that of a file of a tenth of it."""

import argparse
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer

import writing
from writing import Message

ROOT = Path(__file__).parents[1]
SCANS, BEAMS, PERIOD_NS = 10_000, 1080, 25_000_000
PASSES = 2
GIGABYTES = 1.2
MOST_GROWTH_MB = 16
# Lines of a command's output, and its peak of memory in kB.
MEASURE = """
import resource, subprocess, sys
lines = subprocess.run(sys.argv[1:], check=True, stdout=subprocess.PIPE).stdout.count(b"\\n")
print(lines, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


def main() -> int:
    parser = argparse.ArgumentParser(prog="lab/run containers", description=__doc__)
    parser.add_argument("--crosscut", type=Path, help="the program, if not that of the release build")
    parser.add_argument("--memory", action="store_true", help="only the memory")
    args = parser.parse_args()
    work = ROOT / "target/foreign/work/containers"
    work.mkdir(parents=True, exist_ok=True)
    if not args.memory:
        files = list(written(work))
        command = ["cargo", "bench", "--quiet", "-p", "crosscut-ingest", "--bench", "containers", "--", *files]
        subprocess.run(command, cwd=ROOT, check=True)
        print(f"{'rosbags':<28}{'MB':>8}{'messages':>13}{'MB/s':>10}")
        for path in files:
            count, rate = rosbags_rate(path)
            print(f"{path.name:<28}{path.stat().st_size / 1e6:>8.0f}{count:>13}{rate:>10.0f}", flush=True)
    crosscut = args.crosscut or ROOT / "target/release/crosscut"
    return check_memory(crosscut, work)


def scans(count: int) -> Iterator[tuple[int, bytes]]:
    """Times and messages; each is the first one with other ranges and another stamp."""
    types = writing.ROS2_TYPES.types
    time_type, header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    step_rad = 2 * np.pi / BEAMS
    scan = types[writing.LASER_SCAN](
        header=header(stamp=time_type(sec=0, nanosec=0), frame_id="laser"),
        angle_min=-np.pi, angle_max=np.pi - step_rad, angle_increment=step_rad, time_increment=0.0, scan_time=0.0,
        range_min=0.0, range_max=30.0, ranges=np.full(BEAMS, 1234.5, np.float32),
        intensities=np.arange(BEAMS, dtype=np.float32) % 256,
    )  # fmt: skip
    template = bytearray(writing.ROS2_TYPES.serialize_cdr(scan, writing.LASER_SCAN))
    ranges_at = template.index(np.full(BEAMS, 1234.5, "<f4").tobytes())
    random = np.random.default_rng(1)
    noise_m = random.normal(0, 0.01, (64, BEAMS))
    beams = np.arange(BEAMS)
    for i in range(count):
        stamp_ns = writing.FIRST_STAMP_NS + i * PERIOD_NS
        template[4:12] = np.array([stamp_ns // 10**9, stamp_ns % 10**9], "<u4").tobytes()
        ranges_m = 5 + 4 * np.sin(0.01 * i + 0.02 * beams) + noise_m[i % 64]
        template[ranges_at : ranges_at + 4 * BEAMS] = ranges_m.astype("<f4").tobytes()
        yield stamp_ns, bytes(template)


def messages(count: int) -> Iterator[Message]:
    definition = writing.LASER_SCAN_DEFINITION.encode()
    for i, (stamp_ns, data) in enumerate(scans(count)):
        yield Message("/scan", writing.LASER_SCAN, "ros2msg", definition, "cdr", stamp_ns, i, data)


def written(work: Path) -> Iterator[Path]:
    for compression in (CompressionType.NONE, CompressionType.ZSTD, CompressionType.LZ4):
        path = work / f"mcap_{compression.name.lower()}.mcap"
        writing.write_raw(path, messages(SCANS), compression=compression)
        yield path
    ros1 = [(stamp_ns, bytes(writing.ROS2_TYPES.cdr_to_ros1(data, writing.LASER_SCAN))) for stamp_ns, data in scans(SCANS)]
    for compression in (None, BagWriter.CompressionFormat.LZ4):
        path = work / f"bag_{compression.name.lower() if compression else 'none'}.bag"
        path.unlink(missing_ok=True)
        bag = BagWriter(path)
        if compression:
            bag.set_compression(compression)
        writing.write_bag(bag, writing.LASER_SCAN, writing.ROS1_TYPES, ros1)
        yield path
    folder = work / "rosbag2"
    subprocess.run(["rm", "-rf", folder], check=True)
    bag = Rosbag2Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3)
    writing.write_bag(bag, writing.LASER_SCAN, writing.ROS2_TYPES, scans(SCANS))
    yield from folder.glob("*.db3")


def rosbags_rate(path: Path) -> tuple[int, float]:
    """Number of messages, and MB per second of processor time."""
    count, least_s = 0, np.inf
    for _ in range(PASSES):
        start_s = time.process_time()
        # MCAP and databases are read with the metadata of their folder.
        with AnyReader([with_metadata(path)], default_typestore=writing.ROS2_TYPES) as reader:
            count = sum(
                len(reader.deserialize(data, connection.msgtype).ranges) == BEAMS
                for connection, _, data in reader.messages()
            )
        least_s = min(least_s, time.process_time() - start_s)
    return count, path.stat().st_size / 1e6 / least_s


def with_metadata(path: Path) -> Path:
    """What rosbags opens: a bag of ROS 1, or the folder of a rosbag2, which is made around an MCAP."""
    if path.suffix == ".bag":
        return path
    if path.suffix == ".db3":
        return path.parent
    folder = path.with_suffix("")
    folder.mkdir(exist_ok=True)
    link = folder / path.name
    if not link.exists():
        link.hardlink_to(path)
    compressed = "compression_format: ''\n  compression_mode: ''"
    topic = (
        f"{{name: /scan, type: {writing.LASER_SCAN}, serialization_format: cdr, offered_qos_profiles: ''}}, message_count: {SCANS}"
    )
    (folder / "metadata.yaml").write_text(
        f"rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  {compressed}\n"
        f"  relative_file_paths: [{path.name}]\n  duration: {{nanoseconds: {SCANS * PERIOD_NS}}}\n"
        f"  starting_time: {{nanoseconds_since_epoch: {writing.FIRST_STAMP_NS}}}\n  message_count: {SCANS}\n"
        f"  topics_with_message_count: [{{topic_metadata: {topic}}}]\n"
    )
    return folder


def check_memory(crosscut: Path, work: Path) -> int:
    peaks_mb = []
    for share in (0.1, 1.0):
        path = work / "large.mcap"
        count = int(share * GIGABYTES * 1e9 / (8 * BEAMS + 100))
        writing.write_raw(path, messages(count), compression=CompressionType.NONE)
        command = [crosscut, "run", path, "--every", "2000", "--preset", "threshold", "--quiet", "--out", "-"]
        start_s, size_mb = time.monotonic(), path.stat().st_size / 1e6
        # A child counts no less than its parent has, so a small parent starts it.
        measured = subprocess.run([sys.executable, "-c", MEASURE, *command], check=True, capture_output=True)
        lines, peak_kb = map(int, measured.stdout.split())
        took_s = time.monotonic() - start_s
        peaks_mb.append(peak_kb / 1e3)
        print(f"{size_mb:.0f} MB, {count} scans, {lines} lines: peak {peaks_mb[-1]:.0f} MB, {took_s:.1f} s", flush=True)
        path.unlink()
        if lines != -(-count // 2000):
            print("FAILED: lines are missing")
            return 1
    if peaks_mb[1] - peaks_mb[0] > MOST_GROWTH_MB:
        print(f"FAILED: the peak of memory grows by more than {MOST_GROWTH_MB} MB")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""One flight through every container and encoding, as other people's programs write them: the same bytes of results.
Cut off or compressed, everything that is whole."""

import bz2
import gzip
import lzma
import shutil
import sqlite3
import subprocess
import tarfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import zstandard
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer

import scenes
import writing
from flights import Flights
from program import lines
from verdicts import Verdicts
from writing import Message

SCANS = 20
CUTS = 24
FIRST_RAD, RANGE_MAX_M = np.float32(-np.pi), scenes.RANGE_MAX_M


TABLE_OF_TOPICS = (
    "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,"
    "serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL)"
)
TABLE_OF_MESSAGES = (
    "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data BLOB NOT NULL)"
)
# The documentation states how many channels of a file are known.
MOST_CHANNELS = 65_536


def check(flights: Flights, verdicts: Verdicts):
    folder = flights.work / "formats"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    base = folder / "flight.mcap"
    writing.write_ros2(base, scenes.clear_junctions(SCANS, seed=9))
    messages = writing.messages_of(base)
    reference = flights.crosscut.results(base).expect(0).stdout
    check_containers(folder, base, messages, reference, flights, verdicts)
    check_cuts(folder, reference, flights, verdicts)
    check_conversion(folder, reference, flights, verdicts)
    check_channels(folder, messages, flights, verdicts)
    check_other_files(folder, base, flights, verdicts)


def check_containers(folder: Path, base: Path, messages: list[Message], reference: bytes, flights: Flights, verdicts: Verdicts):
    for name, path in containers(folder, base, messages):
        ran = flights.crosscut.results(path)
        holds = ran.code == 0 and ran.stdout == reference
        verdicts.that(holds, name, f"exit code {ran.code}, {len(lines(ran.stdout))} lines{ran.words.strip()[:200]}")
    # The table states the limits of its beams in settings; f32 bearings are those of the messages.
    table = folder / "flight.csv"
    write_table(table, messages)
    first, last = float(FIRST_RAD), float(np.float32(FIRST_RAD + np.float32(2 * np.pi / scenes.BEAMS) * (scenes.BEAMS - 1)))
    settings = [f"csv.first_rad={first}", f"csv.last_rad={last}", f"csv.range_max_m={RANGE_MAX_M}"]
    ran = flights.crosscut.results(table, *(word for setting in settings for word in ("--set", setting)))
    counts = [[line["junctions"] for line in lines(results)] for results in (ran.stdout, reference)]
    verdicts.that(ran.code == 0 and counts[0] == counts[1], "CSV of ranges", f"exit code {ran.code}, the same counts")
    with base.open("rb") as piped:
        done = subprocess.run(
            flights.crosscut.command("run", "-", "--preset", "paper", "--out", "-", "--quiet"), stdin=piped, capture_output=True
        )
    verdicts.that(done.returncode == 0 and done.stdout == reference, "standard input", f"exit code {done.returncode}")


def containers(folder: Path, base: Path, messages: list[Message]) -> Iterator[tuple[str, Path]]:
    for compression in (None, BagWriter.CompressionFormat.BZ2, BagWriter.CompressionFormat.LZ4):
        name = compression.name.lower() if compression else "none"
        path = folder / f"ros1_{name}.bag"
        bag = BagWriter(path)
        if compression:
            bag.set_compression(compression)
        timed = [(m.log_time_ns, writing.ros1(m).data) for m in messages]
        writing.write_bag(bag, writing.LASER_SCAN, writing.ROS1_TYPES, timed)
        yield f"ROS 1 bag, {name}", path
    modes = [(CompressionMode.NONE, "plain"), (CompressionMode.FILE, "files in zstd"), (CompressionMode.MESSAGE, "messages in zstd")]
    for storage in (StoragePlugin.SQLITE3, StoragePlugin.MCAP):
        for version in (8, 9):
            for mode, words in modes:
                path = folder / f"rosbag2_{storage.name}_{version}_{mode.name}".lower()
                bag = Rosbag2Writer(path, version=version, storage_plugin=storage)
                if mode != CompressionMode.NONE:
                    bag.set_compression(mode, CompressionFormat.ZSTD)
                timed = [(m.log_time_ns, m.data) for m in messages]
                writing.write_bag(bag, writing.LASER_SCAN, writing.ROS2_TYPES, timed)
                yield f"rosbag2 {version}, {storage.name.lower()}, {words}", path
    (folder / "rosbag2_sqlite3_9_none/metadata.yaml").rename(folder / "metadata.yaml")
    yield "rosbag2 without metadata.yaml", folder / "rosbag2_sqlite3_9_none"
    yield "write-ahead log beside a database", write_with_log(folder / "killed.db3", messages)
    for name, pack in (("zst", zstandard.ZstdCompressor().compress), ("bz2", bz2.compress)):
        packed = folder / f"flight.mcap.{name}"
        packed.write_bytes(pack(base.read_bytes()))
        yield f"MCAP in {name}", packed
    active = folder / "active"
    active.mkdir()
    shutil.copy(base, active / "flight.mcap.active")
    yield "folder of unclosed files", active


def write_with_log(path: Path, messages: list[Message]) -> Path:
    """A database whose recorder was killed: most of its pages are in the write-ahead log beside it."""
    live = path.with_suffix(".live")
    connection = sqlite3.connect(live)
    connection.execute("PRAGMA journal_mode=WAL")
    connection.execute("PRAGMA wal_autocheckpoint=0")
    connection.execute(TABLE_OF_TOPICS)
    connection.execute(TABLE_OF_MESSAGES)
    connection.execute("CREATE INDEX timestamp_idx ON messages (timestamp ASC)")
    connection.execute("INSERT INTO topics VALUES(1,'/scan',?,'cdr','')", (writing.LASER_SCAN,))
    for m in messages:
        connection.execute("INSERT INTO messages(topic_id,timestamp,data) VALUES(1,?,?)", (m.log_time_ns, m.data))
        connection.commit()
    shutil.copy(live, path)
    shutil.copy(f"{live}-wal", f"{path}-wal")
    connection.close()
    return path


def check_channels(folder: Path, messages: list[Message], flights: Flights, verdicts: Verdicts):
    """Of a database with one topic too many, messages of the last are counted as lost, and all others are read."""
    path = folder / "channels.db3"
    connection = sqlite3.connect(path)
    connection.execute(TABLE_OF_TOPICS)
    connection.execute(TABLE_OF_MESSAGES)
    names = [(id, f"/scan{id}", writing.LASER_SCAN, "cdr", "") for id in range(1, MOST_CHANNELS + 2)]
    connection.executemany("INSERT INTO topics VALUES(?,?,?,?,?)", names)
    for topic in (MOST_CHANNELS, MOST_CHANNELS + 1):
        rows = [(topic, m.log_time_ns, m.data) for m in messages]
        connection.executemany("INSERT INTO messages(topic_id,timestamp,data) VALUES(?,?,?)", rows)
    connection.commit()
    connection.close()
    ran = flights.crosscut.results(path, "--topic", f"/scan{MOST_CHANNELS}")
    lines, loss = ran.stdout.count(b"\n"), f"the definition of a topic is lost, and with it {len(messages)} messages"
    same = ran.code == 3 and lines == len(messages) and loss in ran.words
    verdicts.that(same, "a topic too many", f"{lines} lines, exit code {ran.code}: {ran.words.strip()[:120]}")


def write_table(path: Path, messages: list[Message]):
    rows = []
    for m in messages:
        scan = writing.ROS2_TYPES.deserialize_cdr(m.data, writing.LASER_SCAN)
        rows.append(f"{m.log_time_ns},{','.join(map(str, scan.ranges))}")
    header = ",".join(["stamp_ns", *(f"r{i}" for i in range(scenes.BEAMS))])
    path.write_text("\n".join([header, *rows]) + "\n")


def check_cuts(folder: Path, reference: bytes, flights: Flights, verdicts: Verdicts):
    """A file that ends too early gives true results. Rows of a database fill a page from its end, so the first of a page
    that is cut are missing and `seq` begins later."""
    expected = unnumbered(reference)
    database = next((folder / "rosbag2_sqlite3_8_none").glob("*.db3"))
    for path in (folder / "ros1_none.bag", folder / "ros1_lz4.bag", database):
        whole, counts, wrong = path.read_bytes(), [], []
        for end in np.linspace(1, len(whole) - 1, CUTS).astype(int):
            cut = folder / "cut"
            cut.write_bytes(whole[:end])
            ran = flights.crosscut.results(cut)
            given = unnumbered(ran.stdout)
            counts.append(len(given))
            is_true = all(line in expected for line in given) if path == database else given == expected[: len(given)]
            if not is_true or ran.code != (3 if given else 1):
                wrong.append(f"{end} bytes: {len(given)} lines, exit code {ran.code}: {ran.words.strip()[:120]}")
        holds = not wrong and counts == sorted(counts)
        verdicts.that(holds, f"cut off, {path.name}", wrong[0] if wrong else f"{CUTS} cuts, {counts[CUTS // 2]} lines of the half")


def unnumbered(results: bytes) -> list[dict]:
    """The lines of results without what follows from the scans that were read before."""
    of_flight = ("seq", "pose", "steady")

    def alone(line: dict) -> dict:
        notes = [note for note in line["notes"] if not note.startswith("pose: ")]
        return {name: value for name, value in line.items() if name not in of_flight} | {"notes": notes}

    return [alone(line) for line in lines(results)]


def check_conversion(folder: Path, reference: bytes, flights: Flights, verdicts: Verdicts):
    """What `convert` writes is read by the Python readers, and gives the same results."""
    for name in ("ros1_bz2.bag", "rosbag2_sqlite3_9_message"):
        out = folder / "converted.mcap"
        flights.crosscut("convert", folder / name, "--out", out).expect(0)
        types = {(m.topic, m.schema_name, m.encoding) for m in writing.messages_of(out)}
        same = flights.crosscut.results(out).expect(0).stdout == reference
        verdicts.that(types == {("/scan", writing.LASER_SCAN, "cdr")} and same, f"convert, {name}", f"{types}")


def check_other_files(folder: Path, base: Path, flights: Flights, verdicts: Verdicts):
    """Files that are no recording are named for what they are, with exit code 1."""
    content = base.read_bytes()
    tar = folder / "flight.tar"
    with tarfile.open(tar, "w") as archive:
        archive.add(base, "flight.mcap")
    files = {
        "Git LFS pointer": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
        "web page": b"<!DOCTYPE html><html><body>Sign in</body></html>",
        "line ends": content.replace(b"\r\n", b"\n"),
        "gzip": gzip.compress(content),
        "xz": lzma.compress(content),
        "tar": tar.read_bytes(),
        "rosbag fix": b"#ROSRECORD V1.2\n",
    }
    for words, content in files.items():
        path = folder / "other.mcap"
        path.write_bytes(content)
        ran = flights.crosscut.results(path)
        verdicts.that(ran.code == 1 and words in ran.words, f"no recording: {words}", ran.words.strip()[:120])

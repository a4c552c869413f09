"""MCAP in both directions: simulated flights through the Python readers, and files of the Python writers, whole and
damaged, through `crosscut run`."""

import io
import json
from collections import Counter
from pathlib import Path

import jsonschema
import numpy as np
from mcap.reader import make_reader
from mcap.records import Message as MessageRecord
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType
from mcap_ros2.decoder import DecoderFactory

import scenes
import writing
from flights import Flight, Flights
from program import Ran, lines
from verdicts import Verdicts

SCANS = 40
CUTS = 24
LARGE_CHUNK_SCANS = 200
LARGE_CHUNK_CUTS = 8
FLIPS = 60
HOLE_NS = 1_000_000_000
TYPES = {
    "/scan": "sensor_msgs/msg/LaserScan",
    "/odom": "nav_msgs/msg/Odometry",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/truth": "crosscut.Truth",
}
# With the first scan; the shipped flight was made without.
MAP_TYPE = {"/truth/map": "crosscut.TruthMap"}


def check(flights: Flights, verdicts: Verdicts):
    for flight in [*flights.shipped(), flights.simulated(seed=11)]:
        check_simulated(flight, verdicts)
    folder = flights.work / "mcap"
    folder.mkdir(exist_ok=True)
    base = folder / "zstd.mcap"
    made = scenes.clear_junctions(SCANS, seed=7)
    writing.write_ros2(base, made)
    reference = flights.crosscut.results(base).expect(0).stdout
    verdicts.that(len(lines(reference)) == SCANS, "ROS 2 writer, zstd", f"{len(lines(reference))} lines, exit code 0")
    check_ways_of_writing(base, made, reference, flights, verdicts)
    check_ros1(base, reference, flights, verdicts)
    check_out_of_order(base, reference, flights, verdicts)
    check_topics(folder, made, reference, flights, verdicts)
    check_cut_off(base, reference, flights, verdicts)
    check_cut_off_in_large_chunk(folder, flights, verdicts)
    check_bit_flips(base, reference, flights, verdicts)


def check_simulated(flight: Flight, verdicts: Verdicts):
    """Every message through foreign decoders: types, counts, stamps, ranges, unit quaternions, truth by its schema."""
    by_topic: dict[str, list] = {}
    types: dict[str, str] = {}
    with flight.path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            types[channel.topic] = schema.name
            if schema.encoding == "jsonschema":
                decoded = json.loads(message.data)
                jsonschema.validate(decoded, json.loads(schema.data))
            else:
                decoded = DecoderFactory().decoder_for(channel.message_encoding, schema)(message.data)
            by_topic.setdefault(channel.topic, []).append((message.log_time, decoded))
    counts = {topic: len(found) for topic, found in by_topic.items()}
    verdicts.that(types in (TYPES, TYPES | MAP_TYPE), f"{flight.name}: topics", ", ".join(f"{n} {t}" for t, n in counts.items()))

    times = {topic: [time for time, _ in found] for topic, found in by_topic.items()}
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for _, m in by_topic["/scan"]]
    verdicts.that(
        times["/scan"] == times["/truth"] == stamps and all(np.diff(stamps) > 0),
        f"{flight.name}: times",
        f"scan, its stamp and truth agree on {len(stamps)}; {(stamps[-1] - stamps[0]) / 1e9:.1f} s",
    )

    kinds, labels_fit = Counter(), 0
    for (_, scan), (_, truth) in zip(by_topic["/scan"], by_topic["/truth"]):
        r = np.array(scan.ranges)
        inside = (r >= scan.range_min) & (r <= scan.range_max)
        kinds.update(returns=int(inside.sum()), none=int(np.isposinf(r).sum() + np.isnan(r).sum()), beams=len(r))
        walls = truth["walls"] + truth["islands"]
        names = sorted(set(truth["labels"]) - {-1, -2})
        labels_fit += len(truth["labels"]) == len(r) and names == list(range(walls))
    verdicts.that(
        kinds["returns"] + kinds["none"] == kinds["beams"] and kinds["returns"] > 0,
        f"{flight.name}: ranges",
        f"{kinds['returns']} within the sensor's limits, {kinds['none']} without return, of {kinds['beams']}",
    )
    verdicts.that(
        labels_fit == len(stamps), f"{flight.name}: truth", f"valid by its schema, labels fit on {labels_fit} scans"
    )

    rotations = [m.pose.pose.orientation for _, m in by_topic["/odom"]]
    rotations += [t.transform.rotation for _, m in by_topic["/tf"] for t in m.transforms]
    error = max(abs(q.x**2 + q.y**2 + q.z**2 + q.w**2 - 1) for q in rotations)
    verdicts.that(error < 1e-12, f"{flight.name}: rotations", f"{len(rotations)} of unit length within {error:.0e}")


def check_ways_of_writing(base: Path, made, reference: bytes, flights: Flights, verdicts: Verdicts):
    """The same scans, however written, give the same bytes of results."""
    folder, messages = base.parent, writing.messages_of(base)
    for name, compression in [("lz4", CompressionType.LZ4), ("none", CompressionType.NONE)]:
        path = folder / f"{name}.mcap"
        writing.write_ros2(path, made, compression)
        expect_reference(path, f"ROS 2 writer, {name}", reference, flights, verdicts)
    ways = {
        "unchunked": {"use_chunking": False},
        "unchunked, no summary": {"use_chunking": False, **writing.NO_SUMMARY},
        "no summary": {"chunk_size": 16 * 1024, **writing.NO_SUMMARY},
        "no statistics": {"chunk_size": 16 * 1024, "use_statistics": False},
        "no checksums": {"chunk_size": 16 * 1024, "enable_crcs": False},
        "one scan a chunk": {"chunk_size": 1},
        "one chunk": {"chunk_size": 1 << 30},
    }
    for name, options in ways.items():
        path = folder / f"{name.replace(', ', '_').replace(' ', '_')}.mcap"
        writing.write_raw(path, messages, **options)
        expect_reference(path, f"plain writer, {name}", reference, flights, verdicts)
    path = folder / "big_endian.mcap"
    writing.write_raw(path, map(writing.big_endian, messages))
    expect_reference(path, "big-endian CDR", reference, flights, verdicts)


def check_ros1(base: Path, reference: bytes, flights: Flights, verdicts: Verdicts):
    """Scans in the encoding of ROS 1, made here and of a real bag, give what they give in CDR."""
    path = base.parent / "ros1.mcap"
    writing.write_raw(path, map(writing.ros1, writing.messages_of(base)), profile="ros1")
    expect_reference(path, "ROS 1", reference, flights, verdicts)
    for bag in flights.bags():
        messages = writing.bag_messages(bag)
        as_recorded, in_cdr = (base.parent / f"{bag.stem}_{encoding}.mcap" for encoding in ("ros1", "cdr"))
        writing.write_raw(as_recorded, messages, profile="ros1")
        writing.write_raw(in_cdr, [writing.ros2(m) for m in messages if m.schema_name == writing.ROS1_LASER_SCAN])
        of_cdr = flights.crosscut.results(in_cdr).expect(0).stdout
        expect_reference(as_recorded, f"ROS 1, {bag.name}, {len(lines(of_cdr))} scans", of_cdr, flights, verdicts)


def expect_reference(path: Path, what: str, reference: bytes, flights: Flights, verdicts: Verdicts):
    ran = flights.crosscut.results(path)
    same = "the same bytes of results" if ran.stdout == reference else "other results"
    verdicts.that(ran.code == 0 and ran.stdout == reference, what, f"exit code {ran.code}, {same}{words(ran)}")


def check_out_of_order(base: Path, reference: bytes, flights: Flights, verdicts: Verdicts):
    """With an index, log-time order; without one, the order of the file."""
    shuffled = writing.messages_of(base)
    np.random.default_rng(1).shuffle(shuffled)
    indexed = base.parent / "shuffled.mcap"
    writing.write_raw(indexed, shuffled, chunk_size=4096)
    expect_reference(indexed, "out of order, with index", reference, flights, verdicts)

    unindexed = base.parent / "shuffled_no_summary.mcap"
    writing.write_raw(unindexed, shuffled, chunk_size=4096, **writing.NO_SUMMARY)
    ran = flights.crosscut.results(unindexed)
    times = [m.log_time_ns for m in shuffled]
    in_file_order = [line["stamp_ns"] for line in lines(ran.stdout)] == times
    backwards = [i for i in range(1, len(times)) if times[i] < times[i - 1]]
    onwards = [i for i in range(1, len(times)) if times[i] > times[i - 1] + HOLE_NS]
    of_stamps = {line["seq"]: [n for n in line["notes"] if not n.startswith("pose: ")] for line in lines(ran.stdout)}
    told = {seq: " ".join(notes) for seq, notes in of_stamps.items() if notes}
    noted = [seq for seq, notes in told.items() if "before that of the scan before" in notes]
    holes = [seq for seq, notes in told.items() if "after that of the scan before" in notes]
    verdicts.that(
        ran.code == 0 and in_file_order and noted == backwards,
        "out of order, no summary",
        f"exit code {ran.code}, in {'file' if in_file_order else 'another'} order; "
        f"{len(backwards)} scans go back in time, {len(noted)} have a note{words(ran)}",
    )
    verdicts.that(
        set(holes) <= set(onwards) and sorted(noted + holes) == sorted(told),
        "holes out of order",
        f"{len(holes)} notes on holes, at some of {len(onwards)} steps on by more than a second; no other notes",
    )


def check_topics(folder: Path, made, reference: bytes, flights: Flights, verdicts: Verdicts):
    chatter = folder / "chatter.mcap"
    writing.write_ros2(chatter, made, chatter=True)
    expect_reference(chatter, "one scan topic among others", reference, flights, verdicts)

    two = folder / "two.mcap"
    writing.write_ros2(two, made, topics=("/front", "/rear"))
    ran = flights.crosscut.results(two)
    listed = all(topic in ran.words for topic in ("/front", "/rear"))
    verdicts.that(ran.code in (1, 2) and listed and not ran.stdout, "two scan topics", f"exit code {ran.code}{words(ran)}")
    ran = flights.crosscut.results(two, "--topic", "/rear")
    verdicts.that(ran.code == 0 and ran.stdout == reference, "two scan topics, one chosen", f"exit code {ran.code}")

    none = folder / "none_at_all.mcap"
    writing.write_ros2(none, made, topics=(), chatter=True)
    ran = flights.crosscut.results(none)
    verdicts.that(ran.code == 1 and "/chatter" in ran.words, "no scan topic", f"exit code {ran.code}{words(ran)}")

    for name, content in {"empty file": b"", "text": b"no recording\n" * 99, "zeros": bytes(5000)}.items():
        path = folder / "nothing.mcap"
        path.write_bytes(content)
        ran = flights.crosscut.results(path)
        verdicts.that(ran.code == 1 and not ran.stdout, name, f"exit code {ran.code}{words(ran)}")


def check_cut_off(base: Path, reference: bytes, flights: Flights, verdicts: Verdicts):
    """A copy that ends too early gives every whole scan before its end, and exit code 3; without any, exit code 1."""
    for name in ("zstd", "lz4", "none", "unchunked", "unchunked_no_summary"):
        path = base.parent / f"{name}.mcap"
        wrong, more, codes = cut_off(path, CUTS, reference, flights)
        figures = f"{CUTS} cuts, exit codes {dict(codes)}; {more} scans more than mcap's reader from broken chunks"
        verdicts.that(not wrong, f"cut off, {name}", wrong[0] if wrong else figures)


def check_cut_off_in_large_chunk(folder: Path, flights: Flights, verdicts: Verdicts):
    """A chunk of many compressed blocks gives what is whole before the cut, though it is not whole itself."""
    made = scenes.clear_junctions(LARGE_CHUNK_SCANS, seed=8)
    plain = folder / "large.mcap"
    writing.write_ros2(plain, made)
    messages, reference = writing.messages_of(plain), flights.crosscut.results(plain).expect(0).stdout
    for compression in (CompressionType.ZSTD, CompressionType.LZ4):
        path = folder / f"large_{compression.name.lower()}.mcap"
        writing.write_raw(path, messages, chunk_size=1 << 30, compression=compression)
        wrong, more, codes = cut_off(path, LARGE_CHUNK_CUTS, reference, flights)
        figures = f"{LARGE_CHUNK_CUTS} cuts, exit codes {dict(codes)}; {more} scans more than mcap's reader"
        verdicts.that(not wrong and more > 0, f"cut off in one large chunk, {compression.name}", "; ".join(wrong) or figures)


def cut_off(path: Path, cuts: int, reference: bytes, flights: Flights) -> tuple[list[str], int, Counter]:
    """What went wrong, how many scans were read beyond those of the Python reader, and the exit codes."""
    whole, expected = path.read_bytes(), reference.splitlines(keepends=True)
    wrong, more, codes = [], 0, Counter()
    for end in np.linspace(len(whole) - 1, 9, cuts).astype(int):
        cut = path.parent / "cut.mcap"
        cut.write_bytes(whole[:end])
        least = whole_scans(whole[:end])
        ran = flights.crosscut.results(cut)
        given = ran.stdout.splitlines(keepends=True)
        codes[ran.code] += 1
        more += len(given) - least
        if given != expected[: len(given)] or len(given) < least or ran.code != (3 if given else 1):
            wrong.append(f"{end} bytes: {len(given)} lines, {least} readable, exit code {ran.code}{words(ran)}")
    return wrong, more, codes


def whole_scans(content: bytes) -> int:
    """Messages that the Python reader finds before it gives up, which it does with many kinds of errors."""
    count = 0
    try:
        for record in StreamReader(io.BytesIO(content)).records:
            count += isinstance(record, MessageRecord)
    except Exception:
        pass
    return count


def check_bit_flips(base: Path, reference: bytes, flights: Flights, verdicts: Verdicts):
    """Damage never crashes it, and is never passed on in silence: exit code 0 comes with the true results."""
    rng = np.random.default_rng(3)
    for name in ("zstd", "lz4", "none"):
        whole = (base.parent / f"{name}.mcap").read_bytes()
        wrong, codes = [], Counter()
        for _ in range(FLIPS):
            byte, bit = int(rng.integers(len(whole))), int(rng.integers(8))
            damaged = bytearray(whole)
            damaged[byte] ^= 1 << bit
            path = base.parent / "flipped.mcap"
            path.write_bytes(damaged)
            ran = flights.crosscut.results(path)
            codes[ran.code] += 1
            sound = ran.code in (1, 3) and len(lines(ran.stdout)) <= SCANS
            if not (sound or (ran.code == 0 and ran.stdout == reference)):
                wrong.append(f"bit {bit} of byte {byte}: exit code {ran.code}{words(ran)}")
        verdicts.that(not wrong, f"a bit flipped, {name}", "; ".join(wrong) or f"{FLIPS} times, exit codes {dict(codes)}")


def words(ran: Ran) -> str:
    """The last line that it said, if any."""
    said = ran.words.strip().splitlines()
    return f": {said[-1]:.160}" if said else ""

"""A live robot: a real Zenoh router on this machine, and recorded messages on the keys of rmw_zenoh. Markers are read by
rosbags, which has the definitions of ROS."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import free_port, in_wheel, needs_recordings

import crosscut
import crosscut.live

zenoh = pytest.importorskip("zenoh")
typesys = pytest.importorskip("rosbags.typesys")

ROS = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
MARKERS = "visualization_msgs/msg/MarkerArray"

HASH = "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828"
SCANS = f"7/robot1/scan/sensor_msgs::msg::dds_::LaserScan_/{HASH}"
ODOMETRY = f"7/robot1/odom/nav_msgs::msg::dds_::Odometry_/{HASH}"


NO_HASH = "TypeHashNotSupported"  # as on ROS 2 Humble


def router(port: int, protocol: str = "tcp", **settings: Any) -> Any:
    """A Zenoh router on this port of the loopback."""
    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("listen/endpoints", json.dumps([f"{protocol}/127.0.0.1:{port}"]))
    config.insert_json5("scouting/multicast/enabled", "false")
    for name, value in settings.items():
        config.insert_json5(name.replace("__", "/"), json.dumps(value))
    return zenoh.open(config)


@pytest.fixture
def network() -> Iterator[tuple[Any, int]]:
    port = free_port()
    session = router(port)
    yield session, port
    session.close()


def recorded(path: Path) -> list[tuple[str, bytes]]:
    """The scans and the odometry of a recording in order, each on its key, as CDR."""
    mcap = pytest.importorskip("mcap.reader")
    keys = {"/scan": SCANS, "/odom": ODOMETRY}
    with path.open("rb") as file:
        messages = mcap.make_reader(file).iter_messages(topics=list(keys))
        return [(keys[channel.topic], message.data) for _, channel, message in messages]


def send(session: Any, messages: list[tuple[str, bytes]], pause_s: float, lost: frozenset[int] = frozenset()) -> None:
    """As rmw_zenoh: the number, the stamp and the publisher are attached."""
    sent: dict[str, int] = {}
    for key, data in messages:
        number = sent[key] = sent.get(key, -1) + 1
        if number not in lost:
            publisher = hashlib.sha256(key.encode()).digest()[:16]
            session.put(key, data, attachment=number.to_bytes(8, "little") + bytes(8) + b"\x10" + publisher)
            time.sleep(pause_s)


def wait_for_subscriber(session: Any, key: str) -> None:
    publisher = session.declare_publisher(key)
    deadline = time.monotonic() + 30
    while not publisher.matching_status.matching:
        assert time.monotonic() < deadline, "nobody subscribes"
        time.sleep(0.05)
    publisher.undeclare()


def check_markers(drawings: list[Any], lines: list[dict[str, Any]], scans: list[Any]) -> None:
    """Each removes what was drawn before, and has an arrow along each opening and the corners of walls on returns."""
    kind = ROS.types["visualization_msgs/msg/Marker"]
    for drawing, line, scan in zip(drawings, lines, scans, strict=True):
        clear, *drawn = drawing.markers
        assert clear.action == kind.DELETEALL and {marker.action for marker in drawn} == {kind.ADD}
        stamp = scan.header.stamp
        frames = {(m.header.frame_id, m.header.stamp.sec, m.header.stamp.nanosec) for m in drawing.markers}
        assert frames == {(scan.header.frame_id, stamp.sec, stamp.nanosec)}
        assert len({marker.id for marker in drawn}) == len(drawn)
        arrows = [marker.pose.orientation for marker in drawn if marker.type == kind.ARROW]
        bearings = sorted(2 * math.atan2(turned.z, turned.w) for turned in arrows)
        assert np.allclose(bearings, sorted(opening["bearing_rad"] for opening in line["openings"]), atol=1e-9)
        angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        returns = np.c_[scan.ranges * np.cos(angles), scan.ranges * np.sin(angles)][np.array(line["labels"]) >= 0]
        walls = [marker.points for marker in drawn if marker.type == kind.LINE_STRIP]
        corners = np.array([(point.x, point.y) for points in walls for point in points])
        assert len(walls) > 0 and max(np.min(np.hypot(*(returns - corner).T)) for corner in corners[::20]) < 1e-3
        assert any(marker.text.startswith(f"{line['junctions']} wall") for marker in drawn)


def test_answers_to_a_live_robot_are_those_of_its_recording(
    network: tuple[Any, int], tee: Path, tmp_path: Path
) -> None:
    session, port = network
    heard: dict[str, list[dict[str, Any]]] = {"results": [], "map": []}
    listeners = [session.declare_subscriber(f"crosscut/{name}", lambda sample, name=name: heard[name].append(
        json.loads(sample.payload.to_bytes()))) for name in heard]
    # As RViz subscribes to the topic: domain, name, type and the hash of its definition.
    drawings: list[Any] = []
    topic = f"7/crosscut/markers/visualization_msgs::msg::dds_::MarkerArray_/{ROS.hash_rihs01(MARKERS)}"
    listeners.append(session.declare_subscriber(topic, drawings.append))
    results, flight_map = tmp_path / "live.jsonl", tmp_path / "live.json"
    process = subprocess.Popen(
        [in_wheel(), "run", f"zenoh://127.0.0.1:{port}/robot1/scan?domain=7", "--set", "ingest.odometry=/robot1/odom",
         "--publish", "crosscut", "--out", results, "--map", flight_map],
        stderr=subprocess.PIPE, text=True)
    try:
        wait_for_subscriber(session, SCANS)
        wait_for_subscriber(session, ODOMETRY)
        messages = recorded(tee)
        send(session, messages, 0.005)
        scans = sum(key == SCANS for key, _ in messages)
        deadline = time.monotonic() + 30
        while len(drawings) < scans and time.monotonic() < deadline:
            time.sleep(0.1)
        tokens = [str(reply.ok.key_expr).split("/") for reply in session.liveliness().get("@ros2_lv/7/**")]
    finally:
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1]
    assert process.returncode == 0, said
    assert f"{scans} revolutions in" in said
    of_file = subprocess.run([in_wheel(), "run", tee, "--out", "-", "--quiet"], capture_output=True, text=True, check=True)
    live = [json.loads(line) for line in results.read_text().splitlines()]
    assert live == heard["results"], "what is published is what is written"
    assert results.read_text() == of_file.stdout
    assert any(line["pose"] is not None and line["pose"]["x_m"] > 1.0 for line in live), "odometry was heard"
    assert [node["kind"] for node in json.loads(flight_map.read_text())["nodes"]] == ["junction"]
    assert heard["map"][-1] == json.loads(flight_map.read_text())
    assert [(name, of_type) for *_, name, of_type, _, _ in tokens if of_type.endswith("MarkerArray_")] == [
        ("%crosscut%markers", topic.split("/")[-2])], "the topic is shown to the tools of ROS"
    check_markers([ROS.deserialize_cdr(sample.payload.to_bytes(), MARKERS) for sample in drawings], live,
                  [ROS.deserialize_cdr(data, "sensor_msgs/msg/LaserScan") for key, data in messages if key == SCANS])
    numbers = [int.from_bytes(sample.attachment.to_bytes()[:8], "little") for sample in drawings]
    assert numbers == list(range(1, scans + 1))
    assert len(listeners) == 3


@needs_recordings
def test_a_robot_is_recorded_with_every_option_and_through_a_kill(network: tuple[Any, int], tee: Path, tmp_path: Path) -> None:
    session, port = network
    robot = [in_wheel(), "run", f"zenoh://127.0.0.1:{port}/robot1/scan?domain=7", "--set", "ingest.odometry=/robot1/odom"]
    settings = tmp_path / "settings.toml"
    settings.write_text("[pipeline]\nworkers = 1\n[affinity]\nkind = 'rbf'\n")
    messages = recorded(tee)
    scans = sum(key == SCANS for key, _ in messages)
    for killed in (False, True):
        made = {name: tmp_path / f"{killed}.{name}" for name in ("rrd", "mcap", "json")}
        process = subprocess.Popen([*robot, "--save", made["rrd"], "--out", made["mcap"], "--map", made["json"], "--config", settings],
                                   stderr=subprocess.PIPE, text=True)
        wait_for_subscriber(session, SCANS)
        wait_for_subscriber(session, ODOMETRY)
        send(session, messages, 0.02)
        time.sleep(4)  # what waits is answered, and on the disk
        process.send_signal(signal.SIGKILL if killed else signal.SIGINT)
        said = process.communicate(timeout=60)[1]
        # A machine that is too slow for the robot says so.
        left_out = sum(map(int, re.findall(r"(\d+) messages? of robot1/scan came faster", said)))
        assert process.returncode == (-signal.SIGKILL if killed else 3 if "came faster" in said else 0), said
        listed = subprocess.run([in_wheel(), "rrd", "ls", made["rrd"]], capture_output=True, text=True)
        assert listed.returncode in ((0, 3) if killed else (0,)), listed.stderr
        assert "/affinity/W" in listed.stdout and "/report/junctions" in listed.stdout
        with made["mcap"].open("rb") as file:
            assert file.read(8) == b"\x89MCAP0\r\n", "the format is that of the name"
        assert json.loads(made["json"].read_text())["nodes"]
        if not killed:
            info = subprocess.run([in_wheel(), "info", made["mcap"]], capture_output=True, text=True, check=True)
            assert re.search(rf"/scan +\S+ +cdr +{scans - left_out} ", info.stdout), info.stdout


def spinning(path: Path, to: Path) -> Path:
    """The recording, with odometry that turns by 3 radians each second."""
    reader, writer = pytest.importorskip("mcap.reader"), pytest.importorskip("mcap.writer")
    with path.open("rb") as file, to.open("wb") as out:
        made = writer.Writer(out)
        made.start("ros2", "test")
        channels: dict[str, int] = {}
        for schema, channel, message in reader.make_reader(file).iter_messages(topics=["/scan", "/odom"]):
            if channel.topic not in channels:
                of_type = made.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = made.register_channel(channel.topic, channel.message_encoding, of_type)
            data = message.data
            if channel.topic == "/odom":
                odometry = ROS.deserialize_cdr(data, schema.name)
                yaw_rad = 3e-9 * (message.log_time % 10**12)
                odometry.pose.pose.orientation.z, odometry.pose.pose.orientation.w = math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)
                data = ROS.serialize_cdr(odometry, schema.name)
            made.add_message(channels[channel.topic], message.log_time, data, message.publish_time)
        made.finish()
    return to


def test_motion_is_corrected_as_in_the_recording(
    network: tuple[Any, int], tee: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, port = network
    recording = spinning(tee, tmp_path / "spinning.mcap")
    said = subprocess.run([in_wheel(), "run", recording, "--out", "-", "--quiet"], capture_output=True, check=True)
    expected = [json.loads(line) for line in said.stdout.splitlines()]
    turned = sum("turned by 17.2° during the scan" in " ".join(line["notes"]) for line in expected)
    # No scan is left out or answered before its odometry, however slow this machine is.
    monkeypatch.setattr(crosscut.live, "AHEAD", len(expected))
    monkeypatch.setattr(crosscut.live, "POSE_WAIT_S", 30.0)
    flight = crosscut.Flight()
    address = f"zenoh://127.0.0.1:{port}/robot1/scan?domain=7"
    with crosscut.live.Robot(address, odometry="/robot1/odom") as robot:
        wait_for_subscriber(session, SCANS)
        wait_for_subscriber(session, ODOMETRY)
        threading.Thread(target=send, args=(session, recorded(recording), 0.001)).start()
        # No odometry reaches the end of the last scan.
        live = [flight.process(scan).to_dict() for scan, _ in itertools.islice(robot, len(expected) - 1)]
    assert live == expected[:-1]
    assert turned > len(live) / 2, "the scans were corrected"


def test_scans_that_are_lost_are_counted(network: tuple[Any, int], tee: Path) -> None:
    session, port = network
    messages = [message for message in recorded(tee) if message[0] == SCANS][:12]
    with crosscut.live.Robot(f"zenoh://127.0.0.1:{port}/robot1/scan?domain=7") as robot:
        wait_for_subscriber(session, SCANS)
        send(session, messages, 0.002, lost=frozenset({3, 4, 8}))
        taken = [next(iter(robot)) for _ in range(len(messages) - 3)]
    assert robot.missed == 3
    assert robot.clock_ns is not None and robot.clock_ns > 0
    assert [pose for _, pose in taken] == [None] * len(taken)


def test_a_slow_answer_leaves_out_the_oldest_scans(network: tuple[Any, int], tee: Path) -> None:
    session, port = network
    messages = [message for message in recorded(tee) if message[0] == SCANS][: crosscut.live.AHEAD + 5]
    with crosscut.live.Robot(f"zenoh://127.0.0.1:{port}/robot1/scan?domain=7") as robot:
        wait_for_subscriber(session, SCANS)
        send(session, messages, 0.002)
        deadline = time.monotonic() + 30
        while robot.missed < 5 and time.monotonic() < deadline:
            time.sleep(0.05)
        first = next(iter(robot))[0]
    assert robot.missed == 5
    assert first.stamp_ns == crosscut.Scan.from_message(messages[5][1]).stamp_ns


@pytest.mark.filterwarnings("ignore::crosscut.LossWarning")
def test_a_router_that_was_away_is_found_again(tee: Path) -> None:
    port = free_port()
    session = router(port)
    messages = [message for message in recorded(tee) if message[0] == SCANS]
    with crosscut.live.Robot(f"zenoh://127.0.0.1:{port}/robot1/scan?domain=7") as robot:
        wait_for_subscriber(session, SCANS)
        send(session, messages[:3], 0.002)
        before = [next(iter(robot))[0].stamp_ns for _ in range(3)]
        session.close()
        again = router(port)
        try:
            wait_for_subscriber(again, SCANS)
            send(again, messages[5:8], 0.002)
            after = [next(iter(robot))[0].stamp_ns for _ in range(3)]
        finally:
            again.close()
    stamps = [crosscut.Scan.from_message(data).stamp_ns for _, data in messages]
    assert before + after == stamps[:3] + stamps[5:8]


def test_silence_and_what_cannot_be_read_are_told(network: tuple[Any, int], monkeypatch: pytest.MonkeyPatch) -> None:
    session, port = network
    monkeypatch.setattr(crosscut.live, "SILENCE_S", 0.3)
    with crosscut.live.Robot(f"zenoh://127.0.0.1:{port}/scan", message_type="sensor_msgs/msg/LaserScan") as robot:
        wait_for_subscriber(session, "scan")
        session.put("scan", b"no scan")
        threading.Timer(1.5, robot.stop).start()
        with pytest.warns(crosscut.LossWarning, match="1 messages on scan cannot be read"):
            assert list(robot) == []


@pytest.mark.parametrize("of_definition", [HASH, NO_HASH], ids=["jazzy", "humble"])
def test_a_robot_is_driven_on_the_keys_of_its_version_of_ros(network: tuple[Any, int], tee: Path, of_definition: str) -> None:
    session, port = network
    scan = next(data for key, data in recorded(tee) if key == SCANS)
    driven: dict[str, list[Any]] = {"Twist": [], "TwistStamped": []}
    hashes = {name: ROS.hash_rihs01(f"geometry_msgs/msg/{name}") if of_definition == HASH else NO_HASH for name in driven}
    # As the base subscribes: domain, name, type and the hash of its definition, without a wildcard.
    listeners = [
        session.declare_subscriber(f"7/{name.lower()}/geometry_msgs::msg::dds_::{name}_/{hashes[name]}", heard.append)
        for name, heard in driven.items()
    ]
    with crosscut.live.Robot(f"zenoh://127.0.0.1:{port}/robot1/scan?domain=7") as robot:
        wait_for_subscriber(session, SCANS)
        send(session, [(SCANS.replace(HASH, of_definition), scan)], 0.0)
        heard = next(iter(robot))[0]
        robot.drive("/twist", 0.5, -0.25)
        robot.drive("/twiststamped", 0.5, -0.25, stamped=True, frame_id="base")
        deadline = time.monotonic() + 30
        while not all(driven.values()) and time.monotonic() < deadline:
            time.sleep(0.05)
        tokens = [str(reply.ok.key_expr) for reply in session.liveliness().get("@ros2_lv/7/**")]
    read = {name: ROS.deserialize_cdr(samples[0].payload.to_bytes(), f"geometry_msgs/msg/{name}")
            for name, samples in driven.items()}
    for twist in (read["Twist"], read["TwistStamped"].twist):
        assert (twist.linear.x, twist.linear.y, twist.angular.z) == (0.5, 0.0, -0.25)
    header = read["TwistStamped"].header
    late_s = header.stamp.sec + header.stamp.nanosec / 1e9 - heard.stamp_ns / 1e9
    assert header.frame_id == "base" and 0.0 <= late_s < 30.0, "by the clock of the robot"
    assert sum(f"_/{hashes[name]}/" in token for token in tokens for name in driven) >= 2, tokens
    assert len(listeners) == 2


def test_unreadable_messages_of_a_robot_are_counted_and_told(network: tuple[Any, int], tee: Path, tmp_path: Path) -> None:
    session, port = network
    messages = recorded(tee)
    scans = [data for key, data in messages if key == SCANS][:20]
    results = tmp_path / "live.jsonl"
    process = subprocess.Popen(
        [in_wheel(), "run", f"zenoh://127.0.0.1:{port}/robot1/scan?domain=7", "--set", "ingest.odometry=/robot1/odom", "--out", results],
        stderr=subprocess.PIPE, text=True)
    try:
        wait_for_subscriber(session, SCANS)
        wait_for_subscriber(session, ODOMETRY)
        for data in scans:
            send(session, [(ODOMETRY, b"\0\1\0\0" + b"\xff" * 700), (SCANS, data[:60])], 0.001)
            session.put(SCANS, data)
            time.sleep(0.02)
        deadline = time.monotonic() + 30
        while not (results.exists() and results.read_text().count("\n") == 2 * len(scans)) and time.monotonic() < deadline:
            time.sleep(0.05)
    finally:
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1]
    assert process.returncode == 3, said
    assert "20 messages of robot1/scan cannot be decoded" in said, said
    assert "20 messages of /robot1/odom cannot be decoded" in said, said
    # As of a recording, what cannot be read has its empty line.
    assert results.read_text().count("\n") == 2 * len(scans)


def test_a_transport_that_fails_ends_the_iteration_with_an_error(
    network: tuple[Any, int], tee: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, port = network
    scan = next(data for key, data in recorded(tee) if key == SCANS)

    def fail(*_: Any) -> None:
        raise RuntimeError("out of order")

    with crosscut.live.Robot(f"zenoh://127.0.0.1:{port}/robot1/scan?domain=7") as robot:
        wait_for_subscriber(session, SCANS)
        monkeypatch.setattr(robot._stamps, "missing_before", fail)
        session.put(SCANS, scan)
        with pytest.raises(crosscut.Error, match="can no longer be heard: RuntimeError: out of order"):
            list(robot)


def test_close_ends_the_connection_and_stop_does_not(network: tuple[Any, int]) -> None:
    session, port = network
    heard: list[Any] = []
    listener = session.declare_subscriber("said", heard.append)
    robot = crosscut.live.Robot(f"zenoh://127.0.0.1:{port}/robot1/scan?domain=7")
    wait_for_subscriber(session, SCANS)
    robot.stop()
    assert list(robot) == []
    robot.publish("said", {})
    deadline = time.monotonic() + 30
    while not heard and time.monotonic() < deadline:
        time.sleep(0.05)
    assert len(heard) == 1
    robot.close()
    robot.close()
    publisher = session.declare_publisher(SCANS)
    while publisher.matching_status.matching and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not publisher.matching_status.matching, "nobody subscribes any more"
    listener.undeclare()


@pytest.fixture
def certificates(tmp_path: Path) -> Path:
    """A certificate for 127.0.0.1 that is its own authority, and its key."""
    if shutil.which("openssl") is None:
        pytest.skip("openssl is not installed")
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=127.0.0.1", "-addext",
         "subjectAltName=IP:127.0.0.1", "-addext", "basicConstraints=critical,CA:false", "-keyout", tmp_path / "key.pem", "-out",
         tmp_path / "cert.pem"], check=True, capture_output=True)
    return tmp_path


def test_a_router_with_tls_and_users_is_joined_by_a_file_of_zenoh(certificates: Path, tee: Path) -> None:
    port = free_port()
    (certificates / "users").write_text("robot:secret\nrouter:other\n")
    session = router(
        port, "tls", transport__link__tls__listen_certificate=str(certificates / "cert.pem"),
        transport__link__tls__listen_private_key=str(certificates / "key.pem"),
        transport__auth__usrpwd={"user": "router", "password": "other", "dictionary_file": str(certificates / "users")})
    config = certificates / "zenoh.json5"

    def write(password: str) -> None:
        settings = {"connect": {"endpoints": [f"tls/127.0.0.1:{port}"]},
                    "transport": {"link": {"tls": {"root_ca_certificate": str(certificates / "cert.pem")}},
                                  "auth": {"usrpwd": {"user": "robot", "password": password}}}}
        config.write_text(json.dumps(settings))

    try:
        scan = next(data for key, data in recorded(tee) if key == SCANS)
        write("secret")
        with crosscut.live.Robot(f"zenoh:///robot1/scan?domain=7&config={config}") as robot:
            wait_for_subscriber(session, SCANS)
            session.put(SCANS, scan)
            assert next(iter(robot))[0].stamp_ns == crosscut.Scan.from_message(scan).stamp_ns
        write("wrong")
        with pytest.raises(crosscut.Error, match="do TLS and user of .*zenoh.json5 fit"):
            crosscut.live.Robot(f"zenoh:///robot1/scan?config={config}")
        with pytest.raises(crosscut.SettingsError, match="one of them"):
            crosscut.live.Robot(f"zenoh://127.0.0.1:{port}/scan?config={config}")
    finally:
        session.close()


def test_a_robot_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    done = subprocess.run([in_wheel(), "run", f"zenoh://127.0.0.1:{free_port()}/scan"], capture_output=True, text=True)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1), done.stderr
    assert "no Zenoh router answers at 127.0.0.1" in done.stderr
    done = subprocess.run([in_wheel(), "run", "zenoh://127.0.0.1"], capture_output=True, text=True)
    assert done.returncode == 2 and "has a host and a topic" in done.stderr


def test_the_import_needs_no_network() -> None:
    script = "import sys; sys.modules['zenoh'] = sys.modules['cyclonedds'] = None; import crosscut.live, crosscut.ray"
    subprocess.run([sys.executable, "-c", script], check=True)

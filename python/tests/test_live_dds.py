"""A live robot on DDS: a publisher of Cyclone DDS on this machine. Types and bytes are made from the definitions in rosbags."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import in_wheel

import crosscut
import crosscut.live
from test_live import MARKERS, ROS, check_markers

pytest.importorskip("cyclonedds")
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from rosbags.interfaces import Nodetype

LASER_SCAN, ODOMETRY, TF = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
TEXT = "std_msgs/msg/String"
BEST_EFFORT = Policy.Reliability.BestEffort
RELIABLE = Policy.Reliability.Reliable(duration(seconds=1))

# On the loopback alone, and without multicast.
NETWORK = """<CycloneDDS><Domain>
<General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer Address="127.0.0.1"/></Peers></Discovery>
{}</Domain></CycloneDDS>"""
LOSSY = "<Internal><Test><XmitLossiness>100</XmitLossiness></Test></Internal>"  # of 1000 packets

KNOWN: dict[str, Any] = {}


def idl(ros_type: str) -> Any:
    """A type of ROS as a type of Cyclone DDS."""
    if ros_type not in KNOWN:
        fields = {name: field_type(*definition) for name, definition in ROS.fielddefs[ros_type][1]}
        package, _, name = ros_type.split("/")
        KNOWN[ros_type] = make_idl_struct(name, f"{package}.msg.dds_.{name}_", fields)
    return KNOWN[ros_type]


def field_type(node: Nodetype, of: Any) -> Any:
    if node == Nodetype.BASE:
        return {"string": str, "bool": bool}.get(of[0]) or getattr(types, of[0])
    if node == Nodetype.NAME:
        return idl(of)
    element = field_type(*of[0])
    made: Any = types.array if node == Nodetype.ARRAY else types.sequence
    return made[element, of[1]] if node == Nodetype.ARRAY else made[element]


def idl_value(value: Any) -> Any:
    """What rosbags decoded, for Cyclone DDS to encode."""
    if hasattr(value, "__msgtype__"):
        names = [name for name, _ in ROS.fielddefs[value.__msgtype__][1]]
        return idl(value.__msgtype__)(*(idl_value(getattr(value, name)) for name in names))
    if isinstance(value, list):
        return [idl_value(part) for part in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


class Robot:
    """A robot in a domain of its own."""

    domains = iter(range(os.getpid() % 90, 100))

    def __init__(self, monkeypatch: pytest.MonkeyPatch, network: str = "") -> None:
        self.domain = next(self.domains)
        monkeypatch.setenv("CYCLONEDDS_URI", NETWORK.format(network))
        self.participant = DomainParticipant(self.domain)
        monkeypatch.setenv("CYCLONEDDS_URI", NETWORK.format(""))

    def topic(self, name: str, ros_type: str) -> Any:
        return Topic(self.participant, f"rt{name}", idl(ros_type))

    def writer(self, name: str, ros_type: str, reliability: Any) -> Any:
        return DataWriter(self.participant, self.topic(name, ros_type), Qos(reliability, Policy.History.KeepAll))

    def reader(self, name: str, ros_type: str) -> Any:
        return DataReader(self.participant, self.topic(name, ros_type), Qos(RELIABLE, Policy.History.KeepAll))

    def answers(self, *options: Any) -> subprocess.Popen[str]:
        """`crosscut run` that hears the robot."""
        command = [in_wheel(), "run", f"ros2://{self.domain}/robot1/scan", *options]
        return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


def recorded(path: Path) -> list[tuple[str, Any]]:
    """The scans and the odometry of a recording in order, decoded."""
    mcap = pytest.importorskip("mcap.reader")
    with path.open("rb") as file:
        messages = mcap.make_reader(file).iter_messages(topics=["/scan", "/odom"])
        return [(schema.name, ROS.deserialize_cdr(message.data, schema.name)) for schema, _, message in messages]


def wait_until(done: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 30
    while not done() and time.monotonic() < deadline:
        time.sleep(0.05)


def interrupted(process: subprocess.Popen[str]) -> tuple[int, str]:
    """The exit code after Ctrl-C, and what was said."""
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60)[1]
    return process.returncode, said


def check_answers(results: Path, recording: Path) -> list[dict[str, Any]]:
    lines = [json.loads(line) for line in results.read_text().splitlines()]
    of_file = {result.stamp_ns: result.to_dict() for result in crosscut.Engine().process_many(crosscut.read(recording))}
    for line in lines:
        for name in ("labels", "junctions", "k", "eigenvalues"):
            assert line[name] == of_file[line["stamp_ns"]][name], (line["seq"], name)
    assert any(line["pose"] is not None and line["pose"]["x_m"] > 1.0 for line in lines), "odometry was heard"
    return lines


def test_answers_over_dds_are_those_of_the_recording(
    tee: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = Robot(monkeypatch)
    writers = {LASER_SCAN: robot.writer("/robot1/scan", LASER_SCAN, BEST_EFFORT),
               ODOMETRY: robot.writer("/robot1/odom", ODOMETRY, RELIABLE)}
    told = {name: robot.reader(f"/crosscut/{name}", of_type)
            for name, of_type in (("results", TEXT), ("map", TEXT), ("markers", MARKERS))}
    results, flight_map = tmp_path / "live.jsonl", tmp_path / "live.json"
    process = robot.answers("--set", "ingest.odometry=/robot1/odom", "--publish", "crosscut", "--out", results, "--map", flight_map)
    try:
        wait_until(lambda: all(writer.get_matched_subscriptions() for writer in writers.values()))
        for of_type, message in recorded(tee):
            writers[of_type].write(idl_value(message))
            time.sleep(0.01 if of_type == LASER_SCAN else 0)
        scans = [message for of_type, message in recorded(tee) if of_type == LASER_SCAN]
        stamps = [stamp(scan) for scan in scans]
        wait_until(lambda: results.exists() and results.read_text().count("\n") == len(scans))
    finally:
        code, said = interrupted(process)
    assert code == 0 and f"{len(scans)} revolutions in" in said, said
    lines = check_answers(results, tee)
    # The first ones are sent before the subscribers of the topics are known.
    published = [json.loads(message.data) for message in told["results"].take(1000)]
    assert len(published) > len(lines) / 2 and all(line in lines for line in published)
    assert [json.loads(message.data) for message in told["map"].take(1000)][-1] == json.loads(flight_map.read_text())
    drawings = told["markers"].take(1000)
    assert len(drawings) > len(lines) / 2
    seqs = [stamps.index(stamp(drawing.markers[0])) for drawing in drawings]
    check_markers(drawings, [lines[seq] for seq in seqs], [scans[seq] for seq in seqs])


def test_a_lossy_network_loses_no_scan_of_a_reliable_robot(
    tee: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = Robot(monkeypatch, LOSSY)
    scans, transforms = robot.writer("/robot1/scan", LASER_SCAN, RELIABLE), robot.writer("/tf", TF, RELIABLE)
    results = tmp_path / "live.jsonl"
    process = robot.answers("--set", "ingest.odometry=/tf", "--out", results)
    try:
        wait_until(lambda: all(writer.get_matched_subscriptions() for writer in (scans, transforms)))
        for of_type, message in recorded(tee):
            if of_type == LASER_SCAN:
                scans.write(idl_value(message))
                time.sleep(0.025)
            else:
                transforms.write(transform(message))
        assert scans.wait_for_acks(duration(seconds=30))
        time.sleep(2)  # what waits is answered
    finally:
        said = interrupted(process)[1]
    # Scans that are sent again come late, many at once; some of them may wait too long.
    left_out = sum(map(int, re.findall(r"(\d+) messages? of robot1/scan came faster", said)))
    answered = len(check_answers(results, tee))
    assert answered + left_out == 141 and answered > 100, said


def test_scans_that_a_lossy_network_loses_are_missing_by_their_stamps(
    tee: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = Robot(monkeypatch, LOSSY)
    writer = robot.writer("/robot1/scan", LASER_SCAN, BEST_EFFORT)
    scans = [idl_value(message) for of_type, message in recorded(tee) if of_type == LASER_SCAN]
    results = tmp_path / "live.jsonl"
    process = robot.answers("--out", results)
    try:
        wait_until(writer.get_matched_subscriptions)
        for scan in scans:
            writer.write(scan)
            time.sleep(0.025)
        time.sleep(2)  # what waits is answered
    finally:
        said = interrupted(process)[1]
    gaps = int(re.findall(r"about (\d+) scans are missing by their stamps", said)[0])
    stamps = [json.loads(line)["stamp_ns"] for line in results.read_text().splitlines()]
    # The first intervals show what is usual.
    lost = round((stamps[-1] - stamps[5]) / 1e8) + 1 - len(stamps[5:])
    assert lost > 3 and abs(lost - gaps) <= 3, (lost, said)


def test_commands_reach_the_base_over_dds(monkeypatch: pytest.MonkeyPatch) -> None:
    base = Robot(monkeypatch)
    heard = base.reader("/robot1/cmd_vel", "geometry_msgs/msg/Twist")
    heard_stamped = base.reader("/robot1/cmd_vel_stamped", "geometry_msgs/msg/TwistStamped")
    commands: list[Any] = []
    stamped: list[Any] = []

    def is_heard() -> bool:
        robot.drive("/robot1/cmd_vel", 0.5, -0.25)
        robot.drive("/robot1/cmd_vel_stamped", 0.5, -0.25, stamped=True)
        commands.extend(heard.take(10))
        stamped.extend(heard_stamped.take(10))
        return bool(commands and stamped)

    with crosscut.live.Robot(f"ros2://{base.domain}/robot1/scan") as robot:
        wait_until(is_heard)
    for command in (commands[0], stamped[0].twist):
        linear, angular = command.linear, command.angular
        assert [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z] == [0.5, 0, 0, 0, 0, -0.25]
    assert stamped[0].header.frame_id == "base_link" and abs(stamped[0].header.stamp.sec - time.time()) < 60


def test_a_thread_of_dds_that_dies_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = Robot(monkeypatch)
    writer = robot.writer("/robot1/scan", LASER_SCAN, RELIABLE)

    def fail(*_: Any) -> None:
        raise RuntimeError("out of order")

    monkeypatch.setattr("crosscut._dds.Bus._reader", fail)
    with crosscut.live.Robot(f"ros2://{robot.domain}/robot1/scan") as heard:
        with pytest.raises(crosscut.Error, match="can no longer be heard: RuntimeError: out of order"):
            list(heard)
    del writer


def stamp(message: Any) -> tuple[int, int]:
    return message.header.stamp.sec, message.header.stamp.nanosec


def transform(odometry: Any) -> Any:
    """Odometry as the transform below frame odom."""
    pose = odometry.pose.pose
    moved = idl("geometry_msgs/msg/Vector3")(pose.position.x, pose.position.y, pose.position.z)
    transform = idl("geometry_msgs/msg/Transform")(moved, idl_value(pose.orientation))
    stamped = idl("geometry_msgs/msg/TransformStamped")(idl_value(odometry.header), odometry.child_frame_id, transform)
    return idl(TF)([stamped])


def test_what_is_wrong_with_a_robot_on_dds_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = Robot(monkeypatch)
    writer = robot.writer("/robot1/scan", TEXT, RELIABLE)
    with crosscut.live.Robot(f"ros2://{robot.domain}/robot1/scan") as heard:
        wait_until(writer.get_matched_subscriptions)
        writer.write(idl(TEXT)("no scan"))
        threading.Timer(1.5, heard.stop).start()
        monkeypatch.setattr(crosscut.live, "SILENCE_S", 0.3)
        with pytest.warns(crosscut.LossWarning, match="1 messages on robot1/scan cannot be read"):
            assert list(heard) == []
    for address, why in (("ros2://scan", "a number and a topic"), ("ros2://x/scan", "a number and a topic"),
                         ("dds://0/scan", "zenoh:// or ros2://")):
        with pytest.raises(crosscut.SettingsError, match=why):
            crosscut.live.Robot(address)

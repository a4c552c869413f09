"""The files for ROS 2 and Foxglove name what the program takes and sends."""

from __future__ import annotations

import json
import runpy
import subprocess
import sys
import types
from pathlib import Path
from unittest.mock import MagicMock

import pytest
from conftest import in_wheel

import crosscut

FILES = Path(__file__).parents[2] / "integrations/ros2"
SENT = {"/scan", "/crosscut/markers"}  # by the default of --publish in the launch file


def test_the_launch_file_starts_a_command_that_the_program_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("launch", "launch.actions", "launch.conditions", "launch.substitutions"):
        module = types.ModuleType(name)
        module.__getattr__ = lambda _: MagicMock()  # type: ignore[method-assign]
        monkeypatch.setitem(sys.modules, name, module)
    launch = runpy.run_path(str(FILES / "crosscut.launch.py"))
    given = {name: default for name, (default, _) in launch["ARGUMENTS"].items()}
    given |= {"odometry": "/odom", "options": '--save "my flight.rrd" --map map.json --quiet'}
    words = launch["command"](given.__getitem__)
    assert words[2].startswith("ros2://") and words[2].endswith("/scan") and "my flight.rrd" in words, words
    told = subprocess.run([in_wheel(), *words[1:], "--help"], capture_output=True, text=True, check=False)
    assert told.returncode == 0 and "--publish" in told.stdout, told.stderr
    wrong = subprocess.run([in_wheel(), *words[1:], "--nothing", "--help"], capture_output=True, check=False)
    assert wrong.returncode == 2, "options are read before --help is obeyed"


def test_rviz_shows_topics_that_are_sent() -> None:
    yaml = pytest.importorskip("yaml")
    manager = yaml.safe_load((FILES / "crosscut.rviz").read_text())["Visualization Manager"]
    topics = {display["Topic"]["Value"] for display in manager["Displays"] if "Topic" in display}
    assert topics == SENT


def test_the_layout_shows_topics_and_fields_that_are_sent(tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader")
    layout = json.loads((FILES / "foxglove.json").read_text())
    panels = layout["configById"]
    flight = tmp_path / "flight.mcap"
    crosscut.run(Path(__file__).parents[2] / "recordings/tee.mcap", results=flight)
    with flight.open("rb") as file:
        messages = {channel.topic: message.data for _, channel, message in reader.make_reader(file).iter_messages()}
    assert set(panels["3D!crosscut"]["topics"]) <= messages.keys() | SENT
    result = json.loads(messages["/crosscut/results"])
    for panel in ("Plot!walls", "Plot!confidence"):
        for path in panels[panel]["paths"]:
            topic, _, field = path["value"].partition(".")
            assert topic == "/crosscut/results" and field in result, path
    assert panels["RawMessages!result"]["topicPath"] in messages
    assert set(panels) == {"3D!crosscut", "Plot!walls", "Plot!confidence", "RawMessages!result"}
    drawn = json.dumps(layout["layout"])
    assert all(f'"{name}"' in drawn for name in panels)

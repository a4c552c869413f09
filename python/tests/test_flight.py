"""A flight, and its map."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

import crosscut


def test_the_map_is_that_of_the_command_line(program: str, tee: Path, tmp_path: Path) -> None:
    path = tmp_path / "map.json"
    subprocess.run([program, "run", tee, "--map", path, "--quiet"], check=True)
    expected = json.loads(path.read_text())
    flight = crosscut.Flight()
    for scan in crosscut.read(tee):
        flight.process(scan)
    assert flight.map.to_dict() == expected
    assert flight.map.to_json() == path.read_text().rstrip("\n")
    graph = flight.map.to_networkx()
    assert graph.number_of_nodes() == len(expected["nodes"]) == 1
    assert graph.number_of_edges() == len(expected["edges"])
    for number, node in graph.nodes(data=True):
        of_program = expected["nodes"][number]
        for name in ("kind", "x_m", "y_m"):
            assert node[name] == of_program[name]
        assert [list(visit) for visit in node["visits"]] == of_program["visits"]
        assert len(node["ways"]) == len(of_program["ways"])
    assert repr(flight.map).startswith("Map(1 junction: 1 tee;")


def test_results_of_a_flight_are_the_lines_of_the_command_line(program: str, tee: Path) -> None:
    lines = subprocess.run([program, "run", tee, "--out", "-", "--quiet"], check=True, capture_output=True, text=True)
    engine = crosscut.Engine()
    flight = crosscut.Flight(engine)
    results = [flight.process(scan) for scan in crosscut.read(tee)]
    assert [result.to_dict() for result in results] == [json.loads(line) for line in lines.stdout.splitlines()]
    last = results[-1]
    assert last.here is not None and last.steady is not None and last.pose is not None
    assert last.here.kind in ("junction", "passage", "dead_end", "chamber")
    assert all(way is None or way < len(last.openings) for way in last.here.ways)
    alone = engine.process(next(iter(crosscut.read(tee))))
    assert (alone.here, alone.steady, alone.pose) == (None, None, None), "of the flight alone"


def test_a_given_pose_is_the_odometry() -> None:
    ranges = 2.0 / np.maximum(np.abs(np.sin(np.linspace(0, 2 * np.pi, 360, endpoint=False))), 0.1)
    engine = crosscut.Engine(flight={"pose": "odometry"})
    flight = crosscut.Flight(engine)
    assert flight.pose is None
    for x_m in (5.0, 6.0):
        flight.process(crosscut.Scan(ranges, 0.0, np.pi / 180, range_max=30.0), pose=(x_m, 1.0, np.pi / 2))
    assert flight.pose == pytest.approx((0.0, -1.0, 0.0)), "in the frame of the first scan"

"""What comes out is what the program writes."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import recordings

import crosscut


def lines(program: str, recording: Path, *args: str) -> list[dict[str, Any]]:
    run = subprocess.run([program, "run", recording, "--out", "-", "--quiet", *args], capture_output=True, text=True)
    assert run.returncode in (0, 3), run.stderr
    return [json.loads(line) for line in run.stdout.splitlines()]


@pytest.mark.filterwarnings("ignore::crosscut.LossWarning")
@pytest.mark.parametrize("preset", ["default", "paper"])
@pytest.mark.parametrize("recording", recordings())
def test_results_equal_those_of_the_command_line(program: str, recording: Path, preset: str) -> None:
    every = 1 if preset == "default" else 20
    expected = lines(program, recording, "--preset", preset, "--every", str(every))
    engine = crosscut.Engine(preset)
    scans = engine.read(recording, every=every)
    number = -1
    for number, (result, line) in enumerate(zip(engine.process_many(scans, workers=2), expected, strict=True)):
        for of_flight in ("here", "steady", "pose"):
            line[of_flight] = None
        notes = line.pop("notes")
        found = result.to_dict()
        assert found.pop("notes") == notes[: len(result.notes)], "the flight adds notes at the end"
        assert found == line, f"scan {number}"
    assert number >= 0


@pytest.mark.parametrize("workers", [2, 3])
def test_the_number_of_workers_changes_no_result(tee: Path, workers: int) -> None:
    engine = crosscut.Engine()
    scans = list(crosscut.read(tee))
    alone = list(engine.process_many(scans, workers=1))
    assert alone == list(engine.process_many(iter(scans), workers=workers))
    assert alone == [engine.process(scan) for scan in scans]


def test_count_and_engine_and_message_agree(tee: Path) -> None:
    scan = next(iter(crosscut.read(tee, from_s=8)))
    assert scan.ranges is not None and scan.angle_min is not None and scan.angle_increment is not None
    assert scan.range_min is not None and scan.range_max is not None

    class Message:
        ranges, angle_min, angle_increment = scan.ranges, scan.angle_min, scan.angle_increment
        range_min, range_max = scan.range_min, scan.range_max

    recorded = crosscut.Engine().process(scan)
    message = crosscut.Engine().process(Message())
    counted = crosscut.count(
        scan.ranges, scan.angle_min, scan.angle_increment, range_min=scan.range_min, range_max=scan.range_max
    )
    assert counted == message
    assert np.array_equal(counted.labels, recorded.labels)
    assert counted.openings == recorded.openings
    assert counted.labels.dtype == np.int32 and len(counted.labels) == len(scan.ranges)
    with pytest.raises(dataclasses.FrozenInstanceError):
        counted.junctions = 4  # type: ignore[misc]


@pytest.mark.parametrize("names", [("sec", "nanosec"), ("secs", "nsecs")])
def test_messages_of_both_versions_of_ros_have_their_stamp(names: tuple[str, str]) -> None:
    stamp = types.SimpleNamespace(**dict(zip(names, (5, 7), strict=True)))
    header = types.SimpleNamespace(stamp=stamp, frame_id="lidar")
    message = types.SimpleNamespace(header=header, ranges=[2.0] * 90, angle_min=0.0, angle_increment=0.07)
    assert crosscut.Engine().process(message).stamp_ns == 5_000_000_007


def test_range_limits_are_those_of_the_sensor() -> None:
    ranges = np.full(360, 2.0)
    assert crosscut.count(ranges, 0.0, np.pi / 180, range_max=1.5).returns == 0
    assert crosscut.count(ranges, 0.0, np.pi / 180, range_min=2.5).returns == 0
    assert crosscut.count(list(ranges), 0.0, np.pi / 180, range_max=2.5).returns == 360


def test_settings_are_taken_in_every_form() -> None:
    engines = [
        crosscut.Engine("paper", affinity={"sigma_per_m2": 3}, ingest={"masked_sectors_rad": [(0, 1)]}),
        crosscut.Engine("paper", settings={"affinity.sigma_per_m2": 3.0, "ingest.masked_sectors_rad": [[0.0, 1.0]]}),
    ]
    assert engines[0].config == engines[1].config
    assert "sigma_per_m2 = 3.0  # settings" in engines[0].config
    assert 'kind = "threshold"  # settings' in crosscut.Engine(affinity="threshold").config


def test_matrices_are_kept_dense_and_sparse(tee: Path) -> None:
    scan = next(iter(crosscut.read(tee, from_s=8)))
    for preset, kind in (("paper", np.ndarray), ("default", None)):
        result = crosscut.Engine(preset, keep=("W", "L", "U")).process(scan)
        n = result.returns
        assert result.W.shape == result.L.shape == (n, n) and result.U.shape == (n, result.k)
        w, laplacian = (m if kind else m.toarray() for m in (result.W, result.L))
        degrees = w.sum(axis=0)
        assert np.allclose(laplacian, np.eye(n) - w / np.sqrt(np.outer(degrees, degrees)), atol=1e-14)
        assert np.allclose(result.U.T @ result.U, np.eye(result.k), atol=1e-8)
    assert crosscut.Engine().process(scan).W is None
    with pytest.raises(ValueError, match="keep holds W, L, U and markers, not D"):
        crosscut.Engine(keep=["D"])


def test_points_are_a_cloud() -> None:
    x = np.arange(0, 4, 0.2)
    points = np.concatenate([np.column_stack([x, np.full(20, y)]) for y in (-3.0, 3.0)])
    result = crosscut.Engine("paper").process(points)
    assert (result.junctions, len(result.labels)) == (2, 40)
    assert crosscut.Engine("paper").process(np.column_stack([points, np.zeros(40)])) == result


def test_a_tunnel_seen_all_around_has_two_level_ways() -> None:
    along_m, around_rad = np.meshgrid(np.linspace(-30, 30, 600), np.linspace(-np.pi, np.pi, 60, endpoint=False))
    points = np.stack([along_m, 2 * np.cos(around_rad), 2 * np.sin(around_rad)], axis=-1).reshape(-1, 3)
    result = crosscut.Engine("3d").process(points)
    assert result.ways is not None
    assert [way.kind for way in result.ways] == ["level", "level"]
    line = result.to_dict()
    assert (line["ways_flyer"], line["ways_ground"]) == (2, 2)
    assert crosscut.Engine().process(points).ways is None



def test_an_empty_scan_has_an_answer() -> None:
    for scan in (crosscut.Scan([], 0.0, 0.1), crosscut.Scan([np.inf] * 60, 0.0, 0.1), np.zeros((0, 2))):
        assert crosscut.Engine(keep=("W", "U", "L")).process(scan).junctions == 0


def test_a_file_of_results_is_a_table(program: str, tee: Path, tmp_path: Path) -> None:
    path = tmp_path / "tee.jsonl"
    subprocess.run([program, "run", tee, "--out", path, "--quiet"], check=True)
    table = crosscut.results(path)
    engine = crosscut.Engine()
    expected = list(engine.process_many(engine.read(tee)))
    assert table.num_rows == len(expected)
    assert table["junctions"].to_pylist() == [result.junctions for result in expected]
    assert table["labels"].to_pylist() == [result.labels.tolist() for result in expected]
    assert table["openings"][5].as_py() == expected[5].to_dict()["openings"]
    path.write_text("")
    assert crosscut.results(path).schema == table.schema


def test_a_result_has_every_field(tee: Path) -> None:
    result = crosscut.Engine().process(next(iter(crosscut.read(tee))))
    assert list(vars(result)) == [field.name for field in dataclasses.fields(crosscut.Result)]
    assert dataclasses.replace(result, seq=7).seq == 7

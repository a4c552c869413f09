"""Flights on a Ray cluster: real workers and nodes, which are killed."""

from __future__ import annotations

import contextlib
import io
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT, SHIPPED, in_wheel, write_scans

import crosscut
import crosscut.ray

FLIGHTS = 8


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Two nodes on this machine; the second one can be taken away."""
    ray = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    ray.init(address=made.address, log_to_driver=False)
    yield made
    ray.shutdown()
    made.shutdown()


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    """A folder of flights, one of them damaged, one that is no recording."""
    folder = tmp_path / "archive"
    folder.mkdir()
    for number in range(FLIGHTS - 2):
        shutil.copy(SHIPPED[number % len(SHIPPED)], folder / f"flight{number:02}.mcap")
    whole = SHIPPED[0].read_bytes()
    (folder / "cut.mcap").write_bytes(whole[: len(whole) * 2 // 3])
    (folder / "text.mcap").write_text("no recording")
    return folder


def first_then_slow(tmp_path: Path, program: str) -> list[str]:
    """The program, which waits at its first run for each flight, so that it can be killed there."""
    script = tmp_path / "slow.sh"
    script.write_text(
        f'#!/bin/sh\nmark="{tmp_path}/started-$(basename "$2")"\n'
        f'if mkdir "$mark" 2>/dev/null; then echo $$ > "$mark/pid"; exec sleep 600; fi\nexec "{program}" "$@"\n'
    )
    script.chmod(0o755)
    return [str(script)]


@contextlib.contextmanager
def killing_first_runs(tmp_path: Path, also: Callable[[list[int]], None] = lambda killed: None) -> Iterator[list[int]]:
    """Kills each program of :func:`first_then_slow` at its first run; ``also`` is asked each time, with those killed so far."""
    killed: list[int] = []
    finished = threading.Event()

    def disturb() -> None:
        while not finished.wait(0.2):
            for mark in sorted(tmp_path.glob("started-*/pid")):
                if text := mark.read_text().strip():
                    mark.unlink()
                    os.kill(int(text), signal.SIGKILL)
                    killed.append(int(text))
            also(killed)

    disturber = threading.Thread(target=disturb)
    disturber.start()
    try:
        yield killed
    finally:
        finished.set()
        disturber.join()


def test_rows_are_those_of_one_process_though_workers_and_a_node_are_lost(
    cluster: Any, archive: Path, tmp_path: Path, program: str
) -> None:
    expected = crosscut.ray.run_here(archive, tmp_path / "here", command=[program])
    node = cluster.add_node(num_cpus=2)
    command = first_then_slow(tmp_path, program)

    def take_node_away(killed: list[int]) -> None:
        if len(killed) >= 3 and len(cluster.worker_nodes) > 0:
            cluster.remove_node(node, allow_graceful=False)

    with killing_first_runs(tmp_path, take_node_away) as killed:
        found = crosscut.ray.run(archive, tmp_path / "ray", command=command)
    assert len(killed) >= FLIGHTS, "each flight was killed once"
    assert not cluster.worker_nodes, "the node was lost"
    assert found == expected
    assert found.num_rows == FLIGHTS
    codes = dict(zip((Path(flight).name for flight in found["flight"].to_pylist()), found["code"].to_pylist(), strict=True))
    assert (codes["cut.mcap"], codes["text.mcap"], codes["flight00.mcap"]) == (3, 1, 0)
    names = {path.name for path in (tmp_path / "here").iterdir()}
    assert {path.name for path in (tmp_path / "ray").iterdir()} == names, "nothing unfinished is left"
    for name in names - {"times.csv", "flights.parquet"}:
        if not name.endswith(".done.json"):
            assert (tmp_path / "ray" / name).read_bytes() == (tmp_path / "here" / name).read_bytes(), name


def test_a_comparison_has_the_rows_of_one_process_though_workers_are_lost(
    cluster: Any, tee: Path, tmp_path: Path, program: str
) -> None:
    archive = tmp_path / "archive"
    archive.mkdir()
    flights = [archive / f"flight{number}.mcap" for number in range(3)]
    for flight in flights:
        shutil.copy(tee, flight)
    grid = {"vehicle.width_m": [0.6, 0.8]}
    command = first_then_slow(tmp_path, program)
    with killing_first_runs(tmp_path):
        found = crosscut.ray.compare(archive, tmp_path / "ray", grid=grid, command=command)
    assert sum(1 for _ in tmp_path.glob("started-*")) == 3
    assert found["flight"].to_pylist() == [str(flight) for flight in flights for _ in range(2)]
    crosscut.compare(archive, grid=grid, csv=tmp_path / "here.csv")
    rows = [line.split(",", 1)[1] for line in (tmp_path / "here.csv").read_text().splitlines()]
    assert [line.split(",", 1)[1] for line in (tmp_path / "ray" / "compare.csv").read_text().splitlines()] == rows


def test_a_thousand_flights_are_there_once_though_the_driver_is_killed(
    cluster: Any, tee: Path, tmp_path: Path
) -> None:
    program = os.environ.get("CROSSCUT") or str(ROOT / "target" / "release" / "crosscut")
    if not Path(program).exists():
        pytest.skip("needs target/release/crosscut: the program in the wheel, an interpreter each time, takes minutes")
    node = cluster.add_node(num_cpus=1)
    few = [tmp_path / f"short{number}.mcap" for number in range(4)]
    for number, path in enumerate(few):
        write_scans(tee, path, range(40 * number, 40 * number + 5))
    (tmp_path / "archive").mkdir()
    thousand = [tmp_path / "archive" / f"flight{number:03}.mcap" for number in range(1000)]
    for number, flight in enumerate(thousand):
        flight.hardlink_to(few[number % len(few)])
    out = tmp_path / "out"
    script = f"""
import crosscut.ray
crosscut.ray.run({str(tmp_path / "archive")!r}, {str(out)!r}, command=[{program!r}], address={cluster.address!r})
"""
    with subprocess.Popen([sys.executable, "-c", script]) as driver:
        while len(list(out.glob("*.done.json"))) < 300 and driver.poll() is None:
            time.sleep(0.05)
        driver.kill()
    first = {path: path.stat().st_mtime_ns for path in out.glob("*.done.json")}
    assert 300 <= len(first) < 1000
    found = crosscut.ray.run(tmp_path / "archive", out, command=[program])
    assert all(path.stat().st_mtime_ns == stamp for path, stamp in first.items()), "what was done was kept"
    alone = crosscut.ray.run_here(few, tmp_path / "here", command=[program]).drop_columns("flight").to_pylist()
    assert len({row["mean_confidence"] for row in alone}) == len(few), "the flights differ"
    assert found["flight"].to_pylist() == [str(flight) for flight in thousand]
    assert found.drop_columns("flight").to_pylist() == alone * 250
    assert len(list(out.glob("*.jsonl"))) == len(list(out.glob("*.map.json"))) == 1000
    assert not list(out.glob(".*")), "nothing unfinished is left"
    cluster.remove_node(node)


def test_a_second_run_does_what_is_left(cluster: Any, archive: Path, tmp_path: Path, program: str) -> None:
    out = tmp_path / "out"
    first = crosscut.ray.run(archive, out, command=[program])
    stamps = {path: path.stat().st_mtime_ns for path in out.glob("*.jsonl")}
    again = max(stamps)
    (out / again.name.replace(".jsonl", ".done.json")).unlink()
    assert crosscut.ray.run(archive, out, command=[program]) == first
    changed = {path for path in out.glob("*.jsonl") if path.stat().st_mtime_ns != stamps[path]}
    assert changed == {again}
    failed = (out / "failures.csv").read_text().splitlines()[1:]
    assert [Path(line.split(",")[0]).name for line in failed] == ["cut.mcap", "text.mcap"]


def test_a_flight_whose_name_is_a_pattern_has_its_results(tee: Path, tmp_path: Path, program: str) -> None:
    shutil.copy(tee, tmp_path / "run[1].mcap")
    found = crosscut.ray.run_here(tmp_path, tmp_path / "out", command=[program]).to_pylist()
    assert [(row["code"], row["revolutions"]) for row in found] == [(0, 141)]
    assert len(list((tmp_path / "out").glob("*.jsonl"))) == len(list((tmp_path / "out").glob("*.map.json"))) == 1


def test_what_a_lost_worker_leaves_is_removed_whatever_the_name(tee: Path, tmp_path: Path, program: str) -> None:
    flight = shutil.copy(tee, tmp_path / "run[1].mcap")
    crosscut.ray.run_here(flight, tmp_path / "out", command=[program])
    (done,) = (tmp_path / "out").glob("*.done.json")
    left = tmp_path / "out" / f".{done.name.removesuffix('.done.json')}.0123"
    left.mkdir()
    crosscut.ray.run_here(flight, tmp_path / "out", command=[program])
    assert not left.exists()


def test_a_changed_stage_or_part_has_its_flight_computed_again(
    tee: Path, tmp_path: Path, program: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    flight = tmp_path / "flight"
    flight.mkdir()
    shutil.copy(tee, flight / "flight_0.mcap")
    (flight / "metadata.yaml").write_text("rosbag2_bagfile_information:\n  relative_file_paths: [flight_0.mcap]\n")
    stage = tmp_path / "mine.py"
    stage.write_text("def labels(u, k):\n    return [0] * len(u)\n")

    def stamp() -> int:
        rows = crosscut.ray.run_here(flight, tmp_path / "out", command=[program], kmeans="python:mine.labels").to_pylist()
        assert [row["code"] for row in rows] == [0], rows
        (results,) = (tmp_path / "out").glob("*.jsonl")
        return results.stat().st_mtime_ns

    first = stamp()
    assert stamp() == first, "nothing has changed"
    stage.write_text("def labels(u, k):\n    return [0] * (len(u) - 1) + [1]\n")
    second = stamp()
    assert second > first
    os.utime(flight / "flight_0.mcap", ns=(0, 0))
    assert stamp() > second


def test_each_flight_of_an_archive_is_found_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ["a.mcap", "b.mcap.zst", "c.PCD", "d.ply", "e.bag.active", "bag/metadata.yaml", "bag/bag_0.db3", "bag/bag_1.db3",
             "deep/er/f.clf", "a.mcap.zst", "notes.txt", "settings.toml"]
    for name in names:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    found = crosscut.ray._flights([".", "a.mcap", tmp_path / "a.mcap", "bag/../a.mcap", "bag"])
    expected = ["a.mcap", "b.mcap.zst", "bag", "c.PCD", "d.ply", "deep/er/f.clf", "e.bag.active"]
    assert found == sorted(tmp_path / name for name in expected)


def test_the_endings_of_flights_are_those_of_the_program() -> None:
    source = (ROOT / "crates" / "ingest" / "src" / "inputs.rs").read_text()
    of_program = [re.findall(r'"(\w+)"', re.findall(rf"const {name}: .*= \[(.*)\]", source)[0]) for name in ("KINDS", "AFTER_KIND")]
    assert [f".{kind}" for kind in of_program[0]] == list(crosscut.ray.KINDS[:-2]), "and .log and .csv, which name no kind there"
    assert [f".{ending}" for ending in of_program[1]] == list(crosscut.ray.AFTER_KIND)


def test_an_error_of_a_task_is_its_reason(cluster: Any, tee: Path, tmp_path: Path) -> None:
    (row,) = crosscut.ray.run(tee, tmp_path / "out", command=["/absent/crosscut"]).to_pylist()
    assert row["code"] is None and "No such file or directory: '/absent/crosscut'" in row["error"]
    killed = tmp_path / "killed.sh"
    killed.write_text("#!/bin/sh\nkill -9 $$\n")
    killed.chmod(0o755)
    (row,) = crosscut.ray.run(tee, tmp_path / "out", command=[str(killed)]).to_pylist()
    assert row["error"].startswith("its task was lost 6 times: ")


def test_a_comparison_that_lost_something_says_so(tee: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("ray")
    monkeypatch.setattr(crosscut.ray, "_on_ray", lambda address: crosscut.ray._one_by_one)
    said = io.StringIO()
    monkeypatch.setattr(sys, "stderr", said)
    lossy = tmp_path / "lossy.sh"
    lossy.write_text(f'#!/bin/sh\n"{in_wheel()}" "$@"\necho "lost: a chunk" >&2\nexit 3\n')
    lossy.chmod(0o755)
    args = [str(tee), "--out", str(tmp_path / "out"), "--grid", "vehicle.width_m=0.6"]
    assert crosscut.ray.main("compare", args) == 0
    monkeypatch.setattr(crosscut.ray, "COMMAND", (str(lossy),))
    assert crosscut.ray.main("compare", args) == 3
    assert "1 flights, 0 failed, 1 damaged: " in said.getvalue()


def test_a_task_takes_one_processor(tee: Path, tmp_path: Path) -> None:
    program = tmp_path / "program.sh"
    program.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/arguments\nexec "{in_wheel()}" "$@"\n')
    program.chmod(0o755)
    crosscut.ray.run_here(tee, tmp_path / "out", command=[str(program)])
    assert "--set pipeline.workers=1 " in (tmp_path / "arguments").read_text()


def test_the_command_line_says_what_failed(archive: Path, tmp_path: Path) -> None:
    few = [str(archive / name) for name in ("flight00.mcap", "text.mcap")]
    command = [in_wheel(), "run", "--on", "ray", *few, "--out", str(tmp_path / "out"), "--address", "local"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 3, done.stderr
    assert "2 flights, 1 failed, 0 damaged" in done.stderr and "text.mcap" in done.stderr
    refused = subprocess.run([in_wheel(), "run", "--on", "dask", *few], capture_output=True, text=True)
    assert (refused.returncode, refused.stderr) == (2, "error: --on takes ray\n")

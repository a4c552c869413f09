"""Stages as nodes of dora: real daemons on this machine, of which nodes and one daemon are killed."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sysconfig
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import crosscut
import pytest
from conftest import free_port, in_wheel

SCRIPTS = Path(sysconfig.get_path("scripts"))
NODES = ("source", "affinity", "spectral", "kmeans", "report")


def in_background(folder: Path, *command: str | Path) -> subprocess.Popen[str]:
    """A process with the programs of the wheel on its path; a daemon writes the messages of nodes into its folder."""
    path = f"{SCRIPTS}{os.pathsep}{os.environ['PATH']}"
    log = subprocess.DEVNULL if command[1] in ("coordinator", "daemon") else subprocess.PIPE
    return subprocess.Popen(
        [SCRIPTS / command[0], *command[1:]], env={**os.environ, "PATH": path, "PYTHONPATH": str(Path(__file__).parent)},
        cwd=folder, stdout=log, stderr=subprocess.STDOUT if log is subprocess.PIPE else log, text=True)


class Flow:
    """A dataflow in a folder of its own."""

    def __init__(self, folder: Path, flights: list[Path], *options: str) -> None:
        self.results, self.map, self.file = folder / "flight.jsonl", folder / "map.json", folder / "flow.yml"
        command: list[str | Path] = [SCRIPTS / "crosscut-dora", "dataflow", *flights, "--results", self.results, "--map", self.map, *options]
        self.file.write_text(subprocess.run(command, capture_output=True, text=True, check=True).stdout)

    def run(self) -> subprocess.Popen[str]:
        return in_background(self.file.parent, "dora", "run", self.file)

    @property
    def lines(self) -> int:
        """Those that are written so far."""
        unfinished = self.results.with_name(f".{self.results.name}.unfinished")
        return next((path.read_bytes().count(b"\n") for path in (self.results, unfinished) if path.exists()), 0)

    def node(self, name: str) -> int:
        """The process of a node; 0 if there is none."""
        of_this_flow = str(self.results) if name == "report" else f"node\0{name}\0"
        for entry in Path("/proc").iterdir():
            try:
                command = (entry / "cmdline").read_bytes().decode()
                if of_this_flow in command and "\0node\0" in command and str(self.file.parent) in status(entry, "environ"):
                    return int(entry.name)
            except (OSError, ValueError):
                continue
        return 0


def status(process: Path, what: str) -> str:
    return (process / what).read_bytes().decode(errors="replace")


def peak_mb(process: int) -> float:
    """The most memory that a process has had."""
    return int(re.findall(r"VmHWM:\s+(\d+)", status(Path(f"/proc/{process}"), "status"))[0]) / 1024


def finish(process: subprocess.Popen[str], within_s: float = 90.0) -> str:
    """What was said up to the end, which comes with code 0."""
    try:
        said, _ = process.communicate(timeout=within_s)
    except subprocess.TimeoutExpired:
        process.terminate()  # its nodes end with it
        raise AssertionError(f"it goes on: {process.communicate()[0]}") from None
    assert process.returncode == 0, said
    return said


def wait_for(condition: Callable[[], object], what: str, within_s: float = 60.0) -> None:
    deadline = time.monotonic() + within_s
    while not condition():
        assert time.monotonic() < deadline, f"{what}: not within {within_s:.0f} s"
        time.sleep(0.02)


def sent_again(said: str) -> int:
    return int(re.findall(r"(\d+) messages sent again", said)[0])


@pytest.fixture(scope="module")
def expected(tee: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results and map of the shipped flight, by the program."""
    folder = tmp_path_factory.mktemp("program")
    outputs: list[str | Path] = ["--results", folder / "flight.jsonl", "--map", folder / "map.json", "--quiet"]
    subprocess.run([in_wheel(), "run", tee, *outputs], check=True)
    return folder


def assert_the_same(flow: Flow, expected: Path) -> None:
    assert flow.results.read_bytes() == (expected / "flight.jsonl").read_bytes()
    assert flow.map.read_bytes() == (expected / "map.json").read_bytes()
    assert not list(flow.results.parent.glob(".*.unfinished"))


@pytest.mark.parametrize("batch", ["1", "16"])
def test_one_daemon_gives_the_bytes_of_the_program(tee: Path, tmp_path: Path, expected: Path, batch: str) -> None:
    flow = Flow(tmp_path, [tee], "--batch", batch)
    assert "141 revolutions; 1 junction: 1 tee" in finish(flow.run())
    assert_the_same(flow, expected)


def test_an_affinity_in_python_gives_the_bytes_of_the_program(tee: Path, tmp_path: Path) -> None:
    options = ["--every", "20", "--preset", "paper", "--set", "affinity.kind=python:stages_of_ones_own.rbf"]
    flow, program = Flow(tmp_path, [tee], *options), tmp_path / "program.jsonl"
    finish(flow.run())
    command: list[str | Path] = [in_wheel(), "run", tee, "--results", program, "--quiet", *options]
    subprocess.run(command, check=True, cwd=Path(__file__).parent)
    assert flow.results.read_bytes() == program.read_bytes()
    assert b'"confidence":null' in program.read_bytes(), "nothing was calibrated for it"


@pytest.fixture
def hosts(tmp_path: Path) -> Iterator[Hosts]:
    made = Hosts(tmp_path)
    yield made
    made.stop()


class Hosts:
    """A coordinator and the daemons `robot` and `desk`, as on two hosts."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.overlay = folder, folder / "overlay.json5"
        block = {"key_exprs": ["dora/**"], "config": {"congestion_control": "block"}}
        self.overlay.write_text(json.dumps({"qos": {"publication": [block]}}))
        self.port, self.zenoh = str(free_port()), free_port()
        self.coordinator = in_background(folder, "dora", "coordinator", "--store", "memory", "--port", self.port)
        wait_for(lambda: not is_free(int(self.port)), "the coordinator")
        self.daemons = {name: self.start(name) for name in ("robot", "desk")}

    def start(self, name: str) -> subprocess.Popen[str]:
        here, there = ("127.0.0.2", "127.0.0.3") if name == "robot" else ("127.0.0.3", "127.0.0.2")
        return in_background(
            self.folder, "dora", "daemon", "--machine-id", name, "--coordinator-port", self.port, "--local-listen-port", str(free_port()),
            "--zenoh-listen", f"{here}:{self.zenoh}", "--zenoh-connect", f"tcp/{there}:{self.zenoh}", "--zenoh-no-multicast",
            "--zenoh-config-overlay", str(self.overlay))

    def ask(self, *command: str | Path) -> subprocess.Popen[str]:
        return in_background(self.folder, "dora", *command, "--coordinator-port", self.port)

    def wait_until_connected(self) -> None:
        wait_for(lambda: self.ask("status").communicate()[0].count("robot") + 1, "the daemons")
        time.sleep(1.5)

    def stop(self) -> None:
        for process in (*self.daemons.values(), self.coordinator):
            process.terminate()
        for process in (*self.daemons.values(), self.coordinator):
            process.wait(30)


def is_free(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) != 0


SPLIT = ("--place", "source=robot", "--place", "affinity=robot", "--place", "spectral=desk", "--place", "kmeans=desk",
         "--place", "report=desk")


def test_two_daemons_give_the_bytes_of_the_program(hosts: Hosts, tee: Path, tmp_path: Path, expected: Path) -> None:
    flow = Flow(tmp_path, [tee], *SPLIT)
    hosts.wait_until_connected()
    finish(hosts.ask("start", flow.file, "--attach"))
    assert_the_same(flow, expected)


def test_a_stage_that_is_killed_three_times_loses_nothing(tee: Path, tmp_path: Path) -> None:
    parts = [tee] * 6
    flow = Flow(tmp_path, parts)
    run = flow.run()
    for part, name in ((1, "spectral"), (3, "affinity"), (5, "spectral")):
        wait_for(lambda: flow.lines > 141 * part, "results")
        os.kill(flow.node(name), signal.SIGKILL)
    assert sent_again(finish(run)) > 0
    subprocess.run([in_wheel(), "run", *parts, "--results", tmp_path / "program.jsonl", "--quiet"], check=True)
    lines = flow.results.read_bytes()
    assert [json.loads(line)["seq"] for line in lines.splitlines()] == list(range(len(parts) * 141)), "every one once"
    assert lines == (tmp_path / "program.jsonl").read_bytes()


def test_a_slow_end_holds_the_source_back_in_little_memory(tee: Path, tmp_path: Path) -> None:
    parts = [tee] * 6
    flow = Flow(tmp_path, parts, "--window", "8", "--set", "spectral.kind=slicing", "--set", "affinity.kind=rbf",
                "--set", "affinity.sigma_per_m2=1.5", "--set", "kmeans.kind=components", "--every", "2")
    run = flow.run()
    wait_for(lambda: flow.lines > 50, "results")
    processes = {name: flow.node(name) for name in NODES}
    before = {name: peak_mb(process) for name, process in processes.items()}
    written = flow.lines
    for _ in range(3):  # the last node works a tenth of the time
        os.kill(processes["report"], signal.SIGSTOP)
        time.sleep(0.9)
        os.kill(processes["report"], signal.SIGCONT)
        time.sleep(0.1)
    grown = {name: peak_mb(process) - before[name] for name, process in processes.items()}
    assert 0 < flow.lines - written, "it went on"
    finish(run)
    assert flow.lines == 3 * 141
    # A frame with its W is 1 MB.
    assert max(grown.values()) < 60, grown


def test_a_daemon_that_is_lost_is_noticed_and_a_restart_completes(
    hosts: Hosts, tee: Path, tmp_path: Path
) -> None:
    flow = Flow(tmp_path, [tee], *SPLIT, "--set", "kmeans.kind=python:stages_of_ones_own.slow_rows")
    hosts.wait_until_connected()
    started = hosts.ask("start", flow.file, "--detach")
    uuid = re.findall(r"[0-9a-f]{8}-[0-9a-f-]{27}", started.communicate(timeout=60)[0])[0]
    wait_for(lambda: flow.lines > 20, "results")
    lost = [flow.node(name) for name in ("spectral", "kmeans", "report")]
    for process in (hosts.daemons["desk"].pid, *lost):
        os.kill(process, signal.SIGKILL)
    hosts.daemons["desk"].wait()
    wait_for(lambda: any("no frame has arrived" in log.read_text() for log in tmp_path.rglob("log_source.jsonl")), "a warning")
    hosts.daemons["desk"] = hosts.start("desk")
    hosts.wait_until_connected()
    restarted = hosts.ask("restart", uuid).communicate(timeout=60)[0]
    wait_for(flow.results.exists, f"results after a restart; {restarted}")
    wait_for(lambda: not any(map(flow.node, NODES)), "the end of all nodes")
    quick = ["--set", "kmeans.kind=python:stages_of_ones_own.nearest_row", "--quiet"]
    program = tmp_path / "program.jsonl"
    subprocess.run([in_wheel(), "run", tee, "--results", program, *quick], check=True, cwd=Path(__file__).parent)
    assert flow.results.read_bytes() == program.read_bytes()


def test_the_embedding_of_scikit_learn_takes_the_place_of_a_stage(tee: Path, tmp_path: Path) -> None:
    pytest.importorskip("sklearn")
    stage = Path(__file__).with_name("stages_of_others.py")
    own = Flow(tmp_path, [tee], "--every", "20", "--own", f"spectral={shutil.which('python', path=str(SCRIPTS))} {stage}")
    finish(own.run())
    command: list[str | Path] = [in_wheel(), "run", tee, "--results", tmp_path / "ours.jsonl", "--every", "20", "--quiet"]
    subprocess.run(command, check=True)
    theirs, ours = ([json.loads(line) for line in path.read_text().splitlines()]
                    for path in (own.results, tmp_path / "ours.jsonl"))
    assert [line["seq"] for line in theirs] == [line["seq"] for line in ours]
    clear = [(a, b) for a, b in zip(theirs, ours, strict=True) if b["k"] == a["k"] and (a["eigenvalues"][a["k"]:] or [1.0])[0] > 1e-4]
    assert len(clear) > len(ours) // 2
    for a, b in clear:
        assert a["labels"] == b["labels"], a["seq"]


def test_a_recording_is_that_of_the_program(tee: Path, tmp_path: Path) -> None:
    recording, program = tmp_path / "flight.rrd", tmp_path / "program"
    flow = Flow(tmp_path, [tee], "--every", "20", "--record", str(recording))
    finish(flow.run())
    program.mkdir()
    command: list[str | Path] = [in_wheel(), "run", tee, "--results", program / "lines.jsonl", "--save", program / "flight.rrd"]
    subprocess.run([*command, "--every", "20", "--quiet"], check=True)
    assert flow.results.read_bytes() == (program / "lines.jsonl").read_bytes()
    compared = subprocess.run([in_wheel(), "rrd", "diff", program / "flight.rrd", recording], capture_output=True, text=True)
    # Columns of frames hold no truth, no centroids, and directions in place of what they were computed from.
    unknown = [f"/{name} " for name in ("truth/walls", "truth/json", "log", "kmeans/centroids", "scan/beams/sweep", "scan/returns/exact")]
    differ = [line for line in compared.stdout.splitlines() if " /" in line and not any(f" {entity}" in line for entity in unknown)]
    assert compared.returncode in (0, 1) and differ == [], compared.stdout + compared.stderr


def test_what_cannot_be_read_ends_the_dataflow_with_its_reason(tee: Path, tmp_path: Path) -> None:
    (tmp_path / "text.mcap").write_text("no recording")
    run = Flow(tmp_path, [tmp_path / "text.mcap"]).run()
    said = run.communicate(timeout=60)[0]
    assert run.returncode != 0 and "text.mcap" in said
    run = Flow(tmp_path, [tee], "--record", str(tmp_path / "absent" / "flight.rrd")).run()
    said = run.communicate(timeout=60)[0]
    assert run.returncode != 0 and "record: " in said, said
    assert "error: there is no node solver" in refused("--own", "solver=x")
    assert "x is not NAME=VALUE" in refused("--place", "x")


def refused(*options: str) -> str:
    command: list[str | Path] = [SCRIPTS / "crosscut-dora", "dataflow", "FLIGHT", *options]
    done: subprocess.CompletedProcess[Any] = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2
    return str(done.stderr)

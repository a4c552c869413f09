"""The command line in the wheel."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import in_wheel, needs_recordings

HERE = Path(__file__).resolve().parent


def run(*args: object, cwd: Path = HERE) -> subprocess.CompletedProcess[str]:
    return subprocess.run([in_wheel(), *map(str, args)], capture_output=True, text=True, cwd=cwd)


def test_exit_codes_are_those_of_the_program(tee: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(tee.read_bytes()[: tee.stat().st_size * 2 // 3])
    for code, args in ((0, ["--help"]), (0, ["run", tee]), (1, ["run", "absent.mcap"]), (2, ["run"]), (3, ["run", cut])):
        assert run(*args).returncode == code, args
    assert run("run", tee, "--set", "affinity.kind=rbv").stderr.count("did you mean rbf") == 1


@needs_recordings
def test_the_wheel_records_and_reads_recordings(tee: Path, tmp_path: Path) -> None:
    saved = run("run", tee, "--preset", "paper", "--save", tmp_path / "tee.rrd")
    assert saved.returncode == 0, saved.stderr
    assert "/affinity/W" in run("rrd", "ls", tmp_path / "tee.rrd").stdout


def test_live_inputs_are_in_the_help_of_run() -> None:
    said = run("run", "--help").stdout
    assert all(word in said for word in ("zenoh://HOST[:PORT]/TOPIC", "domain=N", "config=FILE.json5", "ros2://DOMAIN/TOPIC", "--publish"))


@pytest.mark.parametrize("module, package", [("zenoh", "eclipse-zenoh"), ("cyclonedds", "cyclonedds")])
def test_a_live_robot_without_its_extra_names_it(module: str, package: str) -> None:
    address = {"zenoh": "zenoh://robot/scan", "cyclonedds": "ros2://0/scan"}[module]
    script = f"import sys; sys.modules['{module}'] = None; import crosscut.__main__ as main; sys.exit(main.main())"
    done = subprocess.run([sys.executable, "-c", script, "run", address], capture_output=True, text=True)
    assert (done.returncode, f"pip install {package}" in done.stderr) == (2, True), done.stderr


def test_a_stage_of_ones_own_is_chosen_by_name(tee: Path) -> None:
    named = "affinity.kind=python:stages_of_ones_own.rbf"
    args = ("--preset", "paper", "--every", 20, "--quiet", "--out", "-")
    mine, papers = run("run", tee, "--set", named, *args), run("run", tee, *args)
    assert mine.returncode == 0, mine.stderr
    for found, expected in zip(mine.stdout.splitlines(), papers.stdout.splitlines(), strict=True):
        assert json.loads(found)["labels"] == json.loads(expected)["labels"]
    assert 'kind = "python:stages_of_ones_own.rbf"  # --set' in run("config", "--set", named).stdout


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("python:bad", "a stage of Python is python:MODULE.FUNCTION"),
        ("python:absent.rbf", "ModuleNotFoundError: No module named 'absent'"),
        ("python:stages_of_ones_own.absent", "has no attribute 'absent'"),
        ("python:stages_of_ones_own.NO_FUNCTION", "it is not callable"),
    ],
)
def test_a_stage_that_is_not_there_is_wrong_usage(tee: Path, kind: str, text: str) -> None:
    done = run("run", tee, "--set", f"affinity.kind={kind}")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert text in done.stderr


def test_what_a_stage_prints_is_no_line_of_results(tee: Path, tmp_path: Path) -> None:
    stage = "import numpy\nprint('read')\ndef w(points):\n    print('called')\n    return numpy.eye(len(points))\n"
    (tmp_path / "mine.py").write_text(stage)
    done = run("run", tee, "--set", "affinity.kind=python:mine.w", "--preset", "paper", "--every", 70, "-o", "-", cwd=tmp_path)
    assert [json.loads(line)["seq"] for line in done.stdout.splitlines()] == [0, 70, 140], done.stderr
    # Python writes a text and the end of its line apart: lines of two workers may lie in one another.
    assert "read\n" in done.stderr and done.stderr.count("called") >= 3


def test_files_and_their_names_run_no_code(tee: Path, tmp_path: Path) -> None:
    (tmp_path / "evil.py").write_text("open('RUN', 'w')\ndef w(points): ...\n")
    (tmp_path / "numpy.py").write_text("open('RUN', 'w')\n")
    settings, flight = tmp_path / "settings.toml", tmp_path / "python:evil.w.mcap"
    settings.write_text('[affinity]\nkind = "python:evil.w"\n')
    flight.write_bytes(tee.read_bytes())
    for args in (["info", settings], ["info", flight.name], ["config", "--config", settings], [f"--config={settings}", "config"],
                 ["run", flight.name, "--config", settings, "--out", "-"], ["compare", flight.name, "--with", settings]):
        done = run(*args, cwd=tmp_path)
        assert not (tmp_path / "RUN").exists(), args
    refused = run("config", "--config", settings, cwd=tmp_path)
    assert refused.returncode == 2 and "--set affinity.kind=python:evil.w" in refused.stderr
    named = run("config", "--config", settings, "--set", "affinity.kind=python:evil.w", cwd=tmp_path)
    assert named.returncode == 0 and (tmp_path / "RUN").exists(), named.stderr


def test_a_stage_that_raises_keeps_what_came_before(tee: Path) -> None:
    done = run("run", tee, "--preset", "paper", "--set", "affinity.kind=python:stages_of_ones_own.failing",
               "--set", "pipeline.workers=1", "--out", "-")
    assert done.returncode == 1
    assert "affinity failed on revolution 7: stages_of_ones_own.failing raised ValueError: seven were enough" in done.stderr
    assert [json.loads(line)["seq"] for line in done.stdout.splitlines()] == list(range(7))


def test_an_interrupt_saves_what_was_made(tee: Path, tmp_path: Path) -> None:
    results = tmp_path / "results.jsonl"
    named = "affinity.kind=python:stages_of_ones_own.hanging"
    one = "pipeline.workers=1"
    args = ["run", tee, "--preset", "paper", "--set", named, "--set", one, "--out", results]
    process = subprocess.Popen([in_wheel(), *map(str, args)], stderr=subprocess.PIPE, text=True, cwd=HERE)
    assert process.stderr is not None
    for expected in ("hanging", "stopping after the scans in progress"):
        line = process.stderr.readline()
        assert line.startswith(expected)
        process.send_signal(signal.SIGINT)  # the second one quits at once
    process.communicate(timeout=60)
    assert process.returncode == 130
    saved = [json.loads(line)["seq"] for line in results.read_text().splitlines()]
    assert saved == list(range(len(saved))) and len(saved) < 8

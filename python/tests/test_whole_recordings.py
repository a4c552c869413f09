"""Commands of the program as functions."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import stages_of_ones_own
from conftest import in_wheel, write_scans

import crosscut

HERE = Path(__file__).resolve().parent


def test_a_run_writes_what_the_command_line_writes(tee: Path, tmp_path: Path) -> None:
    outputs = [tmp_path / "line.jsonl", tmp_path / "line.json", tmp_path / "line.mcap"]
    for option, path in zip(("--out", "--map", "--out"), outputs, strict=True):
        subprocess.run([in_wheel(), "run", tee, option, path, "--preset", "paper", "--quiet"], check=True)
    made = [path.with_stem("made") for path in outputs]
    crosscut.run(tee, results=made[0], map=made[1], preset="paper")
    crosscut.run([tee], results=made[2], settings={"spectral.kind": "slicing"}, preset="paper")
    assert made[0].read_bytes() == outputs[0].read_bytes() and made[1].read_bytes() == outputs[1].read_bytes()
    assert made[2].stat().st_size > 0
    with pytest.raises(TypeError, match="writes nothing"):
        crosscut.run(tee)


def test_a_report_is_one_page(tee: Path, tmp_path: Path) -> None:
    assert crosscut.report(tee, tmp_path / "tee.html").read_text().startswith("<!doctype html>")


def test_a_comparison_is_the_document_of_the_command_line(tee: Path, tmp_path: Path) -> None:
    written = tmp_path / "line.json"
    configurations = ["paper", "fewer=paper,report.min_returns=3"]
    options = [part for of in configurations for part in ("--with", of)]
    subprocess.run([in_wheel(), "compare", tee, *options, "--json", written, "--quiet"], check=True)
    found = crosscut.compare(tee, configurations)
    assert found == json.loads(written.read_text())
    assert found == crosscut.compare([tee], {"paper": "paper", "fewer": {"preset": "paper", "report": {"min_returns": 3}}})
    assert (found["verdicts"][0]["mends"], found["verdicts"][0]["breaks"]) == (32, 0)


def test_a_comparison_takes_a_callable_and_a_grid(tee: Path, tmp_path: Path) -> None:
    table = tmp_path / "grid.csv"
    mine: dict[str, str | dict[str, Any]] = {"paper": "paper", "mine": {"preset": "paper", "affinity": stages_of_ones_own.rbf}}
    grid = {"spectral.zero_tolerance": [1e-9, 1e-7]}
    found = crosscut.compare(tee, mine, grid=grid, csv=table)
    right = [of["figures"]["right"]["hits"] for of in found["all"]]
    assert right[:2] == right[2:]
    assert len(table.read_text().splitlines()) == 5


def interrupted_run(flight: Path, folder: Path, handler: str) -> tuple[int, bytes, int, int]:
    """Interrupts a run and its caller, as a terminal does. The caller's exit code and words, scans begun and scans saved."""
    script = (
        f"import signal; signal.signal(signal.SIGINT, {handler})\n"
        f"import crosscut\ncrosscut.run({str(flight)!r}, results='results.jsonl', kmeans='python:stages_of_ones_own.slower_rows')"
    )
    caller = subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.PIPE, cwd=folder, start_new_session=True,
                              env={**os.environ, "PYTHONPATH": str(HERE)})
    begun = folder / "begun"
    while not begun.exists() or begun.stat().st_size < 4:
        assert caller.poll() is None
        time.sleep(0.05)
    os.killpg(caller.pid, signal.SIGINT)
    said = caller.communicate(timeout=60)[1]
    assert {path.name for path in folder.iterdir()} == {"begun", "results.jsonl"}
    return caller.returncode, said, begun.stat().st_size, len((folder / "results.jsonl").read_text().splitlines())


def test_an_interrupt_from_the_terminal_saves_what_was_begun(tee: Path, tmp_path: Path) -> None:
    _, said, begun, saved = interrupted_run(tee, tmp_path, "signal.default_int_handler")
    assert b"KeyboardInterrupt" in said and begun == saved < 30


def test_an_interrupt_that_the_caller_handles_ends_no_run(tee: Path, tmp_path: Path) -> None:
    flight, folder = tmp_path / "few.mcap", tmp_path / "run"
    write_scans(tee, flight, range(12))
    folder.mkdir()
    code, said, begun, saved = interrupted_run(flight, folder, "lambda *_: None")
    assert (code, begun, saved) == (0, 12, 12), said


def test_what_a_command_says_is_the_exception(tee: Path, tmp_path: Path) -> None:
    with pytest.raises(crosscut.ReadError, match="absent.mcap"):
        crosscut.report(tmp_path / "absent.mcap", tmp_path / "page.html")
    with pytest.raises(crosscut.SettingsError, match="did you mean rbf"):
        crosscut.report(tee, tmp_path / "page.html", preset="paper", affinity="rbv")
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(tee.read_bytes()[: tee.stat().st_size * 2 // 3])
    with pytest.warns(crosscut.LossWarning):
        crosscut.run(cut, results=tmp_path / "cut.jsonl")
    assert (tmp_path / "cut.jsonl").stat().st_size > 0

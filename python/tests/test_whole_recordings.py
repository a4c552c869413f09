"""Commands of the program as functions."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import stages_of_ones_own
from conftest import in_wheel, write_scans

import crosscut
from crosscut import _program

HERE = Path(__file__).resolve().parent


def test_a_run_writes_what_the_command_line_writes(tee: Path, tmp_path: Path) -> None:
    outputs = [tmp_path / "line.jsonl", tmp_path / "line.json", tmp_path / "line.mcap"]
    for option, path in zip(("--results", "--map", "--results"), outputs, strict=True):
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


def test_a_sweep_is_a_table_with_a_row_for_each_combination(tee: Path, tmp_path: Path) -> None:
    grid = {"affinity.sigma_per_m2": [1.5, 3.0], "spectral.zero_tolerance": [1e-9, 1e-7]}
    table = crosscut.sweep(tee, grid, tmp_path / "out", preset="paper", spectral="slicing", jobs=1)
    assert table.num_rows == 4
    assert crosscut.sweep([tee], grid, tmp_path / "out", preset="paper", spectral="slicing") == table


def test_a_sweep_takes_a_callable(tee: Path, tmp_path: Path) -> None:
    grid = {"spectral.zero_tolerance": [1e-9, 1e-7]}
    mine = crosscut.sweep(tee, grid, tmp_path / "mine", preset="paper", affinity=stages_of_ones_own.rbf, jobs=1)
    papers = crosscut.sweep(tee, grid, tmp_path / "paper", preset="paper")
    assert mine["right"] == papers["right"]
    kept = list((tmp_path / "mine" / "rows").iterdir())
    crosscut.sweep(tee, grid, tmp_path / "mine", preset="paper", affinity=stages_of_ones_own.rbf)
    assert list((tmp_path / "mine" / "rows").iterdir()) == kept, "what was computed counts"
    crosscut.sweep(tee, grid, tmp_path / "mine", preset="paper", affinity=lambda points: stages_of_ones_own.rbf(points))
    assert len(list((tmp_path / "mine" / "rows").iterdir())) == 4, "another callable is computed"


def test_columns_of_a_sweep_have_types_whatever_their_values(tee: Path, tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow")
    flights = [tmp_path / name for name in ("0012.mcap", "2024-05-01.mcap", "null.mcap")]
    for flight in flights:
        shutil.copy(tee, flight)
    grid: dict[str, list[object]] = {"vehicle.width_m": [1], "preset": ["default"]}
    table = crosscut.sweep(flights, grid, tmp_path / "out")
    assert table["flight"].to_pylist() == ["0012", "2024-05-01", "null"]
    types = {name: str(table.schema.field(name).type) for name in table.column_names}
    assert {name for name, of in types.items() if of == "string"} == {"flight", "input_hash", "program", "preset"}
    assert {name for name, of in types.items() if of == "int64"} == {"revolutions", "failed", "flips", "compared"}
    assert len(types) == 18 and set(types.values()) == {"string", "int64", "double"}
    assert pa.parquet.read_table(tmp_path / "out" / "sweep.parquet") == table
    assert not list((tmp_path / "out").glob(".*"))


def test_a_parquet_that_the_program_wrote_is_kept(tee: Path, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    script = tmp_path / "program.sh"
    script.write_text(f'#!/bin/sh\n"{in_wheel()}" "$@" && echo theirs > "$4/sweep.parquet"\n')
    script.chmod(0o755)
    out = tmp_path / "out"
    _program.swept([tee], out, ["--grid", "vehicle.width_m=0.6"], [str(script)])
    assert (out / "sweep.parquet").read_text() == "theirs\n"


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

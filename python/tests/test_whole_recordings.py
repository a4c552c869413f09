"""Commands of the program as functions."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from conftest import in_wheel

import crosscut


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

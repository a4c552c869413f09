"""Recordings from Python, compared with those of the program."""

from __future__ import annotations

import pickle
import subprocess
import warnings
from pathlib import Path

import crosscut
import numpy as np
import pytest
import stages_of_ones_own
from conftest import in_wheel
from numpy.typing import NDArray

EVERY = 8
# What the program writes and a recording of results cannot have: who made it, the truth, the time that the flight took.
# With the truth an answer may be wrong, not only unsure (`/report/doubt`).
OF_PROGRAM = ("/config", "/truth/walls", "/truth/json", "/log", "/timing/flight", "/report/doubt")


def rrd(*args: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([in_wheel(), "rrd", *map(str, args)], capture_output=True, text=True)


def listed(recording: Path) -> dict[str, str]:
    """The entities of a recording, each with its rows and what they hold."""
    lines = rrd("ls", recording).stdout.splitlines()
    found = (line.split() for line in lines if line.startswith(" /"))
    return {words[0]: f"{words[1]} {words[2]} {' '.join(words[4:])}" for words in found if words[0] not in OF_PROGRAM}


def differences(theirs: Path, ours: Path) -> list[str]:
    """The rows that differ, without what the program knows of the truth, which results do not."""
    compared = rrd("diff", theirs, ours)
    assert compared.returncode in (0, 1), compared.stderr
    rows = [line for line in compared.stdout.splitlines() if " /" in line]
    return [row for row in rows if not any(f" {of}" in row for of in ("/truth/", "/log ", "/report/doubt "))]


def values(recording: Path, entity: str, out: Path) -> str:
    got = rrd("get", recording, entity, "--out", out)
    assert got.returncode == 0, got.stderr
    return out.read_text()


def test_what_is_no_result_is_not_recorded(tmp_path: Path) -> None:
    with crosscut.Recorder(tmp_path / "none.rrd") as recorder, pytest.raises(TypeError, match="a crosscut.Result, not 3"):
        recorder.log(3)  # type: ignore[arg-type]


@pytest.mark.parametrize("preset", ["default", "paper"])
@pytest.mark.parametrize("workers", [1, 2])
def test_every_entity_is_that_of_the_program(tee: Path, tmp_path: Path, preset: str, workers: int) -> None:
    theirs, ours = tmp_path / "theirs.rrd", tmp_path / "ours.rrd"
    subprocess.run([in_wheel(), "run", tee, "--every", str(EVERY), "--preset", preset, "--save", theirs, "--quiet"], check=True)
    engine = crosscut.Engine(preset)
    with crosscut.Recorder(ours, engine, name="tee") as recorder:
        for result in engine.process_many(engine.read(tee, every=EVERY), workers=workers):
            recorder.log(result)
    assert differences(theirs, ours) == []
    assert listed(ours) == listed(theirs)


def test_a_flight_is_recorded_with_its_poses(tee: Path, tmp_path: Path) -> None:
    theirs, ours = tmp_path / "theirs.rrd", tmp_path / "ours.rrd"
    subprocess.run([in_wheel(), "run", tee, "--every", str(EVERY), "--save", theirs, "--quiet"], check=True)
    engine = crosscut.Engine()
    flown = crosscut.Flight(engine)
    with crosscut.Recorder(ours, engine) as recorder:
        for scan in engine.read(tee, every=EVERY):
            recorder.log(flown.process(scan))
    assert differences(theirs, ours) == []


def test_a_stage_of_ones_own_is_seen_in_the_same_entities(tee: Path, tmp_path: Path) -> None:
    sigma = 3.0
    own = lambda points: np.exp(-sigma * np.square(points[:, None] - points).sum(axis=2))  # noqa: E731
    theirs, ours, papers = (tmp_path / f"{name}.rrd" for name in ("theirs", "ours", "papers"))
    scans = tmp_path / "few.mcap"
    subprocess.run([in_wheel(), "convert", tee, "--every", "20", "--out", scans], check=True, capture_output=True)
    crosscut.run(scans, preset="paper", affinity=own, save=theirs, map=tmp_path / "map.json")
    crosscut.run(scans, preset="paper", save=papers)
    engine = crosscut.Engine("paper", affinity=own)
    with crosscut.Recorder(ours, engine) as recorder:
        results = []
        for result in engine.process_many(crosscut.read(scans)):
            recorder.log(result)
            results.append(result)
    assert listed(ours) == listed(theirs)
    of_flight = {"/flight/unsure"}  # drawn where an answer is unsure, which hangs on the affinity
    assert set(listed(ours)) | of_flight == set(listed(papers)) | of_flight, "an affinity of one's own lacks no page"
    for entity in ("/spectral/eigenvalues", "/spectral/U", "/kmeans/labels", "/report/junctions", "/report/labels"):
        mine, programs = (values(of, entity, tmp_path / "values.csv") for of in (ours, theirs))
        assert mine == programs, entity
    why = rrd("get", theirs, "/report/why", "--at", "0", "--out", "-").stdout
    missing = [part for part in results[0].why.strip().split("\n\n") if part not in why]
    assert not missing, why
    assert all(result.confidence is None for result in results)
    assert any("nothing was calibrated" in note for note in results[0].notes)
    assert "nothing was calibrated" in results[0].why


def test_the_reasons_are_those_of_the_result(tee: Path) -> None:
    engine = crosscut.Engine("paper")
    results = list(engine.process_many(crosscut.read(tee, every=20), workers=2))
    assert all(f"k = {result.k} zeros of L, {result.junctions} wall" in result.why for result in results)
    flight = crosscut.Flight(engine)
    flown = [flight.process(scan) for scan in crosscut.read(tee, every=20)]
    assert [result.why.split("\n\n")[:2] for result in flown] == [result.why.split("\n\n")[:2] for result in results]
    copied = pickle.loads(pickle.dumps(results[0]))
    assert copied == results[0]
    with pytest.raises(crosscut.Error, match="copy"):
        _ = copied.why


def test_what_cannot_be_recorded_says_why(tee: Path, tmp_path: Path) -> None:
    engine = crosscut.Engine()
    scan = next(iter(crosscut.read(tee)))
    before = engine.process(scan)
    with crosscut.Recorder(tmp_path / "one.rrd", engine) as recorder:
        with pytest.raises(crosscut.Error, match="before the recorder was opened"):
            recorder.log(before)
        during = engine.process(scan)
        recorder.log(during)
        with pytest.raises(crosscut.Error, match="recorded already"):
            recorder.log(during)
        later = engine.process(scan)
    with pytest.raises(crosscut.Error, match="closed"):
        recorder.log(later)
    with pytest.raises(ValueError, match="one of default, light, full"):
        crosscut.Recorder(tmp_path / "two.rrd", engine, detail="all")
    with pytest.raises(crosscut.Error, match="cannot create"):
        crosscut.Recorder(tmp_path / "no" / "folder.rrd", engine)


def test_a_failing_stage_ends_the_program_with_its_exception(tee: Path, tmp_path: Path) -> None:
    def failing(points: NDArray[np.float64]) -> NDArray[np.float64]:
        raise ValueError("not today")

    with pytest.raises(crosscut.ReadError, match="not today"):
        crosscut.run(tee, preset="paper", affinity=failing, results=tmp_path / "results.jsonl")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        page = crosscut.report(tee, tmp_path / "page.html", preset="paper", affinity=stages_of_ones_own.rbf)
    assert "stages_of_ones_own.rbf" in page.read_text()


def test_the_importer_leaves_other_files_to_others(tmp_path: Path) -> None:
    picture = tmp_path / "picture.png"
    picture.write_bytes(b"\x89PNG")
    importer = Path(in_wheel()).with_name("rerun-importer-crosscut")
    done = subprocess.run([importer, picture, "--application-id", "viewer", "--recording-id", "one"], capture_output=True)
    assert (done.returncode, done.stdout) == (66, b"")


def test_a_notebook_shows_a_recording_once(tee: Path, tmp_path: Path) -> None:
    """In a kernel of Jupyter; the packages that this takes are no part of the development environment."""
    nbformat, nbclient = (pytest.importorskip(name) for name in ("nbformat", "nbclient"))
    pytest.importorskip("ipykernel")
    pytest.importorskip("rerun_notebook")
    saved = tmp_path / "flight.rrd"
    subprocess.run([in_wheel(), "run", tee, "--save", saved, "--quiet"], check=True)
    cell = nbformat.v4.new_code_cell(f"import crosscut\ncrosscut.show({str(saved)!r})")
    notebook = nbformat.v4.new_notebook(cells=[cell])
    nbclient.NotebookClient(notebook, timeout=120).execute()
    widgets = notebook.metadata["widgets"]["application/vnd.jupyter.widget-state+json"]["state"].values()
    viewers = [widget for widget in widgets if widget["model_name"] == "AnyModel"]
    assert len(viewers) == 1, "the viewer of rerun-notebook"
    assert any("application/vnd.jupyter.widget-view+json" in output.get("data", {}) for output in cell.outputs)

"""Archives of flights on a Ray cluster: one task a flight, each a process of the program; needs ray and pyarrow.

>>> import crosscut.ray
>>> table = crosscut.ray.run("archive/", out="results/")

``out`` is a folder that all nodes reach. It gets, for each flight, ``NAME.jsonl`` (the answers), ``NAME.map.json`` and
``NAME.done.json`` (its row); and for all of them ``flights.parquet``, ``failures.csv`` and ``times.csv``. A task may run more
than once, as after the loss of a node, but its files are renamed into place when they are whole, so that they are there once.
What an earlier run into the folder has done with the same program, settings and recording is kept.

From a shell: ``crosscut run --on ray FLIGHTS... --out DIR [--preset P] [--set KEY=VALUE]...``, and ``crosscut
compare --on ray FLIGHTS... --out DIR [--with A]... [--grid KEY=V1,V2]...``.
"""

from __future__ import annotations

import argparse
import csv
import glob
import hashlib
import json
import os
import shutil
import socket
import subprocess
import sys
import time
import uuid
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import __version__, _named
from ._engine import Section
from ._errors import Error, MissingPackageError
from ._extras import importing
from ._program import COMMAND, DONE, SOMETHING_LOST, StrPath, compared, configuration, failure

if TYPE_CHECKING:
    import pyarrow

RETRIES = 5
"""A task is started again this many times if its worker or node is lost."""


class Killed(Error):
    """The program was killed on its node; the task is started again."""


KINDS = (".mcap", ".db3", ".bag", ".clf", ".pcd", ".ply", ".log", ".csv")
AFTER_KIND = (".zstd", ".zst", ".lz4", ".bz2", ".active")
"""Endings of what is a flight in a folder of flights, and what may follow them, as in crates/ingest/src/inputs.rs."""


def run(
    flights: StrPath | Iterable[StrPath],
    out: StrPath,
    *,
    address: str | None = None,
    command: Sequence[str] = COMMAND,
    preset: str = "default",
    settings: Mapping[str, object] | None = None,
    **sections: Section,
) -> pyarrow.Table:
    """The answers and the map of each flight. Returns a table with a row for each flight, in the order of their paths.

    ``flights``: recordings, or folders of them; each is a flight of its own, and so is a folder with a ``metadata.yaml``.
    ``address``: the cluster; without one, Ray uses the cluster in $RAY_ADDRESS, or starts one on this machine. ``command``: the
    program, if nodes have another one than this package.
    A flight that fails has its reason in the table and does not end the others.
    """
    options = configuration(preset, settings, sections)
    return _gather(_flights(flights), Path(out).absolute(), list(command), options, _on_ray(address))


def compare(
    flights: StrPath | Iterable[StrPath],
    out: StrPath,
    configurations: Sequence[str] | Mapping[str, str | Mapping[str, Any]] = ("default",),
    *,
    grid: Mapping[str, Sequence[object]] | None = None,
    address: str | None = None,
    command: Sequence[str] = COMMAND,
    settings: Mapping[str, object] | None = None,
) -> pyarrow.Table:
    """The rows of ``crosscut compare --csv`` for each flight, as :func:`crosscut.compare` does it for one; a stage is named by its
    text, ``python:module.name``. ``flights``, ``address`` and ``command`` as in :func:`run`. ``out`` gets ``NAME.csv`` and
    ``NAME.json`` of each flight, and ``compare.csv``, ``failures.csv`` and ``times.csv`` of all."""
    options, stages = compared(configurations, grid, settings)
    if stages:
        raise TypeError("a stage on a cluster is named: affinity='python:module.name'")
    return _compare(_flights(flights), Path(out).absolute(), list(command), options, _on_ray(address))[1]


def run_here(
    flights: StrPath | Iterable[StrPath],
    out: StrPath,
    *,
    command: Sequence[str] = COMMAND,
    preset: str = "default",
    settings: Mapping[str, object] | None = None,
    **sections: Section,
) -> pyarrow.Table:
    """As :func:`run`, one flight after the other in this process: for a few flights, and to compare with."""
    options = configuration(preset, settings, sections)
    return _gather(_flights(flights), Path(out).absolute(), list(command), options, _one_by_one)


def _joined(address: str | None) -> Any:
    """Ray, within a cluster."""
    with importing("crosscut.ray"):
        import ray

    if not ray.is_initialized():  # a cluster that the caller has joined is kept
        ray.init(address=address, log_to_driver=False)
    return ray


def _on_ray(address: str | None) -> Any:
    """What computes rows as tasks of a cluster."""
    ray = _joined(address)
    task = ray.remote(num_cpus=1, max_retries=RETRIES, retry_exceptions=[Killed])(_process)

    def rows(work: list[tuple[Any, ...]]) -> Iterable[dict[str, Any]]:
        waiting = {task.remote(*arguments): arguments for arguments in work}
        while waiting:
            (finished, *_), _ = ray.wait(list(waiting), num_returns=1)
            arguments = waiting.pop(finished)
            try:
                yield ray.get(finished)
            except ray.exceptions.RayError as error:
                text = f"its task was lost {RETRIES + 1} times: {type(error).__name__}"
                if isinstance(error, ray.exceptions.RayTaskError) and not isinstance(error, Killed):
                    text = str(error.cause)  # it raised this at its only run
                yield {"flight": arguments[0], "code": None, "error": text}

    return rows


def _one_by_one(work: list[tuple[Any, ...]]) -> Iterable[dict[str, Any]]:
    for arguments in work:
        yield _process(*arguments)


def _flights(paths: StrPath | Iterable[StrPath]) -> list[Path]:
    """Each recording once, by its path."""
    given = [paths] if isinstance(paths, (str, os.PathLike)) else paths
    found: set[Path] = set()
    for path in map(Path, map(os.path.abspath, given)):
        found.update(_flights_below(path) if path.is_dir() else [path])
    if not found:
        raise ValueError("there is no recording in what was given")
    return sorted(found)


def _flights_below(folder: Path) -> Iterable[Path]:
    for parent, folders, names in os.walk(folder):
        if "metadata.yaml" in names:
            folders.clear()
            yield Path(parent)
            continue
        for name in names:
            uncompressed = _uncompressed(name)
            is_copy = uncompressed != name and uncompressed in names
            if not is_copy and uncompressed.lower().endswith(KINDS):
                yield Path(parent, name)


def _uncompressed(name: str) -> str:
    """The name of a recording before it was compressed, and when it was closed: ``FLIGHT.mcap`` of ``FLIGHT.mcap.zst``."""
    while name.lower().endswith(AFTER_KIND):
        name = name.rpartition(".")[0]
    return name


def _gather(flights: list[Path], out: Path, command: list[str], options: list[str], rows: Any) -> pyarrow.Table:
    return _write_tables(_map(flights, out, [*command, "run"], options, rows), out)


def _compare(
    flights: list[Path], out: Path, command: list[str], options: list[str], rows: Any
) -> tuple[list[dict[str, Any]], pyarrow.Table]:
    done = _map(flights, out, [*command, "compare"], options, rows)
    _write_notes(done, out)
    header, lines = ["flight"], []
    for row, name in zip(done, _names([Path(row["flight"]) for row in done]), strict=True):
        if row["code"] in (DONE, SOMETHING_LOST):
            with (out / f"{name}.csv").open(newline="", encoding="utf-8") as file:
                header, *of_flight = csv.reader(file)
            lines += [[row["flight"], *cells[1:]] for cells in of_flight]
    with (out / "compare.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([header, *lines])
    return done, _table(header, lines)


def _table(header: list[str], lines: list[list[str]]) -> pyarrow.Table:
    """A column has numbers if all its cells are; an empty one is missing."""
    with importing("crosscut.ray"):
        import pyarrow as pa

    def column(name: str, cells: list[str]) -> list[Any]:
        try:
            return [None if cell == "" else float(cell) for cell in cells] if name not in TEXTS else cells
        except ValueError:
            return cells

    return pa.table({name: column(name, [line[at] for line in lines]) for at, name in enumerate(header)})


TEXTS = ("flight", "configuration")
"""Columns of a comparison that are texts whatever is in them."""


def _names(flights: list[Path]) -> list[str]:
    """A name of its own for each flight."""
    return [f"{flight.stem}-{hashlib.sha256(os.fsencode(flight)).hexdigest()[:10]}" for flight in flights]


def _map(flights: list[Path], out: Path, command: list[str], options: list[str], rows: Any) -> list[dict[str, Any]]:
    """A row for each flight, in the order of their paths. ``command`` ends in ``run`` or ``compare``."""
    out.mkdir(parents=True, exist_ok=True)
    names = _names(flights)
    build = _named.build(options, shutil.which(command[0]))
    code = {"version": __version__, "build": build, "command": command, "options": options}
    work, done = [], []
    for flight, name in zip(flights, names, strict=True):
        made_of = {**code, "recording": _files(flight)}
        kept = _kept(out / f"{name}.done.json", made_of)
        if kept is None:
            work.append((str(flight), name, str(out), command, options, made_of))
        else:
            done.append(kept)
    start, last_said_s = time.monotonic(), 0.0
    for number, row in enumerate(rows(work), 1):
        done.append(row)
        elapsed_s = time.monotonic() - start
        if sys.stderr.isatty() and (elapsed_s - last_said_s > 1.0 or number == len(work)):
            last_said_s = elapsed_s
            left_s = elapsed_s / number * (len(work) - number)
            print(f"\r{number} of {len(work)} flights, {left_s:.0f} s left ", end="", file=sys.stderr, flush=True)
    if work and sys.stderr.isatty():
        print(file=sys.stderr)
    for name in names:
        for part in out.glob(f".{glob.escape(name)}.*"):  # of a worker that was lost
            shutil.rmtree(part, ignore_errors=True)
    return sorted(done, key=lambda row: str(row["flight"]))


def _files(flight: Path) -> list[list[Any]]:
    """Name, size and time of each file of a flight; none if it cannot be read."""
    try:
        files = sorted(flight.iterdir()) if flight.is_dir() else [flight]
        return [[file.name, file.stat().st_size, file.stat().st_mtime_ns] for file in files]
    except OSError:
        return []


def _kept(path: Path, made_of: dict[str, Any]) -> dict[str, Any] | None:
    """The row of an earlier run, unless it failed or was made of something else than ``made_of``."""
    try:
        kept: dict[str, Any] = json.loads(path.read_text())
    except (OSError, ValueError):
        return None
    row: dict[str, Any] = kept.get("row", {})
    return row if kept.get("made_of") == made_of and row.get("code") in (DONE, SOMETHING_LOST) else None


def _process(
    flight: str, name: str, out: str, command: list[str], options: list[str], made_of: dict[str, Any]
) -> dict[str, Any]:
    """Runs the program on one flight, in a worker of the cluster and on one processor."""
    start = time.monotonic()
    part = Path(out) / f".{name}.{uuid.uuid4().hex}"
    part.mkdir()
    try:
        outputs: dict[str, dict[str, str]] = {
            "run": {"--out": f"{name}.jsonl", "--map": f"{name}.map.json"},
            "compare": {"--csv": f"{name}.csv", "--json": f"{name}.json"},
        }
        written = {option: part / file for option, file in outputs[command[-1]].items()}
        options = [*options, "--set", "pipeline.workers=1"]
        command_line: list[StrPath] = [*command, flight, *(word for output in written.items() for word in output), *options, "--quiet"]
        said = subprocess.run(command_line, capture_output=True, text=True)
        if said.returncode < 0:
            raise Killed(f"{flight}: the program was killed by signal {-said.returncode}")
        row: dict[str, Any] = {"flight": flight, "code": said.returncode, "error": None}
        if said.returncode in (DONE, SOMETHING_LOST):
            if command[-1] == "run":
                row |= _figures(written["--out"], written["--map"])
            for file in written.values():
                file.replace(Path(out) / file.name)
        if said.returncode != DONE:
            row["error"] = str(failure(said.returncode, said.stderr))
        done = {"row": row, "made_of": made_of, "seconds": time.monotonic() - start, "host": socket.gethostname()}
        (part / "done").write_text(json.dumps(done))
        (part / "done").replace(Path(out) / f"{name}.done.json")
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return row


def _figures(results: Path, map_file: Path) -> dict[str, Any]:
    """Of one flight: what its answers and its map come to."""
    revolutions, counts = 0, Counter[int]()
    confidences: list[float] = []  # null with stages that nothing was calibrated for
    with results.open() as lines:
        for line in map(json.loads, lines):
            revolutions += 1
            if line["confidence"] is not None:
                confidences.append(line["confidence"])
            counts[line["junctions"]] += 1
    flight_map = json.loads(map_file.read_text())
    kinds = Counter(node["kind"] for node in flight_map["nodes"])
    ways = [way for node in flight_map["nodes"] if node["kind"] == "junction" for way in node["ways"]]
    return {
        "revolutions": revolutions,
        "mean_confidence": sum(confidences) / len(confidences) if confidences else None,
        "most_walls": max(counts, default=None),
        "junctions": kinds["junction"],
        "dead_ends": kinds["dead_end"],
        "passages": len(flight_map["edges"]),
        "ways_without_passage": sum(way["edge"] is None for way in ways),
    }


def _write_tables(rows: list[dict[str, Any]], out: Path) -> pyarrow.Table:
    """All flights as Parquet, and the notes on them."""
    with importing("crosscut.ray"):
        import pyarrow as pa
        import pyarrow.parquet

    numbers = ("revolutions", "most_walls", "junctions", "dead_ends", "passages", "ways_without_passage")
    fields = [("flight", pa.string()), ("code", pa.int32()), ("mean_confidence", pa.float64()), ("error", pa.string())]
    schema = pa.schema(fields + [(name, pa.int64()) for name in numbers])
    table = pa.Table.from_pylist([{name: row.get(name) for name in schema.names} for row in rows], schema)
    unfinished = out / f".{uuid.uuid4().hex}"
    pyarrow.parquet.write_table(table, unfinished)
    unfinished.replace(out / "flights.parquet")
    _write_notes(rows, out)
    return table


def _write_notes(rows: list[dict[str, Any]], out: Path) -> None:
    """The flights that failed, with the reason, and times, which differ from run to run."""
    with (out / "failures.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["flight", "code", "error"])
        writer.writerows([row["flight"], row["code"], row["error"]] for row in rows if row["error"] is not None)
    with (out / "times.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["flight", "seconds", "host"])
        for path in sorted(out.glob("*.done.json")):
            done = json.loads(path.read_text())
            writer.writerow([done["row"]["flight"], f"{done['seconds']:.3f}", done["host"]])


def main(verb: str, arguments: Sequence[str]) -> int:
    """``crosscut run --on ray`` or ``crosscut compare --on ray``; returns the exit code of the program."""
    parser = argparse.ArgumentParser(prog=f"crosscut {verb} --on ray", description="Many flights on a Ray cluster.")
    parser.add_argument("flights", nargs="+", help="recordings, or folders of them; each is a flight of its own")
    parser.add_argument("-o", "--out", required=True, metavar="DIR", help="folder that all nodes reach")
    parser.add_argument("--address", help="of the cluster; without one, Ray starts one on this machine")
    passed_on = ["--preset", "--set"] if verb == "run" else ["--with", "--grid", "--set"]
    for option in passed_on:
        parser.add_argument(option, action="append", default=[], dest=option, help=f"as of `crosscut {verb}`")
    args = parser.parse_args(arguments)
    options = [part for option in passed_on for value in vars(args)[option] for part in (option, value)]
    try:
        with importing("--on ray"):
            import pyarrow  # noqa: F401
            import ray  # noqa: F401
    except MissingPackageError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    try:
        flights, out = _flights(args.flights), Path(args.out).absolute()
        rows = _on_ray(args.address)
        if verb == "run":
            table, made = _gather(flights, out, list(COMMAND), options, rows), "flights.parquet"
            done = table.select(["code", "error"]).to_pylist()
        else:
            done, _ = _compare(flights, out, list(COMMAND), options, rows)
            made = "compare.csv"
    except (ValueError, OSError, Error) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    failed = [row["error"] for row in done if row["code"] not in (DONE, SOMETHING_LOST)]
    lost = [row["code"] for row in done].count(SOMETHING_LOST)
    print(f"{len(done)} flights, {len(failed)} failed, {lost} damaged: {out / made}", file=sys.stderr)
    if failed:
        print(f"why: {out / 'failures.csv'}; the first: {failed[0]}", file=sys.stderr)
    return 1 if len(failed) == len(done) else SOMETHING_LOST if failed or lost else DONE

"""Archives of flights on a Ray cluster: one task a flight, each a process of the program; needs ray and pyarrow.

>>> import crosscut.ray
>>> table = crosscut.ray.run("archive/", out="results/")

``out`` is a folder that all nodes reach. It gets, for each flight, ``NAME.jsonl`` (the answers), ``NAME.map.json`` and
``NAME.done.json`` (its row); and for all of them ``flights.parquet``, ``failures.csv`` and ``times.csv``. A task may run more
than once, as after the loss of a node, but its files are renamed into place when they are whole, so that they are there once.
What an earlier run into the folder has done with the same program, settings and recording is kept.

From a shell: ``crosscut run --on ray FLIGHTS... --out DIR [--preset P] [--set KEY=VALUE]...``, and ``crosscut sweep --on ray``
with a ``--grid`` for each axis.
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
import warnings
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import __version__, _named
from ._engine import Section
from ._errors import Error, LossWarning, MissingPackageError
from ._extras import importing
from ._program import COMMAND, DONE, SOMETHING_LOST, StrPath, axes, configuration, failure, swept

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


def sweep(
    flights: StrPath | Iterable[StrPath],
    grid: Mapping[str, Sequence[object]],
    out: StrPath,
    *,
    address: str | None = None,
    command: Sequence[str] = COMMAND,
    preset: str = "default",
    settings: Mapping[str, object] | None = None,
    **sections: Section,
) -> pyarrow.Table:
    """As :func:`crosscut.sweep`, with a task of the cluster for each flight; ``flights``, ``address`` and ``command`` as in
    :func:`run`. The table is that of one process."""
    options = [*axes(grid), *configuration(preset, settings, sections)]
    return _sweep(_flights(flights), Path(out).absolute(), list(command), options, _on_ray(address))


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


def _sweep(flights: list[Path], out: Path, command: list[str], options: list[str], rows: Any) -> pyarrow.Table:
    """Tasks compute the rows of their flights into ``out``; the program, which finds them there, makes the table."""
    (out / "rows").mkdir(parents=True, exist_ok=True)
    _map(flights, out, [*command, "sweep"], options, rows)
    return swept(flights, out, options, command)


def _map(flights: list[Path], out: Path, command: list[str], options: list[str], rows: Any) -> list[dict[str, Any]]:
    """A row for each flight, in the order of their paths. ``command`` ends in ``run`` or ``sweep``."""
    out.mkdir(parents=True, exist_ok=True)
    names = [f"{flight.stem}-{hashlib.sha256(os.fsencode(flight)).hexdigest()[:10]}" for flight in flights]
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
        results, map_file = part / f"{name}.jsonl", part / f"{name}.map.json"
        outputs: dict[str, list[StrPath]] = {
            "run": ["--results", results, "--map", map_file, "--set", "pipeline.workers=1"],
            "sweep": ["--out", part, "--jobs", "1"],
        }
        command_line = [*command, flight, *outputs[command[-1]], *options, "--quiet"]
        said = subprocess.run(command_line, capture_output=True, text=True)
        if said.returncode < 0:
            raise Killed(f"{flight}: the program was killed by signal {-said.returncode}")
        row: dict[str, Any] = {"flight": flight, "code": said.returncode, "error": None}
        if said.returncode in (DONE, SOMETHING_LOST):
            if command[-1] == "run":
                row |= _figures(results, map_file)
            for file in [results, map_file] if command[-1] == "run" else part.glob("rows/*.json"):
                file.replace(Path(out) / file.relative_to(part))
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
    """All flights as Parquet, those that failed with the reason, and times, which differ from run to run."""
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
    return table


def main(verb: str, arguments: Sequence[str]) -> int:
    """``crosscut run --on ray`` or ``crosscut sweep --on ray``; returns the exit code of the program."""
    parser = argparse.ArgumentParser(prog=f"crosscut {verb} --on ray", description="Many flights on a Ray cluster.")
    parser.add_argument("flights", nargs="+", help="recordings, or folders of them; each is a flight of its own")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder that all nodes reach")
    parser.add_argument("--address", help="of the cluster; without one, Ray starts one on this machine")
    parser.add_argument("--preset", default="default")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="changes")
    if verb == "sweep":
        parser.add_argument("--grid", action="append", required=True, metavar="KEY=VALUE,...", help="an axis")
    args = parser.parse_args(arguments)
    settings = [part for change in args.changes for part in ("--set", change)]
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
        options = configuration(args.preset, None, {}) + settings
        if verb == "sweep":
            options = [part for axis in args.grid for part in ("--grid", axis)] + options
            with warnings.catch_warnings(record=True) as losses:
                warnings.simplefilter("always", LossWarning)
                table = _sweep(flights, out, list(COMMAND), options, rows)
            for loss in losses:
                print(f"warning: {loss.message}", file=sys.stderr)
            print(f"{len(table)} rows: {out / 'sweep.parquet'}", file=sys.stderr)
            return SOMETHING_LOST if losses else DONE
        table = _gather(flights, out, list(COMMAND), options, rows)
    except (ValueError, OSError, Error) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    failed = [error for code, error in zip(table["code"].to_pylist(), table["error"].to_pylist(), strict=True)
              if code not in (DONE, SOMETHING_LOST)]
    lost = table["code"].to_pylist().count(SOMETHING_LOST)
    print(f"{len(table)} flights, {len(failed)} failed, {lost} damaged: {out / 'flights.parquet'}", file=sys.stderr)
    if failed:
        print(f"why: {out / 'failures.csv'}; the first: {failed[0]}", file=sys.stderr)
    return 1 if len(failed) == len(table) else SOMETHING_LOST if failed or lost else DONE

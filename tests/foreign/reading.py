"""`crosscut rrd`: its arrays read by NumPy, its tables by the csv module, the snippets of docs/reading-recordings.md run as they stand, values equal to
those of Rerun's own reader, and the same rows found in a file that Rerun has cut into other chunks."""

import csv
import re
import subprocess
import sys
from collections import defaultdict

import numpy as np

import oracle
import rrd
import scans
from flights import Flight, Flights
from verdicts import Verdicts

SIGMA_PER_M2 = 1.5
REVOLUTION = "17"
ENTITIES = (
    ("/spectral/eigenvalues", "BarChart:values"),
    ("/spectral/U", "Tensor:data"),
    ("/kmeans/labels", "Tensor:data"),
    ("/scan/ranges", "Tensor:data"),
    ("/affinity/degrees", "Tensor:data"),
)


def check(flights: Flights, verdicts: Verdicts):
    for flight in [*flights.shipped(), *flights.real()[:1]]:
        check_values(flight, flights, verdicts)
        check_indices(flight, flights, verdicts)
        check_exact(flight, flights, verdicts)
    check_snippets(flights.shipped()[0], flights, verdicts)
    check_other_chunks(flights.shipped()[0], flights, verdicts)


def check_values(flight: Flight, flights: Flights, verdicts: Verdicts):
    """Every number of a CSV file is that of Rerun's own reader."""
    path, out = flights.outcome(flight).rrd, flights.work / "values.csv"
    differing = []
    for entity, component in ENTITIES:
        flights.crosscut("rrd", "get", path, entity, "--out", out).expect(0)
        expected = rrd.values(path, entity, component)
        read = defaultdict(list)
        with out.open() as file:
            for row in csv.DictReader(file):
                read[int(row["revolution"])].append(float(row["value"]))
        for revolution, values in expected.items():
            of_its_type = np.array(read[revolution], values.dtype)
            if not np.array_equal(of_its_type, values.ravel(), equal_nan=values.dtype.kind == "f"):
                differing.append((entity, revolution))
    verdicts.that(
        not differing, f"{flight.name}: rrd get, Rerun's reader", f"{len(ENTITIES)} entities, differing: {differing[:3] or 'none'}"
    )


def check_indices(flight: Flight, flights: Flights, verdicts: Verdicts):
    """A CSV file holds what the array of the same revolution does, in its order; and words."""
    path, table, array = flights.outcome(flight).rrd, flights.work / "indexed.csv", flights.work / "values.npy"

    def rows() -> list[list[str]]:
        with table.open() as file:
            return list(csv.reader(file))[1:]

    differing, count = [], 0
    for entity, _ in ENTITIES:
        flights.crosscut("rrd", "get", path, entity, "--out", table).expect(0)
        flights.crosscut("rrd", "get", path, entity, "--out", array, "--at", REVOLUTION).expect(0)
        expected, of_one = np.load(array), [row for row in rows() if row[0] == REVOLUTION]
        count += len(of_one)
        indices = np.array([row[2:-1] for row in of_one], int).T
        values = np.array([float(row[-1]) for row in of_one], expected.dtype)
        in_order = np.array_equal(np.ravel_multi_index(tuple(indices), expected.shape), np.arange(expected.size))
        if not in_order or not np.array_equal(values, expected.ravel(), equal_nan=expected.dtype.kind == "f"):
            differing.append(entity)
    flights.crosscut("rrd", "get", path, "/report/place", "--out", table).expect(0)
    places = [row[-1] for row in rows()]
    words = places == [line["place"] for line in flights.outcome(flight).lines if line["place"]]
    figures = f"{len(ENTITIES)} entities, {count} rows, differing: {differing or 'none'}; {len(places)} places"
    verdicts.that(not differing and words, f"{flight.name}: rrd get, indices and words", figures)


def check_exact(flight: Flight, flights: Flights, verdicts: Verdicts):
    """W and U recomputed from the recording are those that NumPy makes of the flight itself."""
    path, read = flights.outcome(flight).rrd, scans.read(flight.path)
    errors, revolution = {}, str(len(read) // 2)
    for entity in ("/affinity/W", "/spectral/L"):
        out = flights.work / "exact.npy"
        flights.crosscut("rrd", "get", path, entity, "--exact", "--at", revolution, "--out", out).expect(0)
        affinity = oracle.affinity_of(oracle.points_of(read[int(revolution)]), SIGMA_PER_M2)
        expected = affinity if entity == "/affinity/W" else oracle.laplacian_of(affinity)
        errors[entity] = float(np.abs(np.load(out) - expected).max())
    figures = ", ".join(f"{entity} off by {error:.1e}" for entity, error in errors.items())
    verdicts.that(max(errors.values()) <= 1e-12, f"{flight.name}: rrd get --exact, numpy", f"revolution {revolution}: {figures}")


def check_snippets(flight: Flight, flights: Flights, verdicts: Verdicts):
    """The commands and the Python of the page do what it says."""
    page = (flights.work / "../../../docs/reading-recordings.md").resolve().read_text()
    commands = re.findall(rf"^crosscut (rrd get FLIGHT\.rrd .* --at {REVOLUTION} --out \w+\.npy)$", page, re.MULTILINE)
    folder = flights.work / "snippets"
    folder.mkdir(exist_ok=True)
    recording = flights.outcome(flight).rrd
    for command in commands:
        words = [recording if word == "FLIGHT.rrd" else word for word in command.split()]
        words[-1] = folder / words[-1]
        flights.crosscut(*words).expect(0)
    said = []
    for snippet in re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL):
        source = snippet.replace('"FLIGHT.rrd"', repr(str(recording)))
        ran = subprocess.run([sys.executable, "-c", source], cwd=folder, capture_output=True, text=True)
        said.append(ran.stdout.strip().splitlines()[-1] if ran.returncode == 0 else f"FAILED: {ran.stderr.strip()[-300:]}")
    held = len(said) == 2 and len(commands) >= 4 and not any(line.startswith("FAILED") for line in said)
    verdicts.that(held, f"{flight.name}: snippets of docs/reading-recordings.md", "; ".join(said))


def check_other_chunks(flight: Flight, flights: Flights, verdicts: Verdicts):
    """`rerun rrd optimize` cuts a recording into other chunks; the rows stay the same."""
    path, other = flights.outcome(flight).rrd, flights.work / "optimized.rrd"
    other.unlink(missing_ok=True)
    optimized = rrd.rerun_command("rrd", "optimize", path, "-o", other)
    ran = flights.crosscut("rrd", "diff", path, other)
    said = ran.stdout.decode().strip().splitlines()[:1]
    verdicts.that(
        optimized.returncode == 0 and ran.code == 0, f"{flight.name}: rrd diff, rerun rrd optimize", f"exit code {ran.code}: {said}"
    )

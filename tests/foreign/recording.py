"""The recording of a run: accepted and listed by Rerun's command line, read back value by value, drawn by the viewer,
and not lost when the program is killed."""

import re
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
from PIL import Image

import oracle
import rrd
import scans
from flights import Flight, Flights
from program import lines
from screenshot import Viewer
from verdicts import Verdicts

STEPS = ("ingest", "affinity", "spectral", "kmeans", "report")
CHANGING = {
    "/scan/returns", "/scan/ranges", "/scan/walls", "/scan/openings", "/affinity/W", "/affinity/degrees",
    "/spectral/L", "/spectral/eigenvalues", "/spectral/U", "/spectral/embedding", "/kmeans/labels",
    "/kmeans/centroids", "/report/junctions", "/report/place", *(f"/timing/{step}" for step in STEPS),
}  # fmt: skip
STATIC = {"/config"}

SIGMA_PER_M2 = 1.5
PICTURES_CHECKED = 20
# A level is a decade: half of one by rounding, and a little for values of f32. What lies below 1e-15 is rounding.
LEVEL_TOLERANCE = 0.51
LEAST_VALUE = 1e-15

# What the page that opens has to show, as words in the names of its views.
SHOWN = ("Returns", "W", "L", "Eigenvalues", "U", "openings", "Why")
PICTURE_SIZE = "1400x900"
# A view is not blank when this share of it differs from its background; a spectrum of a few bars has 3 %.
DRAWN_SHARE = 0.003

KILLED_AFTER_S = 7.4
LARGEST_LOSS_S = 1.5


def check(flights: Flights, verdicts: Verdicts):
    for flight in [*flights.shipped(), flights.clear(), *flights.real()]:
        check_file(flight, flights, verdicts)
        check_values(flight, flights, verdicts)
    shipped = flights.shipped()[0]
    check_picture(shipped, flights, verdicts)
    check_killed([*flights.shipped(), *flights.real()], flights, verdicts)


def check_file(flight: Flight, flights: Flights, verdicts: Verdicts):
    """Accepted by `rerun rrd verify`; `rerun rrd stats` lists every entity of the contract, on both timelines."""
    path = flights.outcome(flight).rrd
    verified = rrd.rerun_command("rrd", "verify", path)
    said = (verified.stdout + verified.stderr).strip().splitlines()[-1:]
    verdicts.that(verified.returncode == 0, f"{flight.name}: rerun rrd verify", f"{path.stat().st_size / 1e6:.1f} MB {said}")

    stats = rrd.rerun_command("rrd", "stats", path).stdout
    listed = set(re.findall(r"^(/\S*): \d+$", stats, re.MULTILINE))
    missing = sorted((CHANGING | STATIC) - listed)
    verdicts.that(not missing, f"{flight.name}: rerun rrd stats", f"{len(listed)} entities, missing: {missing or 'none'}")

    timelines = rrd.timelines(path)
    others = {entity: timelines.get(entity) for entity in CHANGING if timelines.get(entity) != {"revolution", "stamp"}}
    others |= {entity: timelines.get(entity) for entity in STATIC if timelines.get(entity) != set()}
    verdicts.that(
        not others,
        f"{flight.name}: timelines",
        f"revolution and stamp on {len(CHANGING)} entities, {len(STATIC)} static; others: {others or 'none'}",
    )


def check_values(flight: Flight, flights: Flights, verdicts: Verdicts):
    """What is read back is what the results and the flight say, and what follows from the raw ranges."""
    outcome, read = flights.outcome(flight), scans.read(flight.path)

    def values(entity: str, component: str = "Tensor:data"):
        return rrd.values(outcome.rrd, entity, component)

    eigenvalues, labels = values("/spectral/eigenvalues", "BarChart:values"), values("/kmeans/labels")
    junctions, ranges = values("/report/junctions", "Scalars:scalars"), values("/scan/ranges")
    places, degrees = values("/report/place", "StateChange:state"), values("/affinity/degrees")
    equal = dict.fromkeys(("labels", "eigenvalues", "junctions", "place", "ranges"), 0)
    degree_error = 0.0
    for i, (line, scan) in enumerate(zip(outcome.lines, read)):
        beams = np.array(line["labels"])
        equal["labels"] += np.array_equal(labels[i], beams[beams != -1])
        equal["eigenvalues"] += np.array_equal(eigenvalues[i][:16], line["eigenvalues"])
        equal["junctions"] += junctions[i] == [line["junctions"]]
        equal["place"] += places[i] == [line["place"]]
        equal["ranges"] += np.array_equal(ranges[i].astype(np.float64), scan.ranges_m, equal_nan=True)
        if line["returns"]:
            expected = oracle.affinity_of(oracle.points_of(scan), SIGMA_PER_M2).sum(axis=1)
            degree_error = max(degree_error, np.abs(degrees[i] / expected - 1).max())
    revolutions = len(outcome.lines)
    verdicts.that(
        set(equal.values()) == {revolutions} == {len(labels)},
        f"{flight.name}: read back equal to the results",
        f"of {revolutions} revolutions: " + ", ".join(f"{name} {count}" for name, count in equal.items()),
    )
    verdicts.that(
        degree_error <= np.finfo(np.float32).eps,
        f"{flight.name}: degrees, numpy",
        f"relative error {degree_error:.1e} at most, of an f32",
    )
    check_pictures(flight, outcome.rrd, read, verdicts)


def check_pictures(flight: Flight, path: Path, read: list[scans.Scan], verdicts: Verdicts):
    """The pictures of W and L, on some revolutions: level v at row and column of the beams stands for 10^(v - 16), in the
    upper triangle."""
    errors = {}
    for entity in ("/affinity/W", "/spectral/L"):
        drawn = rrd.values(path, entity, "EncodedDepthImage:blob")
        every = max(1, len(read) // PICTURES_CHECKED)
        errors[entity] = max(level_error(drawn[i], read[i], entity) for i in range(0, len(read), every))
    figures = ", ".join(f"{entity} off by {error:.2f} of a decade at most" for entity, error in errors.items())
    verdicts.that(max(errors.values()) <= LEVEL_TOLERANCE, f"{flight.name}: pictures, numpy", figures)


def level_error(drawn: np.ndarray, scan: scans.Scan, entity: str) -> float:
    affinity = oracle.affinity_of(oracle.points_of(scan), SIGMA_PER_M2)
    matrix = affinity if entity == "/affinity/W" else oracle.laplacian_of(affinity)
    beams = np.flatnonzero(oracle.returns_of(scan))
    expected = np.full(drawn.shape, np.log10(LEAST_VALUE) + 16)
    upper = np.triu(np.abs(matrix))
    expected[np.ix_(beams, beams)] = np.log10(np.clip(upper, LEAST_VALUE, 1)) + 16
    return float(np.abs(np.maximum(drawn, expected.min()) - expected).max())


def check_picture(flight: Flight, flights: Flights, verdicts: Verdicts):
    """The real viewer draws the layout, and no view of it is blank."""
    outcome = flights.outcome(flight)
    path = flights.work.parent / "screenshot.png"
    fullest = max(outcome.lines, key=lambda line: (line["junctions"], line["returns"]))
    with Viewer.of(outcome.rrd, size=PICTURE_SIZE) as viewer:
        viewer.show(fullest["seq"])
        views = viewer.views()
        viewer.save(path)
    pixels = np.array(Image.open(path).convert("RGB")).astype(int)
    verdicts.that(
        f"{pixels.shape[1]}x{pixels.shape[0]}" == PICTURE_SIZE, f"{flight.name}: viewer", f"revolution {fullest['seq']}: {path}"
    )
    missing = [word for word in SHOWN if not any(re.search(rf"\b{word}\b", name, re.IGNORECASE) for name in views)]
    verdicts.that(not missing, f"{flight.name}: layout", f"{len(views)} views, missing: {missing or 'none'}")
    shares = {name: drawn_share(pixels, place) for name, place in views.items()}
    verdicts.that(
        bool(shares) and min(shares.values()) >= DRAWN_SHARE,
        f"{flight.name}: no view is blank",
        ", ".join(f"{name.split(':')[0]} {100 * share:.1f} %" for name, share in shares.items()),
    )
    scan = next((place for name, place in views.items() if re.search(r"\bopenings\b", name, re.IGNORECASE)), None)
    colours = wall_colours(pixels, scan) if scan else 0
    walls = len(fullest["walls"])
    verdicts.that(colours >= walls, f"{flight.name}: walls have colours", f"{colours} strong colours for {walls} walls")


def crop(pixels: np.ndarray, place: dict) -> np.ndarray:
    x, y, w, h = (round(place[key]) for key in ("x", "y", "w", "h"))
    return pixels[y : y + h, x : x + w].reshape(-1, 3)


def drawn_share(pixels: np.ndarray, place: dict) -> float:
    """Share of pixels that differ from the most frequent colour."""
    view = crop(pixels, place)
    colours, counts = np.unique(view, axis=0, return_counts=True)
    return float(np.mean(np.abs(view - colours[counts.argmax()]).max(axis=1) > 24))


def wall_colours(pixels: np.ndarray, place: dict) -> int:
    """Colours far from grey that fill some pixels."""
    colours, counts = np.unique(crop(pixels, place), axis=0, return_counts=True)
    return int(np.sum((np.ptp(colours, axis=1) > 80) & (counts >= 40)))


def check_killed(candidates: list[Flight], flights: Flights, verdicts: Verdicts):
    """kill -9 in the middle of a flight at the sensor's pace: the recording opens and lacks the last second (and what is on its way)."""
    span_s = {flight: (read[-1].stamp_ns - read[0].stamp_ns) / 1e9 for flight in candidates if (read := scans.read(flight.path))}
    flight = max(span_s, key=span_s.get)
    saved, results = flights.work / "killed.rrd", flights.work / "killed.jsonl"
    results.unlink(missing_ok=True)
    command = flights.crosscut.command(
        "run", flight.path, "--preset", "paper", "--rate", 1, "--out", results, "--save", saved, "--quiet"
    )
    start = time.monotonic()
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        while flown_s(results) < min(KILLED_AFTER_S, span_s[flight] / 2):
            if process.poll() is not None or time.monotonic() - start > 60:
                raise AssertionError(f"the flight does not play: exit code {process.returncode}, {flown_s(results)} s flown")
            time.sleep(0.05)
        elapsed_s = time.monotonic() - start
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()

    reached_ns = lines(results.read_bytes())[-1]["stamp_ns"]
    verdicts.that(
        abs(flown_s(results) - elapsed_s) < 2,
        f"{flight.name}: --rate 1",
        f"{flown_s(results):.1f} of {span_s[flight]:.1f} s flown in {elapsed_s:.1f} s, then killed",
    )
    verified = rrd.rerun_command("rrd", "verify", "--check-footers=false", saved)
    last = rrd.last_stamp_ns(saved)
    lost_s = {entity: (reached_ns - last.get(entity, 0)) / 1e9 for entity in CHANGING}
    worst = max(lost_s, key=lost_s.get)
    verdicts.that(
        verified.returncode == 0 and lost_s[worst] <= LARGEST_LOSS_S,
        f"{flight.name}: the recording after kill -9",
        f"verify {verified.returncode}, opens; {lost_s[worst]:.1f} s of sensor time lost at most ({worst})",
    )


def flown_s(results: Path) -> float:
    """Sensor time from the first to the last whole line."""
    if not results.exists():
        return 0.0
    whole = lines(results.read_bytes().rpartition(b"\n")[0])
    return (whole[-1]["stamp_ns"] - whole[0]["stamp_ns"]) / 1e9 if whole else 0.0

"""Eigenvalues, k and labels of every revolution against numpy's eigh and scikit-learn's KMeans."""

import tomllib
from dataclasses import dataclass, field

import numpy as np
from sklearn.metrics import adjusted_rand_score

import oracle
import rrd
import scans
from flights import Flight, Flights
from verdicts import Verdicts

EIGENVALUE_TOLERANCE = 1e-12
# The gap is clear where τ could be moved by a decade, either way, without another k.
CLEAR_MARGIN_DECADES = 1.0


@dataclass
class Agreement:
    """Labels of the results against those of scikit-learn."""

    compared: int = 0
    with_several: int = 0
    equal: int = 0
    no_worse: int = 0
    rand: list[float] = field(default_factory=list)

    def add(self, u: np.ndarray, labels: np.ndarray):
        theirs = oracle.clusters_of(u)
        self.compared += 1
        self.with_several += u.shape[1] > 1
        if oracle.same_partition(labels, theirs):
            self.equal += 1
        else:
            ours, best = oracle.inertia_of(u, labels), oracle.inertia_of(u, theirs)
            self.no_worse += ours <= best * (1 + 1e-9)
            self.rand.append(adjusted_rand_score(theirs, labels))

    def holds(self) -> bool:
        """Where two answers differ, ours must be as good a minimum of equation (4)."""
        return self.equal + self.no_worse == self.compared

    def figures(self) -> str:
        text = f"{self.equal} of {self.compared} revolutions equal ({self.with_several} of them with k >= 2)"
        if self.rand:
            text += f"; {self.no_worse} of the others minimise (4) as well or better; adjusted Rand index {min(self.rand):.3f}"
        return text


@dataclass
class Tally:
    revolutions: int = 0
    returns_differ: int = 0
    eigenvalues: int = 0
    largest_difference: float = 0.0
    k_equal: int = 0
    k_excused: int = 0
    largest_margin_difference: float = 0.0
    by_numpy: Agreement = field(default_factory=Agreement)
    by_recording: Agreement = field(default_factory=Agreement)
    unclear: Agreement = field(default_factory=Agreement)
    residual: float = 0.0
    residual_tolerance: float = EIGENVALUE_TOLERANCE
    walls_right: int = 0


def check(flights: Flights, verdicts: Verdicts):
    sigma_per_m2, tolerance = paper_settings(flights)
    verdicts.that(sigma_per_m2 == 1.5, "preset paper", f"σ = {sigma_per_m2} per m², τ = {tolerance:g}")
    for flight in flights.all():
        tally = compare(flight, flights, sigma_per_m2, tolerance)
        report(flight, tally, verdicts)


def paper_settings(flights: Flights) -> tuple[float, float]:
    config = tomllib.loads(flights.crosscut("config", "--preset", "paper").expect(0).stdout.decode())
    return config["affinity"]["sigma_per_m2"], config["spectral"]["zero_tolerance"]


def compare(flight: Flight, flights: Flights, sigma_per_m2: float, tolerance: float) -> Tally:
    outcome, read = flights.outcome(flight), scans.read(flight.path)
    recorded_u = rrd.values(outcome.rrd, "/spectral/U", "Tensor:data")
    if [line["stamp_ns"] for line in outcome.lines] != [scan.stamp_ns for scan in read]:
        raise AssertionError(f"{flight.name}: {len(outcome.lines)} lines for {len(read)} scans, or other stamps")
    tally = Tally(revolutions=len(read))
    for i, (scan, line) in enumerate(zip(read, outcome.lines)):
        beams = np.array(line["labels"])
        seen = oracle.returns_of(scan)
        if len(beams) != len(seen) or not np.array_equal(beams >= 0, seen):
            tally.returns_differ += 1
            continue
        spectrum = oracle.spectrum_of(oracle.points_of(scan), sigma_per_m2, tolerance)
        if spectrum.n == 0:
            tally.k_equal += line["k"] == 0
            continue
        add_eigenvalues(tally, spectrum, line, tolerance)
        add_labels(tally, spectrum, beams[seen], line, recorded_u[i])
        tally.walls_right += flight.walls is not None and line["junctions"] == flight.walls[i]
    return tally


def add_eigenvalues(tally: Tally, spectrum: oracle.Spectrum, line: dict, tolerance: float):
    ours = np.array(line["eigenvalues"])
    if len(ours) != min(spectrum.n, 16):
        raise AssertionError(f"revolution {line['seq']}: {len(ours)} eigenvalues for {spectrum.n} returns")
    tally.eigenvalues += len(ours)
    tally.largest_difference = max(tally.largest_difference, np.abs(ours - spectrum.eigenvalues[: len(ours)]).max())
    tally.k_equal += line["k"] == spectrum.k
    tally.k_excused += line["k"] != spectrum.k and not spectrum.k_is_beyond_doubt
    if line["k"] < len(ours):
        margin = oracle.margin_decades(ours, spectrum.n, line["k"], tolerance)
        tally.largest_margin_difference = max(tally.largest_margin_difference, abs(margin - line["margin"]))


def add_labels(tally: Tally, spectrum: oracle.Spectrum, labels: np.ndarray, line: dict, recorded_u: np.ndarray):
    k = line["k"]
    if recorded_u.shape != (spectrum.n, k):
        raise AssertionError(f"revolution {line['seq']}: the recorded U is {recorded_u.shape}, not {(spectrum.n, k)}")
    tally.residual_tolerance = max(EIGENVALUE_TOLERANCE, 8 * np.finfo(recorded_u.dtype).eps)
    recorded_u = recorded_u.astype(np.float64)
    residual = spectrum.laplacian @ recorded_u - recorded_u * spectrum.eigenvalues[:k]
    skew = recorded_u.T @ recorded_u - np.eye(k)
    tally.residual = max(tally.residual, *(np.abs(m).max(initial=0.0) for m in (residual, skew)))
    if k != spectrum.k or k == 0:
        return
    if spectrum.margin_decades >= CLEAR_MARGIN_DECADES:
        tally.by_numpy.add(spectrum.u, labels)
        tally.by_recording.add(recorded_u, labels)
    else:
        tally.unclear.add(spectrum.u, labels)


def report(flight: Flight, tally: Tally, verdicts: Verdicts):
    name = flight.name
    verdicts.that(
        tally.returns_differ == 0,
        f"{name}: returns",
        f"the same beams on {tally.revolutions - tally.returns_differ} of {tally.revolutions} revolutions",
    )
    verdicts.that(
        tally.largest_difference <= EIGENVALUE_TOLERANCE and tally.eigenvalues > 0,
        f"{name}: eigenvalues, numpy",
        f"{tally.eigenvalues} differ by {tally.largest_difference:.1e} at most",
    )
    verdicts.that(
        tally.k_equal + tally.k_excused == tally.revolutions,
        f"{name}: k, numpy",
        f"equal on {tally.k_equal} of {tally.revolutions}; an eigenvalue within 100·n·ε of τ on {tally.k_excused} others",
    )
    verdicts.that(
        tally.largest_margin_difference <= 1e-9,
        f"{name}: margin, its definition",
        f"differs by {tally.largest_margin_difference:.1e} decades at most",
    )
    verdicts.that(
        tally.residual <= tally.residual_tolerance,
        f"{name}: recorded U, |LU - UΛ|, |U'U - I|",
        f"{tally.residual:.1e} at most, of {tally.residual_tolerance:.0e}",
    )
    verdicts.that(tally.by_numpy.holds(), f"{name}: labels, KMeans on numpy's U", tally.by_numpy.figures())
    verdicts.that(tally.by_recording.holds(), f"{name}: labels, KMeans on recorded U", tally.by_recording.figures())
    verdicts.note(f"{name}: labels, margin below {CLEAR_MARGIN_DECADES:.0f} decade", tally.unclear.figures())
    if flight.walls is not None:
        verdicts.that(
            tally.walls_right == tally.revolutions,
            f"{name}: walls as built",
            f"right on {tally.walls_right} of {tally.revolutions}",
        )

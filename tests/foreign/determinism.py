"""The same input gives the same bytes, whatever the number of workers; the same seed gives the same flight."""

from flights import SCENARIO, Flight, Flights
from program import lines
from verdicts import Verdicts

PRESETS = ("paper", "default")
# Beside as many as there are cores.
WORKERS = (1, 4)


def check(flights: Flights, verdicts: Verdicts):
    for preset in PRESETS:
        for flight in [*flights.shipped(), flights.clear(), *flights.real()]:
            check_results(flight, preset, flights, verdicts)
    check_simulation(flights, verdicts)


def check_results(flight: Flight, preset: str, flights: Flights, verdicts: Verdicts):
    crosscut = flights.crosscut
    first = crosscut.results(flight.path, preset=preset).expect(0).stdout
    others = {}
    for workers in WORKERS:
        ran = crosscut.results(flight.path, "--set", f"pipeline.workers={workers}", preset=preset)
        others[f"{workers} workers"] = ran.expect(0).stdout
    if preset == "paper":
        others["with a recording"] = flights.outcome(flight).ran.stdout
    differences = [f"{name}: {first_difference(first, made)}" for name, made in others.items() if made != first]
    figures = "; ".join(differences) or f"{len(first)} bytes, the same in {1 + len(others)} runs ({', '.join(others)})"
    verdicts.that(not differences and bool(first), f"{flight.name}, {preset}: results", figures)


def first_difference(a: bytes, b: bytes) -> str:
    """In words."""
    a, b = lines(a), lines(b)
    for i, (x, y) in enumerate(zip(a, b)):
        for key in [*x, *y]:
            if x.get(key) != y.get(key):
                return f"revolution {i} has {key} {x.get(key)!r:.80}, then {y.get(key)!r:.80}"
    if len(a) != len(b):
        return f"{len(a)} lines, then {len(b)}"
    return "the same values, written differently"


def check_simulation(flights: Flights, verdicts: Verdicts):
    once = flights.simulated(seed=11).path.read_bytes()
    again = flights.work / "again.mcap"
    flights.crosscut("simulate", SCENARIO, "--seed", 11, "--out", again).expect(0)
    verdicts.that(again.read_bytes() == once, f"{SCENARIO}, seed 11 twice", f"{len(once)} bytes, the same")
    other = flights.simulated(seed=12).path.read_bytes()
    verdicts.that(other != once, f"{SCENARIO}, seeds 11 and 12", "differ")

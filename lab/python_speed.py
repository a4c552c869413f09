"""Times the package beside Rust and scikit-learn on the scans of the shipped flight: `lab/run python_speed`.

Each figure is the least of several repetitions, which the load of the machine disturbs least.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

from sklearn.cluster import SpectralClustering

import crosscut

REPETITIONS = 7


def least_ms(work: Callable[[], object], scans: int) -> float:
    """Milliseconds a scan."""
    times = []
    for _ in range(REPETITIONS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times) / scans * 1e3


def main(root: Path) -> None:
    scans = list(crosscut.read(root / "recordings" / "tee.mcap"))
    print(f"{len(scans)} scans of 360 beams, least of {REPETITIONS} repetitions, ms a scan")
    for preset in ("default", "paper"):
        engine = crosscut.Engine(preset)
        some = scans if preset == "default" else scans[::10]
        native = engine._native
        rust = min(native.seconds_in_rust(some) for _ in range(REPETITIONS)) / len(some) * 1e3
        python = least_ms(lambda: [engine.process(scan) for scan in some], len(some))
        print(f"{preset}: Rust {rust:.4f}, Engine.process {python:.4f}, {python / rust:.2f} times")

        many = some * (40 if preset == "default" else 2)
        one, two = (least_ms(lambda: list(engine.process_many(many, workers=w)), len(many)) for w in (1, 2))
        print(f"{preset}: process_many by 1 worker {one:.4f}, by 2 {two:.4f}, {one / two:.2f} times as fast")

    some = scans[::20]
    clustering = SpectralClustering(3, gamma=1.5, random_state=1)
    theirs = least_ms(lambda: [clustering.fit(scan.points) for scan in some], len(some))
    print(f"sklearn.cluster.SpectralClustering (which is given k = 3): {theirs:.4f}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

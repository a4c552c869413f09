"""A first look at a recording: what is in it, what each scan shows, and where it gets interesting.

    python examples/python/first_look.py [FLIGHT.bag]
"""

import collections
import sys
from pathlib import Path

import crosscut

SHIPPED = Path(__file__).parents[2] / "recordings" / "tee.mcap"


def main(path: Path = SHIPPED) -> None:
    engine = crosscut.Engine()
    scans = engine.read(path)
    results = list(engine.process_many(scans))
    print(f"{path.name}: {len(results)} scans on {scans.topic}, {len(scans.losses)} losses")

    places = collections.Counter(result.place for result in results)
    print("places:", ", ".join(f"{place} {count}" for place, count in places.most_common()))
    sure = sum((result.confidence or 0.0) >= 0.9 for result in results)
    print(f"sure: {sure} of {len(results)}")

    before = None
    for result in results:
        if result.place != before:
            ways = ", ".join(f"{opening.width_m:.1f} m at {opening.bearing_rad:+.2f} rad" for opening in result.openings)
            print(f"  scan {result.seq:4}: {result.place:12} {ways}")
            before = result.place


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))

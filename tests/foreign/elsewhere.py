"""The share of right answers of `default` on places of another generator (`places`), compared with the paper's rule."""

import json
import math
from pathlib import Path

import places
from flights import Flights
from verdicts import Verdicts

PUBLISHED = Path(__file__).parents[2] / "docs/results.json"
# A sample of the places of the published figure: the first of each kind.
COUNT = 20
SEED = 202
# It may be this many standard deviations of a sample of its size below the published share.
DEVIATIONS = 2.0
LEAST_RIGHT_OF_SURE = 0.85
SURE_FROM = 0.89  # bins are a tenth wide; this selects the last
PAPER = "paper"


def check(flights: Flights, verdicts: Verdicts):
    folder = flights.work / "places"
    folder.mkdir(exist_ok=True)
    for kind in places.KINDS:
        places.write(folder / f"{kind}.mcap", places.make(kind, COUNT, SEED))
    ran = flights.crosscut("compare", folder, "--with", "default", "--with", PAPER, "--quiet", "--json", "-")
    evaluated = json.loads(ran.expect(0).stdout)
    for family in evaluated["families"]:
        default, paper = (result["figures"]["right"]["share"] for result in family["results"])
        verdicts.note(family["family"], f"{default:.0%} right, paper {paper:.0%}")
    default, paper = (result["figures"] for result in evaluated["all"])
    sure = share_of_sure(default)
    published = published_right()
    counted = [f["results"][0]["figures"]["right"] for f in evaluated["families"] if f["family"] in published]
    hits, revolutions = (sum(right[part] for right in counted) for part in ("hits", "of"))
    right, of = hits / revolutions, f"of {revolutions}, of the {len(counted)} kinds that are published"
    share = published["all"]
    least_right = share - DEVIATIONS * math.sqrt(share * (1.0 - share) / revolutions)
    verdicts.that(right >= least_right, "right", f"{right:.1%} {of}, at least {least_right:.1%}")
    verdicts.that(right > paper["right"]["share"], "more than the paper's rule", f"{paper['right']['share']:.1%}")
    verdicts.that(sure >= LEAST_RIGHT_OF_SURE, "right of the sure", f"{sure:.1%}, at least {LEAST_RIGHT_OF_SURE:.0%}")


def published_right() -> dict[str, float]:
    """Share of places that `default` answers right, by kind and of all."""
    shares = json.loads(PUBLISHED.read_text())["places"]["right"]
    return {kind: by_method["default"] / 100 for kind, by_method in shares.items()}


def share_of_sure(figures: dict) -> float:
    sure = [row["right"] for row in figures["confidence"]["reliability"] if row["from"] > SURE_FROM]
    return sum(right["hits"] for right in sure) / sum(right["of"] for right in sure)

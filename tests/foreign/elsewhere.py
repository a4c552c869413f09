"""How often `default` is right on places of a generator that is not ours (`places`), beside the paper's rule."""

import json

import places
from flights import Flights
from verdicts import Verdicts

COUNT = 30
SEED = 1
# Least shares over all kinds, some points under those of 3000 places (docs/results.json, `places`).
LEAST_RIGHT = 0.82
LEAST_RIGHT_OF_SURE = 0.85
SURE_FROM = 0.89  # the rows are a tenth wide
PAPER = "paper,spectral.kind=slicing"  # the same counts without full decompositions of up to 1800 returns


def check(flights: Flights, verdicts: Verdicts):
    folder = flights.work / "places"
    folder.mkdir(exist_ok=True)
    for kind in places.KINDS:
        places.write(folder / f"{kind}.mcap", places.make(kind, COUNT, SEED))
    ran = flights.crosscut("evaluate", folder, "--with", "default", "--with", PAPER, "--quiet", "--json", "-")
    evaluated = json.loads(ran.expect(0).stdout)
    for family in evaluated["families"]:
        default, paper = (result["figures"]["right"]["share"] for result in family["results"])
        verdicts.note(family["family"], f"{default:.0%} right, paper {paper:.0%}")
    default, paper = (result["figures"] for result in evaluated["all"])
    right, sure = default["right"]["share"], share_of_sure(default)
    of = f"of {default['revolutions']}"
    verdicts.that(right >= LEAST_RIGHT, "right", f"{right:.1%} {of}, at least {LEAST_RIGHT:.0%}")
    verdicts.that(right > paper["right"]["share"], "more than the paper's rule", f"{paper['right']['share']:.1%}")
    verdicts.that(sure >= LEAST_RIGHT_OF_SURE, "right of the sure", f"{sure:.1%}, at least {LEAST_RIGHT_OF_SURE:.0%}")


def share_of_sure(figures: dict) -> float:
    sure = [row["right"] for row in figures["confidence"]["reliability"] if row["from"] > SURE_FROM]
    return sum(right["hits"] for right in sure) / sum(right["of"] for right in sure)

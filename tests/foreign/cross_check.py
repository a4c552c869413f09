"""Runs the cross-checks and prints what was compared. Started by `run`, which sets up the environment."""

import argparse
import sys
import time
import traceback
from pathlib import Path

import answers
import carmen
import determinism
import elsewhere
import formats
import graphs
import html_page
import killing
import mcap_io
import messages
import prompt
import reading
import recording
import spectrum
import viewing
import web_viewer
from flights import Flights
from program import Crosscut
from verdicts import Verdicts

CHECKS = {
    "spectrum": spectrum,
    "recording": recording,
    "reading": reading,
    "viewing": viewing,
    "killing": killing,
    "mcap_io": mcap_io,
    "answers": answers,
    "determinism": determinism,
    "elsewhere": elsewhere,
    "carmen": carmen,
    "formats": formats,
    "graphs": graphs,
    "messages": messages,
    "prompt": prompt,
}
# Need a browser; `browser` needs a program with the feature `web` too.
ON_DEMAND = {"page": html_page, "browser": web_viewer}


def main() -> int:
    parser = argparse.ArgumentParser(prog="tests/foreign/run", description="Cross-checks crosscut with foreign tools.")
    parser.add_argument("checks", nargs="*", metavar="CHECK", help=f"which ones: {', '.join(CHECKS)}, page, browser; all but page and browser if none")
    parser.add_argument("--crosscut", type=Path, help="the program; target/release/crosscut if not given")
    parser.add_argument("--work", default="work", help="folder in target/foreign for what is made; runs side by side need one each")
    parser.add_argument("--root", type=Path, required=True, help=argparse.SUPPRESS)
    args = parser.parse_args()
    known = CHECKS | ON_DEMAND
    if unknown := [name for name in args.checks if name not in known]:
        parser.error(f"no check is called {unknown[0]}; there are {', '.join(known)}")
    binary = args.crosscut or args.root / "target/release/crosscut"
    if not binary.exists():
        parser.error(f"{binary} is not there: cargo build --release -p crosscut")

    flights = Flights(args.root, Crosscut(binary), args.root / "target/foreign" / args.work)
    verdicts = Verdicts()
    if not flights.real():
        verdicts.skipped("real recordings", f"not in {flights.data}; shipped, simulated and made ones are checked")
    for name in args.checks or CHECKS:
        start = time.monotonic()
        verdicts.begin(name)
        try:
            known[name].check(flights, verdicts)
        except Exception as error:
            traceback.print_exc()
            verdicts.failed("the check itself", f"ended early: {error}")
        verdicts.end(time.monotonic() - start)
    print(verdicts.summary())
    return 0 if verdicts.all_held() else 1


if __name__ == "__main__":
    sys.exit(main())

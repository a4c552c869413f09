"""kill -9 at many random moments of a run: the recording is accepted by `rerun rrd verify`, opens in Rerun's reader, and
`crosscut rrd` reads as far as it goes."""

import random
import signal
import subprocess
import time

import rrd
from flights import Flights
from verdicts import Verdicts

KILLS = 12
SEED = 3


def check(flights: Flights, verdicts: Verdicts):
    flight = flights.shipped()[0]
    saved = flights.work / "killed_often.rrd"
    command = flights.crosscut.command("run", flight.path, "--preset", "paper", "--save", saved, "--quiet")
    start = time.monotonic()
    subprocess.run(command, check=True)
    whole_s = time.monotonic() - start

    moments = random.Random(SEED)
    refused, revolutions = [], []
    for _ in range(KILLS):
        saved.unlink(missing_ok=True)
        after_s = moments.uniform(0, whole_s)
        process = subprocess.Popen(command)
        while not saved.exists():
            time.sleep(0.001)
        time.sleep(after_s)
        process.send_signal(signal.SIGKILL)
        killed = process.wait() != 0
        verified = rrd.rerun_command("rrd", "verify", "--check-footers=false", saved)
        listed = flights.crosscut("rrd", "ls", saved)
        rows = rrd.values(saved, "/scan/ranges", "Tensor:data")
        revolutions.append(len(rows))
        if verified.returncode or listed.code != (3 if killed else 0) or sorted(rows) != list(range(len(rows))):
            refused.append(f"after {after_s:.2f} s: verify {verified.returncode}, ls {listed.code}, {len(rows)} revolutions")
    verdicts.that(
        not refused and max(revolutions) > 0,
        f"{flight.name}: killed {KILLS} times, Rerun",
        f"opens with {min(revolutions)} to {max(revolutions)} revolutions; refused: {refused or 'none'}",
    )

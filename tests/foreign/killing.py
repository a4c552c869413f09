"""kill -9 at many random moments of a run, each when so many bytes are on the disk: the recording is accepted by
`rerun rrd verify`, opens in Rerun's reader, and `crosscut rrd` reads as far as it goes."""

import random
import subprocess
import time
from pathlib import Path

import rrd
from flights import Flights
from verdicts import Verdicts

KILLS = 12
SEED = 3
DEADLINE_S = 120
# How much of the file must be there for some revolution to be: the layout comes first, and the first chunks are 2.5 s long.
FIRST_SHARE = 0.4


def check(flights: Flights, verdicts: Verdicts):
    flight = flights.shipped()[0]
    saved = flights.work / "killed_often.rrd"
    command = flights.crosscut.command("run", flight.path, "--preset", "paper", "--save", saved, "--quiet")
    subprocess.run(command, check=True)
    whole_bytes = saved.stat().st_size
    flown = len(rrd.values(saved, "/scan/ranges", "Tensor:data"))

    moments = random.Random(SEED)
    refused, revolutions, running = [], [], 0
    for _ in range(KILLS):
        share = moments.random()
        was_running = run_and_kill(command, saved, int(share * whole_bytes))
        verified = rrd.rerun_command("rrd", "verify", "--check-footers=false", saved)
        listed = flights.crosscut("rrd", "ls", saved)
        rows = rrd.values(saved, "/scan/ranges", "Tensor:data")
        exit_codes = {3} if was_running else {0}
        if len(rows) == flown:
            exit_codes.add(0)  # killed after it closed its file, before it ended
        holds = (
            verified.returncode == 0
            and listed.code in exit_codes
            and sorted(rows) == list(range(len(rows)))
            and (len(rows) > 0 or share < FIRST_SHARE)
        )
        if not holds:
            refused.append(f"at {share:.2f}: verify {verified.returncode}, ls {listed.code}, {len(rows)} revolutions")
        revolutions.append(len(rows))
        running += was_running
    verdicts.that(
        not refused and running > KILLS / 2 and max(revolutions) > 0,
        f"{flight.name}: killed {running} times, Rerun",
        f"opens with {min(revolutions)} to {max(revolutions)} revolutions; refused: {refused or 'none'}",
    )


def run_and_kill(command: list[str], saved: Path, at_bytes: int) -> bool:
    """Kills the run when its recording has so many bytes; whether it was still running."""
    saved.unlink(missing_ok=True)
    process = subprocess.Popen(command)
    deadline = time.monotonic() + DEADLINE_S
    while process.poll() is None and not (saved.exists() and saved.stat().st_size >= at_bytes):
        if time.monotonic() > deadline:
            process.kill()
            raise RuntimeError(f"the recording does not reach {at_bytes} bytes")
        time.sleep(0.001)
    process.kill()
    return process.wait() != 0

"""The scripts of examples/python."""

from __future__ import annotations

import re
import subprocess
import sys

from conftest import ROOT


def run(script: str, *args: object) -> str:
    command = [sys.executable, *map(str, (ROOT / "examples" / "python" / script, *args))]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_first_look_finds_the_junction() -> None:
    out = run("first_look.py")
    assert "tee.mcap: 141 scans on /scan, 0 losses" in out
    assert re.search(r"^  scan +\d+: tee +(\d\.\d m at .* rad,? ?){3}$", out, re.MULTILINE), out


def test_eigenvalues_by_hand_equal_ours() -> None:
    out = run("by_hand.py")
    differences = [float(number) for number in re.findall(r"by (\de[+-]\d+)", out)]
    assert len(differences) == 3 and max(differences) < 1e-13, out
    assert "walls: 3 by hand, 3 by crosscut" in out


def test_the_self_tuning_affinity_is_evaluated_beside_the_presets() -> None:
    out = run("self_tuning.py", ROOT / "recordings" / "tee.mcap")
    heading = ["family", "revolutions", "default", "paper", "self_tuning"]
    lines = out.splitlines()
    flight = lines[[line.split() for line in lines].index(heading) + 1]
    assert flight.split()[:2] == ["tee", "141"]

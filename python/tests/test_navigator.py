"""A vehicle that explores a mine: on recorded scans, and in another simulator."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT

import crosscut

EXAMPLE = ROOT / "examples" / "python" / "explore_irsim.py"


def commands(scans: list[Any], **settings: Any) -> list[crosscut.Command]:
    navigator = crosscut.Navigator(**settings)
    return [navigator.step(scan) for scan in scans]


def test_commands_follow_from_the_scans_alone_and_keep_to_the_limits(tee: Path) -> None:
    scans = list(crosscut.read(tee))
    flown = commands(scans, speed_max_m_s=0.4, turn_rate_max_rad_s=0.3)
    assert flown == commands(scans, speed_max_m_s=0.4, turn_rate_max_rad_s=0.3)
    assert (flown[0].speed_m_s, flown[1].speed_m_s) == (0.0, 0.0), "it looks before it flies"
    assert 0.3 < max(command.speed_m_s for command in flown) <= 0.4
    assert max(abs(command.turn_rate_rad_s) for command in flown) <= 0.3
    assert {command.doing for command in flown} <= {"follows", "arrives", "leaves", "waits"}
    assert not any(command.done for command in flown)


def test_the_map_is_a_copy_of_that_of_the_navigator(tee: Path) -> None:
    navigator, flight = crosscut.Navigator(), crosscut.Flight()
    scans = list(crosscut.read(tee))
    for scan in scans[:100]:
        navigator.step(scan)
        flight.process(scan)
    of_navigator, of_flight = navigator.map, flight.map
    assert of_navigator.to_dict() == of_flight.to_dict() and navigator.pose == flight.pose
    for scan in scans[100:]:
        navigator.step(scan)
        flight.process(scan)
    assert of_navigator.to_dict() == of_flight.to_dict()


ASKED_MEANWHILE = """
import sys, threading, time, crosscut
began = threading.Event()
def slow(points):
    began.set()
    time.sleep(0.5)
    raise ValueError("it answered")
navigator = crosscut.Navigator(crosscut.Engine("paper", affinity=slow))
scan = next(iter(crosscut.read("recordings/tee.mcap")))
def step():
    try:
        navigator.step(scan)
    except crosscut.StageError as error:
        sys.stdout.write(f"{error.__cause__}\\n")  # print() writes the end of the line by itself
stepping = threading.Thread(target=step)
stepping.start()
began.wait()
sys.stdout.write(f"{navigator.map.to_dict()['nodes']}\\n")
stepping.join()
"""


def test_a_map_asked_for_during_a_step_does_not_deadlock() -> None:
    run = subprocess.run([sys.executable, "-c", ASKED_MEANWHILE], capture_output=True, text=True, cwd=ROOT, timeout=60)
    assert sorted(run.stdout.splitlines()) == ["[]", "it answered"], run.stderr


def test_wrong_arguments_are_refused_and_a_failing_stage_is_named(tee: Path) -> None:
    with pytest.raises(ValueError, match="did you mean depth_first"):
        crosscut.Navigator(planner="depth-first")
    with pytest.raises(ValueError, match="speed_max_m_s is above 0, not -1"):
        crosscut.Navigator(speed_max_m_s=-1.0)

    def broken(points: Any) -> Any:
        raise RuntimeError("no affinity")

    navigator = crosscut.Navigator(crosscut.Engine("paper", affinity=broken))
    with pytest.raises(crosscut.StageError) as raised:
        navigator.step(next(iter(crosscut.read(tee))))
    assert isinstance(raised.value.__cause__, RuntimeError)


def test_a_mine_of_another_simulator_is_explored_without_a_contact() -> None:
    pytest.importorskip("irsim")
    spec = importlib.util.spec_from_file_location("explore_irsim", EXAMPLE)
    assert spec is not None and spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    command, seen, home_m, contacts, summary = example.explore()
    assert command.end == "home" and home_m < example.HOME_M, (command, home_m, summary)
    assert seen == set(example.TUNNELS), summary
    assert contacts == 0

"""Where the recordings and the program are."""

from __future__ import annotations

import os
import socket
import sysconfig
from pathlib import Path

import pytest
from _pytest.mark import ParameterSet

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = sorted(path for path in (ROOT / "recordings").iterdir() if path.suffix == ".mcap")
SHARED = ROOT.parent / "shared" / "data"


def recordings() -> list[ParameterSet]:
    """The shipped recordings, and those of shared/data where they are there."""
    known = ("corridor_cross.mcap", "corridor_dead.mcap", "corridor_left.mcap", "corridor_threeway.mcap",
             "corridor_ros1.bag", "intel_excerpt.clf", "aces_excerpt.clf")
    absent = pytest.mark.skip(reason="not there")
    shared = [SHARED / name for name in known]
    marked = [pytest.param(path, id=path.name, marks=() if path.exists() else (absent,)) for path in shared]
    return [pytest.param(path, id=path.name) for path in SHIPPED] + marked


@pytest.fixture(scope="session")
def tee() -> Path:
    """The shipped flight into a T junction."""
    return ROOT / "recordings" / "tee.mcap"


@pytest.fixture(scope="session")
def program() -> str:
    """The program to compare with: $CROSSCUT, else that of the wheel."""
    return os.environ.get("CROSSCUT") or in_wheel()


def in_wheel() -> str:
    """The program that the wheel installed."""
    return str(Path(sysconfig.get_path("scripts")) / "crosscut")


def free_port() -> int:
    """A port of the loopback on which nothing listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port

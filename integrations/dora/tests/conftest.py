"""Where the recordings and the programs are."""

from __future__ import annotations

import socket
import sysconfig
from pathlib import Path

import pytest
from _pytest.mark import ParameterSet

ROOT = Path(__file__).resolve().parents[3]


def recordings() -> list[ParameterSet]:
    """The shipped recordings."""
    return [pytest.param(path, id=path.name) for path in sorted((ROOT / "recordings").glob("*.mcap"))]


@pytest.fixture(scope="session")
def tee() -> Path:
    """The shipped flight into a T junction."""
    return ROOT / "recordings" / "tee.mcap"


def in_wheel() -> str:
    """The program that the wheel installed."""
    return str(Path(sysconfig.get_path("scripts")) / "crosscut")


def free_port() -> int:
    """A port of the loopback on which nothing listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port

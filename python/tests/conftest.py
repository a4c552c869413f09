"""Where the recordings and the program are."""

from __future__ import annotations

import os
import socket
import subprocess
import sysconfig
from pathlib import Path

import mcap.reader
import mcap.writer
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


def has_recordings() -> bool:
    """Whether the wheel was built with Rerun; `python/run --dev` builds it without."""
    said = subprocess.run([in_wheel(), "rrd", "ls", "none.rrd"], capture_output=True, text=True).stderr
    return "built without recordings" not in said


needs_recordings = pytest.mark.skipif("not __import__('conftest').has_recordings()", reason="built without recordings")


def free_port() -> int:
    """A port of the loopback on which nothing listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def write_scans(flight: Path, out: Path, numbers: range) -> None:
    """Writes some of the scans of a flight."""
    with flight.open("rb") as source, out.open("wb") as target:
        writer = mcap.writer.Writer(target)
        writer.start()
        channel_id = None
        for number, (schema, channel, message) in enumerate(mcap.reader.make_reader(source).iter_messages(topics=["/scan"])):
            if channel_id is None:
                assert schema is not None
                schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
                channel_id = writer.register_channel(channel.topic, channel.message_encoding, schema_id)
            if number in numbers:
                writer.add_message(channel_id, message.log_time, message.data, message.publish_time)
        writer.finish()

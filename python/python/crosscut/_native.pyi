import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

from ._results import Result

__version__: str

@final
class Scan:
    """One scan, made of ranges, of points, or by :func:`crosscut.read`.

    ``ranges``: metres, one a beam, +inf for no return; beam i looks at ``angle_min + i * angle_increment``, radians.
    ``range_min`` and ``range_max``: what the sensor measures, metres. ``stamp_ns``: nanoseconds since the epoch.
    """

    def __new__(
        cls,
        ranges: ArrayLike,
        angle_min: float,
        angle_increment: float,
        *,
        range_min: float = 0.0,
        range_max: float = ...,
        stamp_ns: int = ...,
        seq: int | None = None,
        frame_id: str = ...,
    ) -> Self: ...
    @staticmethod
    def from_points(
        points: ArrayLike, *, stamp_ns: int = ..., seq: int | None = None, frame_id: str = ...
    ) -> Scan:
        """A cloud of points, (n, 2) or (n, 3), metres; x forward, y left. An engine works on what a level vehicle sees of it."""

    @staticmethod
    def _without_beams(points: ArrayLike) -> Scan: ...
    @staticmethod
    def from_message(
        message: bytes, message_type: str = "sensor_msgs/msg/LaserScan", *, encoding: str = "cdr", seq: int | None = None
    ) -> Scan:
        """A message as it is on the wire, of any type and encoding that recordings may have."""

    @property
    def seq(self) -> int | None:
        """Its number in its topic; None if it has none."""
    @property
    def stamp_ns(self) -> int:
        """The sensor's stamp, nanoseconds since the epoch."""
    @property
    def frame_id(self) -> str:
        """The sensor's frame, as the message names it."""
    @property
    def ranges(self) -> NDArray[np.float32] | None:
        """One a beam, metres, as on the wire; of a recorded cloud, those that a level vehicle sees; else None for a cloud."""
    @property
    def angle_min(self) -> float | None:
        """Bearing of the first beam, radians."""
    @property
    def angle_increment(self) -> float | None:
        """Angle from one beam to the next, radians."""
    @property
    def range_min(self) -> float | None:
        """The shortest range that the sensor measures, metres."""
    @property
    def range_max(self) -> float | None:
        """The longest range that the sensor measures, metres."""
    @property
    def points(self) -> NDArray[np.float64]:
        """The returns (n, 3), metres; x forward, y left."""
    @property
    def notes(self) -> list[str]:
        """What was dropped, repaired or replaced when it was read."""

@final
class Recording:
    def __iter__(self) -> Recording: ...
    def __next__(self) -> Scan: ...
    @property
    def topic(self) -> str: ...
    @property
    def losses(self) -> list[str]: ...

@final
class Flight:
    @property
    def pose(self) -> tuple[float, float, float] | None: ...
    def map(self) -> Map: ...

@final
class Map:
    def graph(self) -> tuple[list[dict[str, Any]], list[tuple[int, int, dict[str, Any]]]]: ...
    def json(self) -> str: ...
    def summary(self) -> str: ...

@final
class Navigator:
    @property
    def pose(self) -> tuple[float, float, float] | None: ...
    def map(self) -> Map: ...

@final
class Engine:
    def __new__(
        cls,
        preset: str,
        settings: Sequence[str],
        stages: Sequence[Callable[..., Any] | None],
        keep: Sequence[str],
    ) -> Self: ...
    def process(self, scan: Scan, seq: int) -> Result: ...
    def process_batch(self, scans: Sequence[Scan], first_seq: int) -> tuple[list[Result], BaseException | None]: ...
    def flight(self) -> Flight: ...
    def fly(self, scan: Scan, seq: int, pose: tuple[float, float, float] | None, flight: Flight) -> Result: ...
    def navigator(self, planner: str, limits: tuple[float, float]) -> Navigator: ...
    def navigate(
        self, scan: Scan, pose: tuple[float, float, float] | None, navigator: Navigator
    ) -> tuple[float, float, str, str | None, str | None]: ...
    def seconds_in_rust(self, scans: Sequence[Scan]) -> float: ...
    def keep_frames(self, keeps_frames: bool) -> None: ...
    def stop(self) -> None: ...
    def read(self, wanted: dict[str, Any]) -> Recording: ...
    @property
    def config(self) -> str: ...

@final
class Kept:
    def why(self, notes: list[str]) -> str: ...

@final
class Recorder:
    def __new__(cls, path: os.PathLike[str], engine: Engine, name: str, detail: str | None) -> Self: ...
    def log(self, kept: Kept) -> None: ...
    def close(self) -> None: ...

@final
class Odometry:
    def __new__(cls) -> Self: ...
    def add(self, message: bytes, message_type: str) -> None: ...
    def reaches(self, scan: Scan) -> bool: ...
    def beside(self, scan: Scan) -> tuple[Scan, tuple[float, float, float] | None]: ...

@final
class Feed:
    def hear(self, topic: str, message_type: str, message: bytes, missing: int) -> bool: ...
    def fail(self, why: str) -> bool: ...

def program(
    args: Sequence[str],
    stages: Mapping[str, Callable[..., Any]],
    hear: Callable[[str, dict[str, Any], Feed], Any],
    find: Callable[[str], tuple[Callable[..., Any], int]],
) -> int: ...
def check_affinity(function: Callable[..., Any]) -> None: ...

"""A vehicle that explores a mine by its junctions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ._engine import Engine, as_scan, checked_engine
from ._flight import Map


@dataclass(frozen=True)
class Command:
    """What a vehicle is to do until the next scan."""

    speed_m_s: float
    """Speed ahead."""
    turn_rate_rad_s: float
    """Turn rate, anticlockwise."""
    doing: str
    """"follows" a passage, "arrives" at a place, "leaves" it, "waits" for a pose, or "is home"."""
    why: str | None
    """The reason of the decision that was taken at this scan; None at all others."""
    end: str | None
    """None during the mission; then "home", "stuck" (it could not get on) or "gave_up" (nothing new for too long)."""

    @property
    def done(self) -> bool:
        """The mission is over; the vehicle must stop."""
        return self.end is not None


class Navigator:
    """Flies a vehicle through all ways of a mine that it does not know, and home, by one 2D lidar and odometry.

    >>> navigator = Navigator(Engine(vehicle={"width_m": 0.6}), planner="nearest_frontier")
    >>> command = navigator.step(scan, pose)
    >>> while not command.done:
    ...     vehicle.drive(command.speed_m_s, command.turn_rate_rad_s)
    ...     command = navigator.step(next_scan(), next_pose())

    ``engine``: the detector. Setting ``vehicle.width_m`` is the diameter of the vehicle, which turns on the spot.
    ``planner``: "nearest_frontier" or "depth_first". ``speed_max_m_s``, ``turn_rate_max_rad_s``: the vehicle's limits.
    """

    def __init__(
        self,
        engine: Engine | None = None,
        planner: str = "nearest_frontier",
        *,
        speed_max_m_s: float = 1.5,
        turn_rate_max_rad_s: float = 1.0,
    ) -> None:
        self._engine = checked_engine(engine)._native
        self._navigator = self._engine.navigator(planner, (speed_max_m_s, turn_rate_max_rad_s))

    def step(self, scan: Any, pose: tuple[float, float, float] | None = None) -> Command:
        """What the vehicle is to do after the next scan. The navigator expects about ten scans a second.

        ``scan``: as for :meth:`Engine.process`; its ``stamp_ns`` must be that of the sensor. ``pose``: where the vehicle was
        by its odometry, x and y in metres and yaw in radians, in any fixed frame; without it, the pose comes from the scans.
        """
        return Command(*self._engine.navigate(as_scan(scan), pose, self._navigator))

    @property
    def pose(self) -> tuple[float, float, float] | None:
        """Where the vehicle was at the last step: x and y in metres, yaw in radians, in the frame of the start."""
        return self._navigator.pose

    @property
    def map(self) -> Map:
        """The map up to now, in the frame of the start. Later steps do not change it."""
        return Map(self._navigator.map())

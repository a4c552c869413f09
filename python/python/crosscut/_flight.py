"""A flight, and the map that it makes."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from . import _native
from ._engine import Engine, as_scan, checked_engine
from ._extras import importing
from ._results import Result

if TYPE_CHECKING:
    import networkx


class Flight:
    """The flight of one vehicle: its scans in order become answers, poses and a map.

    >>> flight = Flight(Engine())
    >>> for scan in crosscut.read("FLIGHT.bag"):
    ...     result = flight.process(scan)
    >>> graph = flight.map.to_networkx()
    """

    def __init__(self, engine: Engine | None = None) -> None:
        self._engine = checked_engine(engine)._native
        self._native = self._engine.flight()
        self._processed = 0

    def process(self, scan: Any, pose: tuple[float, float, float] | None = None) -> Result:
        """The answer for the next scan, with the fields ``here``, ``steady`` and ``pose``, which :meth:`Engine.process` leaves
        out.

        ``pose``: where it was taken, x and y in metres and yaw in radians, in any fixed frame, as by odometry. Without it the
        odometry of a recording is taken if there is any. Setting ``flight.pose`` chooses how scans correct it.
        """
        result = self._engine.fly(as_scan(scan), self._processed, pose, self._native)
        self._processed += 1
        return result

    @property
    def pose(self) -> tuple[float, float, float] | None:
        """Where the last scan was taken: x and y in metres, yaw in radians, in the frame of the first scan."""
        return self._native.pose

    @property
    def map(self) -> Map:
        """The map so far. Later scans do not change it."""
        return Map(self._native.map())


class Map:
    """Junctions and dead ends, each once, and the passages between them: :attr:`Flight.map`, :attr:`Navigator.map`."""

    def __init__(self, native: _native.Map) -> None:
        self._native = native

    def to_networkx(self) -> networkx.MultiGraph:
        """As a graph; needs networkx.

        Nodes are numbers and have ``kind`` ("junction" or "dead_end"), ``x_m``, ``y_m``, ``ways`` and ``visits`` (pairs of
        stamps); a way whose ``edge`` is None was not flown from end to end. Edges have ``length_m``, ``length_sd_m``,
        ``width_m`` and
        ``via_m``, and their number as key.
        """
        with importing("to_networkx()"):
            import networkx

        graph = networkx.MultiGraph()
        nodes, passages = self._native.graph()
        graph.add_nodes_from(enumerate(nodes))
        for number, (start, end, attributes) in enumerate(passages):
            graph.add_edge(start, end, key=number, **attributes)
        return graph

    def to_dict(self) -> dict[str, Any]:
        """In the form that ``crosscut run --map`` writes: plain numbers, lists and texts."""
        plain: dict[str, Any] = json.loads(self.to_json())
        return plain

    def to_json(self) -> str:
        """The text that ``crosscut run --map FILE.json`` writes."""
        return self._native.json()

    def summary(self) -> str:
        """In a line: junctions by their ways, dead ends, loops, ways not taken."""
        return self._native.summary()

    def __repr__(self) -> str:
        return f"Map({self.summary()})"

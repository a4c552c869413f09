"""The map of a flight."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from ._engine import Engine, as_scan
from ._results import Result

if TYPE_CHECKING:
    import networkx


class FlightMap:
    """Junctions and dead ends of a flight, each once, and the passages between them, from its scans in order.

    >>> flight = FlightMap(Engine())
    >>> for scan in crosscut.read("FLIGHT.bag"):
    ...     result = flight.add(scan)
    >>> graph = flight.to_networkx()
    """

    def __init__(self, engine: Engine | None = None) -> None:
        self._engine = (engine or Engine())._native
        self._map = self._engine.flight_map()
        self._added = 0

    def add(self, scan: Any, pose: tuple[float, float, float] | None = None) -> Result:
        """The answer for the next scan, which becomes a part of the map.

        ``pose``: where it was taken, x and y in metres and yaw in radians, in any fixed frame, as by odometry. Without it the
        odometry of a recording is taken if there is any. Setting ``flight.pose`` chooses how scans correct it.
        """
        result = self._engine.add_to_map(as_scan(scan), self._added, pose, self._map)
        self._added += 1
        return result

    @property
    def pose(self) -> tuple[float, float, float] | None:
        """Where the last scan was taken: x and y in metres, yaw in radians, in the frame of the first scan."""
        return self._map.pose

    def to_networkx(self) -> networkx.MultiGraph:
        """The map so far; needs networkx.

        Nodes are numbers and have ``kind`` ("junction" or "dead_end"), ``x_m``, ``y_m``, ``ways`` and ``visits`` (pairs of
        stamps); a way whose ``edge`` is None was not flown from end to end. Edges have ``length_m``, ``length_sd_m``, ``width_m`` and
        ``via_m``, and their number as key.
        """
        import networkx

        graph = networkx.MultiGraph()
        nodes, passages = self._map.graph()
        graph.add_nodes_from(enumerate(nodes))
        for number, (start, end, attributes) in enumerate(passages):
            graph.add_edge(start, end, key=number, **attributes)
        return graph

    def to_dict(self) -> dict[str, Any]:
        """The map so far, in the form that ``crosscut run --map`` writes: plain numbers, lists and texts."""
        flight_map: dict[str, Any] = json.loads(self._map.json())
        return flight_map

    def summary(self) -> str:
        """The map in a line: junctions by their ways, dead ends, loops, ways not taken."""
        return self._map.summary()

    def __repr__(self) -> str:
        return f"FlightMap({self.summary()})"

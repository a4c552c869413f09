"""What is reported of one scan."""

from __future__ import annotations

import dataclasses
import os
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._errors import Error, ReadError
from ._extras import importing, scipy_sparse

if TYPE_CHECKING:
    import pyarrow

    from . import _native


class Wall(NamedTuple):
    """The returns between two consecutive openings."""

    id: int
    """Its number, as in the labels."""
    returns: int
    """Number of its returns."""
    bearing_rad: tuple[float, float]
    """From its first to its last return, anticlockwise (from > to crosses ±π)."""
    island: bool
    """A pillar: counted in ``k``, not in ``junctions``."""
    nearest_m: float | None = None
    """How far its nearest return is from the sensor, metres."""
    nearest_rad: float | None = None
    """The direction of that return, anticlockwise from straight ahead."""


class Opening(NamedTuple):
    """Where a vehicle can leave the place."""

    bearing_rad: float
    """Direction towards the branch, anticlockwise from straight ahead."""
    width_m: float
    """Clear width across the branch, metres."""
    range_m: float
    """How far its nearer end is from the sensor, metres."""
    p: float | None
    """Probability that a vehicle can pass; None where it is not known."""
    walls: tuple[int, int]
    """The walls on its clockwise and anticlockwise side; the same twice at a dead end."""
    evidence: str
    """``seen_through`` or ``no_return``."""
    known: str
    """``seen``: the beams show a way as wide as the vehicle and 3 m long behind it; or ``judged``."""
    cut_by_view: bool
    """The end of a limited view cuts it: bearing and width are those of the part in view."""


class Here(NamedTuple):
    """The place that the vehicle is in."""

    kind: str
    """``junction``, ``passage``, ``dead_end`` or ``chamber``."""
    ways: tuple[int | None, ...]
    """By bearing ascending: the index of the opening that a way of the place leads to; None where no opening lies behind."""
    confidence: float
    """0 to 1."""


class FollowedOpening(NamedTuple):
    """An opening that is followed from scan to scan."""

    track: int
    """Its number in the flight."""
    bearing_rad: float
    """Direction towards the branch, anticlockwise from straight ahead."""
    width_m: float
    """Clear width across the branch, metres."""
    p: float | None
    """The odds that a vehicle can pass, as a probability, of the scan that saw it last; ``None`` where too little was seen."""
    seen_ns: int | None
    """The last scan that saw through; ``None`` where neither this scan nor what was seen around tells: a hidden wall may close it."""


class Steady(NamedTuple):
    """The answer over the last scans of a flight."""

    junctions: int
    """The number of walls, islands left out."""
    here: Here | None
    """The place; its ways are indices of the openings below."""
    openings: tuple[FollowedOpening, ...]
    """By bearing ascending."""


class Pose(NamedTuple):
    """Where a scan was taken, in the frame of the flight's first pose."""

    x_m: float
    """Forward of the first pose, metres."""
    y_m: float
    """To the left of the first pose, metres."""
    yaw_rad: float
    """Anticlockwise from the first pose, in (-π, π]."""
    sd_m: float | None = None
    """Standard deviation of the position in the direction in which it is known least, metres; None where it is not known."""


class WayOn(NamedTuple):
    """A way on in three dimensions, of preset ``3d``."""

    direction: tuple[float, float, float]
    """Towards it, in the body frame: a unit vector."""
    bearing_rad: float
    """Its bearing, anticlockwise from straight ahead."""
    elevation_rad: float
    """Its elevation, up is positive."""
    slope_rad: float
    """How steep it is, up is positive: ``kind`` goes by it, and not by the direction from the sensor."""
    clearance_m: float
    """Diameter of the largest ball that passes, metres."""
    kind: str
    """``level``, ``ramp_up``, ``ramp_down``, ``shaft_up`` or ``shaft_down``."""
    p: float
    """Probability that it is one."""
    evidence: str
    """``seen_through`` or ``no_return``."""
    cut_by_view: bool
    """It goes on beyond what the sensor looks at: direction and clearance are those of the part in view."""


@dataclasses.dataclass(frozen=True, eq=False)
class Result:
    """The answer for one scan. Two results are equal if all but their timings are.

    The fields are those of the lines that ``crosscut run -o`` writes, and what ``keep`` asks for.
    """

    seq: int
    """Number of the scan in its topic."""
    stamp_ns: int
    """The sensor's stamp, nanoseconds since the epoch."""
    returns: int
    """Number of returns, n."""
    junctions: int
    """The number of walls, islands left out: 2 in a tunnel, 1 in a dead end."""
    k: int
    """The number of eigenvalues that count as zero."""
    margin: float | None
    """Decades by which the zero tolerance could be moved before ``k`` changes."""
    confidence: float | None
    """Probability that the answer is right, 0 to 1; None with a stage of one's own, for which nothing was calibrated."""
    place: str
    """``closed``, ``dead_end``, ``corridor``, ``bend``, ``tee``, ``cross``, ``junction_5``..., ``partial_view``."""
    eigenvalues: NDArray[np.float64]
    """The smallest eigenvalues of L, ascending: all that the spectral stage gave (a line of results has 16)."""
    walls: tuple[Wall, ...]
    """The walls, by number."""
    openings: tuple[Opening, ...]
    """The openings, by bearing ascending."""
    gaps: dict[str, int]
    """How many gaps are ``seen`` through, ``proved`` to be closed, and ``judged``."""
    holds_for_width_m: tuple[float, float] | None
    """The widths of the vehicle for which the count stays the same, metres; None where the affinity knows no width."""
    labels: NDArray[np.int32] = dataclasses.field(repr=False)
    """One a beam, in the order of the ranges: its wall; -1 no return; -2 a return of no wall. One a point for a cloud."""
    clusters: NDArray[np.int32] = dataclasses.field(repr=False)
    """One a return: its cluster as the kmeans stage found it, before the report joins and drops; -1 left out."""
    notes: tuple[str, ...]
    """What was dropped, repaired or replaced."""
    timings_ms: dict[str, float] = dataclasses.field(repr=False)
    """Milliseconds that each stage took."""
    here: Here | None = None
    """The place that the vehicle is in, where that is known; of scans that a :class:`Flight` processed."""
    steady: Steady | None = None
    """The answer over the last scans; of scans that a :class:`Flight` processed."""
    pose: Pose | None = None
    """Where the scan was taken; of scans that a :class:`Flight` processed."""
    ways: tuple[WayOn, ...] | None = None
    """The ways on in three dimensions, by bearing ascending; None but with preset ``3d``."""
    ways_view_rad: tuple[float, float] | None = None
    """The elevations between which the sensor looks: of ways beyond them, nothing is known. None but with preset ``3d``."""
    W: Any = dataclasses.field(default=None, repr=False)
    """The affinity matrix (n, n), an array or a ``scipy.sparse.csr_array``; with ``keep=("W",)``."""
    L: Any = dataclasses.field(default=None, repr=False)
    """The Laplacian I - D^-1/2 W D^-1/2 (n, n), stored as W is; with ``keep=("L",)``."""
    U: Any = dataclasses.field(default=None, repr=False)
    """The embedding (n, k); with ``keep=("U",)``."""
    markers: bytes | None = dataclasses.field(default=None, repr=False)
    """Walls and openings in the sensor's frame as a ``visualization_msgs/msg/MarkerArray`` in CDR; with ``keep=("markers",)``."""
    _kept: _native.Kept | None = dataclasses.field(default=None, repr=False)
    """The scan and its engine, for :attr:`why` and for a :class:`Recorder`."""

    @property
    def why(self) -> str:
        """Why the count is what it is, as Markdown: the inequality that gives k, what would change it, the edges of W that
        decide it, what was left out.

        It is the text that a recording has at ``/report/why`` if it begins with this scan (later it may give a wall the colour
        that it had before). It is made when it is asked for, by running the stages on the scan again.
        """
        if self._kept is None:
            raise Error("this is a copy of a result; the result itself knows why")
        return self._kept.why(list(self.notes))

    def __getstate__(self) -> dict[str, Any]:
        """What copies, also those in other processes, have: the answer, without the engine that gave it."""
        return {name: value for name, value in self.__dict__.items() if name != "_kept"} | {"_kept": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Result):
            return NotImplemented
        mine, others = self.to_dict(), other.to_dict()
        matrices = all(_same(getattr(self, name), getattr(other, name)) for name in ("W", "L", "U"))
        arrays = all(np.array_equal(getattr(self, name), getattr(other, name)) for name in ("eigenvalues", "clusters"))
        return mine == others and arrays and matrices and self.markers == other.markers

    __hash__ = None  # type: ignore[assignment]

    def to_dict(self) -> dict[str, Any]:
        """As the line of results that the program writes: plain numbers, lists and texts, for ``json.dumps``."""
        line: dict[str, Any] = {
            "seq": self.seq,
            "stamp_ns": self.stamp_ns,
            "returns": self.returns,
            "junctions": self.junctions,
            "k": self.k,
            "margin": self.margin,
            "confidence": self.confidence,
            "place": self.place,
            "eigenvalues": self.eigenvalues[:16].tolist(),
            "walls": [wall._asdict() | {"bearing_rad": list(wall.bearing_rad)} for wall in self.walls],
            "openings": [opening._asdict() | {"walls": list(opening.walls)} for opening in self.openings],
            "gaps": self.gaps,
            "holds_for_width_m": self.holds_for_width_m and list(self.holds_for_width_m),
            "here": _here(self.here),
            "steady": self.steady
            and {
                "junctions": self.steady.junctions,
                "here": _here(self.steady.here),
                "openings": [opening._asdict() for opening in self.steady.openings],
            },
            "pose": self.pose and self.pose._asdict(),
            "labels": self.labels.tolist(),
            "notes": list(self.notes),
        }
        if self.ways is not None and self.ways_view_rad is not None:
            line["ways"] = [way._asdict() | {"direction": list(way.direction)} for way in self.ways]
            line["ways_flyer"] = len(self.ways)
            line["ways_ground"] = sum(not way.kind.startswith("shaft") for way in self.ways)
            line["ways_view_rad"] = list(self.ways_view_rad)
        return line


def _here(here: Here | None) -> dict[str, Any] | None:
    return here and here._asdict() | {"ways": list(here.ways)}


def _same(mine: Any, other: Any) -> bool:
    if mine is None or other is None:
        return mine is other
    dense = [matrix.toarray() if hasattr(matrix, "toarray") else matrix for matrix in (mine, other)]
    return np.array_equal(dense[0], dense[1])


def laplacian(w: Any, degrees: NDArray[np.float64]) -> Any:
    """I - D^-1/2 W D^-1/2, stored as W is."""
    scale = 1.0 / np.sqrt(degrees)
    if isinstance(w, np.ndarray):
        return np.eye(len(degrees)) - scale[:, None] * w * scale
    sparse = scipy_sparse()
    d = sparse.diags_array(scale)
    return (sparse.eye_array(len(degrees)) - d @ w @ d).tocsr()


def results(path: str | os.PathLike[str]) -> pyarrow.Table:
    """A file that ``crosscut run -o`` wrote, one row a scan; needs pyarrow.

    pandas, polars and DuckDB accept the table directly.
    """
    with importing("results()"):
        import pyarrow as pa
        from pyarrow import json

    here = pa.struct([("kind", pa.string()), ("ways", pa.list_(pa.int64())), ("confidence", pa.float64())])
    numbers = [(name, pa.float64()) for name in ("bearing_rad", "width_m", "p")]
    followed = pa.struct([("track", pa.int64()), *numbers, ("seen_ns", pa.int64())])
    steady = pa.struct([("junctions", pa.int64()), ("here", here), ("openings", pa.list_(followed))])
    wall = [
        ("id", pa.int64()),
        ("returns", pa.int64()),
        ("bearing_rad", pa.list_(pa.float64())),
        ("island", pa.bool_()),
        ("nearest_m", pa.float64()),
        ("nearest_rad", pa.float64()),
    ]
    opening = [
        ("bearing_rad", pa.float64()),
        ("width_m", pa.float64()),
        ("range_m", pa.float64()),
        ("p", pa.float64()),
        ("walls", pa.list_(pa.int64())),
        ("evidence", pa.string()),
        ("known", pa.string()),
        ("cut_by_view", pa.bool_()),
    ]
    schema = pa.schema(
        [
            ("seq", pa.int64()),
            ("stamp_ns", pa.int64()),
            ("returns", pa.int64()),
            ("junctions", pa.int64()),
            ("k", pa.int64()),
            ("margin", pa.float64()),
            ("confidence", pa.float64()),
            ("place", pa.string()),
            ("eigenvalues", pa.list_(pa.float64())),
            ("walls", pa.list_(pa.struct(wall))),
            ("openings", pa.list_(pa.struct(opening))),
            ("gaps", pa.struct([(name, pa.int64()) for name in ("seen", "proved", "judged")])),
            ("holds_for_width_m", pa.list_(pa.float64())),
            ("here", here),
            ("steady", steady),
            ("pose", pa.struct([(name, pa.float64()) for name in ("x_m", "y_m", "yaw_rad", "sd_m")])),
            ("labels", pa.list_(pa.int32())),
            ("notes", pa.list_(pa.string())),
        ]
    )
    try:
        size = os.path.getsize(path)
        if size == 0:
            return schema.empty_table()
        # A block holds whole lines, and a cloud's line has no upper limit.
        read = json.ReadOptions(block_size=min(size + 1, 2**31 - 1))
        return json.read_json(path, read, json.ParseOptions(explicit_schema=schema))
    except FileNotFoundError as error:
        raise ReadError(f"there is no file {os.fspath(path)}") from error
    except OSError as error:
        raise ReadError(f"{os.fspath(path)} cannot be read: {error}") from error
    except pa.ArrowException as error:
        raise ReadError(
            f"{os.fspath(path)} has no lines of results, as `crosscut run -o FILE.jsonl` writes them: {error}"
        ) from error

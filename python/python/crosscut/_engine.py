"""The method on scans: settings in, results out."""

from __future__ import annotations

import json
import numbers
import operator
import os
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from . import _native, _parallel
from ._errors import LossWarning
from ._native import Scan
from ._results import Result

Section: TypeAlias = "str | Mapping[str, object]"
"""The settings of one section by name; of a stage also the name of its kind alone."""

SECTIONS = ("ingest", "csv", "affinity", "spectral", "kmeans", "report", "vehicle", "flight", "pipeline")
STAGES = ("affinity", "spectral", "kmeans")

MOST_WORKERS = 256
"""Each is a thread with an engine of its own."""


class Engine:
    """All stages of one configuration.

    >>> engine = Engine("paper", affinity={"sigma_per_m2": 3.0}, vehicle={"width_m": 0.8})
    >>> engine = Engine("paper", settings={"affinity.sigma_per_m2": 3.0, "vehicle.width_m": 0.8})  # the same

    A section that is a stage (``affinity``, ``spectral``, ``kmeans``) may also be the name of a kind, or any callable:

    - ``affinity(points) -> W``: points (n, 3) in metres, x forward, y left; W (n, n), symmetric, 0 <= W_ij <= 1,
      W_ii = 1, an array or a sparse matrix of scipy.
    - ``spectral(W) -> (eigenvalues, U)``: eigenvalues ascending, at least k of them; U (n, k). k is what it counts.
    - ``kmeans(U, k) -> labels``: n whole numbers, equal for returns of one wall, -1 for a return that is left out.

    What a callable returns is checked; an exception in it becomes the cause of a :class:`StageError`. With an affinity of
    one's own, start from preset ``paper`` and set ``spectral.zero_tolerance`` into the gap above the zeros.

    ``keep`` names what else results hold: the matrices "W", "L" and "U", and "markers", a drawing for RViz. An engine works on
    one scan at a time.
    """

    def __init__(
        self,
        preset: str = "default",
        *,
        settings: Mapping[str, object] | None = None,
        keep: Iterable[str] = (),
        **sections: Section | Callable[..., Any],
    ) -> None:
        stages: list[Any] = [sections.pop(name) if callable(sections.get(name)) else None for name in STAGES]
        self._made_of = (preset, setting_changes(settings, sections), stages, texts("keep", keep))
        self._native = _native.Engine(*self._made_of)
        self._open_recorders = 0

    @classmethod
    def with_changes(
        cls, preset: str, changes: Iterable[str], keep: Iterable[str] = (), /, **stages: Callable[..., Any]
    ) -> Engine:
        """From settings as the command line has them: ``section.key=value``, the value in TOML. ``stages`` are callables."""
        made = cls.__new__(cls)
        made._made_of = (preset, list(changes), [stages.get(name) for name in STAGES], list(keep))
        made._native = _native.Engine(*made._made_of)
        made._open_recorders = 0
        return made

    def _recorders(self, more: int) -> None:
        """More or fewer recorders wait for the matrices of results."""
        self._open_recorders += more
        self._native.keep_frames(self._open_recorders > 0)

    def _another(self) -> _native.Engine:
        """An engine of the same settings, for another thread."""
        another = _native.Engine(*self._made_of)
        another.keep_frames(self._open_recorders > 0)
        return another

    @property
    def config(self) -> str:
        """Every setting with its value, unit, range and origin, as TOML."""
        return self._native.config

    def process(self, scan: Any) -> Result:
        """The answer for one scan; it depends on nothing but the scan and the settings.

        ``scan`` is a :class:`Scan`, an array of points (n, 2) or (n, 3) in metres, or any message with ``ranges``,
        ``angle_min`` and ``angle_increment``, such as a ``sensor_msgs/LaserScan``.
        """
        return self._native.process(as_scan(scan), 0)

    def process_many(self, scans: Iterable[Any], *, workers: int | None = None) -> Iterator[Result]:
        """The answers for many scans, in their order, by this many threads (None: one for each processor).

        A scan without a number has its place in ``scans``. ``workers`` is at most 256. With several workers scans are taken in small batches, ahead of
        their results. If a stage fails, the results before it are given first.
        """
        workers = min(os.cpu_count() or 1, MOST_WORKERS) if workers is None else operator.index(workers)
        if not 1 <= workers <= MOST_WORKERS:
            raise ValueError(f"workers is 1 to {MOST_WORKERS}, not {workers}")
        if workers == 1:
            return (self._native.process(as_scan(scan), seq) for seq, scan in enumerate(scans))
        return _parallel.process(self._another, workers, map(as_scan, scans))

    def read(
        self,
        path: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
        topic: str | Iterable[str] | None = None,
        *,
        read_as: str | None = None,
        from_s: float | None = None,
        to_s: float | None = None,
        every: int = 1,
    ) -> Recording:
        """The scans of a recording, with the settings of this engine (sections ``ingest`` and ``csv``). See :func:`read`."""
        paths = [path] if isinstance(path, (str, os.PathLike)) else list(path)
        topics = [] if topic is None else [topic] if isinstance(topic, str) else texts("topic", topic)
        every = min(operator.index(every), (1 << 64) - 1)  # which gives the first scan alone, as any more would
        if every < 1:
            raise ValueError(f"every is 1 or more, not {every}")
        wanted = {
            "paths": [os.fspath(part) for part in paths],
            "topics": topics,
            "read_as": read_as,
            "from_s": seconds("from_s", from_s),
            "to_s": seconds("to_s", to_s),
            "every": every,
        }
        return Recording(lambda: self._native.read(wanted))


class Recording:
    """The scans of a recording; each loop reads it from its start.

    At the end of a loop, a :class:`LossWarning` reports each part that could not be read.
    """

    def __init__(self, open_it: Callable[[], _native.Recording]) -> None:
        self._open = open_it
        self._native = open_it()
        self._begun = False

    @property
    def topic(self) -> str:
        """The topic that the scans are of."""
        return self._native.topic

    @property
    def losses(self) -> list[str]:
        """What could not be read so far, and why, in the loop that began last."""
        return self._native.losses

    def __iter__(self) -> Iterator[Scan]:
        if self._begun:
            self._native = self._open()
        self._begun = True
        return self._scans(self._native)

    def _scans(self, native: _native.Recording) -> Iterator[Scan]:
        yield from native
        for loss in native.losses:
            warnings.warn(loss, LossWarning, stacklevel=2)


def count(
    ranges: ArrayLike,
    angle_min: float,
    angle_increment: float,
    preset: str = "default",
    *,
    range_min: float = 0.0,
    range_max: float = np.inf,
    settings: Mapping[str, object] | None = None,
    **sections: Section,
) -> Result:
    """Counts the walls that one scan shows, and finds the openings between them.

    ``ranges``: metres, one a beam, +inf for no return. Beam i looks at ``angle_min + i * angle_increment``, radians,
    anticlockwise from straight ahead. Ranges outside ``range_min`` to ``range_max`` (metres) are no returns.

    >>> count(np.full(360, 2.0), 0.0, np.pi / 180).place
    'closed'
    """
    changes = setting_changes(settings, sections)
    engines: dict[Any, _native.Engine] = _OF_THREAD.__dict__.setdefault("engines", {})
    key = (preset, *changes)
    if key not in engines:
        if len(engines) >= 8:
            engines.clear()
        engines[key] = _native.Engine(preset, changes, [None, None, None], [])
    scan = Scan(ranges, angle_min, angle_increment, range_min=range_min, range_max=range_max)
    return engines[key].process(scan, 0)


_OF_THREAD = threading.local()


def read(
    path: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    topic: str | Iterable[str] | None = None,
    *,
    read_as: str | None = None,
    from_s: float | None = None,
    to_s: float | None = None,
    every: int = 1,
    preset: str = "default",
    settings: Mapping[str, object] | None = None,
    **sections: Section,
) -> Recording:
    """The scans of a recording of any format: MCAP, ROS 1 bag, rosbag2, CARMEN log, CSV, PCD or PLY.

    Several paths, or a folder, are the parts of one flight. Several topics are the scanners of one vehicle. ``from_s`` and
    ``to_s`` are seconds after the first scan. Section ``ingest`` sets how the sensor is mounted:
    ``read("FLIGHT.bag", "/scan", ingest={"yaw_rad": 3.14})``.
    """
    engine = Engine(preset, settings=settings, **sections)
    return engine.read(path, topic, read_as=read_as, from_s=from_s, to_s=to_s, every=every)


def checked_engine(engine: Engine | None) -> Engine:
    """The engine that was given; that of the default settings without one."""
    if engine is not None and not isinstance(engine, Engine):
        raise TypeError(f"engine is a crosscut.Engine, not {engine!r}")
    return Engine() if engine is None else engine


def as_scan(scan: Any) -> Scan:
    """A scan, a message or an array of points as a :class:`Scan`."""
    if isinstance(scan, Scan):
        return scan
    if hasattr(scan, "ranges") and hasattr(scan, "angle_min"):
        stamp = getattr(getattr(scan, "header", None), "stamp", None)
        # ROS 2, ROS 1
        seconds = getattr(stamp, "sec", getattr(stamp, "secs", 0))
        ns = getattr(stamp, "nanosec", getattr(stamp, "nsecs", 0))
        return Scan(
            np.asarray(scan.ranges, dtype=np.float32),
            scan.angle_min,
            scan.angle_increment,
            range_min=getattr(scan, "range_min", 0.0),
            range_max=getattr(scan, "range_max", np.inf),
            stamp_ns=max(0, seconds) * 1_000_000_000 + ns,
            frame_id=getattr(getattr(scan, "header", None), "frame_id", ""),
        )
    return Scan.from_points(scan)


def seconds(name: str, value: object) -> float | None:
    """A time after the first scan, if there is one."""
    if value is None:
        return None
    if not isinstance(value, numbers.Real):
        raise TypeError(f"{name} is a number of seconds, not {value!r}")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{name} is larger than any number of 64 bits") from None


def texts(name: str, values: Iterable[str]) -> list[str]:
    """The values of an argument; the first that is no text ends it, however many there are."""
    checked = []
    for value in values:
        if not isinstance(value, str):
            raise TypeError(f"{name} has texts, not {value!r}")
        checked.append(value)
    return checked


def setting_changes(settings: Mapping[str, object] | None, sections: Mapping[str, Any]) -> list[str]:
    """Each as ``section.key=value``, the value in TOML."""
    if not (settings is None or isinstance(settings, Mapping)):
        raise TypeError(f"settings is a mapping of names to values, not {settings!r}")
    changes = [f"{name}={toml(value)}" for name, value in (settings or {}).items()]
    for section, values in sections.items():
        if section not in SECTIONS:
            raise TypeError(f"there is no argument or section {section!r}; sections are {', '.join(SECTIONS)}")
        values = {"kind": values} if isinstance(values, str) else values
        if not isinstance(values, Mapping):
            raise TypeError(f"{section} is a mapping of settings, not {values!r}")
        changes += [f"{section}.{key}={toml(value)}" for key, value in values.items()]
    return changes


def toml(value: object) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Iterable):
        return f"[{', '.join(map(toml, value))}]"
    raise TypeError(f"{value!r} is not a setting: numbers, texts, true, false and lists are")

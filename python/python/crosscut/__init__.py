"""Junction detection on 2D lidar scans: how many walls a scan shows, and where a vehicle can go on.

>>> import numpy as np, crosscut
>>> result = crosscut.count(np.full(360, 2.0), angle_min=0.0, angle_increment=np.pi / 180)
>>> result.junctions, result.place
(1, 'closed')

- :func:`count`: one scan. :class:`Engine`: many, also with stages of one's own.
- :class:`Flight`: poses, and a :class:`Map` of junctions, dead ends and passages, by the scans of a flight in order.
- :class:`Navigator`: commands for a vehicle that explores all of a mine, and comes home.
- :func:`run`, :func:`report`, :func:`compare`: whole recordings into files. :mod:`crosscut.ray`: archives on a cluster.
- :class:`Recorder`: scans, stages and reasons for the Rerun viewer. :func:`view`: a recording in it.
- :func:`read`: the scans of a recording. :func:`results`: a file of results as a table.
- :mod:`crosscut.sklearn`: an estimator. :mod:`crosscut.testing`: tests for a stage of one's own.

Bearings are in radians, anticlockwise from straight ahead; x is forward, y left; lengths are in metres.
"""

from typing import TYPE_CHECKING, Any

from ._engine import Engine, Recording, count, read
from ._errors import Error, LossWarning, MissingPackageError, ReadError, SettingsError, StageError
from ._flight import Flight, Map
from ._native import Scan, __version__
from ._navigator import Command, Navigator
from ._program import compare, report, run, view
from ._recorder import Recorder, show
from ._results import FollowedOpening, Here, Opening, Pose, Result, Steady, Wall, WayOn, results

if TYPE_CHECKING:
    from . import live, ray, sklearn, testing

_LAZY = ("live", "ray", "sklearn", "testing")
"""Modules that are imported when they are asked for: some need packages that others do not."""


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        import importlib

        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "Command",
    "Engine",
    "Error",
    "Flight",
    "FollowedOpening",
    "Here",
    "LossWarning",
    "Map",
    "MissingPackageError",
    "Navigator",
    "Opening",
    "Pose",
    "ReadError",
    "Recorder",
    "Recording",
    "Result",
    "Scan",
    "SettingsError",
    "StageError",
    "Steady",
    "Wall",
    "WayOn",
    "__version__",
    "compare",
    "count",
    "read",
    "report",
    "results",
    "run",
    "show",
    "view",
]

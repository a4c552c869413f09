"""Recordings for the Rerun viewer."""

from __future__ import annotations

import os
from pathlib import Path
from types import TracebackType

from . import _native
from ._engine import Engine, checked_engine
from ._results import Result


class Recorder:
    """Records results as ``crosscut run --save`` does: the same pages, entities and reasons, also of stages of one's own.

    >>> engine = Engine("paper", affinity=my_affinity)
    >>> with Recorder("FLIGHT.rrd", engine) as recorder:
    ...     for result in engine.process_many(crosscut.read("FLIGHT.bag")):
    ...         recorder.log(result)

    While it is open, results of ``engine`` keep their matrices until they are recorded, each once. Results of a
    :class:`Flight` on this engine are recorded with its poses; those of the engine itself become a flight here. ``detail`` is
    "light" (no matrix), "default" or "full" (exact W and U of every scan). The number of a scan is its place on the timeline.
    """

    def __init__(
        self, path: str | os.PathLike[str], engine: Engine | None = None, *, name: str | None = None, detail: str | None = None
    ) -> None:
        self.path = Path(path)
        self._engine = checked_engine(engine)
        self._native = _native.Recorder(self.path, self._engine._native, name or self.path.stem, detail)
        self._engine._recorders(1)
        self._open = True

    def log(self, result: Result) -> None:
        """Adds the next scan of the flight."""
        if not isinstance(result, Result):
            raise TypeError(f"what is recorded is a crosscut.Result, not {result!r}")
        if result._kept is None:
            raise TypeError("a copy of a result cannot be recorded; record the result itself")
        self._native.log(result._kept)

    def close(self) -> None:
        """Ends the file. It can be read before, up to its last 10 s."""
        if self._open:
            self._open = False
            self._engine._recorders(-1)
        self._native.close()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _ipython_display_(self) -> None:
        """In a notebook, the recording up to here; needs rerun-sdk with its extra ``notebook``."""
        show(self.path)


def show(path: str | os.PathLike[str]) -> None:
    """Shows a recording in a notebook, with its pages; needs rerun-sdk with its extra ``notebook``."""
    from ._extras import importing

    with importing("show()"):
        from rerun.notebook import Viewer

    viewer = Viewer()
    viewer._flush_hook(Path(path).read_bytes())
    viewer.display()

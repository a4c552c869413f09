"""Scans over several threads, in order."""

from __future__ import annotations

import atexit
import ctypes
import itertools
import os
import queue
import threading
import weakref
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from . import _native
from ._errors import Error
from ._native import Scan
from ._results import Result

BATCH = 16
"""Scans that a thread takes at a time: a scan takes less time than a switch between threads of Python."""

LONGEST_STAGE_S = 5.0
"""A thread whose stage does not return for longer is left to itself; it ends with the process."""

AHEAD = 2
"""Batches that a thread has before it."""


class _Worker:
    """A thread with an engine of its own. It ends with the process, even if a stage of one's own never returns."""

    def __init__(self, engine: _native.Engine) -> None:
        self.batches: queue.SimpleQueue[tuple[list[Scan], int] | None] = queue.SimpleQueue()
        self.done: queue.SimpleQueue[tuple[list[Result], BaseException | None]] = queue.SimpleQueue()
        self.engine = engine
        self.process_id = os.getpid()
        _workers.add(self)
        self.thread = threading.Thread(target=self._run, name="crosscut", daemon=True)
        self.thread.start()

    def _run(self) -> None:
        try:
            self._work()
        except SystemExit:  # see interrupt
            pass

    def _work(self) -> None:
        while (batch := self.batches.get()) is not None:
            try:
                done = self.engine.process_batch(*batch)
            except BaseException as error:  # the caller raises it
                done = ([], error)
            self.done.put(done)

    def interrupt(self) -> None:
        """Ends the thread after its current scan, and a stage of one's own that is running there at once; of a forked process there is none."""
        if self.process_id != os.getpid():
            return
        self.engine.stop()
        thread = ctypes.c_ulong(self.thread.ident or 0)
        ctypes.pythonapi.PyThreadState_SetAsyncExc(thread, ctypes.py_object(SystemExit))


_workers: weakref.WeakSet[_Worker] = weakref.WeakSet()
"""Those whose results nobody has read to their end."""


def _end(workers: Iterable[_Worker]) -> None:
    """Waits for the threads of this process: one that comes back from native code while the interpreter is taken down would abort it."""
    of_this_process = [worker for worker in workers if worker.process_id == os.getpid()]
    for worker in of_this_process:
        worker.batches.put(None)
    for worker in of_this_process:
        worker.thread.join(LONGEST_STAGE_S)
        _workers.discard(worker)


@atexit.register
def _end_all() -> None:
    """Ends what a script that is over has left unread."""
    for worker in list(_workers):
        worker.interrupt()
    _end(list(_workers))


def process(make: Callable[[], _native.Engine], most: int, scans: Iterable[Scan]) -> Iterator[Result]:
    """The results of ``scans`` in order, by at most this many threads; batch i goes to thread i mod N."""
    source = iter(scans)
    process_id = os.getpid()
    workers: list[_Worker] = []
    waiting: deque[_Worker] = deque()
    seq = 0
    failed_source: BaseException | None = None
    ended = False
    try:
        while True:
            while not ended and len(waiting) < AHEAD * most:
                batch, failed_source = _take(source)
                ended = len(batch) < BATCH
                if batch:
                    if len(workers) < most:
                        workers.append(_Worker(make()))
                    following = workers[(seq // BATCH) % most]
                    following.batches.put((batch, seq))
                    waiting.append(following)
                    seq += len(batch)
            if not waiting:
                break
            results, error = waiting.popleft().done.get()
            for result in results:
                yield result
                if os.getpid() != process_id:
                    raise Error("process_many() was begun before this process was forked, and its threads are not in it; begin anew here")
            if error is not None:
                raise error
    except BaseException:
        for worker in workers:
            worker.interrupt()
        raise
    finally:
        _end(workers)
    if failed_source is not None:
        raise failed_source


def _take(source: Iterator[Any]) -> tuple[list[Scan], BaseException | None]:
    """The next batch, and the error of the source after it; what came before an error is worked on."""
    batch: list[Scan] = []
    try:
        for scan in itertools.islice(source, BATCH):
            batch.append(scan)
    except Exception as error:
        return batch, error
    return batch, None

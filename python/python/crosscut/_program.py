"""Commands of the program, on whole recordings. Each runs in a process of its own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from . import __main__, _named, _native
from ._engine import STAGES, Section, setting_changes, toml
from ._errors import Error, LossWarning, ReadError, SettingsError

StrPath: TypeAlias = "str | os.PathLike[str]"

DONE, FAILED, WRONG_USAGE, SOMETHING_LOST, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit codes."""

COMMAND = (sys.executable, *(["-P"] if sys.version_info >= (3, 11) else []), "-m", "crosscut")
"""The program in this environment. ``-P``: no module of the current folder, which may hold data, stands for an installed one."""


def run(
    flight: StrPath | Iterable[StrPath],
    *,
    results: StrPath | None = None,
    map: StrPath | None = None,
    save: StrPath | None = None,
    preset: str = "default",
    settings: Mapping[str, object] | None = None,
    **sections: Section | Callable[..., Any],
) -> None:
    """Writes the answers for a whole flight into files, as ``crosscut run`` does.

    >>> run("FLIGHT.bag", preset="paper", affinity=my_affinity, save="FLIGHT.rrd", map="FLIGHT.json")

    ``results``: ``FILE.jsonl`` for :func:`results`, or ``FILE.mcap`` with the scans beside them and drawings for Foxglove.
    ``map``: junctions, dead ends and passages as JSON. ``save``: all stages for the Rerun viewer, see :func:`view`. Several
    paths, or a folder, are the parts of one flight. A stage may be any callable, as in :class:`Engine`; it then runs in a fork
    of this process.
    """
    outputs = [part for option, path in (("--out", results), ("--map", map), ("--save", save)) if path is not None
               for part in (option, path)]
    if not outputs:
        raise TypeError("run() writes nothing without results=, map= or save=")
    stages, sections = _own_stages(sections)
    _finish(["run", *_paths(flight), *outputs, *configuration(preset, settings, sections), "--quiet"], stages=stages)


def view(recording: StrPath | Iterable[StrPath], *, layout: str | None = None, beside: StrPath | None = None) -> None:
    """Shows a recording in the Rerun viewer with the pages of crosscut, until the viewer is closed; needs rerun-sdk.

    ``layout`` is the page that it opens with: "overview", "stages", "map" or "speed". ``beside``: another recording.
    """
    options = [part for option, value in (("--layout", layout), ("--beside", beside)) if value is not None
               for part in (option, value)]
    _finish(["view", *_paths(recording), *options])


def report(
    flight: StrPath | Iterable[StrPath],
    out: StrPath,
    *,
    preset: str = "default",
    settings: Mapping[str, object] | None = None,
    **sections: Section | Callable[..., Any],
) -> Path:
    """Writes one self-contained HTML page on a flight: counts over time, junctions, map, settings. Returns its path. A stage
    may be any callable, as in :func:`run`.
    """
    stages, sections = _own_stages(sections)
    _finish(["report", *_paths(flight), "--out", out, *configuration(preset, settings, sections), "--quiet"], stages=stages)
    return Path(out)


def compare(
    flights: StrPath | Iterable[StrPath],
    configurations: Sequence[str] | Mapping[str, str | Mapping[str, Any]] = ("default",),
    *,
    grid: Mapping[str, Sequence[object]] | None = None,
    csv: StrPath | None = None,
    settings: Mapping[str, object] | None = None,
) -> dict[str, Any]:
    """Several configurations on flights, each file one, as ``crosscut compare --json`` has it: what the others mend and break
    against the first where there is a truth (``verdicts``, ``all``, ``families``), and where they differ (``comparisons``).

    >>> compare("FLIGHT.mcap", {"paper": "paper", "mine": {"preset": "paper", "affinity": my_affinity}})
    >>> compare("flights/", ["paper"], grid={"affinity.sigma_per_m2": [0.5, 1.5]}, csv="sigma.csv")

    A configuration is a text as after ``--with``, or a mapping with the arguments of :class:`Engine`, in which a stage may be any
    callable, as in :func:`run`. ``grid``: each configuration with every combination of these values. ``csv``: a file for a row of
    figures for each flight and configuration. ``settings`` hold for all.
    """
    options, stages = compared(configurations, grid, settings)
    with tempfile.TemporaryDirectory() as folder:
        document = Path(folder, "compared.json")
        outputs = ["--json", document, *([] if csv is None else ["--csv", csv])]
        _finish(["compare", *_paths(flights), *options, *outputs, "--quiet"], stages=stages)
        found: dict[str, Any] = json.loads(document.read_text())
    return found


def compared(
    configurations: Sequence[str] | Mapping[str, str | Mapping[str, Any]],
    grid: Mapping[str, Sequence[object]] | None,
    settings: Mapping[str, object] | None,
) -> tuple[list[str], dict[str, Callable[..., Any]]]:
    """The options of ``crosscut compare`` that choose these configurations, and the callables among their stages."""
    if isinstance(configurations, str) or not isinstance(configurations, (Sequence, Mapping)):
        raise TypeError(f"configurations are texts, or a mapping of names to them, not {configurations!r}")
    if grid is not None and not isinstance(grid, Mapping):
        raise TypeError(f"grid is a mapping of settings to lists of values, not {grid!r}")
    stages: dict[str, Callable[..., Any]] = {}
    texts = []
    for name in configurations:
        of = configurations[name] if isinstance(configurations, Mapping) else None
        if isinstance(of, Mapping):
            own, sections = _own_stages({key: value for key, value in of.items() if key != "preset"})
            stages |= own
            of = ",".join([of.get("preset", "default"), *setting_changes(None, sections)])
        texts.append(name if of is None else f"{name}={of}")
    options = [part for text in texts for part in ("--with", text)]
    options += [part for key, values in (grid or {}).items() for part in ("--grid", f"{key}={','.join(map(_value, values))}")]
    return options + configuration("default", settings, {}), stages


def _own_stages(sections: Mapping[str, Any]) -> tuple[dict[str, Callable[..., Any]], dict[str, Any]]:
    """The callables among the stages by the names of their kinds, and the sections with these names."""
    stages = {}
    sections = dict(sections)
    for section in STAGES:
        function = sections.get(section)
        if callable(function):
            module = getattr(function, "__module__", None) or "__main__"
            name = getattr(function, "__qualname__", None) or type(function).__qualname__
            sections[section] = f"python:{module}.{name}"
            stages[sections[section]] = function
    return stages, sections


class _Fork:
    """The program in a fork of this process, where stages of one's own are what they are here."""

    def __init__(self, arguments: Sequence[StrPath], stages: dict[str, Callable[..., Any]]) -> None:
        if not hasattr(os, "fork"):
            raise Error("this system cannot fork a process; give the stage by its name: affinity='python:module.name'")
        reading, writing = os.pipe()
        sys.stdout.flush()
        sys.stderr.flush()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # other threads are not in the fork, which needs none of them
            self._id = os.fork()
        if self._id == 0:
            code = FAILED
            try:
                os.setsid()
                os.dup2(writing, 2)
                os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
                signal.signal(signal.SIGINT, signal.SIG_DFL)
                command = ["crosscut", *(os.fspath(argument) for argument in arguments)]
                code = _native.program(command, stages, __main__.hear, _named.find_again)
            finally:
                os._exit(code)
        os.close(writing)
        self.stderr = open(reading, errors="replace")
        self.returncode: int | None = None

    def wait(self) -> None:
        self.returncode = os.waitstatus_to_exitcode(os.waitpid(self._id, 0)[1])

    def send_signal(self, number: int) -> None:
        os.kill(self._id, number)

    def __enter__(self) -> _Fork:
        return self

    def __exit__(self, *_: object) -> None:
        self.stderr.close()


def _finish(
    arguments: Sequence[StrPath], command: Sequence[str] = COMMAND, stages: dict[str, Callable[..., Any]] | None = None
) -> None:
    """Runs a command to its end; what it says becomes an exception or warnings."""
    # In a session of its own, an interrupt from the terminal reaches it once, from here.
    with _Fork(arguments, stages) if stages else subprocess.Popen(
        [*command, *arguments], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, start_new_session=True
    ) as process:
        assert process.stderr is not None
        said, interrupted = "", False
        while process.returncode is None:
            try:
                said += process.stderr.read()
                process.wait()
            except KeyboardInterrupt:
                process.send_signal(signal.SIGINT)  # it saves what it has; at the second one it quits at once
                interrupted = True
    if interrupted:
        raise KeyboardInterrupt
    lines = said.splitlines()
    if process.returncode == SOMETHING_LOST:
        for line in lines:
            warnings.warn(line, LossWarning, stacklevel=3)
    elif process.returncode == INTERRUPTED:
        raise KeyboardInterrupt
    elif process.returncode != DONE:
        raise failure(process.returncode, said)


def failure(code: int, said: str) -> Error:
    """The exception for an exit code and what was written to standard error."""
    errors = [line.removeprefix("error: ") for line in said.splitlines() if line.startswith("error: ")]
    text = "\n".join(errors) or said.strip() or f"crosscut ended with code {code}"
    return {FAILED: ReadError, WRONG_USAGE: SettingsError}.get(code, Error)(text)


def _paths(paths: StrPath | Iterable[StrPath]) -> list[StrPath]:
    return [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)


def configuration(preset: str, settings: Mapping[str, object] | None, sections: Mapping[str, Any]) -> list[str]:
    chosen = [] if preset == "default" else ["--preset", preset]
    return chosen + [part for change in setting_changes(settings, sections) for part in ("--set", change)]


def _value(value: object) -> str:
    return value if isinstance(value, str) else toml(value)

"""Stages on several hosts: each a node of a dora dataflow, frames as Arrow between them; needs dora-rs-cli, dora-rs, pyarrow.

    crosscut-dora dataflow FLIGHT.mcap --results FLIGHT.jsonl > flow.yml
    dora run flow.yml

The results are the bytes that ``crosscut run`` writes. Nothing is lost, and all is in order, also when a stage is killed:
the source keeps the frames that the last node has not acknowledged and sends them again (``_window.py``). The stages
hold no state; the source and the last node, which holds the flight, do: where one of them is lost, the dataflow starts again.

A stage of one's own, in any language, has an input and an output ``frames``. It passes on the metadata of each message, adds
its columns to each struct array (``_frames.py``), and passes on unchanged any other array.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import os
import re
import shlex
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ._engine import Engine, Recording
from ._errors import Error, SettingsError

STAGES = ("affinity", "spectral", "kmeans")
NODES = ("source", *STAGES, "record", "report")

PROGRAM = "crosscut-dora"
"""As the hosts find it, on their PATH."""

WINDOW = 32
"""Messages on the way."""

STALL_S = 5.0
"""After so long without an acknowledgement, that is reported."""

STAGE_IN_PYTHON = re.compile(rf"({'|'.join(STAGES)})\.kind=python:([\w.]+)\.(\w+)")

DONE, FAILED, WRONG_USAGE, SOMETHING_LOST = 0, 1, 2, 3


def main() -> int:
    """``crosscut-dora``; returns its exit code."""
    args = _parser().parse_args()
    if args.command == "dataflow":
        return _write_dataflow(args)
    try:
        from dora import Node
    except ImportError:
        print("error: dora needs packages: pip install 'crosscut[dora]'", file=sys.stderr)
        return WRONG_USAGE
    try:
        engine = _engine(args)
        node = Node()
        if args.node == "source":
            return _source(node, engine, args)
        if args.node == "report":
            return _report(node, engine, args)
        if args.node == "record":
            return _record(node, engine, args.recording)
        return _stage(node, engine, args.node, args.recorded)
    except ImportError as error:
        print(f"error: {error}; pip install 'crosscut[view]' for a recording", file=sys.stderr)
        return WRONG_USAGE
    except (Error, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return WRONG_USAGE if isinstance(error, ValueError) else FAILED


def _engine(args: argparse.Namespace) -> Engine:
    """The engine of these settings; ``STAGE.kind=python:module.name`` is a callable, which this node alone has."""
    from .__main__ import _find

    changes: list[str] = []
    stages: dict[str, Callable[..., Any]] = {}
    for change in args.changes:
        if named := STAGE_IN_PYTHON.fullmatch(change):
            stage, module, name = named.groups()
            if stage == args.node:
                try:
                    stages[stage] = _find(module, name)
                except (ImportError, AttributeError, TypeError) as error:
                    raise SettingsError(f"there is no stage python:{module}.{name}: {error}") from error
        else:
            changes.append(change)
    return Engine.with_changes(args.preset, changes, **stages)


# The nodes.


def _source(node: Any, engine: Engine, args: argparse.Namespace) -> int:
    """Sends the scans of a recording as frames, as fast as they are acknowledged."""
    import pyarrow as pa

    from . import _frames
    from ._window import Window

    def send(number: int, transmission: int, message: tuple[Any, dict[str, Any]]) -> None:
        value, about = message
        node.send_output("frames", value, {"number": number, "transmission": transmission, **about})

    def messages() -> Iterator[tuple[Any, dict[str, Any]]]:
        recording = engine.read(args.flight, args.topic or None, from_s=args.from_s, to_s=args.to_s, every=args.every)
        about, first = {"ended": True, "failed": ""}, 0
        while True:
            scans = []
            try:
                for scan in itertools.islice(_quiet(recording), args.batch):
                    scans.append(scan)
            except Error as error:  # what was read before it counts
                about["failed"] = str(error)
            if scans:
                yield _frames.of_scans(engine._native, scans, first), {"ended": False, "failed": ""}
                first += len(scans)
            if len(scans) < args.batch:
                break
        yield pa.array(recording.losses, pa.string()), about

    window: Window[tuple[Any, dict[str, Any]]] = Window(send, args.window)
    waiting, stalled, lost = messages(), False, 0
    ended = False
    while not ended or len(window):
        while not ended and window.has_room:
            value, about = next(waiting)
            ended = about["ended"]
            lost = len(value) if ended else 0
            window.add((value, about))
        event = _next(node, window.patience_s)
        if event is None:
            window.repeat()
        elif event["type"] == "STOP":
            raise Error("the dataflow was stopped before its end")
        elif event["type"] == "INPUT":
            about = event["metadata"]
            window.acknowledge(about["number"], about["transmission"])
            if about["failed"]:
                return FAILED  # the last node has said why
        if stalled != (window.silent_s > STALL_S):
            stalled = not stalled
            what = f"no frame has arrived for {STALL_S:.0f} s: is a stage or a daemon down?" if stalled else "frames arrive again"
            print(f"warning: {what}", file=sys.stderr, flush=True)
    print(f"{window.resent} messages sent again", file=sys.stderr)
    return SOMETHING_LOST if lost else DONE


def _stage(node: Any, engine: Engine, stage: str, recorded: bool) -> int:
    """Runs one stage on all frames that come."""
    from . import _frames

    for event in _inputs(node):
        value, about = event["value"], event["metadata"]
        if not about["ended"] and not about["failed"]:
            try:
                value = _frames.after(stage, engine._native, value, recorded=recorded)
            except (ValueError, KeyError) as error:  # of a stage of another's
                about["failed"] = f"{stage}: {error}"
        node.send_output("frames", value, _own(about))
    return DONE


def _record(node: Any, engine: Engine, path: Path) -> int:
    """Records the frames for the viewer, each once, and passes on what the report reads."""
    from . import _frames
    from ._record import Recording
    from ._window import Order

    order = Order[Any]()
    with Recording(path, engine._native) as recording:
        for event in _inputs(node):
            value, about = event["value"], event["metadata"]
            for frames, is_end in order.take(about["number"], (value, about["ended"] or bool(about["failed"]))):
                try:
                    recording.close() if is_end else recording.add(frames)
                except (ValueError, KeyError) as error:  # of a stage of another's
                    about["failed"] = f"record: {error}"
            if not about["ended"] and not about["failed"]:
                value = _frames.without({**_frames.W, **_frames.U}, value)
            node.send_output("frames", value, _own(about))
    return DONE


def _report(node: Any, engine: Engine, args: argparse.Namespace) -> int:
    """The last node: the report and the flight, in order, and the files."""
    import pyarrow as pa

    from . import _frames
    from ._window import Order

    flight, order, frames, outcome = engine._native.flight_map(), Order[Any](), 0, None
    with contextlib.ExitStack() as opened:
        results = opened.enter_context(_whole(args.results)) if args.results else None
        for event in _inputs(node):
            about = event["metadata"]
            for value, ended, failed in order.take(about["number"], (event["value"], about["ended"], about["failed"])):
                if outcome is not None:
                    continue
                if not failed and not ended:
                    try:
                        lines, failed = engine._native.report(_frames.columns(value), flight)
                    except (ValueError, KeyError) as error:  # of a stage of another's
                        lines, failed = b"", f"report: {error}"
                    frames += lines.count(b"\n")
                    if results is not None:
                        results.write(lines)
                        results.flush()
                if failed or ended:
                    opened.close()
                    if args.map:
                        with _whole(args.map) as file:
                            file.write(flight.json().encode() + b"\n")
                    outcome = _told(frames, flight, failed, value.to_pylist() if ended else [])
            failure = outcome == FAILED
            node.send_output("acks", pa.array([], pa.null()), {**_own(about), "failed": "see the last node" if failure else ""})
        if outcome is None:
            raise Error("the dataflow was stopped before its end")
    return outcome


def _told(frames: int, flight: Any, failed: str | None, losses: list[str]) -> int:
    """Says how the flight ended; returns the exit code."""
    for loss in losses:
        print(f"warning: {loss}", file=sys.stderr)
    if failed:
        print(f"error: {failed}; saved before it: {frames} revolutions", file=sys.stderr, flush=True)
        return FAILED
    print(f"{frames} revolutions; {flight.summary()}", file=sys.stderr, flush=True)
    return SOMETHING_LOST if losses else DONE


@contextlib.contextmanager
def _whole(path: Path) -> Iterator[Any]:
    """A file that is there once it is whole, under another name before."""
    unfinished = path.with_name(f".{path.name}.unfinished")
    with unfinished.open("wb") as file:
        yield file
    unfinished.replace(path)


def _inputs(node: Any) -> Iterator[dict[str, Any]]:
    for event in node:
        if event["type"] == "INPUT":
            yield event
        elif event["type"] == "STOP":
            return


def _next(node: Any, patience_s: float) -> dict[str, Any] | None:
    """The next event; None if there is none for so long."""
    event: dict[str, Any] | None = node.next(timeout=max(patience_s, 0.001))
    if event is None:
        return {"type": "STOP"}
    return None if event["type"] == "ERROR" and "imeout" in event["error"] else event


def _own(about: dict[str, Any]) -> dict[str, Any]:
    """The metadata that are ours; dora adds its own."""
    return {name: about[name] for name in ("number", "transmission", "ended", "failed")}


def _quiet(recording: Recording) -> Iterator[Any]:
    """The scans; what was lost is told by the last node."""
    return iter(recording._native)


# The dataflow.


def _write_dataflow(args: argparse.Namespace) -> int:
    import yaml

    try:
        places, own = dict(args.place), dict(args.own)
        flow = {"nodes": list(_nodes(args, places, own))}
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return WRONG_USAGE
    yaml.safe_dump(flow, sys.stdout, sort_keys=False, width=120)
    return DONE


def _nodes(args: argparse.Namespace, places: dict[str, str], own: dict[str, str]) -> Iterator[dict[str, Any]]:
    nodes = [name for name in NODES if name != "record" or args.recording]
    for name in [*places, *own]:
        if name not in (nodes if name in places else STAGES):
            raise ValueError(f"there is no node {name} to place or replace: {', '.join(nodes)}")
    settings = [part for change in args.changes for part in ("--set", change)]
    settings += ["--preset", args.preset] if args.preset != "default" else []
    files: dict[str, list[Any]] = {
        "source": [*(Path(path).absolute() for path in args.flight), "--batch", args.batch, "--window", args.window],
        "report": [part for option, path in (("--results", args.results), ("--map", args.map)) if path
                   for part in (option, path.absolute())],
    }
    if args.recording:
        files |= {stage: ["--recorded"] for stage in STAGES} | {"record": [args.recording.absolute()]}
    for option, value in (("--from", args.from_s), ("--to", args.to_s)):
        files["source"] += [] if value is None else [option, value]
    files["source"] += [part for topic in args.topic for part in ("--topic", topic)]
    files["source"] += [] if args.every == 1 else ["--every", args.every]
    for before, name in zip((None, *nodes), nodes):
        arguments = shlex.join(map(str, ["node", name, *files.get(name, []), *settings]))
        node: dict[str, Any] = {"id": name, "path": PROGRAM, "args": arguments}
        if name in own:
            program, *rest = shlex.split(own[name])
            node["path"] = program
            node["args"] = shlex.join(rest)
        # Each message that is sent again is one more on the way.
        queue = 2 * args.window
        if before is None:
            node["inputs"] = {"acks": {"source": "report/acks", "queue_size": queue}}
        else:
            node["inputs"] = {"frames": {"source": f"{before}/frames", "queue_size": queue}}
        node["outputs"] = ["acks" if name == NODES[-1] else "frames"]
        if name in STAGES:
            node["restart_policy"] = "on-failure"
        if name in places:
            node["deploy"] = {"machine": places[name]}
        yield node


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=PROGRAM, description="Stages on several hosts, as nodes of a dora dataflow.")
    commands = parser.add_subparsers(dest="command", required=True)
    dataflow = commands.add_parser("dataflow", help="write the dataflow of a flight to standard output, as YAML")
    _add_source(dataflow)
    _add_report(dataflow)
    dataflow.add_argument("--record", type=Path, metavar="FLIGHT.rrd", dest="recording",
                          help="a recording for the Rerun viewer, also of stages of your own; needs crosscut[view]")
    dataflow.add_argument("--place", action="append", default=[], type=_pair, metavar="NODE=MACHINE",
                          help=f"run a node on a machine; nodes are {', '.join(NODES)}")
    dataflow.add_argument("--own", action="append", default=[], type=_pair, metavar="STAGE=COMMAND",
                          help="a program or Python script that takes the place of a stage")
    _add_settings(dataflow)
    nodes = commands.add_parser("node", help="run one node; dora does").add_subparsers(dest="node", required=True)
    for name in NODES:
        node = nodes.add_parser(name)
        if name == "source":
            _add_source(node)
        elif name == "report":
            _add_report(node)
        elif name == "record":
            node.add_argument("recording", type=Path)
        else:
            node.add_argument("--recorded", action="store_true", help="pass on W and U for a recording")
        _add_settings(node)
    return parser


def _add_source(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("flight", nargs="+", help="recordings, the parts of one flight")
    parser.add_argument("--topic", action="append", default=[], help="of the scans; several are the scanners of one vehicle")
    parser.add_argument("--from", dest="from_s", type=float, metavar="SECONDS")
    parser.add_argument("--to", dest="to_s", type=float, metavar="SECONDS")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="take every Nth scan")
    parser.add_argument("--batch", type=_count, default=1, metavar="N", help="frames in a message [default: 1]")
    parser.add_argument("--window", type=_count, default=WINDOW, metavar="N",
                        help=f"messages on the way, which bounds the memory [default: {WINDOW}]")


def _add_report(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--results", type=Path, metavar="FILE.jsonl", help="one JSON object for each scan")
    parser.add_argument("--map", type=Path, metavar="FLIGHT.json", help="the map of the flight")


def _add_settings(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--preset", default="default")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="changes")


def _count(text: str) -> int:
    if (count := int(text)) < 1:
        raise ValueError
    return count


def _pair(text: str) -> tuple[str, str]:
    name, _, value = text.partition("=")
    if not value:
        raise argparse.ArgumentTypeError(f"{text} is not NAME=VALUE")
    return name, value


if __name__ == "__main__":
    sys.exit(main())

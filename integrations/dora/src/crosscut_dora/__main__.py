"""Stages on several hosts: each a node of a dora dataflow, frames as Arrow between them.

    crosscut-dora dataflow FLIGHT.mcap --results FLIGHT.jsonl > flow.yml
    dora run flow.yml

The results are the bytes that ``crosscut run`` writes. Nothing is lost, and all is in order, also when a stage is killed:
the source keeps the frames that the last node has not acknowledged and sends them again (``window.py``). The stages
hold no state; the source and the last node, which holds the flight, do: where one of them is lost, the dataflow starts again.

A stage of one's own, in any language, has an input and an output ``frames``. It passes on the metadata of each message, adds
its columns to each struct array (``arrow.py``), and passes on unchanged any other array.
"""

from __future__ import annotations

import argparse
import importlib
import os
import re
import shlex
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from crosscut import Engine, Error, LossWarning, SettingsError

STAGES = ("affinity", "spectral", "kmeans")
NODES = ("source", *STAGES, "record", "report")

PROGRAM = "crosscut-dora"
"""As the hosts find it, on their PATH."""

WINDOW = 32
"""Messages on the way."""

STAGE_IN_PYTHON = re.compile(rf"({'|'.join(STAGES)})\.kind=python:([\w.]+)\.(\w+)")

DONE, FAILED, WRONG_USAGE = 0, 1, 2


def main() -> int:
    """``crosscut-dora``; returns its exit code."""
    args = _parser().parse_args()
    if args.command == "dataflow":
        return _write_dataflow(args)
    from dora import Node

    from . import nodes

    warnings.simplefilter("ignore", LossWarning)  # the last node reports what was lost
    try:
        engine = _engine(args)
        node = Node()
        if args.node == "source":
            return nodes.source(node, engine, args)
        if args.node == "report":
            return nodes.report(node, engine, args)
        if args.node == "record":
            return nodes.record(node, engine, args.recording)
        return nodes.stage(node, engine, args.node, args.recorded)
    except (Error, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return WRONG_USAGE if isinstance(error, ValueError) else FAILED


def _engine(args: argparse.Namespace) -> Engine:
    """The engine of these settings; ``STAGE.kind=python:module.name`` is a callable, which this node alone has."""
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
    if args.node == "report" and args.own_stage:
        stages["affinity"] = _elsewhere
    return Engine.with_changes(args.preset, changes, **stages)


def _elsewhere(_: Any) -> Any:
    """In the place of a stage that another node has: for the report, what matters is that nothing was calibrated for it."""
    raise NotImplementedError


def _find(module: str, name: str) -> Callable[..., Any]:
    """The callable; modules are found from the current folder, after those that are installed."""
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    found = getattr(importlib.import_module(module), name)
    if not callable(found):
        raise TypeError("it is not callable")
    made: Callable[..., Any] = found
    return made


def _write_dataflow(args: argparse.Namespace) -> int:
    import yaml

    try:
        places, own = dict(args.place), dict(args.own)
        flow = {"nodes": list(_graph(args, places, own))}
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return WRONG_USAGE
    yaml.safe_dump(flow, sys.stdout, sort_keys=False, width=120)
    return DONE


def _graph(args: argparse.Namespace, places: dict[str, str], own: dict[str, str]) -> Iterator[dict[str, Any]]:
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
    if own or any(STAGE_IN_PYTHON.fullmatch(change) for change in args.changes):
        files["report"].append("--own-stage")
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
                          help="a recording for the Rerun viewer, also of stages of your own")
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
            node.add_argument("--own-stage", action="store_true", help="no confidence was calibrated for one of the stages")
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

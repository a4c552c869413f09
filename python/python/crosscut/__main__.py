"""The command line: ``crosscut ...``, or ``python -m crosscut ...``."""

from __future__ import annotations

import contextlib
import signal
import sys
from collections.abc import Callable
from typing import Any

from . import _named, _native


def main() -> int:
    """Runs the command in the arguments of this process and returns its exit code.

    ``--set affinity.kind=python:module.name`` takes a callable of one's own; modules are found in the current folder, too. A
    file of settings may name a callable that the command line names as well: code comes from the command line alone, and from
    what is typed at the prompt of ``debug``.
    """
    if sys.argv[1:2] in (["run"], ["compare"]) and "--on" in sys.argv:
        at = sys.argv.index("--on")
        where, arguments = sys.argv[at + 1 : at + 2], sys.argv[2:at] + sys.argv[at + 2 :]
        if where != ["ray"]:
            print("error: --on takes ray", file=sys.stderr)
            return 2
        from . import ray

        return ray.main(sys.argv[1], arguments)
    sys.stdout.flush()
    with contextlib.redirect_stdout(sys.stderr):  # what stages print is none of the results of the program
        return _program()


def _program() -> int:
    stages: dict[str, Callable[..., Any]] = {}
    for module, name in _named.named(sys.argv[1:]):
        try:
            stages[f"python:{module}.{name}"] = _named.find(module, name)
        except Exception as error:
            text = f"error: there is no stage python:{module}.{name}: {type(error).__name__}: {error}"
            print(text, file=sys.stderr)
            return 2
    # As in the program: its own handler where there is one, else the process ends.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.program(["crosscut", *sys.argv[1:]], stages, hear, _named.find_again)


def hear(address: str, options: dict[str, Any], feed: Any) -> Any:
    """Hears a live robot for the program."""
    from . import live

    return live.Source(address, options, feed)


if __name__ == "__main__":
    sys.exit(main())

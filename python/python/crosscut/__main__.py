"""The command line: ``crosscut ...``, or ``python -m crosscut ...``."""

from __future__ import annotations

import importlib
import os
import re
import signal
import sys
from collections.abc import Callable
from typing import Any

from . import _native

_NAMED = re.compile(r"\b(affinity|spectral|kmeans)\.kind\s*=\s*[\"']?(python:([\w.]+)\.(\w+))")


def main() -> int:
    """Runs the command in the arguments of this process and returns its exit code.

    ``--set affinity.kind=python:module.name`` takes a callable of one's own; modules are found from the current folder.
    """
    stages: dict[str, tuple[str, str, Callable[..., Any]]] = {}
    for section, kind, module, name in _NAMED.findall("\n".join(sys.argv[1:])):
        try:
            stages[section + kind] = (section, kind, _find(module, name))
        except Exception as error:
            print(f"error: there is no {section}.kind = {kind!r}: {type(error).__name__}: {error}", file=sys.stderr)
            return 2
    # As in the program: its own handler where there is one, else the process ends.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.stdout.flush()
    return _native.program(["crosscut", *sys.argv[1:]], list(stages.values()))


def _find(module: str, name: str) -> Callable[..., Any]:
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    found = getattr(importlib.import_module(module), name)
    if not callable(found):
        raise TypeError("it is not callable")
    return found  # type: ignore[no-any-return]


if __name__ == "__main__":
    sys.exit(main())

"""Stages of one's own by name: ``python:module.name``."""

from __future__ import annotations

import hashlib
import importlib
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from . import _native

_NAMED = re.compile(r"python:([\w.]+)\.(\w+)")
_OPTIONS = ("--set", "--with", "--grid")
"""The options that choose a kind."""


def named(arguments: Iterable[str]) -> list[tuple[str, str]]:
    """Module and name of each callable that the settings among the arguments of a command name.

    Only these are imported: a file of settings, or the name of a recording, comes with data and runs no code.
    """
    found = (_NAMED.fullmatch(value.strip("\"' ")) for value in _values(arguments))
    return sorted({(named[1], named[2]) for named in found if named})


def _values(arguments: Iterable[str]) -> Iterator[str]:
    """The values in ``--set KEY=VALUE``, ``--with PRESET,KEY=VALUE`` and ``--grid KEY=VALUE,VALUE``."""
    option = ""
    for argument in arguments:
        if argument.startswith("--"):
            option, _, argument = argument.partition("=")
        if option in _OPTIONS and argument:
            for part in argument.split(","):
                key, _, value = part.rpartition("=")
                if key or option == "--grid":
                    yield value
            option = ""


_loaded: dict[str, tuple[bytes, int]] = {}
"""Of each module its text when it was loaded last, and how often that was another one."""


def find(module: str, name: str) -> Callable[..., Any]:
    """The callable; modules are found in the current folder, too, after those that are installed."""
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    found = getattr(importlib.import_module(module), name)
    _loaded.setdefault(module, (_text(module), 0))
    if not callable(found):
        raise TypeError("it is not callable")
    return found


def find_again(kind: str) -> tuple[Callable[..., Any], int]:
    """The callable of ``python:module.name``, and how often the text of its module has changed. The module is loaded once more if
    its text is another one than before; what it imports is not. Callables of the module before stay as they were."""
    named = _NAMED.fullmatch(kind)
    if not named:
        raise ValueError("a stage of one's own is python:module.name")
    module, name = named[1], named[2]
    found = find(module, name)
    before, changes = _loaded[module]
    text = _text(module)
    if text != before:
        module_before = sys.modules.pop(module)
        try:
            found = find(module, name)
        except BaseException:
            sys.modules[module] = module_before
            raise
        _loaded[module] = (text, changes + 1)
    return found, _loaded[module][1]


def _text(module: str) -> bytes:
    path = getattr(sys.modules[module], "__file__", None)
    return Path(path).read_bytes() if path is not None else b""


def build(arguments: Iterable[str], *programs: str | None) -> str:
    """Identifies the code that the answers of a command depend on: this package, these programs and the modules of the stages
    that the arguments name, but not what those modules import."""
    digest = hashlib.sha256()
    for path in (_native.__file__, *programs, *(_source(module) for module, _ in named(arguments))):
        digest.update(hashlib.sha256(Path(path).read_bytes() if path is not None else b"").digest())
    return digest.hexdigest()


def _source(module: str) -> str | None:
    """The file of a module; it is not imported."""
    relative = module.replace(".", "/")
    paths = [Path(folder, relative + ending) for folder in (*sys.path, os.getcwd()) for ending in (".py", "/__init__.py")]
    return next((str(path) for path in paths if path.is_file()), None)

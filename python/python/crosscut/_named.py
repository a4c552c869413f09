"""Stages of one's own by name: ``python:module.name``."""

from __future__ import annotations

import hashlib
import importlib
import os
import re
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from . import _native

_NAMED = re.compile(r"\bpython:([\w.]+)\.(\w+)")
_TEXT_OR_COMMENT = re.compile(r"""("(?:[^"\\\n]|\\.)*"|'[^'\n]*')|#.*""")


def named(arguments: Iterable[str]) -> list[tuple[str, str]]:
    """Module and name of each that the arguments of a command name, or the files of settings among them."""
    texts = [text for argument in arguments for text in (argument, *_settings_in(argument))]
    return sorted({found for text in texts for found in _NAMED.findall(text)})


def _settings_in(argument: str) -> list[str]:
    """The files of settings that an argument names, such as ``paper,A.toml`` or ``--config=B.toml``, without comments."""
    parts = [*argument.split(","), *argument.partition("=")[2].split(",")]
    paths = [Path(part) for part in parts if part.endswith(".toml")]
    return [_TEXT_OR_COMMENT.sub(r"\1", path.read_text(errors="replace")) for path in paths if path.is_file()]


def find(module: str, name: str) -> Callable[..., Any]:
    """The callable; modules are found from the current folder."""
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    found = getattr(importlib.import_module(module), name)
    if not callable(found):
        raise TypeError("it is not callable")
    return found


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
    paths = [Path(folder, relative + ending) for folder in (os.getcwd(), *sys.path) for ending in (".py", "/__init__.py")]
    return next((str(path) for path in paths if path.is_file()), None)

"""Prints the page docs/python-reference.md: what the package `crosscut` makes public, with signatures and what is said of it.

Usage: target/python/venv/bin/python lab/python_reference.py > docs/python-reference.md
"""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import re
import sys
from collections.abc import Iterator
from typing import Any

MODULES = ["crosscut", "crosscut.live", "crosscut.ray", "crosscut.sklearn", "crosscut.testing"]
ROLE = re.compile(r":[a-z]+:`~?([^`]+)`")


def text(of: Any) -> str:
    """What is said of something, with the names of other things as code, and tables as they are."""
    said = ROLE.sub(r"`\1`", (inspect.getdoc(of) or "").replace("``", "`"))
    said = re.sub(r"(^={4,}(?:.|\n)*={4,}$)", r"```text\n\1\n```", said, flags=re.MULTILINE)
    return re.sub(r"(^>>> .*(?:\n(?:>>>|\.\.\.) .*|\n[^\n]+)*)", r"```pycon\n\1\n```", said, flags=re.MULTILINE)


def signature(of: Any) -> str:
    try:
        written = re.sub(r"\bself(, )?", "", str(inspect.signature(of)), count=1)
        plain = re.sub(r"ForwardRef\('([^']*)'\)", r"\1", written)
        return re.sub(r"(: |-> )'([^']*)'", r"\1\2", plain).replace(", _kept: _native.Kept | None = None", "").replace(
            sys.executable, "python"
        )
    except ValueError:  # of the native half
        return "(...)"


def public(module: Any) -> list[str]:
    own = [name for name, value in vars(module).items() if getattr(value, "__module__", "") == module.__name__]
    return [name for name in getattr(module, "__all__", own) if not name.startswith("_")]


def members(of: type) -> Iterator[str]:
    """The methods and properties of a class, and the fields of a dataclass. Those of a tuple are in its signature."""
    if dataclasses.is_dataclass(of):
        for field in dataclasses.fields(of):
            if not field.name.startswith("_"):
                yield f"- `{field.name}: {field.type}`"
    for name, value in list(vars(of).items()):
        if name.startswith("_") or name in getattr(of, "__annotations__", {}):
            continue
        said = " ".join(text(getattr(of, name)).split("\n\n")[0].split())
        if callable(value) or isinstance(value, (classmethod, staticmethod)):
            yield f"- `{name}{signature(getattr(of, name))}`: {said}"
        elif said and (isinstance(value, property) or inspect.isdatadescriptor(value)):
            yield f"- `{name}`: {said}"


def page() -> str:
    parts = ["# Python, every name", "`lab/make reference` makes this page from the package; [Python](python.md) shows how it is used."]
    for name in MODULES:
        module = importlib.import_module(name)
        parts.append(f"## `{name}`")
        parts.append(text(module) if name != "crosscut" else "")
        for thing in sorted(public(module)):
            value = getattr(module, thing)
            parts.append(f"### `{name}.{thing}`")
            if inspect.isclass(value) and not issubclass(value, BaseException):
                parts += [f"```python\n{thing}{signature(value)}\n```", text(value), "\n".join(members(value))]
            elif callable(value) and not inspect.isclass(value):
                parts += [f"```python\n{thing}{signature(value)}\n```", text(value)]
            else:
                parts.append(text(value) if inspect.isclass(value) else f"`{value!r}`")
    return "\n\n".join(part for part in parts if part) + "\n"


if __name__ == "__main__":
    print(page(), end="")

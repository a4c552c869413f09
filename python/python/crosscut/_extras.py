"""Packages that single parts of crosscut need; it is installed without them."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

from ._errors import MissingPackageError

EXTRA_AND_PACKAGE = {
    "scipy": ("sparse", "scipy"),
    "pyarrow": ("table", "pyarrow"),
    "sklearn": ("sklearn", "scikit-learn"),
    "networkx": ("map", "networkx"),
    "ray": ("ray", "ray"),
    "zenoh": ("live", "eclipse-zenoh"),
    "cyclonedds": ("dds", "cyclonedds"),
    "rerun": ("view", "rerun-sdk[notebook]"),
}
"""By module: the extra that brings it, and its name for pip."""


@contextlib.contextmanager
def importing(what: str) -> Iterator[None]:
    """Around the imports of such a package, which ``what`` needs: where it is not installed, the error names it."""
    try:
        yield
    except ModuleNotFoundError as error:
        missing = (error.name or "").partition(".")[0]
        if missing not in EXTRA_AND_PACKAGE:
            raise
        extra, package = EXTRA_AND_PACKAGE[missing]
        text = f"{what} needs {package}: pip install {package} (it is in the extra {extra!r} of crosscut)"
        raise MissingPackageError(text, name=error.name) from error


def scipy_sparse() -> Any:
    """The module ``scipy.sparse``."""
    with importing("a sparse matrix"):
        from scipy import sparse
    return sparse

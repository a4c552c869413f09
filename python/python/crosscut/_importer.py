"""``rerun-importer-crosscut``: with it on the PATH the Rerun viewer opens recorded flights with the pages of crosscut."""

from __future__ import annotations

import sys

from . import _named, _native
from .__main__ import hear


def main() -> int:
    return _native.program(["rerun-importer-crosscut", *sys.argv[1:]], {}, hear, _named.find_again)

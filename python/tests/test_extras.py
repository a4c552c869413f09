"""Packages that single parts need: what is missing is named, with the way to install it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

SPARSE = "crosscut.Engine(affinity='threshold', keep=('{}',)).process([[0, 1], [1, 0]])"


@pytest.mark.parametrize(
    ("missing", "use", "said"),
    [
        ("scipy", SPARSE.format("W"), "a sparse matrix needs scipy: pip install scipy (it is in the extra 'sparse' of crosscut)"),
        ("scipy", SPARSE.format("L"), "pip install scipy"),
        ("scipy", "import crosscut.sklearn", "crosscut.sklearn needs scipy: pip install scipy"),
        ("sklearn", "import crosscut.sklearn", "pip install scikit-learn (it is in the extra 'sklearn'"),
        ("pyarrow", "crosscut.results('FLIGHT.jsonl')", "results() needs pyarrow: pip install pyarrow (it is in the extra 'table'"),
        ("pyarrow", "import crosscut.ray; crosscut.ray.run(recordings, 'out')", "crosscut.ray needs pyarrow"),
        ("ray", "import crosscut.ray; crosscut.ray.run(recordings, 'out')", "pip install ray (it is in the extra 'ray'"),
        ("networkx", "crosscut.Flight().map.to_networkx()", "to_networkx() needs networkx: pip install networkx"),
        ("zenoh", "import crosscut.live; crosscut.live.Robot('zenoh://robot/scan')", "zenoh:// needs eclipse-zenoh"),
        ("cyclonedds", "import crosscut.live; crosscut.live.Robot('ros2://0/scan')", "ros2:// needs cyclonedds"),
    ],
)
def test_a_missing_package_is_named_with_its_extra(missing: str, use: str, said: str, tmp_path: Path) -> None:
    script = f"""
import sys
sys.modules[{missing!r}] = None
import crosscut
recordings = {str(ROOT / 'recordings')!r}
try:
    {use}
except crosscut.MissingPackageError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=tmp_path)
    assert said in done.stdout, done


def test_the_page_lists_every_extra() -> None:
    import tomllib

    from crosscut._extras import EXTRA_AND_PACKAGE

    project = tomllib.loads((ROOT / "python" / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    page = (ROOT / "docs" / "python.md").read_text()
    assert all(f"`{extra}`" in page for extra in project)
    for extra, package in EXTRA_AND_PACKAGE.values():
        assert any(requirement.startswith(package) for requirement in project[extra])

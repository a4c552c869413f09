"""The steps of docs/tutorial.md that need the Python package, as a reader follows them."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
from pathlib import Path

from conftest import ROOT, in_wheel


def blocks(page: str, kind: str) -> list[str]:
    return [rest.split("\n```", 1)[0] for rest in page.split(f"```{kind}\n")[1:]]


def test_a_stage_of_python_is_judged_as_the_tutorial_shows(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "tutorial.md").read_text()
    (stage,) = blocks(page, "python")
    (tmp_path / "mine.py").write_text(stage)
    shutil.copy(ROOT / "recordings" / "tee.mcap", tmp_path / "FLIGHT.mcap")
    (simulate,) = [line for line in page.splitlines() if line.startswith("$ crosscut simulate --suite")]
    shown = [[simulate], *(block.splitlines() for block in blocks(page, "text"))]
    assert len(shown) == 3
    path = {"PATH": f"{Path(in_wheel()).parent}{os.pathsep}{os.environ['PATH']}"}
    for command, *expected in shown:
        done = subprocess.run(
            shlex.split(command.removeprefix("$ ")), capture_output=True, text=True, cwd=tmp_path, env=os.environ | path
        )
        assert done.returncode == 0, done.stderr
        printed = [line.split() for line in done.stdout.splitlines()]
        for line in expected:
            assert line == "…" or line.split() in printed, f"{command}: {line}\n{done.stdout}"

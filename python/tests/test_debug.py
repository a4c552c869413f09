"""The prompt of ``crosscut debug`` with stages of one's own."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import in_wheel

MODULE = """
import numpy as np

SIGMA_PER_M2 = {sigma}

def affinity(points):
    between = points[:, None, :] - points[None, :, :]
    return np.exp(-SIGMA_PER_M2 * (between ** 2).sum(axis=2))

def failing(points):
    if len(points) > 300:
        raise ValueError("too many points for me")
    return affinity(points)
"""


class Prompt:
    """A session that is talked to in JSON-RPC."""

    def __init__(self, *args: object, cwd: Path):
        self.process = subprocess.Popen(
            [in_wheel(), "debug", *map(str, args), "--json"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=cwd,
            env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        )  # fmt: skip

    def ask(self, line: str) -> dict[str, Any]:
        assert self.process.stdin is not None and self.process.stdout is not None
        method, *params = line.split()
        self.process.stdin.write(json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}) + "\n")
        self.process.stdin.flush()
        answer: dict[str, Any] = json.loads(self.process.stdout.readline())
        return answer

    def __call__(self, line: str) -> dict[str, Any]:
        """The result of a command."""
        answer = self.ask(line)
        assert "result" in answer, answer
        result: dict[str, Any] = answer["result"]
        return result

    def refusal(self, line: str) -> str:
        answer = self.ask(line)
        assert "error" in answer, answer
        return str(answer["error"]["message"])


@pytest.fixture
def prompt(tee: Path, tmp_path: Path) -> Iterator[Prompt]:
    """On the shipped flight, beside a module with an affinity whose scale is wrong."""
    (tmp_path / "mine.py").write_text(MODULE.format(sigma=15.0))
    prompt = Prompt(tee, "--preset", "paper", cwd=tmp_path)
    yield prompt
    assert prompt.process.stdin is not None
    assert prompt.process.stdout is not None
    prompt.process.stdin.close()
    prompt.process.stdout.close()
    assert prompt.process.wait(timeout=60) == 0


def test_a_foreign_stage_is_debugged_to_the_number_that_is_wrong(prompt: Prompt, tmp_path: Path) -> None:
    prompt("seek 107")
    prompt("hold")
    swapped = prompt("swap affinity=python:mine.affinity")
    assert swapped["walls"] == 14, "the scale is wrong"
    assert prompt("diff")["stage"] == "affinity"
    # Which number? W of both, and the distances between the returns, say.
    prompt(f"get W {tmp_path / 'mine.npy'}")
    prompt(f"get points {tmp_path / 'points.npy'}")
    prompt("unset affinity.kind")
    prompt(f"get W {tmp_path / 'w.npy'}")
    mine, w = (np.load(tmp_path / name)[0, 1:40] for name in ("mine.npy", "w.npy"))
    assert np.log(mine) / np.log(w) == pytest.approx(10.0), "σ is ten times too large"
    # Mended in the editor, and taken again: no session is lost.
    (tmp_path / "mine.py").write_text(MODULE.format(sigma=1.5))
    again = prompt("swap affinity=python:mine.affinity")
    assert again["walls"] == 4
    assert prompt("differs")["differ"] == []
    assert "python:mine.affinity#2" in prompt("settings")["text"], "both can be told apart"


def test_the_code_that_is_held_stays_as_it_was(prompt: Prompt, tmp_path: Path) -> None:
    prompt("swap affinity=python:mine.affinity")
    prompt("seek 107")
    prompt("hold")
    (tmp_path / "mine.py").write_text(MODULE.format(sigma=1.5))
    prompt("swap affinity=python:mine.affinity")
    differ = prompt("differs")["differ"]
    assert 107 in differ and len(differ) > 20, "A is answered by the code that was held"


def test_a_stage_that_raises_leaves_the_prompt_and_says_where(prompt: Prompt) -> None:
    before = prompt("seek 107")["text"]
    failed = prompt("swap affinity=python:mine.failing")
    assert "mine.failing raised ValueError: too many points for me" in failed["text"]
    assert 'mine.py", line 12, in failing' in failed["traceback"] and failed["traceback"] in failed["text"] + "\n"
    assert "without an answer" in prompt("again")["text"]
    assert prompt("unset all")["text"].startswith(before)


@pytest.mark.parametrize("name, says", [("absent.affinity", "No module named 'absent'"), ("mine.absent", "no attribute 'absent'"),
                                        ("mine.SIGMA_PER_M2", "it is not callable"), ("mine", "python:module.name")])
def test_a_stage_that_is_not_there_is_refused(prompt: Prompt, name: str, says: str) -> None:
    before = prompt("show")["text"]
    assert says in prompt.refusal(f"swap affinity=python:{name}")
    assert prompt("show")["text"] == before


def test_a_file_of_settings_runs_no_code(tee: Path, tmp_path: Path) -> None:
    (tmp_path / "evil.py").write_text("open('RUN', 'w')\ndef w(points): ...\n")
    (tmp_path / "settings.toml").write_text('[affinity]\nkind = "python:evil.w"\n')
    done = subprocess.run([in_wheel(), "debug", tee, "--config", "settings.toml"], input="show\n", capture_output=True, text=True,
                          cwd=tmp_path)  # fmt: skip
    assert done.returncode == 2 and "where the command line names it" in done.stderr
    assert not (tmp_path / "RUN").exists()

"""The prompt of ``crosscut debug`` with stages of one's own."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

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
    """A session that is talked to by lines through a pipe."""

    def __init__(self, *args: object, cwd: Path):
        self.process = subprocess.Popen(
            [in_wheel(), "debug", *map(str, args)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, cwd=cwd, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        )  # fmt: skip
        assert self.process.stdout is not None
        self.process.stdout.readline()  # its greeting
        self.refused = False

    def ask(self, line: str) -> str:
        """The answer, up to that of a command that is known to be one line."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(f"{line}\nbreak\n")
        self.process.stdin.flush()
        lines: list[str] = []
        while (answer := self.process.stdout.readline()) != "no break\n":
            if not answer:
                raise RuntimeError(f"the prompt ended: {''.join(lines)}")
            lines.append(answer)
        return "".join(lines)

    def __call__(self, line: str) -> str:
        """The answer to a command."""
        answer = self.ask(line)
        assert not answer.startswith("error: "), answer
        return answer

    def refusal(self, line: str) -> str:
        answer = self.ask(line)
        assert answer.startswith("error: "), answer
        self.refused = True
        return answer


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
    assert prompt.process.wait(timeout=60) == int(prompt.refused)


def test_a_foreign_stage_is_debugged_to_the_number_that_is_wrong(prompt: Prompt, tmp_path: Path) -> None:
    prompt("seek 107")
    prompt("hold")
    assert ": 14 walls, " in prompt("swap affinity=python:mine.affinity"), "the scale is wrong"
    assert prompt("diff").startswith("affinity: ")
    # Which number? W of both, and the distances between the returns, say.
    prompt(f"get W {tmp_path / 'mine.npy'}")
    prompt(f"get points {tmp_path / 'points.npy'}")
    prompt("unset affinity.kind")
    prompt(f"get W {tmp_path / 'w.npy'}")
    mine, w = (np.load(tmp_path / name)[0, 1:40] for name in ("mine.npy", "w.npy"))
    assert np.log(mine) / np.log(w) == pytest.approx(10.0), "σ is ten times too large"
    # Mended in the editor, and taken again: no session is lost.
    (tmp_path / "mine.py").write_text(MODULE.format(sigma=1.5))
    assert ": 4 walls, " in prompt("swap affinity=python:mine.affinity")
    assert "A and now differ in 0 of 141" in prompt("differs")
    assert "python:mine.affinity#2" in prompt("settings"), "both can be told apart"


def test_the_code_that_is_held_stays_as_it_was(prompt: Prompt, tmp_path: Path) -> None:
    prompt("swap affinity=python:mine.affinity")
    prompt("seek 107")
    prompt("hold")
    (tmp_path / "mine.py").write_text(MODULE.format(sigma=1.5))
    prompt("swap affinity=python:mine.affinity")
    differ = re.search(r"A and now differ in (\d+) of 141", prompt("differs"))
    assert differ is not None and int(differ[1]) > 20, "A is answered by the code that was held"


def test_a_stage_that_raises_leaves_the_prompt_and_says_where(prompt: Prompt) -> None:
    before = prompt("seek 107").strip()
    failed = prompt("swap affinity=python:mine.failing")
    assert "mine.failing raised ValueError: too many points for me" in failed
    assert 'mine.py", line 12, in failing' in failed
    assert "without an answer" in prompt("again")
    assert prompt("unset all").startswith(before)


@pytest.mark.parametrize("name, says", [("absent.affinity", "No module named 'absent'"), ("mine.absent", "no attribute 'absent'"),
                                        ("mine.SIGMA_PER_M2", "it is not callable"), ("mine", "python:module.name")])
def test_a_stage_that_is_not_there_is_refused(prompt: Prompt, name: str, says: str) -> None:
    before = prompt("show")
    assert says in prompt.refusal(f"swap affinity=python:{name}")
    assert prompt("show") == before


def test_a_file_of_settings_runs_no_code(tee: Path, tmp_path: Path) -> None:
    (tmp_path / "evil.py").write_text("open('RUN', 'w')\ndef w(points): ...\n")
    (tmp_path / "settings.toml").write_text('[affinity]\nkind = "python:evil.w"\n')
    done = subprocess.run([in_wheel(), "debug", tee, "--config", "settings.toml"], input="show\n", capture_output=True, text=True,
                          cwd=tmp_path)  # fmt: skip
    assert done.returncode == 2 and "where the command line names it" in done.stderr
    assert not (tmp_path / "RUN").exists()

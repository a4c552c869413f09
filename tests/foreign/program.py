"""The program under test, at its process boundary."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

TIMEOUT_S = 600


@dataclass(frozen=True)
class Ran:
    """How a command ended: its exit code (negative: the signal that ended it), and what it wrote."""

    code: int
    stdout: bytes
    words: str

    def expect(self, code: int) -> "Ran":
        if self.code != code:
            raise AssertionError(f"exit code {self.code}, not {code}: {self.words.strip()}")
        return self


class Crosscut:
    def __init__(self, binary: Path):
        self.binary = binary

    def __call__(self, *args) -> Ran:
        done = subprocess.run(self.command(*args), stdin=subprocess.DEVNULL, capture_output=True, timeout=TIMEOUT_S)
        return Ran(done.returncode, done.stdout, done.stderr.decode(errors="replace"))

    def command(self, *args) -> list[str]:
        return [str(self.binary), *map(str, args)]

    def results(self, *args, preset: str = "paper") -> Ran:
        """`run` with a preset; its standard output is the results."""
        return self("run", *args, "--preset", preset, "--out", "-", "--quiet")


def lines(results: bytes) -> list[dict]:
    return [json.loads(line) for line in results.splitlines()]

"""The prompt of `debug` on a pseudo-terminal: Tab, editing, history, Ctrl-C and Ctrl-D."""

import os
import pty
import re
import select
import signal
import subprocess
import time

from flights import Flights
from verdicts import Verdicts

DEADLINE_S = 30
TAB, UP, LEFT, RIGHT, BACKSPACE, CTRL_C, CTRL_D = "\t", "\x1b[A", "\x1b[D", "\x1b[C", "\x7f", "\x03", "\x04"


def check(flights: Flights, verdicts: Verdicts):
    flight = flights.shipped()[0]
    with Terminal(flights.crosscut.command("debug", flight.path, "--preset", "paper", "--set", "spectral.kind=faer")) as terminal:
        typed = {
            "a command": ("seek 107\r", "107 at 10.70 s"),
            "Tab after two letters": (f"se{TAB}{TAB}", "seek +set +settings"),
            "Tab after a command": (f"t spectral.zero_t{TAB}1e-8\r", "3 walls"),
            "the line before the last": (f"{UP}{UP}\r", "107 at 10.70 s"),
            "editing": (f"shwo{LEFT}{BACKSPACE}{RIGHT}w\r", "returns: 317"),
            "Ctrl-C drops the line": (f"nonsense{CTRL_C}", r"107> \r?$"),
            "Ctrl-C on an empty line": (CTRL_C, r"107> \r?$"),
            "the line after it": ("show walls\r", r"0: \d+ returns"),
            "an unknown command": ("jump\r", "there is no command"),
        }
        missing = [what for what, (keys, shown) in typed.items() if not terminal.type(keys, shown)]
        terminal.type("hold\rset affinity.sigma_per_m2=1.4\r", "before")
        terminal.send("again\r")
        time.sleep(0.2)
        terminal.send(CTRL_C)
        stopped = terminal.awaits("stopped; everything is as before") and terminal.type("step\r", "108 at 10.80 s")
        os.kill(terminal.program.pid, signal.SIGINT)
        stays = terminal.type("step\r", "109 at 10.90 s")
        terminal.send(CTRL_D)
        code = terminal.program.wait(timeout=DEADLINE_S)
    verdicts.that(not missing, "keys at the prompt", f"{len(typed)} tried, missing: {missing or 'none'}")
    verdicts.that(stopped and stays and code == 0, "Ctrl-C while `again` works, and Ctrl-D", f"stopped: {stopped}, stays: {stays}, exit code {code}")


class Terminal:
    """A program on a pseudo-terminal."""

    def __init__(self, command: list[str]):
        self._ours, theirs = pty.openpty()
        self.program = subprocess.Popen(
            command, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True, env={**os.environ, "TERM": "xterm"},
            preexec_fn=lambda: os.close(os.open(os.ttyname(0), os.O_RDWR)),
        )  # fmt: skip
        os.close(theirs)
        self._shown = ""
        self.awaits("> ")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.program.poll() is None:
            self.program.kill()
        self.program.wait()
        os.close(self._ours)

    def send(self, keys: str):
        os.write(self._ours, keys.encode())

    def type(self, keys: str, shown: str) -> bool:
        """Sends keys; whether something like `shown` then appears."""
        self._read(0.05)
        self._shown = ""
        self.send(keys)
        return self.awaits(shown)

    def awaits(self, shown: str) -> bool:
        deadline = time.monotonic() + DEADLINE_S
        while time.monotonic() < deadline:
            if re.search(shown, self._plain()):
                return True
            self._read(0.1)
        return False

    def _plain(self) -> str:
        """What was shown without what moves the cursor."""
        return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", self._shown)

    def _read(self, within_s: float):
        while select.select([self._ours], [], [], within_s)[0]:
            try:
                more = os.read(self._ours, 1 << 16)
            except OSError:  # it ended
                return
            if not more:
                return
            self._shown += more.decode(errors="replace")
            within_s = 0.02

"""A picture of a recording in the real Rerun viewer, drawn without a screen. Needs a Vulkan driver
(apt-get install libvulkan1 mesa-vulkan-drivers) and rerun-sdk.

    screenshot.py FILE.rrd OUT.png [--seq N] [--size WxH] [--light]
"""

import argparse
import contextlib
import json
import os
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from rrd import RERUN

DEADLINE_S = 120
# Frames that the viewer draws after a change before it is looked at: pictures are decoded on the way.
SETTLING_FRAMES = 40
# Where a viewer listens that is started during a flight.
SPAWNED_AT = 9876

# Stands in for the viewer's command, which would open a window.
HEADLESS_RERUN = """#!/bin/sh
case "$1" in mcap | viewer-mcp) exec {rerun} "$@" ;; esac
port={port}
for argument; do
    shift
    case "$argument" in
        --port=auto) ;;
        --port=*) port=${{argument#--port=}} ;;
        *) set -- "$@" "$argument" ;;
    esac
done
if [ "$1" != --version ]; then
    echo $$ >"$(dirname "$0")/pid"
    echo "$port" >"$(dirname "$0")/port"
fi
exec {rerun} --headless --window-size {size} --port "$port" "$@"
"""


class Viewer:
    """A headless viewer, driven over the control protocol that it brings along."""

    def __init__(self, command: list, port: int | Path, environment: dict, whole: bool = True, talks: bool = False):
        """`port` is that of the viewer, or a file that will have it."""
        self._log = tempfile.TemporaryFile()
        self._detached = None  # where the id of a viewer is that leaves the group of its program
        ends = (subprocess.PIPE, subprocess.PIPE) if talks else (subprocess.DEVNULL, self._log)
        quiet = {"RUST_LOG": "error", "NO_COLOR": "1"}
        self._viewer = subprocess.Popen(
            command, stdin=ends[0], stdout=ends[1], stderr=self._log,
            env={**os.environ, **quiet, **environment}, start_new_session=True, text=True,
        )  # fmt: skip
        self._control = subprocess.Popen(
            [RERUN, "viewer-mcp"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log, env={**os.environ, **quiet}, text=True,
        )  # fmt: skip
        self._requests = 0
        try:
            client = {"name": "screenshot", "version": "1"}
            self._request("initialize", protocolVersion="2024-11-05", capabilities={}, clientInfo=client)
            self._send(method="notifications/initialized")
            self._wait_until_loaded(lambda: f"http://127.0.0.1:{port_of(port)}", whole)
        except BaseException:
            self.close()
            raise

    @classmethod
    def of(cls, *sources, size: str, whole: bool = True, importers: Path | None = None) -> "Viewer":
        """Of recordings, or of what a server serves; unless `whole`, as soon as anything is there. `importers` is a folder
        of further importers."""
        port = free_port()
        address = ["--bind", "127.0.0.1", "--port", str(port)]
        path = {} if importers is None else {"PATH": f"{importers}:{os.environ['PATH']}"}
        return cls([RERUN, "--headless", *address, "--window-size", size, *map(str, sources)], port, path, whole)

    @classmethod
    def started_by(cls, command: list[str], size: str) -> "Viewer":
        """The one that another program starts: it finds a viewer on its path that needs no screen."""
        port = free_port()
        folder = headless_rerun(size, port)
        return cls(command, folder / "port", {"PATH": f"{folder}:{os.environ['PATH']}"})

    @classmethod
    def beside(cls, command: list[str], size: str) -> "Viewer":
        """The one beside the prompt of a program that reads commands from a pipe (`ask`)."""
        folder = headless_rerun(size, SPAWNED_AT)
        viewer = cls(command, folder / "port", {"PATH": f"{folder}:{os.environ['PATH']}"}, whole=False, talks=True)
        viewer._detached = folder / "pid"
        viewer._viewer.stdout.readline()  # its greeting
        return viewer

    def ask(self, command: str) -> str:
        """The answer at the prompt of `debug`, up to that of a command that is known to be one line."""
        self._viewer.stdin.write(f"{command}\nbreak\n")
        self._viewer.stdin.flush()
        lines: list[str] = []
        while (answer := self._viewer.stdout.readline()) != "no break\n":
            if not answer:
                raise RuntimeError(f"the prompt ended: {''.join(lines)}")
            lines.append(answer)
        return "".join(lines)

    def kill(self):
        """The viewer, not the program that started it."""
        os.kill(int(self._detached.read_text()), signal.SIGKILL)

    def leave(self) -> tuple[int, str]:
        """Ends what is asked; the exit code, and what was said on standard error."""
        self._viewer.stdin.close()
        return self._viewer.wait(), self._said()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._control.terminate()
        self._control.wait()
        if self._viewer.poll() is None:
            os.killpg(self._viewer.pid, signal.SIGTERM)  # with the viewer that it started
            os.killpg(self._viewer.pid, signal.SIGCONT)
        self._viewer.wait()
        if self._detached:
            with contextlib.suppress(ProcessLookupError):
                self.kill()

    def pause(self):
        """It reads no more, and does not answer."""
        os.killpg(self._viewer.pid, signal.SIGSTOP)

    def last_revolution(self) -> int | None:
        """`None` while nothing is loaded."""
        return self.last("revolution")

    def last(self, timeline: str) -> int | None:
        """The last time of a timeline; `None` while nothing is loaded."""
        for recording in self._call("viewer_state").get("recordings", []):
            for of in recording["timelines"]:
                if of["timeline"] == timeline:
                    return of["max"]
        return None

    def time(self) -> tuple[str, int] | None:
        """The timeline that is shown, and where on it; `None` while nothing is loaded."""
        for recording in self._call("viewer_state").get("recordings", []):
            if time := recording.get("current_time"):
                return time["timeline"], time["time"]
        return None

    def show(self, revolution: int):
        for _ in range(5):  # a layout that comes later goes to the end of the flight
            self._call("set_time", timeline="revolution", time=revolution)
            self.settle()
            if self.time() == ("revolution", revolution):
                return

    def light(self):
        """From the dark theme, which a viewer without a desktop starts with, to the light one."""
        for target in ({"role": "Button", "label_contains": "Menu"}, {"role": "Button", "label_contains": "Settings"}, {"content_contains": "Light"}):
            self._call("click", **target)
            self.settle()
        self._call("press_key", key="Escape")
        self.settle()

    def views(self) -> dict[str, dict]:
        """The views on the screen by name, with their place: x, y, w, h in pixels, without the title."""
        panes = self._call("query_tree", role="Pane")["nodes"]
        return {pane["label"]: pane["bounds"] for pane in panes if pane["label"] and not pane["hidden"]}

    def save(self, path: Path):
        self._call("screenshot", save_path=str(path.resolve()))

    def settle(self):
        """Waits until what has come is drawn."""
        self._call("wait_for", min_steps=SETTLING_FRAMES, timeout_secs=DEADLINE_S)

    def _wait_until_loaded(self, endpoint: Callable[[], str], whole: bool):
        """Loaded as a whole is when the flight has grown no more while some frames were drawn."""
        deadline = time.monotonic() + DEADLINE_S
        while not self._connects(endpoint()):
            if self._viewer.poll() is not None or time.monotonic() > deadline:
                raise RuntimeError(f"the viewer does not start: {self._said()}")
            time.sleep(0.1)
        before, now = None, self.last_revolution()
        while now is None or (whole and now != before):
            if time.monotonic() > deadline:
                raise RuntimeError(f"the viewer does not load the recording: {self._said()}")
            self.settle()
            before, now = now, self.last_revolution()

    def _connects(self, endpoint: str) -> bool:
        try:
            self._call("connect", endpoint=endpoint)
            return True
        except RuntimeError:
            return False

    def _call(self, tool: str, **arguments) -> dict:
        answer = self._request("tools/call", name=tool, arguments=arguments)
        if "error" in answer or answer["result"]["isError"]:
            raise RuntimeError(f"{tool}: {json.dumps(answer)[:400]}")
        return json.loads(answer["result"]["content"][0]["text"])

    def _request(self, method: str, **params) -> dict:
        self._requests += 1
        self._send(id=self._requests, method=method, params=params)
        answer = self._control.stdout.readline()
        if not answer:
            raise RuntimeError(f"the viewer's control ended: {self._said()}")
        return json.loads(answer)

    def _send(self, **message):
        self._control.stdin.write(json.dumps({"jsonrpc": "2.0", **message}) + "\n")
        self._control.stdin.flush()

    def _said(self) -> str:
        self._log.seek(0)
        return self._log.read().decode(errors="replace").strip()[-600:]


def headless_rerun(size: str, port: int) -> Path:
    """A folder with a viewer's command that needs no screen."""
    folder = Path(tempfile.mkdtemp(prefix="viewer-"))
    (folder / "rerun").write_text(HEADLESS_RERUN.format(rerun=RERUN, size=size, port=port))
    (folder / "rerun").chmod(0o755)
    return folder


def port_of(port: int | Path) -> int | str:
    """0, where nobody listens, while the file is not there."""
    if isinstance(port, int):
        return port
    return port.read_text().strip() or "0" if port.exists() else "0"


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def main():
    parser = argparse.ArgumentParser(description="A picture of a recording in the Rerun viewer.")
    parser.add_argument("recording", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--seq", type=int, help="revolution to show; the last one if not given")
    parser.add_argument("--size", default="1400x900", help="WxH in pixels (default: %(default)s)")
    parser.add_argument("--light", action="store_true", help="with the light theme")
    args = parser.parse_args()
    args.picture.parent.mkdir(parents=True, exist_ok=True)
    with Viewer.of(args.recording, size=args.size) as viewer:
        viewer.show(viewer.last_revolution() if args.seq is None else args.seq)
        if args.light:
            viewer.light()
        viewer.save(args.picture)


if __name__ == "__main__":
    main()

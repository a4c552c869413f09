"""What can be looked at, in the real viewer: every page, two flights side by side, the robot's own sensors beside ours,
a viewer that comes late, one that stops reading."""

import os
import re
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
from PIL import Image

import rrd
import scenes
import sensors
import writing
from flights import Flights
from recording import DRAWN_SHARE, drawn_share
from screenshot import Viewer
from verdicts import Verdicts

SIZE = "1400x900"
# Pages by the option, and words in the names of their views.
PAGES = {
    "overview": ("Here", "Walls counted", "Place", "Confidence"),
    "stages": ("Returns", "W", "L", "Eigenvalues", "U", "Walls"),
    "speed": ("Time per stage", "All stages"),
}
# More than viewers and the queue before them take in, and more than one part.
STALLED_SCANS = 6500


def check(flights: Flights, verdicts: Verdicts):
    flight = flights.shipped()[0]
    saved = flights.outcome(flight).rrd
    for page, words in PAGES.items():
        command = flights.crosscut.command("view", saved, "--layout", page)
        check_view(command, f"view --layout {page}", words, flights, verdicts)
    check_at(saved, flights, verdicts)
    check_beside(saved, flights, verdicts)
    check_sensors(flights, verdicts)
    check_importer(flights, verdicts)
    check_debug(flight.path, flights, verdicts)
    check_debug_recording(saved, flights, verdicts)
    check_late(flight.path, flights, verdicts)
    check_stalled(flights, verdicts)


def check_view(command: list[str], what: str, words, flights: Flights, verdicts: Verdicts, at: int | None = None):
    """In the dark and in the light theme: which views there are, that something is drawn in each, and on a ground of the
    theme."""
    path = flights.work.parent / f"{re.sub('[^a-z]+', '-', what)}.png"
    light = path.with_stem(f"{path.stem}-light")
    with Viewer.started_by(command, SIZE) as viewer:
        viewer.show(viewer.last_revolution() if at is None else at)
        views = {name: place for name, place in viewer.views().items() if not name.startswith("_")}
        viewer.save(path)
        viewer.light()
        viewer.save(light)
    missing = [word for word in words if not any(re.search(rf"\b{word}\b", name) for name in views)]
    shown = {name: place for name, place in views.items() if place["w"] > 0}
    failing = []
    for theme, is_ground in ((path, lambda level: level < 60), (light, lambda level: level > 195)):
        pixels = np.array(Image.open(theme).convert("RGB")).astype(int)
        for name, place in shown.items():
            if drawn_share(pixels, place) < DRAWN_SHARE:
                failing.append(f"{theme.stem}: {name} is blank")
            if not is_ground(ground_level(pixels, place)):
                failing.append(f"{theme.stem}: {name} is on another ground")
    figures = f"{len(views)} views, missing: {missing or 'none'}, {failing or 'two themes'}; {path.name}, {light.name}"
    verdicts.that(not missing and not failing, what, figures)


def ground_level(pixels: np.ndarray, place: dict) -> float:
    """How bright a view is in its corners (above its lower edge, where plots have their numbers)."""
    left, top = int(place["x"]) + 3, int(place["y"]) + 3
    right, bottom = int(place["x"] + place["w"]) - 4, int(place["y"] + place["h"]) - 4
    return float(np.median([pixels[top, left].mean(), pixels[top, right].mean(), pixels[bottom, right].mean()]))


def check_at(saved: Path, flights: Flights, verdicts: Verdicts):
    """The viewer opens at the revolution that was asked for."""
    with Viewer.started_by(flights.crosscut.command("view", saved, "--at", "7"), SIZE) as viewer:
        deadline = time.monotonic() + 60
        while (shown := viewer.time()) != ("revolution", 7) and time.monotonic() < deadline:
            time.sleep(0.2)
    verdicts.that(shown == ("revolution", 7), "view --at 7", f"{shown}")


def check_beside(saved: Path, flights: Flights, verdicts: Verdicts):
    """The same flight with other settings: what differs, and both, by their presets."""
    other = flights.work / "other.rrd"
    flights.crosscut("run", flights.shipped()[0].path, "--preset", "default", "--save", other, "--quiet").expect(0)
    command = flights.crosscut.command("view", saved, "--beside", other)
    names = ("paper", "default")
    both = [f"{name}: {view}" for name in names for view in ("scan", "why")]  # in front of their tabs
    check_view(command, "view --beside", [*both, "Walls counted", "What differs", "Where they differ"], flights, verdicts)
    stages = [f"{name}: {number} {view}" for name in names for number, view in ((1, "Returns"), (2, "W"), (8, "Why"))]
    check_view([*command, "--layout", "stages"], "view --beside --layout stages", stages, flights, verdicts)


def check_sensors(flights: Flights, verdicts: Verdicts):
    """A point cloud that stands on the walls when transforms and times are right, and a camera."""
    path, saved = flights.work / "sensors.mcap", flights.work / "sensors.rrd"
    sensors.write(path)
    flights.crosscut("run", path, "--save", saved, "--quiet", "--set", "ingest.yaw_rad=0.5").expect(0)
    command = flights.crosscut.command("view", saved, "--beside", path)
    check_view(command, "view --beside MCAP", ("point clouds", "camera"), flights, verdicts, at=sensors.SCENES // 2)
    command += ["--layout", "overview"]
    check_view(command, "view --beside MCAP --layout overview", PAGES["overview"], flights, verdicts, at=sensors.SCENES // 2)


def check_importer(flights: Flights, verdicts: Verdicts):
    """The stock viewer opens a file that it does not know, by the importer beside the program."""
    path = flights.work / "hall.clf"
    ranges = [round(min(3 / max(abs(np.sin(np.radians(beam - 90))), 1e-9), 12.0), 2) for beam in range(180)]
    scan = " ".join(map(str, ranges))
    path.write_text("".join(f"FLASER 180 {scan} 0 0 0 0 0 0 {i}.0 host {i}.0\n" for i in range(20)))
    importers = flights.work / "importers"
    importers.mkdir(exist_ok=True)
    link = importers / "rerun-importer-crosscut"
    link.unlink(missing_ok=True)
    link.symlink_to(Path(flights.crosscut.binary).resolve())
    with Viewer.of(path, size=SIZE, importers=importers) as viewer:
        last, views = viewer.last_revolution(), viewer.views()
    missing = [word for word in ("Returns", "W", "Walls") if not any(re.search(rf"\b{word}\b", name) for name in views)]
    verdicts.that(last == 19 and not missing, "rerun FILE.clf", f"revolution {last} of 19, missing: {missing or 'none'}")


# A setting shows in the viewer within this time, seconds: the quickest of several, as the machine may be at work.
SHOWN_WITHIN_S = 0.1


def check_debug(path: Path, flights: Flights, verdicts: Verdicts):
    """The viewer beside `debug` shows the present revolution after every command, beside it what is held; the session outlives
    it."""
    pictures = flights.work.parent
    command = flights.crosscut.command("debug", path, "--preset", "paper", "--view")
    with Viewer.beside(command, SIZE) as viewer:
        viewer.ask("seek 107")
        viewer.settle()
        alone, at = set(viewer.views()), viewer.time()
        viewer.save(pictures / "debug.png")
        shown_s = [time_to_show(viewer, tolerance, shown) for shown, tolerance in enumerate(("1e-8", "1e-7", "1e-6", "1e-7"), start=3)]
        viewer.ask("hold")
        time_to_show(viewer, "1e-8", 8)
        viewer.settle()
        both, after = set(viewer.views()), viewer.time()
        viewer.save(pictures / "debug-held.png")
        viewer.kill()
        time.sleep(0.5)
        answers = [viewer.ask(f"seek {seq}") for seq in (20, 21)]
        code, said = viewer.leave()
    words = ("1 Returns", "2 W", "4 Eigenvalues", "5 U", "6 Walls", "7 Walls", "8 Why")
    missing = [word for word in words if not any(name.startswith(word) for name in alone)]
    # Beside each other, the steps after the eigenvalues are a page of their own.
    first = [f"{side}: {word}" for side in ("A", "now") for word in words if word[0] in "1248"]
    missing += [word for word in first if not any(name.startswith(word) for name in both)]
    follows = at == ("command", 2) and after == ("command", 8)
    figures = f"missing: {missing or 'none'}, at {at[1]} and {after[1]}, a setting after {', '.join(f'{1e3 * s:.0f}' for s in shown_s)} ms"
    verdicts.that(not missing and follows and min(shown_s) < SHOWN_WITHIN_S, "debug --view", figures)
    lives = code == 0 and "it was closed; the session goes on" in said and all(answer.startswith(f"{seq} at ") for seq, answer in zip((20, 21), answers))
    verdicts.that(lives, "debug --view, the viewer is killed", f"exit code {code}, {said.splitlines()[-1]}")


def check_debug_recording(saved: Path, flights: Flights, verdicts: Verdicts):
    """A recording in place of a flight: the viewer shows what is rebuilt from it, with the settings that it was made with."""
    command = flights.crosscut.command("debug", saved, "--view")
    with Viewer.beside(command, SIZE) as viewer:
        recorded = viewer.ask("seek 107")
        viewer.ask("hold")
        changed = viewer.ask("set report.min_returns=3")
        viewer.settle()
        at, views = viewer.time(), viewer.views()
        viewer.save(flights.work.parent / "debug-recording.png")
        code, _ = viewer.leave()
    figures = f"recorded: {recorded.strip()}, now: {changed.strip()}, at {at}, {sorted(views)[:4]}, exit code {code}"
    answered = ": 4 walls" in recorded and ": 3 walls" in changed
    sides = all(any(name.startswith(f"{side}: 8 Why") for name in views) for side in ("A", "now"))
    verdicts.that(answered and at == ("command", 4) and sides and code == 0, "debug FLIGHT.rrd --view", figures)


def time_to_show(viewer: Viewer, tolerance: str, shown: int) -> float:
    """Seconds from a setting to when the viewer has its answer, the revolution that is `shown` so far."""
    start = time.monotonic()
    viewer.ask(f"set spectral.zero_tolerance={tolerance}")
    while viewer.last("command") != shown:
        if time.monotonic() - start > 10:
            raise RuntimeError("the viewer does not follow")
    return time.monotonic() - start


def check_late(path: Path, flights: Flights, verdicts: Verdicts):
    """A viewer that connects when the flight is over sees all of it; the file beside it is whole."""
    saved = flights.work / "served.rrd"
    with Served(flights.crosscut.command("run", path, "--serve=127.0.0.1:0", "--save", saved)) as served:
        served.wait_for("still served")
        with Viewer.of(served.url, size=SIZE) as viewer:
            last = viewer.last_revolution()
        code = served.interrupt()
    expected = len(flights.outcome(flights.shipped()[0]).lines) - 1
    figures = f"revolution {last} of {expected}, exit code {code}, {saved.stat().st_size / 1e6:.1f} MB saved"
    verdicts.that(last == expected and code == 0, "run --serve, a viewer that comes late", figures)


def check_stalled(flights: Flights, verdicts: Verdicts):
    """A viewer that is stopped (SIGSTOP) early on: the flight goes on, and its file is whole."""
    path, saved, results = flights.work / "long.mcap", flights.work / "long.rrd", flights.work / "long.jsonl"
    made = scenes.clear_junctions(50, seed=3)
    writing.write_ros2(path, [made[i % len(made)] for i in range(STALLED_SCANS)])
    command = ["run", path, "--serve=127.0.0.1:0", "--save", saved, "--out", results, "--rate", "10"]
    with Served(flights.crosscut.command(*command)) as served:
        with Viewer.of(served.url, size=SIZE, whole=False) as viewer:
            before = results.read_bytes().count(b"\n")
            viewer.pause()
            served.wait_for("still served")
        code = served.interrupt()
    count = results.read_bytes().count(b"\n")
    parts = [saved, saved.with_stem(f"{saved.stem}-2")]
    recorded = sum(len(rrd.values(part, "/report/junctions", "Scalars:scalars")) for part in parts)
    figures = f"stopped after {before} of {STALLED_SCANS} results; then {count}, {recorded} recorded, exit code {code}"
    held = before < STALLED_SCANS / 2 and count == recorded == STALLED_SCANS and code == 0
    verdicts.that(held, "a viewer that stops reading", figures)


class Served:
    """A run that serves, until the end of a `with` block."""

    def __init__(self, command: list[str]):
        self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self._said = ""
        self.wait_for("/proxy")
        self.url = re.search(r"rerun\+http://\S+", self._said)[0]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()

    @property
    def page(self) -> str | None:
        found = re.search(r"http://\S+\?url=\S+", self._said)
        return found and found[0]

    def wait_for(self, words: str):
        while words not in self._said:
            more = os.read(self._process.stderr.fileno(), 1 << 16)
            if not more:
                raise RuntimeError(f"it ended: {self._said[-400:]}")
            self._said += more.decode(errors="replace")

    def interrupt(self) -> int:
        self._process.send_signal(signal.SIGINT)
        self._process.communicate()
        return self._process.returncode

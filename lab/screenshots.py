"""The screenshots of docs/images: started by `lab/make pictures`."""

import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests/foreign"))

import sensors  # noqa: E402
from screenshot import Viewer  # noqa: E402

SIZE = "1400x900"
# The viewer's own bar on top: it has badges of the machine that draws, and nothing of the page.
BAR_PX = 28
IMAGES, WORK = ROOT / "docs/images", ROOT / "target/screenshots"
# Real recordings: see docs/viewing.md for their origin.
REAL = ROOT / "../shared/data"


def main(crosscut: str):
    IMAGES.mkdir(exist_ok=True)
    WORK.mkdir(parents=True, exist_ok=True)
    tee = ROOT / "recordings/tee.mcap"
    for name, flight, seq in (("tee", tee, 81), ("corridor", REAL / "corridor_cross.mcap", 567)):
        if not flight.exists():
            print(f"skipped: {flight} is not here")
            continue
        paper, default = (run(crosscut, flight, preset, f"{name}/{preset}") for preset in ("paper", "default"))
        for page in ("overview", "stages", "speed"):
            take(crosscut, [default, "--layout", page], seq, f"{page}-{name}")
        take(crosscut, [paper, "--beside", default], seq, f"beside-{name}")
        if name == "tee":
            take(crosscut, [paper, "--layout", "stages"], seq, "tee")
            take(crosscut, [paper, "--layout", "stages"], seq, "stages-light", light=True)
    maps(crosscut)
    mission(crosscut)
    ways(crosscut)
    robot = WORK / "robot.mcap"
    sensors.write(robot)
    take(crosscut, [run(crosscut, robot, "default", "robot"), "--beside", robot], 20, "sensors-robot")
    why(crosscut, tee)


def maps(crosscut: str):
    """The page `map` of a simulated flight with loops."""
    loops = WORK / "loops.mcap"
    subprocess.run([crosscut, "simulate", "loops", "--seed", "1", "--out", loops, "--quiet"], check=True)
    take(crosscut, [run(crosscut, loops, "default", "loops", detail="light"), "--layout", "map"], 3000, "map-loops")


def mission(crosscut: str):
    """A mission at one of its decisions."""
    saved = WORK / "mission.rrd"
    subprocess.run([crosscut, "explore", "loops", "--seed", "7", "--save", saved, "--set", "recording.detail=light", "--quiet"], check=True)
    take(crosscut, [saved], 2112, "mission")


def ways(crosscut: str):
    """The ways on of a cloud: a gallery, a raise above it, and a ramp down from it."""
    tubes = [((-60, 0, 0), (60, 0, 0), 2.0), ((0.5, 0, 0), (0.5, 0, 25), 1.3), ((0, 0, 0), (5, 25, -11), 1.6)]
    elevation, bearing = (angles.ravel() for angles in np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, 129)[1:-1], np.linspace(-np.pi, np.pi, 512)))
    towards = np.stack([np.cos(elevation) * np.cos(bearing), np.cos(elevation) * np.sin(bearing), np.sin(elevation)], axis=1)
    range_m = np.zeros(len(towards))
    for _ in range(200):  # from wall to wall of the spheres that are free
        at_m = range_m[:, None] * towards
        range_m += np.max([free_m(at_m, *(np.array(of, dtype=float) for of in tube)) for tube in tubes], axis=0).clip(0)
    points = (range_m[:, None] * towards)[range_m < 25].astype("<f4")
    cloud = WORK / "ways.ply"
    fields = "".join(f"property float {axis}\n" for axis in "xyz")
    cloud.write_bytes(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n{fields}end_header\n".encode() + points.tobytes())
    take(crosscut, [run(crosscut, cloud, "3d", "ways")], 0, "ways")


def free_m(at_m: np.ndarray, start: np.ndarray, end: np.ndarray, radius_m: np.ndarray) -> np.ndarray:
    """How far it is to the rough wall of a tube; below 0 outside of it."""
    along = end - start
    share = ((at_m - start) @ along / (along @ along)).clip(0, 1)
    rough_m = 0.1 * np.sin(at_m * (2.1, 1.7, 2.6)).sum(axis=1)
    return 0.6 * (radius_m + rough_m - np.linalg.norm(at_m - start - share[:, None] * along, axis=1))


def why(crosscut: str, tee: Path):
    """The pictures of docs/why.md: three wrong counts, and what the change makes of them."""
    dust = WORK / "dust.mcap"
    if not dust.exists():
        subprocess.run([crosscut, "simulate", "--suite", "dust", "--split", "dev", "--out", WORK], check=True)
    cases = (
        ("leak", REAL / "corridor_cross.mcap", 358, ["affinity.sigma_per_m2=3"]),
        ("far", tee, 107, ["report.min_returns=3"]),
        ("dust", dust, 1, None),
    )
    for name, flight, seq, change in cases:
        if not flight.exists():
            print(f"skipped: {flight} is not here")
            continue
        wrong = run(crosscut, flight, "paper", f"why-{name}", around=seq)
        take(crosscut, [wrong, "--layout", "stages"], seq, f"why-{name}")
        preset, settings = ("default", []) if change is None else ("paper", change)
        right = run(crosscut, flight, preset, f"why-{name}-changed", settings, around=seq)
        take(crosscut, [right, "--layout", "stages"], seq, f"why-{name}-changed")


def run(crosscut: str, flight: Path, preset: str, name: str, settings=(), around: int | None = None, detail="default") -> Path:
    """The recording of a flight, or of some revolutions of it."""
    saved = WORK / f"{name}.rrd"
    saved.parent.mkdir(parents=True, exist_ok=True)
    chosen = [] if around is None else ["--set", f"recording.revolutions=[[{max(0, around - 20)}, {around + 20}]]"]
    changes = [part for setting in settings for part in ("--set", setting)]
    command = [crosscut, "run", flight, "--preset", preset, *changes, "--save", saved, "--quiet", "--set", f"recording.detail={detail}", *chosen]
    subprocess.run(command, check=True)
    return saved


def take(crosscut: str, what: list, seq: int, name: str, light: bool = False):
    path = IMAGES / f"{name}.png"
    with Viewer.started_by([crosscut, "view", *map(str, what)], SIZE) as viewer:
        viewer.show(seq)
        if light:
            viewer.light()
        viewer.save(path)
    # 256 colours are enough for lines and letters, and a third of the size; chosen so that a wall of two returns keeps its own.
    page = Image.open(path).convert("RGB")
    page = page.crop((0, BAR_PX, page.width, page.height))
    few = page.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
    few.save(path, optimize=True)
    print(f"{path.relative_to(ROOT)}, {path.stat().st_size / 1e3:.0f} KB")


if __name__ == "__main__":
    main(sys.argv[1])

"""small_gicp's matching of a scan to a map and crosscut's flight on the same scans, in turn, in one run. Started by
`run flight_speed`.

crosscut: pose, place and steady answer, by its bench of the flight. small_gicp: the pose alone, from points of a plane: the scan
is thinned out, matched (ICP, as its other kinds need surfaces in space) to the walls of the last keyframes from where steady
motion leads, and added to them each 0.5 m. Both on one thread, without input or output; of each scan the least time of all
passes, of those median and 99th percentile."""

import argparse
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import small_gicp

import oracle
import program
import scans

PASSES = 3
ROOT = Path(__file__).parents[1]
SCENARIO, SEED = "loops", 7
THINNED_M, KEYFRAME_M, RADIUS_M, MATCHED_M = 0.1, 0.5, 40.0, 0.5


def main() -> int:
    parser = argparse.ArgumentParser(prog="lab/run flight_speed", description=__doc__)
    parser.add_argument("recordings", nargs="*", type=Path)
    args = parser.parse_args()
    recordings = args.recordings or [simulated()]
    print(f"{'recording':<16}{'scans':>7}{'small_gicp p50':>16}{'p99 us':>9}{'crosscut p50':>14}{'p99 us':>9}{'ratio p50':>11}{'p99':>6}")
    for recording in recordings:
        read = [padded(oracle.points_of(scan)) for scan in scans.read(recording)]
        passes = [(bench(recording), matched_us(read)) for _ in range(PASSES)]
        ours = np.min([ours for ours, _ in passes], axis=0)
        theirs = np.percentile(np.min([theirs for _, theirs in passes], axis=0), [50, 99])
        ratios = theirs / ours
        print(
            f"{recording.stem:<16}{len(read):>7}{theirs[0]:>16.1f}{theirs[1]:>9.1f}{ours[0]:>14.1f}{ours[1]:>9.1f}"
            f"{ratios[0]:>11.1f}{ratios[1]:>6.1f}",
            flush=True,
        )
    return 0


def simulated() -> Path:
    recording = ROOT / f"target/foreign/work/{SCENARIO}-{SEED}.mcap"
    recording.parent.mkdir(parents=True, exist_ok=True)
    program.Crosscut(ROOT / "target/release/crosscut")("simulate", SCENARIO, "--seed", str(SEED), "-o", recording).expect(0)
    return recording


def bench(recording: Path) -> list[float]:
    """Median and 99th percentile of the flight, microseconds."""
    command = ["cargo", "bench", "--quiet", "-p", "crosscut-detector", "--bench", "flight", "--", recording.resolve()]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    return [float(cell) for cell in done.stdout.splitlines()[1].split(",")[3:5]]


def padded(points_m: np.ndarray) -> np.ndarray:
    return np.hstack([points_m, np.zeros((len(points_m), 1))])


def matched_us(read: list[np.ndarray]) -> list[float]:
    """Microseconds of each scan."""
    pose = keyframe = step = np.eye(4)
    walls_m, walls, tree = np.empty((0, 3)), None, None
    times_us = []
    for points_m in read:
        start = time.perf_counter_ns()
        scan = small_gicp.voxelgrid_sampling(points_m, THINNED_M)
        if walls is not None and scan.size() > 0:
            result = small_gicp.align(
                walls, scan, tree, init_T_target_source=pose @ step, registration_type="ICP",
                max_correspondence_distance=MATCHED_M, num_threads=1,
            )  # fmt: skip
            step = np.linalg.inv(pose) @ result.T_target_source
            pose = result.T_target_source
        if walls is None or np.linalg.norm(pose[:2, 3] - keyframe[:2, 3]) > KEYFRAME_M:
            keyframe = pose
            added_m = scan.points()[:, :3] @ pose[:3, :3].T + pose[:3, 3]
            walls_m = np.vstack([walls_m[np.abs(walls_m - pose[:3, 3]).max(axis=1) < RADIUS_M], added_m])
            walls = small_gicp.voxelgrid_sampling(walls_m, THINNED_M)
            walls_m = walls.points()[:, :3]
            tree = small_gicp.KdTree(walls, num_threads=1)
        times_us.append((time.perf_counter_ns() - start) / 1e3)
    return times_us


if __name__ == "__main__":
    sys.exit(main())

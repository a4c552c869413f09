"""Test places in a real mine: its mesh is cut at the height of a level lidar, and the truth is what a vehicle's disc can do there.

The lidar is 0.9 m above the floor of each place; what it does to the scan is what it does in carved rock (`rock`). Rock that
stands alone and is smaller than 3 m is left out, as there: whether it is a wall or a pillar hangs on the definition.

Usage: lab/run mesh MINE.stl OUT_DIR [--count N] [--seed S]
"""

import argparse
import sys
from functools import cache
from pathlib import Path

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

import places
import rock
from passable import GRID_M, Ground
from sight import Unclear

LIDAR_M = 0.9  # above the floor
SLICE_M = 0.1  # places whose floors differ by less share a cut
MARGIN_M = 8.0
WALL_M = 0.06  # half as thick as a cut through the mesh is drawn
SMALL_M = 3.0  # rock that stands alone
STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


class Mine:
    """A mesh of triangles (count x 3 corners x 3 coordinates), in metres, z up."""

    def __init__(self, path: Path):
        self.corners_m = np.frombuffer(path.read_bytes()[84:], STL)["corners"].astype(float)
        self.middles_m = self.corners_m.mean(axis=1)
        self.low_m = self.corners_m.min(axis=(0, 1))[:2] - MARGIN_M
        self.high_m = self.corners_m.max(axis=(0, 1))[:2] + MARGIN_M
        self.near = cKDTree(self.middles_m[:, :2])

    def floor_m(self, spot_m: np.ndarray) -> float | None:
        around = self.near.query_ball_point(spot_m, 0.7)
        return float(np.percentile(self.middles_m[around, 2], 3)) if len(around) > 4 else None

    def is_inside(self, spot_m: np.ndarray, height_m: float) -> bool:
        """There is rock above and below."""
        to_m = self.corners_m[..., :2] - spot_m
        turns = np.cross(np.pad(to_m, ((0, 0), (0, 0), (0, 1))), np.pad(np.roll(to_m, -1, axis=1), ((0, 0), (0, 0), (0, 1))))[..., 2]
        crossed_m = self.middles_m[np.all(turns >= 0, axis=1) | np.all(turns <= 0, axis=1), 2]
        return bool(np.any(crossed_m > height_m) and np.any(crossed_m < height_m))

    def cut(self, height_m: float) -> np.ndarray:
        """Points on the walls at this height, closer than the grid."""
        above_m = self.corners_m[..., 2] - height_m
        ends = []
        for a, b in ((0, 1), (1, 2), (2, 0)):
            crosses = above_m[:, a] * above_m[:, b] < 0
            share = np.divide(above_m[:, a], above_m[:, a] - above_m[:, b], where=crosses, out=np.zeros(len(above_m)))
            at_m = self.corners_m[:, a, :2] + share[:, None] * (self.corners_m[:, b, :2] - self.corners_m[:, a, :2])
            ends.append(np.where(crosses[:, None], at_m, np.nan))
        ends_m = np.stack(ends, axis=1)
        known = np.isfinite(ends_m[..., 0])
        pairs_m = ends_m[known.sum(axis=1) == 2]
        pairs_m = pairs_m[np.isfinite(pairs_m[..., 0])].reshape(-1, 2, 2)
        counts = np.maximum(2, np.ceil(np.linalg.norm(pairs_m[:, 1] - pairs_m[:, 0], axis=1) / (GRID_M / 4)).astype(int))
        return np.concatenate([np.linspace(a, b, count) for (a, b), count in zip(pairs_m, counts)])

    @cache
    def ground(self, slice_number: int) -> Ground:
        x, y = np.rint((self.cut(slice_number * SLICE_M) - self.low_m) / GRID_M).astype(int).T
        open_cells = np.ones(np.ceil((self.high_m - self.low_m) / GRID_M).astype(int)[::-1], dtype=bool)
        open_cells[y, x] = False
        free_m = np.clip(ndimage.distance_transform_edt(open_cells) * GRID_M - WALL_M, -1, 1)
        # A pillar is a ring in the cut: its inside is filled, and it goes if it is small.
        parts, _ = ndimage.label(free_m > 0)
        outside = parts[0, 0]
        for part, (rows, columns) in enumerate(ndimage.find_objects(parts), start=1):
            if part != outside and (parts == part).sum() * GRID_M**2 < SMALL_M**2:
                free_m[rows, columns][parts[rows, columns] == part] = -WALL_M
        alone, _ = ndimage.label(free_m <= 0)
        for part, (rows, columns) in enumerate(ndimage.find_objects(alone), start=1):
            if max(rows.stop - rows.start, columns.stop - columns.start) * GRID_M < SMALL_M:
                free_m[rows, columns][alone[rows, columns] == part] = WALL_M
        return Ground(free_m, (float(self.low_m[0]), float(self.low_m[1])))

    def place(self, rng: np.random.Generator) -> places.Place | None:
        """A place that flights come by, if this random spot is one; `Unclear` where the definition is on edge."""
        spot_m = rng.uniform(self.low_m, self.high_m)
        if (floor_m := self.floor_m(spot_m)) is None:
            return None
        ground = self.ground(round((floor_m + LIDAR_M) / SLICE_M))
        (y,), (x,) = ground.cells(spot_m[None])
        around = slice(max(0, y - 20), y + 21), slice(max(0, x - 20), x + 21)
        clear_m = ground.clearance_m[y, x]
        if clear_m < max(rock.LEAST_CLEAR_M, 0.45 * ground.clearance_m[around].max()):
            return None
        if not self.is_inside(spot_m, floor_m + LIDAR_M):
            return None
        return rock.place_at(ground, spot_m, rock.any_beams(rng), rng, 0)


def make(mine: Mine, count: int, seed: int) -> tuple[list[places.Place], dict[str, int]]:
    """Some places, and why others were left out."""
    rng = np.random.default_rng(seed)
    made: list[places.Place] = []
    left_out: dict[str, int] = {}
    while len(made) < count:
        try:
            if place := mine.place(rng):
                made.append(place)
        except Unclear as why:
            left_out[str(why)] = left_out.get(str(why), 0) + 1
    return made, left_out


def main() -> int:
    parser = argparse.ArgumentParser(description="Writes test places in a mine's mesh, with known truth, as MCAP.")
    parser.add_argument("mine", type=Path, metavar="MINE.stl", help="binary STL in metres, z up")
    parser.add_argument("out", type=Path, metavar="OUT_DIR")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    made, left_out = make(Mine(args.mine), args.count, args.seed)
    reasons = ", ".join(f"{why} {times}" for why, times in sorted(left_out.items()))
    share = sum(left_out.values()) / (sum(left_out.values()) + len(made))
    print(f"{args.mine.stem} {len(made)} places, {share:.0%} left out: {reasons}")
    args.out.mkdir(parents=True, exist_ok=True)
    places.write(args.out / f"{args.mine.stem}.mcap", made)
    return 0


if __name__ == "__main__":
    sys.exit(main())

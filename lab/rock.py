"""Test places in rock, carved and not drawn, with the truth of what a vehicle's disc can do in the real free space.

A world is 80 m wide. A random network of passages, from 0.6 to 9 m wide, is carved into a field that is rough at all scales;
the wall is where the field is zero. Kinds:
- drifts    straight passages, blasted a few metres at a time: each side steps in and out; faces at any angle
- caves     passages that wander, with chambers; rough from 8 m down to 0.2 m
- narrow    the same, 0.7 to 1.7 m wide
- worn      random walks, worn by erosion
- grown     cellular growth around a network
- recess    straight passages of 2.5 to 4 m whose sides step by 0.2 to 0.8 m every few metres

and those that real scans show (`real_kinds`). The sensor stands where flights come: in free space, not much nearer to a wall
than to the middle. All that real lidars do is done to all of it at once: noise, beams lost alone, at grazing incidence and in
patches, dust, mixed returns, legs of the vehicle, a limited view. What the definition leaves to a hair is left out
(`passable`), and its share is printed.

Usage: lab/run rock OUT_DIR [--count N] [--seed S] [KIND...]
"""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy import fft, ndimage
from scipy.spatial import Delaunay, cKDTree

import passable
import places
import real_kinds
from passable import GRID_M, Ground
from sight import NO_RETURN, NO_WALL, Beams, Place, Unclear, directions

WORLD_M = 80.0
CARVED_M = 2 * GRID_M  # the grid that is carved; the wall is straight between its points
SPOTS = 12  # in one world
LEAST_CLEAR_M = 0.33


# Fields.


def noise(rng: np.random.Generator, size: int, longest_m: float, shortest_m: float, slope: float) -> np.ndarray:
    """Of standard deviation 1; a wave twice as long is 2^slope times as high."""
    frequency = np.hypot(fft.fftfreq(size, CARVED_M)[:, None], fft.rfftfreq(size, CARVED_M)[None])
    with np.errstate(divide="ignore"):
        height = np.where((frequency > 1 / longest_m) & (frequency < 1 / shortest_m), frequency ** -(slope + 1.0), 0)
    waves = fft.irfft2(height * fft.rfft2(rng.standard_normal((size, size))), s=(size, size))
    return waves / waves.std()


def facets(rng: np.random.Generator, grid_m: np.ndarray, face_m: float) -> np.ndarray:
    """Flat faces that step from one to the next, between -1 and 1; each slants in its own way."""
    middles = rng.uniform(0, WORLD_M, (int((WORLD_M / face_m) ** 2), 2))
    nearest = cKDTree(middles).query(grid_m)[1]
    slant = rng.normal(0, 0.4 / face_m, middles.shape)
    height = rng.uniform(-0.7, 0.7, len(middles))[nearest] + np.sum((grid_m - middles[nearest]) * slant[nearest], axis=1)
    return np.clip(height, -1, 1)


def network(rng: np.random.Generator, spacing_m: float, more: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """The ends of passages that join all of some random points; `more` of the other neighbours are joined as well."""
    points = rng.uniform(3, WORLD_M - 3, (4000, 2))
    kept: list[np.ndarray] = []
    for point in points:
        if all(np.linalg.norm(point - other) > spacing_m for other in kept):
            kept.append(point)
    nodes = np.array(kept)
    triangles = Delaunay(nodes).simplices
    pairs = np.unique(np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [0, 2]]])), axis=0)
    pairs = pairs[np.linalg.norm(nodes[pairs[:, 0]] - nodes[pairs[:, 1]], axis=1) < 2.2 * spacing_m]
    group, passages = list(range(len(nodes))), []
    for a, b in rng.permutation(pairs):
        if group[a] != group[b] or rng.random() < more:
            group = [group[a] if of == group[b] else of for of in group]
            passages.append((nodes[a], nodes[b]))
    return passages


def steps(rng: np.random.Generator, at_m: np.ndarray, every_m: tuple[float, float], height_m: float) -> np.ndarray:
    """A new level every few metres."""
    ends_m = np.cumsum(rng.uniform(*every_m, int(at_m[-1] / every_m[0]) + 2))
    return rng.uniform(-height_m, height_m, len(ends_m))[np.searchsorted(ends_m, at_m)]


def swept(grid_m: np.ndarray, start, end, side_m: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]], bow_m: float):
    """How far inside a passage each point is, metres; its sides are as far from its middle as `side_m` says along it."""
    length_m = np.linalg.norm(end - start)
    at_m = np.arange(0, length_m, 0.1)
    forward = (end - start) / length_m
    aside = np.array([-forward[1], forward[0]])
    line = start + at_m[:, None] * forward + bow_m * np.sin(np.pi * at_m / length_m)[:, None] * aside
    left_m, right_m = side_m(at_m)
    widest_m = max(left_m.max(), right_m.max())
    low_m, high_m = line.min(axis=0) - widest_m - 3, line.max(axis=0) + widest_m + 3
    near = np.flatnonzero(((grid_m > low_m) & (grid_m < high_m)).all(axis=1))
    off_m, nearest = cKDTree(line).query(grid_m[near])
    to = grid_m[near] - line[nearest]
    is_left = forward[0] * to[:, 1] - forward[1] * to[:, 0] > 0
    return near, np.where(is_left, left_m[nearest], right_m[nearest]) - off_m


# Kinds of worlds.


def grid(size: int) -> np.ndarray:
    at_m = np.arange(size) * CARVED_M
    return np.stack(np.meshgrid(at_m, at_m), axis=-1).reshape(-1, 2)


def carved(
    rng: np.random.Generator,
    widths_m,
    *,
    wander_m=0.0,
    step_m=0.0,
    every_m=(2, 4),
    rough_m=0.0,
    face_m=0.0,
    chambers=0.0,
    spacing_m=None,
) -> np.ndarray:
    size = int(WORLD_M / CARVED_M)
    grid_m = grid(size)
    place_m = grid_m
    if wander_m:
        longest_m = rng.uniform(12, 30)
        place_m = grid_m + wander_m * np.stack([noise(rng, size, longest_m, 5, 1.0).ravel() for _ in range(2)], axis=1)
    usual_m = np.exp(rng.uniform(*np.log(widths_m)))
    spacing_m = spacing_m or max(rng.uniform(5, 9), rng.uniform(2, 3.5) * usual_m)
    inside_m = np.full(size * size, -9.0)
    for start, end in network(rng, spacing_m, rng.uniform(0.05, 0.4)):
        half_m = np.clip(usual_m * np.exp(rng.normal(0, 0.25)), 0.6, 9) / 2
        neck = rng.random() < 0.15

        def side_m(at_m):
            sides = [half_m + steps(rng, at_m, every_m, step_m) for _ in range(2)]
            if neck:
                pinch = np.exp(-(((at_m - rng.uniform(0.2, 0.8) * at_m[-1]) / rng.uniform(0.3, 1.5)) ** 2))
                sides = [side - pinch * half_m * rng.uniform(0.3, 0.9) for side in sides]
            return [np.maximum(side, 0.1) for side in sides]

        near, here_m = swept(place_m, start, end, side_m, rng.normal(0, 0.08) * np.linalg.norm(end - start) if wander_m else 0)
        inside_m[near] = np.maximum(inside_m[near], here_m)
        if rng.random() < chambers:
            round_m = usual_m * rng.uniform(0.6, 1.5) - np.linalg.norm((place_m - start) * np.exp(rng.normal(0, 0.2, 2)), axis=1)
            inside_m = np.maximum(inside_m, round_m)
    if rough_m:
        inside_m += rough_m * noise(rng, size, 8, 0.2, rng.uniform(0.4, 1.1)).ravel()
    if face_m:
        inside_m += face_m * facets(rng, grid_m, rng.uniform(0.6, 3))
    return inside_m.reshape(size, size)


def drifts(rng):
    step_m, rough_m = rng.uniform(0.05, 0.35), rng.uniform(0.02, 0.12)
    face_m, wander_m = rng.choice([0, rng.uniform(0.1, 0.4)]), rng.choice([0, 0.5])
    return carved(rng, (2, 6), step_m=step_m, rough_m=rough_m, face_m=face_m, wander_m=wander_m)


def caves(rng):
    wander_m, rough_m = rng.uniform(0.6, 2.5), rng.uniform(0.1, 0.6)
    face_m = rng.choice([0, rng.uniform(0.1, 0.6)])
    return carved(rng, (1, 9), wander_m=wander_m, rough_m=rough_m, face_m=face_m, chambers=0.25)


def narrow(rng):
    wander_m, rough_m = rng.choice([0, rng.uniform(0.3, 1.5)]), rng.uniform(0.02, 0.2)
    face_m = rng.choice([0, 0.15])
    return carved(rng, (0.8, 1.7), wander_m=wander_m, rough_m=rough_m, step_m=0.1, face_m=face_m, chambers=0.1)


def recess(rng):
    step_m, every_m, rough_m = rng.uniform(0.1, 0.4), (1, rng.uniform(3, 7)), rng.uniform(0.01, 0.08)
    return carved(rng, (2.5, 4), step_m=step_m, every_m=every_m, rough_m=rough_m, spacing_m=rng.uniform(12, 18))


def worn(rng):
    """Where many walked, rock is worn away."""
    size, worn_away = int(WORLD_M / CARVED_M), None
    steps_taken = np.zeros((size, size))
    for start, end in network(rng, rng.uniform(7, 12), rng.uniform(0.05, 0.3)):
        for _ in range(4):
            count = int(3 * np.linalg.norm(end - start) / CARVED_M)
            drift = np.linspace(0, 1, count)[:, None] * (end - start)
            walk = np.cumsum(rng.normal(0, CARVED_M, (count, 2)), axis=0)
            walk -= np.linspace(0, 1, count)[:, None] * walk[-1]
            at = np.clip((start + drift + rng.uniform(0.3, 1.2) * walk) / CARVED_M, 0, size - 1).astype(int)
            np.add.at(steps_taken, (at[:, 1], at[:, 0]), 1)
    wear_m = rng.uniform(0.4, 1.1)
    worn_away = ndimage.gaussian_filter(np.minimum(steps_taken, 3), wear_m / CARVED_M)
    signed_m = signed(worn_away > rng.uniform(0.08, 0.25))
    return signed_m + rng.uniform(0.02, 0.25) * noise(rng, size, 6, 0.2, rng.uniform(0.4, 1.0))


def grown(rng):
    """Cells live or die by their neighbours."""
    base_m = carved(rng, (1.5, 6), wander_m=rng.uniform(0.5, 2), rough_m=0.3)
    cell = rng.integers(3, 8)
    alive = base_m[::cell, ::cell] + rng.uniform(0.3, 1.2) * rng.standard_normal(base_m[::cell, ::cell].shape) > 0
    for _ in range(rng.integers(2, 5)):
        alive = ndimage.uniform_filter(alive.astype(float), 3) > 0.5
    near_m = ndimage.zoom(signed(alive) * cell, cell, order=1)[: len(base_m), : len(base_m)]
    padded = np.full(base_m.shape, -1.0)
    padded[: near_m.shape[0], : near_m.shape[1]] = near_m
    return padded + rng.uniform(0.02, 0.2) * noise(rng, len(base_m), 4, 0.2, 0.7)


def signed(free: np.ndarray) -> np.ndarray:
    inside, outside = (ndimage.distance_transform_edt(part) for part in (free, ~free))
    return (inside - outside) * CARVED_M


WORLDS = {"drifts": drifts, "caves": caves, "narrow": narrow, "worn": worn, "grown": grown, "recess": recess}


def world(kind: str, rng: np.random.Generator) -> Ground:
    """One piece of free space on the finer grid, in rock on all sides, without rock that stands alone and is small; a few
    posts stand in some."""
    field = WORLDS[kind](rng)
    rim = int(1 / CARVED_M)
    field[:rim], field[-rim:], field[:, :rim], field[:, -rim:] = -1, -1, -1, -1
    fine = ndimage.zoom(np.clip(field, -1, 1), CARVED_M / GRID_M, order=1)
    parts, _ = ndimage.label(fine > 0)
    largest = np.bincount(parts[parts > 0]).argmax()
    fine[(fine > 0) & (parts != largest)] = -0.05
    alone, count = ndimage.label(fine <= 0)
    for part, (y, x) in enumerate(ndimage.find_objects(alone), start=1):
        if max(y.stop - y.start, x.stop - x.start) * GRID_M < 3:
            fine[y, x][alone[y, x] == part] = 0.05
    ground = Ground(fine, (0.0, 0.0))
    if rng.random() < 0.4:
        room = np.argwhere(ground.clearance_m > 1.2)
        posts = room[rng.integers(len(room), size=30)] * GRID_M if len(room) else []
        sizes_m = rng.uniform(0.05, 0.35, len(posts))
        ground = Ground(fine, (0.0, 0.0), tuple((x, y, r) for (y, x), r in zip(posts, sizes_m)))
    return ground


def spots_m(ground: Ground, rng: np.random.Generator) -> np.ndarray:
    """Where a flight comes by: not much nearer to a wall than to the middle."""
    coarse = ground.clearance_m[::4, ::4]
    middle = ndimage.maximum_filter(coarse, size=int(2 / (4 * GRID_M)))
    usual = np.argwhere((coarse > LEAST_CLEAR_M) & (coarse > 0.45 * middle))
    chosen = usual[rng.integers(len(usual), size=40 * SPOTS)]
    spots = chosen[:, ::-1] * 4 * GRID_M
    apart = [np.linalg.norm(np.array(ground.posts)[:, :2] - spot, axis=1).min() > 0.7 if ground.posts else True for spot in spots]
    return spots[np.array(apart)]


# What lidars do.


def any_beams(rng: np.random.Generator, most_m: float = 30.0) -> Beams:
    count = int(rng.choice([180, 360, 720, 1080], p=[0.1, 0.6, 0.2, 0.1]))
    range_max_m = np.exp(rng.uniform(np.log(6), np.log(most_m)))
    if rng.random() < 0.8:
        return Beams(count, -np.pi, 2 * np.pi / count, range_max_m, full_turn=True)
    view_rad = np.radians(rng.uniform(180, 270))
    return Beams(count, -view_rad / 2, view_rad / (count - 1), range_max_m, full_turn=False)


def measured(view: passable.View, beams: Beams, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """The scan with everything that lidars do, each in some places, and the labels of its beams."""
    count = beams.count
    ranges_m, labels = view.ranges_m.copy(), view.labels.copy()
    known_m = np.where(np.isfinite(ranges_m), ranges_m, 0)
    inexact = rng.uniform(0, 0.03) + known_m * rng.choice([0, rng.uniform(0, 0.015)], p=[0.7, 0.3])
    with np.errstate(invalid="ignore"):
        ranges_m = np.where(np.isfinite(ranges_m), ranges_m + inexact * rng.standard_normal(count), np.inf)
    if rng.random() < 0.3:
        mix(ranges_m, labels, view.ranges_m, rng)
    if rng.random() < 0.25:
        dusty = np.flatnonzero((rng.random(count) < rng.uniform(0, 0.04)) & np.isfinite(view.ranges_m))
        dusty = dusty[np.diff(dusty, prepend=-2) > 1]
        ranges_m[dusty] *= rng.uniform(0.2, 0.9, len(dusty))
        labels[dusty] = NO_WALL
    lost = rng.random(count) < rng.choice([0, rng.uniform(0, 0.06), rng.uniform(0.05, 0.15)], p=[0.4, 0.45, 0.15])
    if rng.random() < 0.4:  # grazing beams
        lost |= rng.random(count) < 0.9 * np.exp(-view.incidence / rng.uniform(0.02, 0.08))
    for _ in range(rng.choice([0, 1, 2, 4], p=[0.6, 0.2, 0.1, 0.1])):  # wet patches
        middle = rng.integers(count)
        if np.isfinite(view.ranges_m[middle]):
            half = rng.uniform(0.15, 0.8) / view.ranges_m[middle] / beams.step_rad
            patch = np.abs((np.arange(count) - middle + count / 2) % count - count / 2) < half
            lost |= patch & (rng.random(count) < rng.uniform(0.7, 1)) & (np.abs(view.ranges_m - view.ranges_m[middle]) < 1.0)
    lost |= ranges_m > beams.range_max_m
    ranges_m[lost], labels[lost] = np.inf, NO_RETURN
    return ranges_m.astype(np.float32), labels


def mix(ranges_m: np.ndarray, labels: np.ndarray, exact_m: np.ndarray, rng: np.random.Generator):
    """At half of the edges, where one thing hides another, a beam reports a range in between."""
    known_m = np.where(np.isfinite(exact_m), exact_m, 1e3)
    for before in np.flatnonzero((np.abs(np.diff(known_m)) > 0.4) & (known_m[1:] < 1e3) & (known_m[:-1] < 1e3)):
        beside = np.abs(np.diff(known_m[max(before - 1, 0) : before + 3]))
        if rng.random() < 0.5 and np.abs(known_m[before + 1] - known_m[before]) > 2.5 * np.sort(beside)[-2]:
            reported = rng.choice([before, before + 1])
            ranges_m[reported], labels[reported] = rng.uniform(*np.sort(known_m[[before, before + 1]])), NO_WALL


def place_at(ground: Ground, spot_m: np.ndarray, beams: Beams, rng: np.random.Generator, redrawn: int) -> Place:
    view = passable.look(ground, spot_m, rng.uniform(-np.pi, np.pi), beams)
    ranges_m, labels = measured(view, beams, rng)
    return Place(beams, ranges_m, view.truth(labels), redrawn)


def make(kind: str, count: int, seed: int) -> tuple[list[Place], dict[str, int]]:
    """Some places, and why others were left out."""
    if kind in real_kinds.KINDS:
        return real_kinds.make(kind, count, seed, measured)
    made: list[Place] = []
    left_out: dict[str, int] = {}
    number = 0
    while len(made) < count:
        rng = np.random.default_rng([seed, *kind.encode(), number])
        number += 1
        ground, done = world(kind, rng), 0
        for spot_m in spots_m(ground, rng):
            try:
                made.append(place_at(ground, spot_m, any_beams(rng), rng, 0))
                done += 1
            except Unclear as why:
                left_out[str(why)] = left_out.get(str(why), 0) + 1
            if done == SPOTS or len(made) == count:
                break
    return made, left_out


KINDS = [*WORLDS, *real_kinds.KINDS]


def main() -> int:
    parser = argparse.ArgumentParser(description="Writes test places in rock, with known truth, as MCAP.")
    parser.add_argument("out", type=Path, metavar="OUT_DIR")
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"{', '.join(KINDS)}; all if none")
    parser.add_argument("--count", type=int, default=100, help="places of each kind")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_intermixed_args()
    if unknown := [kind for kind in args.kinds if kind not in KINDS]:
        parser.error(f"no kind is called {unknown[0]}; there are {', '.join(KINDS)}")
    args.out.mkdir(parents=True, exist_ok=True)
    for kind in args.kinds or KINDS:
        made, left_out = make(kind, args.count, args.seed)
        share = sum(left_out.values()) / (sum(left_out.values()) + len(made))
        reasons = ", ".join(f"{why} {times}" for why, times in sorted(left_out.items()))
        print(f"{kind:<18} {len(made)} places, {share:.0%} left out: {reasons}", flush=True)
        places.write(args.out / f"{kind}.mcap", made)
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Test places with known truth, made without the program's own simulator and with other means.

Kinds, each a plane of free space with smooth walls in half of the places and rough ones in the others:
- tunnels       straight ones, bends of 45 to 135°, and wide curves; some cross themselves
- dead_ends     tunnels that end flat, slanted or round, some behind a bend
- tees          a branch leaves a tunnel at 30 to 150°, half as wide to as wide; some arms are dead ends
- crossings     four or five arms of different widths, some of them dead ends
- forks         Y, some arms are dead ends
- drifts        two parallel drifts with crosscuts between them and side passages, staggered
- chambers      round or with 5 to 8 corners, 1 to 4 exits, most with posts and pillars
- rooms         a building: rooms and corridors behind doors of 1 to 3 m
- caves         wandering centreline, width that varies, branches
- mines         room and pillar
- halls         beside a wall of a hall wider than most ranges, a straight one, a corner or a bay; boxes stand before some
- dark_doors    a room with one or two doors of 1 to 3 m into a hall whose far side is mostly out of range
- niches        corridors with niches of 0.2 to 0.4 m; they go on, end, meet another corridor or have a side passage
- furnished     tunnels, dead ends, tees, crossings and drifts whose walls have recesses, posts, door frames and furniture;
                of these nearly all are close calls, so they are made with `--close` alone

The sensor stands anywhere in the free space near the middle, 0.5 m from all walls, and looks anywhere; beams, view,
range and noise vary from place to place; beams are lost, and in some places dust is seen. Truth is what `sight` says of
the same view without noise. Places that it leaves out are drawn anew; how many were is counted. With `--close` niches and
ways about as deep as the definition asks are let in, and what a vehicle of another width takes for something else. With `--effects`, what
real lidars do is done to all of them, one effect at a time (`effects`).

Not here: floors that are not level, motion during the revolution, people.

Usage: tests/foreign/run places OUT_DIR [--count N] [--seed S] [--close] [--effects] [KIND...]
One MCAP a kind, or with `--effects` one an effect, for `crosscut compare OUT_DIR`.
"""

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
import shapely.ops
from shapely import LineString, Point, Polygon, affinity, box

import sight
import writing
from effects import EFFECTS
from sight import Beams, Place, Unclear, directions

ARM_M = 110.0  # longer than any range
FIXTURES = [(0.1, 0.4, 0.3), (0.8, 1.3, 0.3), (0.5, 2.5, 0.8)]  # posts, door frames, recesses and furniture: lengths, depth
WALL_CLEARANCE_M = 0.5


@dataclass(frozen=True)
class Ground:
    """Free space, and where in it the sensor may stand: no further than `near_m` from the origin."""

    free: shapely.Geometry
    near_m: float = 30.0
    roughest_m: float = 0.2


# The kinds.


def tunnel(rng: np.random.Generator) -> Ground:
    return Ground(strip(bent_line(rng, bends=rng.integers(0, 3)), rng.uniform(1.5, 8), rng))


def dead_end(rng: np.random.Generator) -> Ground:
    width_m = rng.uniform(1.5, 8)
    free = strip(bent_line(rng, bends=rng.integers(0, 2), back_m=0), width_m, rng)
    match rng.choice(["flat", "round", "slanted"]):
        case "round":
            free = free.union(Point(0, 0).buffer(width_m / 2))
        case "slanted":
            tip = (-width_m * rng.uniform(0.2, 1), width_m / 2)
            free = free.union(Polygon([tip, (0.01, -width_m / 2), (0.01, width_m / 2)]))
    return Ground(free)


def tee(rng: np.random.Generator) -> Ground:
    width_m = rng.uniform(1.5, 8)
    branch_rad = np.radians(rng.uniform(30, 150))
    branch_m = max(1.5, width_m * rng.uniform(0.5, 1))
    return arms([0, np.pi, branch_rad], [width_m, width_m, branch_m], rng)


def crossing(rng: np.random.Generator) -> Ground:
    count = rng.integers(4, 6)
    return arms(headings_rad(rng, count, 50), rng.uniform(1.5, 8) * rng.uniform(0.5, 1, count), rng, corner_m=1)


def fork(rng: np.random.Generator) -> Ground:
    sides_rad = np.radians([rng.uniform(15, 60), -rng.uniform(15, 60)])
    widths_m = rng.uniform(2, 8) * np.array([1, *rng.uniform(0.5, 1, 2)])
    return arms([np.pi, *sides_rad], widths_m, rng, corner_m=1)


def drifts(rng: np.random.Generator) -> Ground:
    widths_m = rng.uniform(2.5, 7, 2)
    between_m = rng.uniform(3, 10)
    centre_m = between_m + widths_m.sum() / 2
    parts = [
        box(-ARM_M, -widths_m[0] / 2, ARM_M, widths_m[0] / 2),
        box(-ARM_M, centre_m - widths_m[1] / 2, ARM_M, centre_m + widths_m[1] / 2),
    ]
    for x_m in spaced(rng, 8, 25):
        parts.append(passage((x_m, 0), (x_m + rng.uniform(-3, 3), centre_m), rng.uniform(1.5, 5)))
    for x_m in spaced(rng, 10, 40):
        end = (x_m + rng.uniform(-6, 6), -rng.choice([rng.uniform(4, 15), ARM_M]))
        parts.append(passage((x_m, 0), end, rng.uniform(1.5, 5)))
    return Ground(shapely.union_all(parts))


def chamber(rng: np.random.Generator) -> Ground:
    radius_m = rng.uniform(4, 12)
    if rng.random() < 0.4:
        hall = affinity.scale(Point(0, 0).buffer(radius_m), 1, rng.uniform(0.6, 1))
    else:
        corners = rng.integers(5, 9)
        reach_m = radius_m * rng.uniform(0.75, 1.1, corners)
        hall = Polygon(reach_m[:, None] * directions(np.array(headings_rad(rng, corners, 25))))
    exits = headings_rad(rng, rng.integers(1, 5), 50)
    free = shapely.union_all([hall, *(passage((0, 0), ARM_M * directions(h), rng.uniform(1.5, 4)) for h in exits)])
    if rng.random() < 0.75:
        free = with_posts(free, hall, rng)
    return Ground(free, near_m=radius_m)


def rooms(rng: np.random.Generator) -> Ground:
    """A grid of cells with doors to most of their neighbours; some rows and columns are corridors."""
    wall_m = rng.uniform(0.15, 0.5)
    xs_m, ys_m = cell_edges_m(rng), cell_edges_m(rng)
    parts = []
    for i, (x_m, x_end_m) in enumerate(zip(xs_m, xs_m[1:] - wall_m)):
        for j, (y_m, y_end_m) in enumerate(zip(ys_m, ys_m[1:] - wall_m)):
            parts.append(box(x_m, y_m, x_end_m, y_end_m))
            if i and rng.random() < 0.7:
                from_m, to_m = door_m(rng, y_m, y_end_m)
                parts.append(box(x_m - wall_m - 0.01, from_m, x_m + 0.01, to_m))
            if j and rng.random() < 0.7:
                from_m, to_m = door_m(rng, x_m, x_end_m)
                parts.append(box(from_m, y_m - wall_m - 0.01, to_m, y_m + 0.01))
    return Ground(shapely.union_all(parts), roughest_m=wall_m / 4)


def cave(rng: np.random.Generator) -> Ground:
    """A way through, dead at one end at times, and up to two side branches."""
    parts = [burrow((0, 0), 0, ARM_M, rng), burrow((0, 0), np.pi, rng.choice([ARM_M, rng.uniform(5, 20)]), rng)]
    for _ in range(rng.integers(0, 3)):
        heading_rad = rng.choice([-1, 1]) * np.radians(rng.uniform(50, 130))
        parts.append(burrow((rng.uniform(-3, 8), 0), heading_rad, rng.choice([ARM_M, rng.uniform(8, 20)]), rng))
    return Ground(shapely.union_all(parts))


def mine(rng: np.random.Generator) -> Ground:
    road_m, pillar_m = rng.uniform(3, 8, 2), rng.uniform(4, 14, 2)
    pitch_m, rounding_m = road_m + pillar_m, rng.uniform(0, 1.5)
    reach = np.ceil(ARM_M / pitch_m / 1.4).astype(int)
    pillars = []
    for i in range(-reach[0], reach[0] + 1):
        for j in range(-reach[1], reach[1] + 1):
            half_m = pillar_m / 2 + road_m * rng.uniform(-0.15, 0.1, 2)
            x_m, y_m = (np.array([i, j]) + 0.5) * pitch_m + road_m * rng.uniform(-0.1, 0.1, 2)
            block = box(x_m - half_m[0], y_m - half_m[1], x_m + half_m[0], y_m + half_m[1])
            pillars.append(block.buffer(-rounding_m).buffer(rounding_m, quad_segs=6))
    (reach_x_m, reach_y_m), end_is_near = reach * pitch_m, rng.random() < 0.5
    mined = box(-reach_x_m * (0.1 if end_is_near else 1), -reach_y_m, reach_x_m, reach_y_m)
    return Ground(mined.difference(shapely.union_all(pillars)))


def hall(rng: np.random.Generator) -> Ground:
    """The origin is 1.5 to 4 m from the wall."""
    reach_m, off_m = 2.5 * ARM_M, rng.uniform(1.5, 4)
    match rng.choice(["straight", "corner", "bay"]):
        case "straight":
            tilt_m = rng.uniform(-0.1, 0.1, 2) * reach_m
            solid = Polygon([(-reach_m, off_m + tilt_m[0]), (0, off_m), (reach_m, off_m + tilt_m[1]), (0, 2 * reach_m)])
        case "corner":
            solid = box(-reach_m, off_m, reach_m, reach_m).union(box(rng.uniform(2, 6), -reach_m, reach_m, reach_m))
        case "bay":
            half_m, depth_m = rng.uniform(2, 5), off_m + rng.uniform(0, 3)
            bay = box(-half_m, off_m - depth_m, half_m, off_m)
            solid = box(-reach_m, off_m - depth_m, reach_m, reach_m).difference(bay)
    boxes = []
    for _ in range(rng.choice([0, 0, 1, 2])):
        x_m, half_m, depth_m = rng.uniform(-6, 6), *rng.uniform(0.3, 0.6, 2)
        boxes.append(box(x_m - half_m, off_m - depth_m, x_m + half_m, off_m + 0.1))
    free = box(-reach_m, -reach_m, reach_m, reach_m).difference(shapely.union_all([solid, *boxes]))
    return Ground(free, near_m=3)


def dark_door(rng: np.random.Generator) -> Ground:
    """A room around the origin; its doors are in opposite walls."""
    half_m, wall_m = rng.uniform(2, 5, 2), rng.uniform(0.1, 0.4)
    parts = [box(*-half_m, *half_m)]
    for side in (1, -1)[: rng.integers(1, 3)]:
        door_half_m = min(rng.uniform(0.5, 1.5), 0.4 * half_m[1])
        middle_m = rng.uniform(-0.8, 0.8) * (half_m[1] - door_half_m)
        x_m = side * (half_m[0] + wall_m)
        parts.append(passage((0, middle_m), (x_m + 0.01 * side, middle_m), 2 * door_half_m))
        parts.append(passage((x_m, middle_m), (x_m + ARM_M * side, middle_m), rng.uniform(20, 2 * ARM_M)))
    free = affinity.rotate(shapely.union_all(parts), rng.uniform(0, 90), origin=(0, 0))
    return Ground(free, near_m=1.5 * half_m.min(), roughest_m=0.05)


def niches(rng: np.random.Generator) -> Ground:
    half_m, depth_m = rng.uniform(1.2, 2.6), rng.uniform(0.2, 0.4)
    parts = [box(-ARM_M, -half_m, ARM_M, half_m)]
    for side in (1, -1)[: rng.integers(1, 3)]:
        starts_m = spaced(rng, 1.5, 3)
        for x_m, length_m in zip(starts_m, rng.uniform(0.5, 1.2, len(starts_m))):
            low_m, high_m = sorted((0, side * (half_m + depth_m)))
            parts.append(box(x_m, low_m, x_m + length_m, high_m))
    free, end_m, across_m = shapely.union_all(parts), rng.uniform(2, 8), rng.uniform(1.5, 3)
    match rng.choice(["on", "ends", "ahead", "aside"]):
        case "ends":
            free = free.intersection(box(-ARM_M, -ARM_M, end_m, ARM_M))
        case "ahead":
            across = box(end_m, -ARM_M, end_m + across_m, ARM_M)
            free = free.intersection(box(-ARM_M, -ARM_M, end_m, ARM_M)).union(across)
        case "aside":
            side_m = rng.choice([ARM_M, -ARM_M])
            free = free.union(passage((end_m, 0), (end_m + rng.uniform(-3, 3), side_m), across_m))
    return Ground(free, near_m=4, roughest_m=0.05)


def furnished(rng: np.random.Generator) -> Ground:
    """Every 0.5 to 4 m something is cut into the wall, or stands before it."""
    ground = rng.choice([tunnel, dead_end, tee, crossing, drifts])(rng)
    free = ground.free
    for wall in shapely.get_parts(shapely.line_merge(free.boundary.intersection(Point(0, 0).buffer(ARM_M / 4)))):
        for at_m in np.cumsum(rng.uniform(0.5, 4, int(wall.length / 2))):
            shortest_m, longest_m, deepest_m = FIXTURES[rng.choice(len(FIXTURES))]
            part = shapely.ops.substring(wall, at_m, at_m + rng.uniform(shortest_m, longest_m))
            stuck = part.buffer(rng.uniform(0.05, deepest_m), cap_style="flat", join_style="mitre")
            free = free.union(stuck) if rng.random() < 0.5 else free.difference(stuck)
    return Ground(free, near_m=8, roughest_m=0.05)


KINDS: dict[str, Callable[[np.random.Generator], Ground]] = {
    "tunnels": tunnel,
    "dead_ends": dead_end,
    "tees": tee,
    "crossings": crossing,
    "forks": fork,
    "drifts": drifts,
    "chambers": chamber,
    "rooms": rooms,
    "caves": cave,
    "mines": mine,
    "halls": hall,
    "dark_doors": dark_door,
    "niches": niches,
}
CLOSE_KINDS = KINDS | {"furnished": furnished}


# Their parts.


def strip(line: np.ndarray, width_m: float, rng: np.random.Generator) -> Polygon:
    return LineString(line).buffer(width_m / 2, cap_style="flat", join_style=rng.choice(["mitre", "round"]))


def passage(start, end, width_m: float) -> Polygon:
    return LineString([start, end]).buffer(width_m / 2, cap_style="flat")


def bent_line(rng: np.random.Generator, bends: int, back_m: float = ARM_M) -> np.ndarray:
    """Through the origin along x, with bends near it, sharp or in steps of at most 15°."""
    points, heading_rad = [np.array([-back_m, 0.0]), np.array([rng.uniform(2, 8), 0.0])], 0.0
    for _ in range(bends):
        turn_rad = rng.choice([-1, 1]) * np.radians(rng.uniform(45, 135))
        steps = rng.choice([1, int(np.ceil(abs(turn_rad) / np.radians(15)))])
        for _ in range(steps):
            heading_rad += turn_rad / steps
            points.append(points[-1] + rng.uniform(1.5, 2.5) * directions(heading_rad))
        points.append(points[-1] + rng.uniform(4, 15) * directions(heading_rad))
    points.append(points[-1] + ARM_M * directions(heading_rad))
    return np.array(points)


def arms(arm_headings_rad, widths_m, rng: np.random.Generator, corner_m: float = 0) -> Ground:
    """Passages that meet at the origin, a quarter of them dead ends; `corner_m` rounds what lies between them."""
    parts = [Point(0, 0).buffer(max(widths_m) / 2 + corner_m * rng.uniform(0, 1))]
    for heading_rad, width_m in zip(arm_headings_rad, widths_m):
        length_m = rng.uniform(8, 25) if rng.random() < 0.25 else ARM_M
        parts.append(passage((0, 0), length_m * directions(heading_rad), width_m))
    return Ground(shapely.union_all(parts))


def headings_rad(rng: np.random.Generator, count: int, least_deg: float) -> list[float]:
    """All round, at least so far apart."""
    slack_rad = 2 * np.pi - count * np.radians(least_deg)
    return (np.cumsum(np.radians(least_deg) + slack_rad * rng.dirichlet(np.ones(count)))).tolist()


def spaced(rng: np.random.Generator, least_m: float, most_m: float) -> np.ndarray:
    return rng.uniform(-ARM_M, -ARM_M + most_m) + np.cumsum(rng.uniform(least_m, most_m, int(2 * ARM_M / most_m)))


def cell_edges_m(rng: np.random.Generator) -> np.ndarray:
    widths_m = np.where(rng.random(8) < 0.3, rng.uniform(1.8, 3, 8), rng.uniform(5, 16, 8))
    return np.cumsum(np.append(-25.0, widths_m))


def door_m(rng: np.random.Generator, from_m: float, to_m: float) -> tuple[float, float]:
    """Where a door begins and ends in the wall between these."""
    width_m = min(rng.uniform(1, 3), 0.9 * (to_m - from_m))
    begin_m = rng.uniform(from_m, to_m - width_m)
    return begin_m, begin_m + width_m


def with_posts(free: Polygon, hall: Polygon, rng: np.random.Generator) -> Polygon:
    """Up to four posts and pillars, round or square, that can be passed on all sides."""
    for _ in range(rng.integers(1, 5)):
        half_m = rng.uniform(0.1, 0.5) if rng.random() < 0.75 else rng.uniform(0.5, 3)
        x_m, y_m = rng.uniform(-0.8, 0.8, 2) * hall.bounds[2:]
        round_post = Point(x_m, y_m).buffer(half_m)
        post = round_post if rng.random() < 0.5 else affinity.rotate(round_post.envelope, rng.uniform(0, 90))
        if free.contains(post.buffer(1.2)):
            free = free.difference(post)
    return free


def burrow(start, heading_rad: float, length_m: float, rng: np.random.Generator) -> Polygon:
    """Discs along a line that wanders, with what lies between neighbours."""
    step_m = 0.5
    at_m = np.arange(0, length_m, step_m)
    turn_rad = waves(at_m, 8, 40, 0.6, rng)
    width_m = np.clip(rng.uniform(2, 6) + waves(at_m, 4, 20, 1.2, rng), 1.5, 8)
    points = start + np.cumsum(step_m * directions(heading_rad + turn_rad - turn_rad[0]), axis=0)
    discs = shapely.buffer(shapely.points(points), width_m / 2, quad_segs=6)
    return shapely.union_all(shapely.convex_hull(shapely.union(discs[1:], discs[:-1])))


def waves(
    at_m: np.ndarray, shortest_m: float, longest_m: float, amplitude: float, rng: np.random.Generator
) -> np.ndarray:
    """Four sine waves that add up to at most the amplitude, the long ones larger than the short."""
    lengths_m = np.exp(rng.uniform(np.log(shortest_m), np.log(longest_m), 4))
    phase_rad = 2 * np.pi * at_m[:, None] / lengths_m + rng.uniform(0, 2 * np.pi, 4)
    shares = lengths_m * rng.dirichlet(np.ones(4))
    return np.sin(phase_rad) @ (amplitude * shares / shares.sum())


# Walls, sensor, scan.


def make(kind: str, count: int, seed: int, close: bool = False) -> list[Place]:
    """Place i is the same whatever the count."""
    return [place(kind, np.random.default_rng([seed, *kind.encode(), i]), close) for i in range(count)]


def place(kind: str, rng: np.random.Generator, close: bool) -> Place:
    redrawn = 0
    while True:
        try:
            return draw(CLOSE_KINDS[kind](rng), rng, redrawn, close)
        except Unclear:
            redrawn += 1


def draw(ground: Ground, rng: np.random.Generator, redrawn: int, close: bool) -> Place:
    beams = any_beams(rng)
    free = around_sensor(ground, beams.range_max_m, rng)
    if rng.random() < 0.5:
        free = rough(free, rng.uniform(0.1, 1) * ground.roughest_m, rng)
    if not clear_of_walls(free):
        raise Unclear("too near to a wall")
    view = sight.look(free, beams, close)
    ranges_m, labels = measured(view, beams, rng)
    return Place(beams, ranges_m, view.truth(labels), redrawn)


def any_beams(rng: np.random.Generator) -> Beams:
    count = int(rng.choice([180, 360, 720, 1080, 1800], p=[0.1, 0.55, 0.1, 0.1, 0.15]))
    range_max_m = np.exp(rng.uniform(np.log(10), np.log(100)))
    if rng.random() < 0.75:
        return Beams(count, -np.pi, 2 * np.pi / count, range_max_m, full_turn=True)
    view_rad = np.radians(rng.uniform(180, 270))
    return Beams(count, -view_rad / 2, view_rad / (count - 1), range_max_m, full_turn=False)


def around_sensor(ground: Ground, range_max_m: float, rng: np.random.Generator) -> Polygon:
    """The free space that plays a part, in the body frame of a sensor anywhere in it and turned any way."""
    standing = shapely.intersection(ground.free.buffer(-WALL_CLEARANCE_M), Point(0, 0).buffer(ground.near_m))
    if standing.is_empty:
        raise Unclear("no room for the sensor")
    x_m, y_m = rng.uniform(standing.bounds[:2], standing.bounds[2:])
    while not shapely.contains_xy(standing, x_m, y_m):
        x_m, y_m = rng.uniform(standing.bounds[:2], standing.bounds[2:])
    near = ground.free.intersection(Point(x_m, y_m).buffer(range_max_m + sight.BEYOND_RANGE_M))
    moved = affinity.translate(near, -x_m, -y_m)
    return part_with_sensor(affinity.rotate(moved, rng.uniform(0, 360), origin=(0, 0)))


def part_with_sensor(free: shapely.Geometry) -> Polygon:
    for part in shapely.get_parts(free):
        if shapely.contains_xy(part, 0, 0):
            return part
    raise Unclear("in the wall")


def clear_of_walls(free: Polygon) -> bool:
    return free.boundary.distance(Point(0, 0)) >= WALL_CLEARANCE_M


def rough(free: Polygon, amplitude_m: float, rng: np.random.Generator) -> Polygon:
    """All rings but posts displaced across themselves by at most the amplitude."""
    outer, *holes = (rough_ring(np.array(ring.coords), amplitude_m, rng) for ring in (free.exterior, *free.interiors))
    solid = shapely.union_all([shapely.make_valid(Polygon(hole)) for hole in holes])
    return part_with_sensor(shapely.make_valid(Polygon(outer)).difference(solid))


def rough_ring(ring: np.ndarray, amplitude_m: float, rng: np.random.Generator) -> np.ndarray:
    corners_m = np.append(0, np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1)))
    length_m = corners_m[-1]
    if length_m < np.pi * sight.POST_M:
        return ring
    at_m = np.linspace(0, length_m, int(length_m / 0.1), endpoint=False)
    points = np.stack([np.interp(at_m, corners_m, ring[:, axis]) for axis in (0, 1)], axis=1)
    along = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    across = np.stack([along[:, 1], -along[:, 0]], axis=1) / (np.linalg.norm(along, axis=1)[:, None] + 1e-9)
    return points + across * waves(at_m, 0.3, 3, amplitude_m, rng)[:, None]


def measured(view: sight.View, beams: Beams, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """The scan with its noise, its lost beams and its dust, and the labels of its beams."""
    labels = view.labels.copy()
    ranges_m = view.hit_m + rng.normal(0, rng.uniform(0, 0.03), beams.count)
    if rng.random() < 0.25:
        dusty = np.flatnonzero(rng.random(beams.count) < rng.uniform(0, 0.04))
        dusty = dusty[np.diff(dusty, prepend=-2) > 1]
        reach_m = np.minimum(view.hit_m, beams.range_max_m)[dusty]
        ranges_m[dusty] = rng.uniform(0.2, 0.9, len(dusty)) * reach_m
        labels[dusty] = sight.NO_WALL
    lost = (rng.random(beams.count) < rng.uniform(0, 0.05)) | (ranges_m > beams.range_max_m)
    ranges_m[lost], labels[lost] = np.inf, sight.NO_RETURN
    return ranges_m.astype(np.float32), labels


# Files.

TRUTH_SCHEMA = Path(__file__).parents[2] / "crates/messages/src/truth.schema.json"


def write(path: Path, places: list[Place]):
    """The places at 10 Hz as `/scan`, each with its `/truth` at the same time."""
    seen = ((place.beams, place.ranges_m) for place in places)
    writing.write_scans(path, ((by.first_rad, by.step_rad, by.range_max_m, ranges_m) for by, ranges_m in seen))
    # The writer of ROS 2 writes nothing else: what it wrote is written again, with the truth in between.
    scans = writing.messages_of(path)
    truths = [truth_message(place, scan) for place, scan in zip(places, scans)]
    writing.write_raw(path, [message for pair in zip(scans, truths) for message in pair])


def truth_message(place: Place, scan: writing.Message) -> writing.Message:
    return replace(
        scan,
        topic="/truth",
        schema_name="truth",
        schema_encoding="jsonschema",
        schema=TRUTH_SCHEMA.read_bytes(),
        encoding="json",
        data=json.dumps(place.truth).encode(),
    )


def with_effect(name: str, places: list[Place], seed: int) -> list[Place]:
    return [EFFECTS[name](place, np.random.default_rng([seed, *name.encode(), i])) for i, place in enumerate(places)]


def main() -> int:
    parser = argparse.ArgumentParser(prog="tests/foreign/run places", description="Writes test places with known truth as MCAP.")
    parser.add_argument("out", type=Path, metavar="OUT_DIR")
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"{', '.join(CLOSE_KINDS)}; all if none")
    parser.add_argument("--count", type=int, default=100, help="places of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--close", action="store_true", help="let in close calls, such as niches, by the definition")
    parser.add_argument("--effects", action="store_true", help=f"do to the places what real lidars do: {', '.join(EFFECTS)}")
    args = parser.parse_intermixed_args()
    kinds = CLOSE_KINDS if args.close else KINDS
    if unknown := [kind for kind in args.kinds if kind not in kinds]:
        parser.error(f"no kind is called {unknown[0]}; there are {', '.join(kinds)}")
    args.out.mkdir(parents=True, exist_ok=True)
    made = {}
    for kind in args.kinds or kinds:
        made[kind] = make(kind, args.count, args.seed, args.close)
        redrawn = sum(place.redrawn for place in made[kind])
        print(f"{kind:<10} {args.count} places, {redrawn / max(redrawn + args.count, 1):.0%} of all drawn left out")
    if args.effects:
        made = {name: with_effect(name, sum(made.values(), []), args.seed) for name in EFFECTS}
    for name, places in made.items():
        write(args.out / f"{name}.mcap", places)
    return 0


if __name__ == "__main__":
    sys.exit(main())

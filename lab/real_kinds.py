"""Places built after what was wrong with real scans, with the truth of what a vehicle's disc can do (`passable`).

- near_wall           0.35 to 0.8 m beside the sensor a straight wall 1.7 to 2.4 m long; else two clusters of few returns
- one_wall_and_legs   a long wall 0.6 to 0.7 m away in a hall, and legs 5 to 15 cm wide, 1 to 2 m away
- person_ahead        a passage 2.4 m wide; bodies 1.7 to 2.7 m ahead, together 0.6 to 1 m wide
- pilasters           pilasters 0.1 to 0.4 m deep and niches in straight walls, seen at grazing incidence; some dead ends
- edge_on             a tee whose far wall shows 0.7 m beside its mouth, a side way, a door at 13 m
- corners             a crossing of four thin L-shaped corners with gaps of 0.85 to 2.1 m
- step_back           a side wall ends, 0.2 to 0.6 m behind it a wall stands across, far ahead in a straight passage
- seen_edge_on_bend   a narrow passage that bends at its end, the mouth seen nearly edge-on
- narrow_ways         tees, crossings and bends of passages of 0.9 to 1.6 m
"""

from collections.abc import Callable

import numpy as np
import shapely
from scipy import ndimage
from shapely import LineString, box

import passable
from passable import GRID_M, Ground
from sight import Beams, Place, Unclear, directions

FAR_M = 60.0


def strip(*points, width_m: float) -> shapely.Geometry:
    return LineString(points).buffer(width_m / 2, cap_style="flat", join_style="mitre")


def near_wall(rng):
    off_m, long_m = rng.uniform(0.35, 0.8), rng.uniform(1.7, 2.4)
    start_m = -long_m * rng.uniform(0.3, 0.7)
    free = box(-FAR_M, -FAR_M, FAR_M, FAR_M) - box(start_m, off_m, start_m + long_m, off_m + rng.uniform(0.1, 0.3))
    posts = [cluster(rng, rng.uniform(-150, -30), rng.uniform(1.3, 2.5), rng.uniform(0.03, 0.08)) for _ in range(2)]
    return free, posts, full(361, 5.0)


def one_wall_and_legs(rng):
    off_m = rng.uniform(0.6, 0.7)
    free = box(-FAR_M, -FAR_M, FAR_M, off_m)
    legs = rng.integers(1, 3)
    posts = [cluster(rng, rng.uniform(-150, -30), rng.uniform(1, 2), rng.uniform(0.025, 0.075)) for _ in range(legs)]
    return free, posts, full(360, rng.uniform(5, 8))


def person_ahead(rng):
    half_m, at_m = 1.2, rng.uniform(1.7, 2.7)
    end_m = rng.choice([FAR_M, rng.uniform(4.5, 7)])
    free = box(-FAR_M, -half_m, end_m, half_m)
    width_m = rng.uniform(0.6, 1.0)
    middle_m = rng.uniform(-1, 1) * (half_m - width_m / 2 - 0.8)
    bodies = [(at_m + rng.uniform(-0.1, 0.1), middle_m + side * width_m / 4, width_m / 4) for side in (-1, 1)]
    return free, bodies, full(360, 8.0)


def pilasters(rng):
    half_m = rng.uniform(0.8, 2)
    free = box(-FAR_M, -half_m, rng.choice([FAR_M, rng.uniform(3, 8)]), half_m)
    for side in (-1, 1):
        at_m = -10.0
        while at_m < 10:
            at_m += rng.uniform(1, 4)
            long_m, deep_m = rng.uniform(0.2, 0.6), rng.uniform(0.1, 0.4)
            if rng.random() < 0.7:
                free -= box(at_m, side * half_m - deep_m, at_m + long_m, side * half_m + deep_m)
            else:
                free = free.union(box(at_m, side * half_m - deep_m, at_m + 2 * long_m, side * half_m + 2.5 * deep_m))
    return free, [], any_view(rng, rng.uniform(5, 20))


def edge_on(rng):
    match rng.integers(3):
        case 0:
            half_m, ahead_m, back_m = rng.uniform(0.8, 2), rng.uniform(3, 8), rng.uniform(1.5, 2.5)
            across = box(ahead_m - back_m, -FAR_M, ahead_m, FAR_M if rng.random() < 0.5 else half_m)
            free = box(-FAR_M, -half_m, ahead_m, half_m).union(across)
        case 1:
            half_m, wide_m, at_m = rng.uniform(0.8, 2), rng.uniform(1.2, 2.5), rng.uniform(-2, 6)
            free = box(-FAR_M, -half_m, FAR_M, half_m).union(box(at_m, 0, at_m + wide_m, rng.uniform(half_m + 4, FAR_M)))
        case _:
            half_m, ahead_m, door_m = rng.uniform(1, 3), rng.uniform(5, 13), rng.uniform(0.9, 1.5)
            middle_m = rng.uniform(-1, 1) * (half_m - door_m / 2)
            free = box(-FAR_M, -half_m, ahead_m, half_m)
            free = free.union(box(ahead_m - 0.1, middle_m - door_m / 2, ahead_m + 0.3, middle_m + door_m / 2))
            free = free.union(box(ahead_m + 0.2, -rng.uniform(2, 8), ahead_m + rng.uniform(4, 12), rng.uniform(2, 8)))
    return free, [], any_view(rng, rng.uniform(8, 20))


def corners(rng):
    gap_m = rng.uniform(0.85, 2.1, 2) / 2
    thick_m, free = rng.uniform(0.1, 0.3), box(-FAR_M, -FAR_M, FAR_M, FAR_M)
    for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        arms_m = rng.uniform(1.0, 3.5, 2)
        for (long_m, wide_m) in ((arms_m[0], thick_m), (thick_m, arms_m[1])):
            near, far = np.array([x, y]) * gap_m, np.array([x, y]) * (gap_m + [long_m, wide_m])
            free -= box(*np.minimum(near, far), *np.maximum(near, far))
    return free, [], full(360, rng.uniform(4, 10))


def step_back(rng):
    half_m, ahead_m = rng.uniform(1.4, 1.9), rng.uniform(4, 12)
    free = box(-FAR_M, -half_m, ahead_m, half_m)
    for side in rng.permutation([-1, 1])[: rng.integers(1, 3)]:
        deep_m, long_m, at_m = rng.uniform(0.2, 0.6), rng.uniform(1.5, 3.5), ahead_m - rng.uniform(0, 2)
        free = free.union(box(at_m - long_m, min(0, side * (half_m + deep_m)), at_m, max(0, side * (half_m + deep_m))))
    if rng.random() < 0.5:  # the way goes on to one side
        side = rng.choice([-1, 1])
        free = free.union(box(ahead_m - 2 * half_m, min(0, side * FAR_M), ahead_m, max(0, side * FAR_M)))
    elif rng.random() < 0.5:
        free = free.union(box(0, -half_m, FAR_M, half_m))
    return free, [], any_view(rng, rng.uniform(10, 25))


def seen_edge_on_bend(rng):
    wide_m, ahead_m = rng.uniform(0.9, 1.8), rng.uniform(2, 8)
    turn_rad = rng.choice([-1, 1]) * np.radians(rng.uniform(50, 120))
    end = np.array([ahead_m, 0.0])
    beyond_m = rng.choice([FAR_M, rng.uniform(1.0, 2.0)])
    return strip((-FAR_M, 0), end, end + beyond_m * directions(turn_rad), width_m=wide_m), [], any_view(rng, rng.uniform(6, 15))


def narrow_ways(rng):
    ways = rng.integers(2, 5)
    headings_rad = np.cumsum(rng.uniform(np.radians(55), np.radians(130), ways))
    parts = [strip((0, 0), rng.choice([FAR_M, rng.uniform(2, 9)]) * directions(rad), width_m=rng.uniform(0.9, 1.6)) for rad in headings_rad]
    return shapely.union_all([*parts, shapely.Point(0, 0).buffer(rng.uniform(0.5, 1.0))]), [], any_view(rng, rng.uniform(6, 20))


def cluster(rng, bearing_deg: float, range_m: float, radius_m: float):
    x_m, y_m = range_m * directions(np.radians(bearing_deg))
    return x_m, y_m, radius_m


def full(count: int, range_max_m: float) -> Beams:
    return Beams(count, -np.pi, 2 * np.pi / count, range_max_m, full_turn=True)


def any_view(rng, range_max_m: float) -> Beams:
    count = int(rng.choice([360, 720, 1080]))
    if rng.random() < 0.75:
        return full(count, range_max_m)
    view_rad = np.radians(rng.uniform(200, 270))
    return Beams(count, -view_rad / 2, view_rad / (count - 1), range_max_m, full_turn=False)


# Each with how far from the origin the sensor may stand, metres.
KINDS: dict[str, tuple[Callable, float]] = {
    "near_wall": (near_wall, 0.0),
    "one_wall_and_legs": (one_wall_and_legs, 0.05),
    "person_ahead": (person_ahead, 0.3),
    "pilasters": (pilasters, 1.5),
    "edge_on": (edge_on, 1.5),
    "corners": (corners, 0.6),
    "step_back": (step_back, 1.0),
    "seen_edge_on_bend": (seen_edge_on_bend, 1.0),
    "narrow_ways": (narrow_ways, 3.0),
}


def ground_of(free: shapely.Geometry, posts, reach_m: float) -> Ground:
    """The distance from the walls, exact beside them."""
    at_m = np.arange(-reach_m, reach_m, GRID_M)
    x_m, y_m = np.meshgrid(at_m, at_m)
    shapely.prepare(free)
    inside = shapely.contains_xy(free, x_m, y_m)
    apart = [ndimage.distance_transform_edt(part) * GRID_M for part in (inside, ~inside)]
    field = np.where(inside, apart[0], -apart[1])
    beside = np.abs(field) < 3 * GRID_M
    exact_m = shapely.distance(free.boundary, shapely.points(x_m[beside], y_m[beside]))
    field[beside] = np.where(inside[beside], exact_m, -exact_m)
    return Ground(field, (-reach_m, -reach_m), tuple(posts))


def make(kind: str, count: int, seed: int, measured: Callable) -> tuple[list[Place], dict[str, int]]:
    """Some places, and why others were left out."""
    made: list[Place] = []
    left_out: dict[str, int] = {}
    draw, near_m = KINDS[kind]
    number = 0
    while len(made) < count:
        rng = np.random.default_rng([seed, *kind.encode(), number])
        number += 1
        free, posts, beams = draw(rng)
        eye_m = near_m * rng.uniform(-1, 1, 2)
        window_m = beams.range_max_m + passable.BEYOND_M + near_m + 1
        ground = ground_of(free.intersection(box(-window_m, -window_m, window_m, window_m)), posts, window_m)
        try:
            if ground.clearance_m[ground.cells(eye_m[None])][0] < passable.VEHICLE_M / 2:
                continue
            view = passable.look(ground, eye_m, rng.uniform(-np.pi, np.pi), beams)
            ranges_m, labels = measured(view, beams, rng)
            made.append(Place(beams, ranges_m, view.truth(labels), 0))
        except Unclear as why:
            left_out[str(why)] = left_out.get(str(why), 0) + 1
    return made, left_out

"""What a lidar sees of free space that is given on a grid, and the truth of the view by what the vehicle's disc can do.

An opening is an edge of the space that is seen, over which a disc as wide as the vehicle gets at least 3 m into space that is
not seen. What hits between two openings is one wall. A view is left out (`Unclear`) only where this definition itself is on
edge: a vehicle wider or narrower by a quarter, or a depth of 3 m more or less by a quarter, would give another answer; or a
wall is seen over little more than the least that counts as one. Posts are islands; they hide, and close nothing.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from sight import BRANCH_AT_M, NO_RETURN, NO_WALL, Beams, Unclear, directions

VEHICLE_M, DEPTH_M, QUARTER = 0.6, 3.0, 0.25
LEAST_RETURNS = 3
LEAST_WALL_RAD = np.radians(3)
RAY_STEP_RAD = np.radians(0.15)
GRID_M = 0.05
NEIGHBOURS = np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1]), axis=-1).reshape(-1, 2)
BEYOND_M = DEPTH_M * (1 + QUARTER) + 0.5  # what lies farther beyond what is seen plays no part


@dataclass(frozen=True)
class Ground:
    """`free_m[y, x]` is positive in free space and negative in rock; near a wall it is about the distance from it."""

    free_m: np.ndarray
    corner_m: tuple[float, float]  # where [0, 0] is
    posts: tuple[tuple[float, float, float], ...] = ()  # x, y, radius

    @cached_property
    def clearance_m(self) -> np.ndarray:
        """The distance from rock."""
        return (ndimage.distance_transform_edt(self.free_m > 0) * GRID_M).astype(np.float32)

    def cells(self, points_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        at = np.rint((points_m - self.corner_m) / GRID_M).astype(int)
        high = np.array(self.free_m.shape[::-1]) - 1
        x, y = np.clip(at, 0, high).T
        return y, x

    def height_m(self, points_m: np.ndarray) -> np.ndarray:
        """`free_m`, straight between the points of the grid."""
        at = (points_m - self.corner_m) / GRID_M
        return ndimage.map_coordinates(self.free_m, at[:, ::-1].T, order=1, mode="nearest")


@dataclass(frozen=True)
class View:
    """What is seen without noise, in the frame of the sensor."""

    ranges_m: np.ndarray  # of the beams; inf: nothing in range
    labels: np.ndarray
    walls: int
    islands: int
    openings: list[dict]
    incidence: np.ndarray  # the cosine between a beam and the normal of what it hits

    def truth(self, labels: np.ndarray) -> dict:
        """In the format of `/truth`; `Unclear` if too little is left of a wall."""
        count = np.bincount(labels[labels >= 0], minlength=self.walls + self.islands)
        if len(count) and count.min() < LEAST_RETURNS:
            raise Unclear("a wall of few returns")
        return {"walls": self.walls, "islands": self.islands, "openings": self.openings, "labels": labels.tolist()}


def cast(ground: Ground, eye_m: np.ndarray, bearing_rad: np.ndarray, reach_m: float) -> np.ndarray:
    """The distance from rock along each ray; inf beyond `reach_m`. Steps are as long as the clearance allows."""
    heading, range_m = directions(bearing_rad), np.full(len(bearing_rad), 0.0)
    before_m, height_m = range_m.copy(), np.full(len(bearing_rad), 1.0)
    hit_m, active = np.full(len(bearing_rad), np.inf), np.arange(len(bearing_rad))
    while len(active):
        points_m = eye_m + range_m[active, None] * heading[active]
        clear_m = ground.clearance_m[ground.cells(points_m)]
        here_m = np.ones(len(active))
        near = clear_m < 2 * GRID_M
        here_m[near] = ground.height_m(points_m[near])
        hits = here_m <= 0
        struck = active[hits]
        share = height_m[struck] / (height_m[struck] - here_m[hits])
        hit_m[struck] = before_m[struck] + share * (range_m[struck] - before_m[struck])
        before_m[active], height_m[active] = range_m[active], np.where(near, here_m, GRID_M)
        range_m[active] += np.maximum(clear_m - 1.5 * GRID_M, 0.4 * GRID_M)
        active = active[~hits & (before_m[active] <= reach_m)]
    hit_m[hit_m > reach_m] = np.inf
    return hit_m


def posts_hit(ground: Ground, eye_m: np.ndarray, bearing_rad: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The distance from the nearest post along each ray, and its number."""
    hit_m, number = np.full(len(bearing_rad), np.inf), np.full(len(bearing_rad), -1)
    for at, (x_m, y_m, radius_m) in enumerate(ground.posts):
        to = np.array([x_m, y_m]) - eye_m
        along, across = directions(bearing_rad) @ to, np.abs(directions(bearing_rad) @ [-to[1], to[0]])
        meets = (along > 0) & (across < radius_m)
        here_m = np.where(meets, along - np.sqrt(np.maximum(radius_m**2 - across**2, 0)), np.inf)
        number, hit_m = np.where(here_m < hit_m, at, number), np.minimum(here_m, hit_m)
    return hit_m, number


def look(ground: Ground, eye_m: np.ndarray, turned_rad: float, beams: Beams) -> View:
    """What these beams see from here; `Unclear` where the definition is on edge. The sensor is turned by this much."""
    per_beam = int(np.ceil(beams.step_rad / RAY_STEP_RAD))
    count = beams.count * per_beam if beams.full_turn else (beams.count - 1) * per_beam + 1
    bearing_rad = beams.first_rad + np.arange(count) * beams.step_rad / per_beam
    hit_m = cast(ground, eye_m, bearing_rad + turned_rad, beams.range_max_m)
    hits = np.flatnonzero(np.isfinite(hit_m))
    if len(hits) < 2:
        raise Unclear("nothing in range")
    ends_m = np.minimum(hit_m, beams.range_max_m)[:, None] * directions(bearing_rad)
    seen = Seen(ground, eye_m, turned_rad, beams, hit_m, hits, ends_m)
    opening_hits = seen.openings()
    piece = np.cumsum(np.isin(np.arange(len(hits)), opening_hits + 1))
    if beams.full_turn and len(opening_hits):
        piece %= len(opening_hits)
    labels = np.full(count, NO_RETURN)
    labels[hits] = piece
    check_walls(labels, beams.step_rad / per_beam, len(opening_hits))
    post_m, post = posts_hit(ground, eye_m, bearing_rad + turned_rad)
    hides = (post_m < np.minimum(hit_m, beams.range_max_m))[::per_beam]
    ranges_m, of_beam = hit_m[::per_beam].copy(), labels[::per_beam].copy()
    ranges_m[hides], of_beam[hides] = post_m[::per_beam][hides], 1000 + post[::per_beam][hides]
    return numbered(ranges_m, of_beam, seen.described(opening_hits), incidence_of(ends_m, hit_m, per_beam))


def check_walls(labels: np.ndarray, step_rad: float, openings: int):
    """Each wall between two openings is seen over a quarter more than the least angle."""
    if openings > 1:
        least = (1 + QUARTER) * LEAST_WALL_RAD / step_rad
        if np.bincount(labels[labels >= 0]).min() < least:
            raise Unclear("a wall seen over a small angle")


def numbered(ranges_m: np.ndarray, groups: np.ndarray, openings: list[dict], incidence: np.ndarray) -> View:
    """Walls and islands numbered together by their first beam; an island of few returns is none."""
    posts = [group for group in np.unique(groups) if group >= 1000]
    few = [group for group in posts if (groups == group).sum() < LEAST_RETURNS]
    groups = np.where(np.isin(groups, few), NO_WALL, groups)
    order = list(dict.fromkeys(groups[groups >= 0].tolist()))
    number = {group: at for at, group in enumerate(order)} | {NO_RETURN: NO_RETURN, NO_WALL: NO_WALL}
    islands = sum(group >= 1000 for group in order)
    labels = np.array([number[group] for group in groups.tolist()])
    return View(ranges_m, labels, len(order) - islands, islands, openings, incidence)


def incidence_of(ends_m: np.ndarray, hit_m: np.ndarray, per_beam: int) -> np.ndarray:
    along = np.roll(ends_m, -1, axis=0) - np.roll(ends_m, 1, axis=0)
    across = np.abs(along[:, 0] * ends_m[:, 1] - along[:, 1] * ends_m[:, 0])
    cosine = across / (np.linalg.norm(along, axis=1) * np.linalg.norm(ends_m, axis=1) + 1e-9)
    return np.where(np.isfinite(hit_m), cosine, 1)[::per_beam]


@dataclass(frozen=True)
class Seen:
    """One view: its rays, in the frame of the sensor, and the free space around it."""

    ground: Ground
    eye_m: np.ndarray
    turned_rad: float
    beams: Beams
    hit_m: np.ndarray
    hits: np.ndarray
    ends_m: np.ndarray

    def openings(self) -> np.ndarray:
        """The gaps that are openings, each by the number of the hit before it."""
        answers = set()
        for width_m in VEHICLE_M * np.array([1, 1 - QUARTER, 1 + QUARTER]):
            depth_of = self.depths_m(width_m)
            for depth_m in DEPTH_M * np.array([1, 1 - QUARTER, 1 + QUARTER] if width_m == VEHICLE_M else [1]):
                answers.add(frozenset(gap for gap, deep_m in depth_of.items() if deep_m > depth_m))
            if len(answers) > 1:
                raise Unclear("only some vehicles pass, or a depth of about 3 m")
        return np.array(sorted(answers.pop()), dtype=int)

    def depths_m(self, width_m: float) -> dict[int, float]:
        """How far beyond each gap a disc gets that no wall holds back."""
        low, unseen, clear_m = self.unseen
        parts, _ = ndimage.label(unseen & (clear_m > width_m / 2))
        high = np.array(parts.shape[::-1]) - 1
        depths: dict[int, float] = {}
        cells_of = {}
        for gap, edge_m in self.edges:
            at = np.rint((edge_m - self.ground.corner_m) / GRID_M).astype(int) - low
            around = np.clip(at[:, None] + NEIGHBOURS, 0, high)
            for part in np.unique(parts[around[..., 1], around[..., 0]]):
                if part == 0:
                    continue
                if part not in cells_of:
                    cells_of[part] = (np.argwhere(parts == part)[::7, ::-1] + low) * GRID_M + self.ground.corner_m
                deep_m = cKDTree(edge_m[::2]).query(cells_of[part])[0].max()
                depths[gap] = max(depths.get(gap, 0.0), deep_m)
        return depths

    @cached_property
    def unseen(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The cell of the grid where what is near enough begins, what of this is in view but not seen, and its clearance."""
        range_m = np.minimum(self.hit_m, self.beams.range_max_m)
        reach_m = range_m.max() + BEYOND_M
        low = np.floor((self.eye_m - reach_m - self.ground.corner_m) / GRID_M).astype(int)
        high = low + int(2 * reach_m / GRID_M) + 1
        low, high = np.maximum(low, 0), np.minimum(high, self.ground.free_m.shape[::-1])
        clear_m = self.ground.clearance_m[low[1] : high[1], low[0] : high[0]]
        unseen = clear_m > (1 - QUARTER) * VEHICLE_M / 2
        cells = np.argwhere(unseen)
        from_m = (cells[:, ::-1] + low) * GRID_M + self.ground.corner_m - self.eye_m
        bearing_rad = np.arctan2(from_m[:, 1], from_m[:, 0]) - self.turned_rad - self.beams.first_rad
        step_rad = self.beams.step_rad / np.ceil(self.beams.step_rad / RAY_STEP_RAD)
        ray = np.rint((bearing_rad % (2 * np.pi)) / step_rad).astype(int)
        in_view = ray < len(range_m)
        ray = ray % len(range_m)
        in_view |= self.beams.full_turn
        unseen[tuple(cells.T)] = in_view & (np.linalg.norm(from_m, axis=1) > range_m[ray])
        return low, unseen, clear_m

    @cached_property
    def edges(self) -> list[tuple[int, np.ndarray]]:
        """Each gap that a vehicle may pass, with points along its edge, on the ground."""
        found = []
        for gap in range(len(self.hits) if self.beams.full_turn else len(self.hits) - 1):
            rays = self.rays_of(gap)
            line_m = self.ends_m[rays]
            if len(rays) > 2 or np.linalg.norm(line_m[1] - line_m[0]) > (1 - QUARTER) * VEHICLE_M:
                found.append((gap, self.to_ground(along(line_m))))
        return found

    def rays_of(self, gap: int) -> np.ndarray:
        """The rays of a gap, with the hits at both ends."""
        first, last, count = self.hits[gap], self.hits[(gap + 1) % len(self.hits)], len(self.hit_m)
        return np.arange(first, last + 1 + (count if last <= first else 0)) % count

    def to_ground(self, points_m: np.ndarray) -> np.ndarray:
        cos, sin = np.cos(self.turned_rad), np.sin(self.turned_rad)
        return self.eye_m + points_m @ np.array([[cos, sin], [-sin, cos]])

    def described(self, opening_hits: np.ndarray) -> list[dict]:
        """Bearing and width where the clearance is largest: across the branch at 8 m if it is seen that far, else across
        the edge."""
        found = []
        for gap in opening_hits:
            edge_m = along(self.ends_m[self.rays_of(gap)])
            spot = at_edge = self.clearest(edge_m)
            rays = self.rays_of(gap)
            far = rays[1:-1][np.minimum(self.hit_m, self.beams.range_max_m)[rays[1:-1]] > BRANCH_AT_M]
            if len(far):
                start, end = np.angle(self.ends_m[[far[0], far[-1]]] @ [1, 1j])
                arc_rad = start + np.linspace(0, (end - start) % (2 * np.pi), 60)
                at_branch = self.clearest(BRANCH_AT_M * directions(arc_rad))
                if at_branch[1] < 1.3 * at_edge[1]:
                    spot = at_branch
            (x_m, y_m), clear_m = spot
            found.append({"bearing_rad": float(np.arctan2(y_m, x_m)), "width_m": float(2 * clear_m)})
        return sorted(found, key=lambda opening: opening["bearing_rad"])

    def clearest(self, points_m: np.ndarray) -> tuple[np.ndarray, float]:
        clear_m = self.ground.clearance_m[self.ground.cells(self.to_ground(points_m))]
        return points_m[clear_m.argmax()], float(clear_m.max())


def along(line_m: np.ndarray) -> np.ndarray:
    """Points on a line through these, half a cell of the grid apart."""
    at_m = np.append(0, np.cumsum(np.linalg.norm(np.diff(line_m, axis=0), axis=1)))
    points = np.arange(0, at_m[-1] + GRID_M / 2, GRID_M / 2)
    return np.stack([np.interp(points, at_m, line_m[:, axis]) for axis in (0, 1)], axis=1)

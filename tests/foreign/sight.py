"""What a lidar sees of a plane in which the free space is known: its beams, and the truth of the view without noise.

The free space is a polygon, its holes are pillars, the sensor stands at the origin and looks along x.

How truth is computed: rays, ten to a beam of 1°, make the polygon that is seen. The places where the centre of the
vehicle's disc can be are the free space eroded by its radius; those outside of the seen polygon fall into pieces, the
hidden ways. A *gap* lies between one ray that hits and the next that does, with the rays between them that hit nothing
in range. A gap is an opening if a hidden way that reaches further than 3 m beyond it touches the edge of the seen
polygon there. What is hit between two openings is a wall, whatever bumps and jumps it has. Openings on both sides of what
is seen through a door are one way, through the door. A hole of the free space that is smaller than `POST_M` is a post; it
is an island if no opening is at its sides.

Left out, as one view cannot tell (`Unclear`):
- hidden ways that reach to between 0.5 and 5 m beyond their gap, and shorter ones beyond a gap of 1.5 m or more, where
  a way on could begin: niches; in the shadow of a pillar, which is seen from both sides, those of 1.5 to 5 m;
- a gap that a disc half as wide again, or three quarters as wide, takes for something else than the disc does;
- an opening that lies between the beams, no wider than the steps from return to return beside it let expect;
- a way closed within 5 m beyond the range, where nothing at all is seen of its end;
- a post at the side of an opening, which is a wall to some and an island to others;
- a wall between two openings that is shorter than 0.5 m, a wall or island of fewer than 6 returns;
- a view that ends within 5° of a jump in depth or of the end of the range.

Close calls of the first two kinds can be let in: the definition decides them, by 3 m and by the vehicle itself.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from shapely import LineString, Polygon

VEHICLE_WIDTHS_M = (0.45, 0.6, 0.9)  # the vehicle's own in the middle; the others must see the same openings
CLOSED_M, OPEN_M = 0.5, 5.0  # beyond a gap: less is closed, more is open, and the definition lies between
DEFINED_M = 3.0
NARROWEST_WAY_M = 1.5  # in a hidden space that is nowhere wider no way on begins
POST_M = 3.0
LEAST_RETURNS = 6
LEAST_WALL_M = 0.5
VIEW_MARGIN_RAD = np.radians(5)
RAY_STEP_RAD = np.radians(0.1)
BEYOND_RANGE_M = 9.0  # what lies further beyond the range plays no part
DOOR_M = 2.4  # a wider mouth is no door
JAMB_M, JAMB_COS = 1.5, 0.8  # over so much of the wall beside a door, its direction is no farther off that of the door
BRANCH_AT_M = 8.0  # where bearing and width of an opening are taken, if it is seen that far

NO_RETURN, NO_WALL = -1, -2


class Unclear(Exception):
    """The answer hangs on a margin, or on what one view cannot tell."""


@dataclass(frozen=True)
class Beams:
    """The beam geometry, anticlockwise in the body frame."""

    count: int
    first_rad: float
    step_rad: float
    range_max_m: float
    full_turn: bool

    def bearings_rad(self) -> np.ndarray:
        return self.first_rad + np.arange(self.count) * self.step_rad


@dataclass(frozen=True)
class Rays:
    """Dense rays; every `per_beam`-th is a beam. `hit_m` is inf where nothing is in range, `ring` 0 for the outer
    boundary and else the number of the hole."""

    bearing_rad: np.ndarray
    hit_m: np.ndarray
    ring: np.ndarray
    per_beam: int
    range_max_m: float
    full_turn: bool

    def ends_m(self) -> np.ndarray:
        reach_m = np.minimum(self.hit_m, self.range_max_m)
        return reach_m[:, None] * directions(self.bearing_rad)

    def hits(self) -> np.ndarray:
        return np.flatnonzero(np.isfinite(self.hit_m))


@dataclass(frozen=True)
class View:
    """What is seen without noise: range and label of every beam, and the openings by bearing."""

    hit_m: np.ndarray
    labels: np.ndarray
    islands: frozenset[int]  # which labels
    openings: list[dict]

    def truth(self, labels: np.ndarray) -> dict:
        """In the format of `/truth`, for the scan with these labels; `Unclear` if it has too little of a wall."""
        count = self.labels.max() + 1
        if np.bincount(labels[labels >= 0], minlength=count).min() < LEAST_RETURNS:
            raise Unclear("a wall of few returns")
        return {
            "walls": int(count) - len(self.islands),
            "islands": len(self.islands),
            "openings": self.openings,
            "labels": labels.tolist(),
        }


@dataclass(frozen=True)
class Place:
    beams: Beams
    ranges_m: np.ndarray  # float32, inf: nothing in range, or lost
    truth: dict  # in the format of `/truth`
    redrawn: int  # how many places were left out before this one


def look(free: Polygon, beams: Beams, close: bool = False) -> View:
    """What these beams see; `Unclear` if that is for no single view to say, or with `close` for no definition."""
    rays = dense_rays(free, beams)
    if not len(rays.hits()):
        raise Unclear("nothing in range")
    opening_hits = openings_of(free, rays, close)
    check_beams_show(rays, opening_hits)
    hits = rays.hits()
    piece = np.cumsum(np.isin(np.arange(len(hits)), opening_hits + 1))
    if rays.full_turn and len(opening_hits):
        piece %= len(opening_hits)
    posts = posts_of(free)
    on_post = np.isin(rays.ring[hits], posts)
    check_posts(on_post, opening_hits, rays.full_turn)
    check_walls_between(piece, rays.ends_m()[hits], opening_hits, rays.full_turn)
    group = np.where(on_post, len(hits) + rays.ring[hits], piece)
    labels, islands = beam_labels(rays, hits, group, on_post)
    doors = doors_of(rays, opening_hits)
    inside = {hit for _, through in doors for hit in through}
    openings = [described(free, rays, hit, opening_hits) for hit in opening_hits if hit not in inside]
    openings += [described_at(*clearest(free, along(door))) for door, _ in doors]
    openings.sort(key=lambda opening: opening["bearing_rad"])
    return View(rays.hit_m[:: rays.per_beam], labels, islands, openings)


def dense_rays(free: Polygon, beams: Beams) -> Rays:
    per_beam = int(np.ceil(beams.step_rad / RAY_STEP_RAD - 1e-9))
    step_rad = beams.step_rad / per_beam
    if beams.full_turn:
        margin, count = 0, beams.count * per_beam
    else:
        margin, count = int(np.ceil(VIEW_MARGIN_RAD / step_rad)), (beams.count - 1) * per_beam + 1
    bearing_rad = beams.first_rad + np.arange(-margin, count + margin) * step_rad
    hit_m, ring = cast(free, bearing_rad[0], step_rad, len(bearing_rad))
    hit_m[hit_m > beams.range_max_m] = np.inf
    rays = Rays(bearing_rad, hit_m, ring, per_beam, beams.range_max_m, beams.full_turn)
    if beams.full_turn:
        return rays
    check_view_ends(rays, margin)
    seen = slice(margin, margin + count)
    return Rays(bearing_rad[seen], hit_m[seen], ring[seen], per_beam, beams.range_max_m, False)


def cast(free: Polygon, first_rad: float, step_rad: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Distance from the origin to the boundary along each ray, and the ring of the boundary that is there."""
    rings = [shapely.get_coordinates(ring) for ring in (free.exterior, *free.interiors)]
    start = np.concatenate([ring[:-1] for ring in rings])
    along = np.concatenate([np.diff(ring, axis=0) for ring in rings])
    ring_of = np.repeat(np.arange(len(rings)), [len(ring) - 1 for ring in rings])
    segment, ray = covered_rays(start, along, first_rad, step_rad, count)
    direction = directions(first_rad + ray * step_rad)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance_m = cross(start[segment], along[segment]) / cross(direction, along[segment])
    real = np.isfinite(distance_m) & (distance_m > 0)
    segment, ray, distance_m = segment[real], ray[real], distance_m[real]
    farthest_first = np.argsort(-distance_m)
    hit_m, hit_segment = np.full(count, np.inf), np.zeros(count, dtype=int)
    hit_m[ray[farthest_first]] = distance_m[farthest_first]  # of equal indices the last one stays
    hit_segment[ray[farthest_first]] = segment[farthest_first]
    return hit_m, ring_of[hit_segment]


def covered_rays(start, along, first_rad: float, step_rad: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """All pairs of a segment and a ray that it crosses; a hair more at its ends, so that none slips through."""
    from_rad = np.arctan2(start[:, 1], start[:, 0])
    turn_rad = np.arctan2(cross(start, along), np.sum(start * (start + along), axis=1))
    low_rad = (np.minimum(from_rad, from_rad + turn_rad) - first_rad) % (2 * np.pi)
    segment = np.arange(len(start))
    again = low_rad + np.abs(turn_rad) >= 2 * np.pi - step_rad
    segment = np.concatenate([segment, segment[again]])
    low_rad = np.concatenate([low_rad, low_rad[again] - 2 * np.pi])
    first = np.maximum(np.ceil(low_rad / step_rad - 1e-6), 0).astype(int)
    last = np.minimum(np.floor((low_rad + np.abs(turn_rad[segment])) / step_rad + 1e-6), count - 1).astype(int)
    lengths = np.maximum(last - first + 1, 0)
    ray = np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths - first, lengths)
    return np.repeat(segment, lengths), ray


def check_view_ends(rays: Rays, margin: int):
    """`rays` go on beyond both ends of the view by `margin` rays."""
    ends_m, hit = rays.ends_m(), np.isfinite(rays.hit_m)
    jumps = np.linalg.norm(np.diff(ends_m, axis=0), axis=1) >= VEHICLE_WIDTHS_M[0]
    changes = jumps & hit[1:] & hit[:-1] | (hit[1:] != hit[:-1])
    if changes[: 2 * margin].any() or changes[-2 * margin :].any():
        raise Unclear("the view ends at an edge")


def openings_of(free: Polygon, rays: Rays, close: bool) -> np.ndarray:
    """The gaps that are openings, each by the number of the hit before it; -1 if none is before it in a limited
    view."""
    in_view = None if rays.full_turn else sector(rays)
    answers = set()
    for width_m in VEHICLE_WIDTHS_M[1:2] if close else VEHICLE_WIDTHS_M:
        ways = shapely.difference(free.buffer(-width_m / 2, quad_segs=4), seen_polygon(rays))
        answers.add(open_gaps(ways, rays, close))
        if in_view:
            answers.add(open_gaps(shapely.intersection(ways, in_view), rays, close))
    if len(answers) > 1:
        raise Unclear("only some vehicles pass")
    return np.array(sorted(answers.pop()), dtype=int)


def seen_polygon(rays: Rays) -> Polygon:
    return Polygon(rays.ends_m() if rays.full_turn else [(0.0, 0.0), *rays.ends_m()])


def sector(rays: Rays) -> Polygon:
    return Polygon([(0.0, 0.0), *directions(rays.bearing_rad) * (rays.range_max_m + 2 * BEYOND_RANGE_M)])


def open_gaps(ways: shapely.Geometry, rays: Rays, close: bool) -> frozenset[int]:
    """The gaps over which the hidden ways are deep."""
    ends_m, hit = rays.ends_m(), np.isfinite(rays.hit_m)
    if rays.full_turn:
        ends_m, hit = np.vstack([ends_m, ends_m[:1]]), np.append(hit, hit[0])
    length_m = np.linalg.norm(np.diff(ends_m, axis=0), axis=1)
    wide = np.flatnonzero((length_m > 0.9 * VEHICLE_WIDTHS_M[0]) | ~hit[1:] | ~hit[:-1])
    edges = shapely.linestrings(np.stack([ends_m[wide], ends_m[wide + 1]], axis=1))
    gaps = gap_before(rays, wide)
    found = set()
    for way in shapely.get_parts(ways):
        shapely.prepare(way)
        touched = np.unique(gaps[shapely.dwithin(way, edges, 1e-3)])
        for gap in touched:
            if is_deep(way, gap_line(rays, gap), shadow=len(touched) > 1, close=close):
                found.add(int(gap))
    return frozenset(found)


def gap_before(rays: Rays, edge: np.ndarray) -> np.ndarray:
    """The gap that holds the edge between a ray and the next."""
    hits = rays.hits()
    gap = np.searchsorted(hits, edge, side="right") - 1
    return gap % len(hits) if rays.full_turn else gap


def gap_rays(rays: Rays, gap: int) -> np.ndarray:
    """The rays of a gap, with the hits at both of its ends."""
    hits, count = rays.hits(), len(rays.hit_m)
    if rays.full_turn:
        return np.arange(hits[gap], hits[(gap + 1) % len(hits)] + count * (gap + 1 == len(hits)) + 1) % count
    first = hits[gap] if gap >= 0 else 0
    last = hits[gap + 1] if gap + 1 < len(hits) else count - 1
    return np.arange(first, last + 1)


def gap_line(rays: Rays, gap: int) -> LineString:
    return LineString(rays.ends_m()[gap_rays(rays, gap)])


def is_deep(way: Polygon, gap: LineString, shadow: bool, close: bool) -> bool:
    corners = shapely.points(shapely.get_coordinates(way.convex_hull))
    depth_m = shapely.distance(gap, corners).max()
    if close or depth_m > OPEN_M:
        return depth_m > DEFINED_M
    nothing_in_range = len(gap.coords) > 2
    small = depth_m < NARROWEST_WAY_M if shadow else depth_m < CLOSED_M and gap.length < NARROWEST_WAY_M
    if nothing_in_range or not small:
        raise Unclear("a niche, or a way on?")
    return False


def check_beams_show(rays: Rays, opening_hits: np.ndarray):
    """An opening shows if two beams at least see nothing there, or if it is wider than the steps from return to return
    on both sides let expect."""
    ends_m, hits = rays.ends_m()[:: rays.per_beam], rays.hits()
    returns = np.flatnonzero(np.isfinite(rays.hit_m[:: rays.per_beam]))
    if len(returns) < LEAST_RETURNS:
        raise Unclear("a wall of few returns")
    step_m = np.linalg.norm(ends_m[returns] - np.roll(ends_m[returns], 1, axis=0), axis=1)
    for gap in opening_hits[(opening_hits >= 0) & ((opening_hits + 1 < len(hits)) | rays.full_turn)]:
        after = np.searchsorted(returns * rays.per_beam, hits[gap], side="right") % len(returns)
        unseen = (returns[after] - returns[after - 1]) % len(ends_m) - 1
        beside_m = max(np.median(step_m[np.arange(after + i, after + i + 3) % len(returns)]) for i in (-3, 1))
        if unseen < 2 and step_m[after] < VEHICLE_WIDTHS_M[-1] + 2 * beside_m:
            raise Unclear("an opening between the beams")


def posts_of(free: Polygon) -> list[int]:
    return [i for i, hole in enumerate(free.interiors, start=1) if 2 * shapely.minimum_bounding_radius(hole) < POST_M]


def check_posts(on_post: np.ndarray, opening_hits: np.ndarray, full_turn: bool):
    beside = np.concatenate([opening_hits, opening_hits + 1])
    beside = beside % len(on_post) if full_turn else beside[(beside >= 0) & (beside < len(on_post))]
    if on_post[beside].any():
        raise Unclear("a post in an opening")


def check_walls_between(piece: np.ndarray, ends_m: np.ndarray, opening_hits: np.ndarray, full_turn: bool):
    for number in np.unique(piece):
        at_view_end = not full_turn and number in (piece[0], piece[-1])
        extent_m = np.linalg.norm(np.ptp(ends_m[piece == number], axis=0))
        if len(opening_hits) > 1 and not at_view_end and extent_m < LEAST_WALL_M:
            raise Unclear("openings side by side")


def beam_labels(rays: Rays, hits, group, on_post) -> tuple[np.ndarray, frozenset[int]]:
    """Walls and islands numbered together by their first beam; -1 for beams without a return."""
    ray_group = np.full(len(rays.hit_m), NO_RETURN)
    ray_group[hits] = group
    beam_group = ray_group[:: rays.per_beam]
    if missed := set(group.tolist()) - set(beam_group.tolist()):
        raise Unclear(f"{len(missed)} walls between the beams")
    groups = list(dict.fromkeys(beam_group[beam_group >= 0].tolist()))
    number = {group: i for i, group in enumerate(groups)} | {NO_RETURN: NO_RETURN}
    islands = frozenset(number[group] for group in set(group[on_post].tolist()))
    return np.array([number[group] for group in beam_group.tolist()]), islands


def doors_of(rays: Rays, opening_hits: np.ndarray) -> list[tuple[LineString, set[int]]]:
    """Each door through which a wall is seen, and the openings through it: the walls at its two sides run towards each other,
    and all that is seen between them lies behind it."""
    hits, ends_m = rays.hits(), rays.ends_m()[rays.hits()]
    found = []
    for at, first in enumerate(opening_hits):
        for more in range(len(opening_hits) - 1 if rays.full_turn else len(opening_hits) - 1 - at, 0, -1):
            through = opening_hits[np.arange(at, at + more + 1) % len(opening_hits)]
            last = through[-1]
            if not rays.full_turn and (first < 0 or last + 1 >= len(hits)):
                continue
            seen = np.arange(first + 1, last + 1 + (len(hits) if last < first else 0)) % len(hits)
            if is_door(ends_m, first, (last + 1) % len(hits), seen):
                found.append((LineString(ends_m[[first, (last + 1) % len(hits)]]), {int(hit) for hit in through}))
                break
    return [door for door in found if not any(door[1] < other[1] for other in found)]


def is_door(ends_m: np.ndarray, before: int, after: int, seen: np.ndarray) -> bool:
    door = ends_m[after] - ends_m[before]
    width_m, range_m = np.linalg.norm(door), np.linalg.norm(ends_m, axis=1)
    if not VEHICLE_WIDTHS_M[1] <= width_m <= DOOR_M or range_m[before] > range_m[seen[0]] or range_m[after] > range_m[seen[-1]]:
        return False
    towards = [jamb_towards(ends_m, before, -1) @ door, jamb_towards(ends_m, after, 1) @ -door]
    return min(towards) >= JAMB_COS * width_m and cross(door, ends_m[seen] - ends_m[before]).max() < 0


def jamb_towards(ends_m: np.ndarray, end: int, step: int) -> np.ndarray:
    """The direction in which a wall runs towards its end, from what is hit `JAMB_M` before it."""
    others_m = ends_m[(end + step * np.arange(1, len(ends_m))) % len(ends_m)]
    far = np.linalg.norm(others_m - ends_m[end], axis=1) >= JAMB_M
    run = ends_m[end] - others_m[far.argmax() if far.any() else -1]
    return run / np.linalg.norm(run)


def along(line: LineString) -> np.ndarray:
    return shapely.line_interpolate_point(line, np.arange(0.0, line.length, 0.1))


def described(free: Polygon, rays: Rays, gap: int, opening_hits: np.ndarray) -> dict:
    """Bearing and width of an opening, where the clearance is largest: across the branch at 8 m from the sensor; across
    the opening's edge if that is nearer or narrower (8 m off is still the chamber), or if other openings lie beyond the
    8 m too."""
    edge = gap_line(rays, gap)
    spot = at_edge = clearest(free, along(edge))
    arc = far_rays(rays, gap_rays(rays, gap))
    if sum(np.isin(gap_rays(rays, other), arc).all() for other in opening_hits) == 1:
        at_branch = clearest(free, shapely.points(BRANCH_AT_M * directions(rays.bearing_rad[arc])))
        if at_branch[1] < 1.3 * at_edge[1]:
            spot = at_branch
    return described_at(*spot)


def described_at(spot_m: np.ndarray, clearance_m: float) -> dict:
    x_m, y_m = spot_m
    return {"bearing_rad": float(np.arctan2(y_m, x_m)), "width_m": float(2 * clearance_m)}


def clearest(free: Polygon, points: np.ndarray) -> tuple[np.ndarray, float]:
    """The point that is furthest from all walls, and how far."""
    clearance_m = shapely.distance(free.boundary, points)
    return shapely.get_coordinates(points[clearance_m.argmax()])[0], clearance_m.max()


def far_rays(rays: Rays, inside: np.ndarray) -> np.ndarray:
    """The rays side by side with these that see further than the 8 m; none if one of these does not."""
    far, count = rays.hit_m > BRANCH_AT_M, len(rays.hit_m)
    if rays.range_max_m <= BRANCH_AT_M or not far[inside].all() or far.all():
        return np.array([], dtype=int)
    first, last = inside[0], inside[-1] + (count if inside[-1] < inside[0] else 0)
    while far[(first - 1) % count] and (rays.full_turn or first > 0):
        first -= 1
    while far[(last + 1) % count] and (rays.full_turn or last < count - 1):
        last += 1
    return np.arange(first, last + 1) % count


def directions(bearing_rad: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(bearing_rad), np.sin(bearing_rad)], axis=-1)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]

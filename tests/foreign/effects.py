"""What real lidars on real vehicles do to a scan, done to places with known truth."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

import sight
from sight import Place, directions

MIXED_SHARE = 0.5
NOISE_SHARE = 0.02
LEG_RANGE_M = 0.4
LEG_HALF_RAD = np.radians(3.5)
LEG_BEARINGS_RAD = np.radians([45, 135, -135, -45])
LEG_CLEARANCE_RAD = np.radians(15)
LEG_HIDES = 1 / 3
DARK_M = 1.5
DARK_WITHIN_M = 4.0
DARK_LEAST_BESIDE = 5
SHORT_RAD = np.radians(3)


def plain(place: Place, _: np.random.Generator) -> Place:
    """As it is."""
    return place


def mixed(place: Place, rng: np.random.Generator) -> Place:
    """At half of the edges, where one thing hides another, one of the two beams reports a range in between."""
    ranges_m, labels = place.ranges_m.copy(), list(place.truth["labels"])
    with np.errstate(invalid="ignore"):
        step_m = np.abs(np.diff(ranges_m, append=ranges_m[0] if place.beams.full_turn else np.inf))
    known_m = np.where(np.isfinite(step_m), step_m, 0)
    # Along a wall the steps beside one are not much smaller.
    is_edge = known_m > np.maximum(0.3, 2.5 * np.maximum(np.roll(known_m, 1), np.roll(known_m, -1)))
    for before in np.flatnonzero(is_edge & (rng.random(len(known_m)) < MIXED_SHARE)):
        after = (before + 1) % len(ranges_m)
        reported = rng.choice([before, after])
        ranges_m[reported] = rng.uniform(*sorted(place.ranges_m[[before, after]]))
        labels[reported] = sight.NO_WALL
    return changed(place, ranges_m, labels)


def noise(place: Place, rng: np.random.Generator) -> Place:
    """Ranges are inexact by 2 % of themselves, as of small lidars."""
    ranges_m = place.ranges_m * (1 + NOISE_SHARE * rng.standard_normal(len(place.ranges_m)))
    lost = ranges_m > place.beams.range_max_m
    return changed(place, np.where(lost, np.inf, ranges_m), np.where(lost, sight.NO_RETURN, place.truth["labels"]))


def legs(place: Place, rng: np.random.Generator) -> Place:
    """Four legs of the vehicle, 0.4 m from the sensor, each hides 7°; none where it would hide a third of a wall, or the
    sides of a way on. Of a limited view, none."""
    if not place.beams.full_turn:
        return place
    ranges_m, labels = place.ranges_m.copy(), np.array(place.truth["labels"])
    bearings_rad, islands = place.beams.bearings_rad(), 0
    ways_rad = np.array([opening["bearing_rad"] for opening in place.truth["openings"]])
    before = np.bincount(labels[labels >= 0], minlength=1)
    for leg_rad in LEG_BEARINGS_RAD:
        hidden = np.abs(turned(bearings_rad - leg_rad)) < LEG_HALF_RAD
        of_walls = np.bincount(labels[hidden & (labels >= 0)], minlength=len(before))[: len(before)]
        if (of_walls > LEG_HIDES * before).any() or (np.abs(turned(ways_rad - leg_rad)) < LEG_CLEARANCE_RAD).any():
            continue
        ranges_m[hidden] = LEG_RANGE_M + rng.normal(0, 0.005, hidden.sum())
        labels[hidden] = place.truth["walls"] + place.truth["islands"] + islands
        islands += 1
    truth = {**place.truth, "islands": place.truth["islands"] + islands}
    return changed(replace(place, truth=truth), ranges_m, labels)


def dark(place: Place, rng: np.random.Generator) -> Place:
    """1.5 m of a near wall, which is seen to go on past both ends, give no return."""
    ranges_m, labels = place.ranges_m.copy(), np.array(place.truth["labels"])
    points_m = np.where(np.isfinite(ranges_m), ranges_m, 0)[:, None] * directions(place.beams.bearings_rad())
    for middle in rng.permutation(np.flatnonzero((ranges_m < DARK_WITHIN_M) & (labels >= 0))):
        near = np.linalg.norm(points_m - points_m[middle], axis=1) < DARK_M / 2
        patch = np.flatnonzero(near & (labels == labels[middle]))
        beside = [*range(patch[0] - DARK_LEAST_BESIDE, patch[0]), *range(patch[-1] + 1, patch[-1] + 1 + DARK_LEAST_BESIDE)]
        is_one = len(patch) == patch[-1] - patch[0] + 1
        if is_one and beside[0] >= 0 and beside[-1] < len(labels) and (labels[beside] == labels[middle]).all():
            ranges_m[patch], labels[patch] = np.inf, sight.NO_RETURN
            break
    return changed(place, ranges_m, labels)


def short(place: Place, _: np.random.Generator) -> Place:
    """The message of a full turn leaves out its last 3°, within one wall; of a limited view, nothing."""
    labels = np.array(place.truth["labels"])
    kept = len(labels) - max(1, int(SHORT_RAD / place.beams.step_rad))
    around = np.append(labels[kept - 1 :], labels[0])
    if not place.beams.full_turn or len(set(around.tolist())) > 1 or around[0] < 0:
        return place
    return changed(replace(place, beams=replace(place.beams, count=kept)), place.ranges_m[:kept], labels[:kept])


def constant(place: Place, _: np.random.Generator) -> Place:
    """Beams without a return report a constant, 0.1 m below the largest range."""
    nothing = ~np.isfinite(place.ranges_m)
    return changed(place, np.where(nothing, place.beams.range_max_m - 0.1, place.ranges_m), place.truth["labels"])


EFFECTS: dict[str, Callable[[Place, np.random.Generator], Place]] = {
    effect.__name__: effect for effect in (plain, mixed, noise, legs, dark, short, constant)
}


def changed(place: Place, ranges_m: np.ndarray, labels) -> Place:
    labels = np.asarray(labels).tolist()
    return replace(place, ranges_m=ranges_m.astype(np.float32), truth={**place.truth, "labels": labels})


def turned(angle_rad: np.ndarray) -> np.ndarray:
    """The same angle between -π and π."""
    return (angle_rad + np.pi) % (2 * np.pi) - np.pi

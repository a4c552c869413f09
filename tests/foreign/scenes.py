"""Junctions whose walls are far apart and well sampled, so that the gap in the spectrum is clear: made here, with
numpy alone, so that they do not rest on the program's own simulator."""

from dataclasses import dataclass

import numpy as np

BEAMS = 360
RANGE_MAX_M = 12.0
NOISE_SD_M = 0.01
LEAST_ANGLE_RAD = np.radians(54)


@dataclass(frozen=True)
class Scene:
    walls: int
    ranges_m: np.ndarray  # one a beam, anticlockwise from -π; inf: nothing within range


def clear_junctions(count: int, seed: int) -> list[Scene]:
    """Dead ends, tunnels, and junctions of 3, 4 and 5 branches in turn, each branch 6 to 6.5 m wide."""
    rng = np.random.default_rng(seed)
    return [junction(1 + i % 5, rng) for i in range(count)]


def junction(branches: int, rng: np.random.Generator) -> Scene:
    """A branch is a strip that begins behind the sensor. Each strip holds the sensor, so their union is seen from it
    in full: a beam ends where it leaves the last of the strips."""
    beam_rad = bearings_rad()
    ranges_m = np.zeros(BEAMS)
    for heading_rad in headings_rad(branches, rng):
        along, across = np.cos(beam_rad - heading_rad), np.sin(beam_rad - heading_rad)
        half_width_m, offset_m = rng.uniform(3.0, 3.25), rng.uniform(-0.5, 0.5)
        with np.errstate(divide="ignore"):
            to_sides_m = np.where(across > 0, half_width_m - offset_m, half_width_m + offset_m) / np.abs(across)
            to_back_m = np.where(along < 0, half_width_m / 2 / np.abs(along), np.inf)
        ranges_m = np.maximum(ranges_m, np.minimum(to_sides_m, to_back_m))
    ranges_m += rng.normal(0, NOISE_SD_M, BEAMS)
    return Scene(branches, np.where(ranges_m < RANGE_MAX_M, ranges_m, np.inf))


def headings_rad(branches: int, rng: np.random.Generator) -> np.ndarray:
    """Directions at least 54° apart."""
    slack_rad = 2 * np.pi - branches * LEAST_ANGLE_RAD
    gaps_rad = LEAST_ANGLE_RAD + slack_rad * rng.dirichlet(np.full(branches, 4.0))
    return rng.uniform(-np.pi, np.pi) + np.cumsum(gaps_rad)


def bearings_rad() -> np.ndarray:
    return -np.pi + np.arange(BEAMS) * 2 * np.pi / BEAMS

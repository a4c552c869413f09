"""Poses of public logs of real robots, against their true ones: how far crosscut is off, and how far the odometry that it was
given is off by itself. The logs are not part of this project; docs/flights.md says where they are.

    tests/foreign/run slam DIR [--crosscut BINARY] [NAME...]

DIR holds CARMEN logs with corrected poses (`NAME-corrected.log`, `NAME.gfs.log`), as GMapping writes them: each FLASER has the true
pose, and the ODOM lines between count on from there. They are written anew with the odometry alone. `NAME.raw.clf` beside one is the
whole log, and its scans are those with the same ranges. Relations (`NAME.relations`) are true motions between two times of it.
"""

import argparse
import json
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

PROPERTY = 1.1  # the pose is off by at most so many times what the odometry is off by
LEAST_M = 0.05  # and this much: true poses are no better
LONGEST_S = 30.0  # the stamps of some logs leap
ENDINGS = ["-corrected.log", ".gfs.log", ".corrected.log"]


@dataclass(frozen=True)
class Log:
    """A log as the program gets it, and what is true: poses x, y, yaw of scans, NaN where it is not known."""

    path: Path
    true: np.ndarray
    odometry: np.ndarray
    stamps_s: np.ndarray


def composed(pose: np.ndarray, step: np.ndarray) -> np.ndarray:
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([pose[0] + c * step[0] - s * step[1], pose[1] + s * step[0] + c * step[1], pose[2] + step[2]])


def between(pose: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The second pose as seen from the first."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    x, y = other[:2] - pose[:2]
    return np.array([c * x + s * y, -s * x + c * y, np.angle(np.exp(1j * (other[2] - pose[2])))])


def laser_lines(log: Path):
    """Of each laser line the ranges, pose and odometry as words, and the last odometry line that stands before it."""
    last = None
    for words in map(str.split, log.read_text().splitlines()):
        if words[:1] == ["ODOM"] and len(words) > 7:
            last = np.array(words[1:4], float)
        elif words[:1] == ["FLASER"] and words[1].isdigit():
            count = int(words[1])
            yield words[2 : 2 + count], words[2 + count : 8 + count], words[8 + count], last


def of_corrected(log: Path, folder: Path, drawn: bool) -> Log:
    """With the odometry of its own lines, which count on from each true pose; or with one that is drawn: 3 % too long, and
    0.01 rad a root of a metre."""
    true, odometry, stamps, lines = [], [], [], []
    draw = np.random.default_rng(1)
    for ranges, poses, stamp, last in laser_lines(log):
        pose = np.array(poses[:3], float)
        if not true:
            at = np.zeros(3)
        elif drawn:
            step = between(true[-1], pose)
            turn_rad = 0.01 * np.sqrt(np.hypot(*step[:2])) * draw.normal()
            at = composed(odometry[-1], step * [1.03, 1.03, 1.0] + [0, 0, turn_rad])
        else:
            at = composed(odometry[-1], between(true[-1], last))
        since_s = float(stamp) - stamps[-1][0] if stamps else 0.0
        if stamps and not 0 < since_s < LONGEST_S:  # no stamps, or too coarse ones: half a metre a second
            since_s = max(0.1, 2.0 * np.hypot(*(pose - true[-1])[:2]))
        stamps.append((float(stamp), stamps[-1][1] + since_s if stamps else 1000.0))
        true.append(pose)
        odometry.append(at)
        numbers = " ".join(f"{value:.6f}" for value in (*pose, *at))
        lines.append(f"FLASER {len(ranges)} {' '.join(ranges)} {numbers} {stamps[-1][1]:.3f} host 0")
    path = folder / f"{log.stem}{'-drawn' * drawn}.clf"
    path.write_text("\n".join(lines) + "\n")
    return Log(path, np.array(true), np.array(odometry), np.array([at for _, at in stamps]))


def has_odometry(log: Path) -> bool:
    """Whether odometry lines count on between the true poses."""
    kinds = [line.split(maxsplit=1)[0] for line in log.read_text().splitlines() if line[:4] in ("ODOM", "FLAS")]
    return kinds.count("ODOM") > 1.5 * kinds.count("FLASER")


def of_raw(raw: Path, corrected: Path | None) -> Log:
    key = lambda ranges: tuple(round(float(m), 2) for m in ranges)
    known = {}
    if corrected:
        known = {key(ranges): np.array(poses[:3], float) for ranges, poses, _, _ in laser_lines(corrected)}
    lines = list(laser_lines(raw))
    none = np.full(3, np.nan)
    true = np.array([known.get(key(ranges), none) for ranges, _, _, _ in lines])
    odometry = np.array([np.array(poses[3:], float) for _, poses, _, _ in lines])
    return Log(raw, true, odometry, np.array([float(stamp) for _, _, stamp, _ in lines]))


def apart_m(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """How far each position is off after the rigid motion that fits best."""
    is_known = np.isfinite(found[:, 0]) & np.isfinite(true[:, 0])
    a, b = (of[is_known, 0] + 1j * of[is_known, 1] for of in (found, true))
    a, b = a - a.mean(), b - b.mean()
    turn = np.sum(b * a.conj())
    off = np.full(len(found), np.nan)
    off[is_known] = np.abs(a * turn / abs(turn) - b)
    return off


def from_start_m(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """How far each position is off in the frame of the first pose whose truth is known, as sd_m has it."""
    is_known = np.isfinite(found[:, 0]) & np.isfinite(true[:, 0])
    first = int(np.argmax(is_known))
    return np.array([np.hypot(*(between(found[first], a) - between(true[first], b))[:2]) for a, b in zip(found, true)])


def ate_m(off_m: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(off_m**2)))


def of_relations(path: Path, log: Log, found: np.ndarray) -> str:
    """Mean and median translational error, and the mean of the odometry's."""
    stamps = {round(stamp, 4): at for at, stamp in enumerate(log.stamps_s)}
    errors = []
    for line in path.read_text().splitlines():
        first, second, x, y, _, _, _, yaw = map(float, line.split())
        at = [stamps.get(round(stamp, 4)) for stamp in (first, second)]
        if None not in at:
            true = np.array([x, y, yaw])
            off = [between(true, between(*of[at])) for of in (found, log.odometry)]
            errors.append([np.hypot(*of[:2]) for of in off])
    mean, odometry = np.mean(errors, axis=0)
    return f"{len(errors)} relations: mean {mean:.3f} m, median {np.median(errors, axis=0)[0]:.3f}; odometry {odometry:.3f}"


def measured(crosscut: Path, log: Log, *settings: str) -> list[dict]:
    command = [crosscut, "run", log.path, "--quiet", "--out", "-", *settings]
    done = subprocess.run(list(map(str, command)), stdin=subprocess.DEVNULL, capture_output=True)
    if done.returncode not in (0, 3):
        sys.exit(f"{log.path}: {done.stderr.decode()}")
    return [json.loads(line) for line in done.stdout.splitlines()]


def row(name: str, log: Log, results: list[dict], seconds: float) -> tuple[str, np.ndarray, bool]:
    poses = [result.get("pose") for result in results]
    found = np.array([[p["x_m"], p["y_m"], p["yaw_rad"]] if p else [np.nan] * 3 for p in poses])
    # Where no pose is told, that before counts.
    for at in range(1, len(found)):
        found[at] = found[at] if np.isfinite(found[at, 0]) else found[at - 1]
    off_m, by_odometry_m = (apart_m(of, log.true) for of in (found, log.odometry))
    ate, odometry = ate_m(off_m), ate_m(by_odometry_m)
    sd_m = np.array([p["sd_m"] if p and p["sd_m"] is not None else np.nan for p in poses])
    since_m = from_start_m(found, log.true)
    judged = np.isfinite(since_m) & np.isfinite(sd_m)
    beyond = np.mean(since_m[judged] > 3 * sd_m[judged] + LEAST_M) if judged.any() else 0.0
    is_kept = ate <= max(PROPERTY * odometry, LEAST_M)
    notes = [note for result in results for note in result["notes"]]
    stretches = sum("new stretch" in note for note in notes)
    way_m = np.nansum(np.hypot(*np.diff(log.odometry[:, :2], axis=0).T))
    cells = [
        name, len(results), f"{way_m:.0f}", f"{ate:.2f}", f"{odometry:.2f}", "yes" if is_kept else "**no**",
        f"{100 * beyond:.0f} %", f"{100 * np.mean(~np.isfinite(sd_m)):.0f} %", stretches, f"{1000 * seconds / len(results):.2f}",
    ]
    return f"| {' | '.join(map(str, cells))} |", found, is_kept


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--crosscut", type=Path, default=Path("target/release/crosscut"))
    parser.add_argument("--work", type=Path, default=Path("target/foreign/slam"))
    parser.add_argument("--set", action="append", default=[])
    args = parser.parse_intermixed_args()
    args.work.mkdir(parents=True, exist_ok=True)
    corrected = {p.name[: -len(e)]: p for p in sorted(args.folder.iterdir()) for e in ENDINGS if p.name.endswith(e)}
    raw = {p.name[: -len(".raw.clf")]: p for p in sorted(args.folder.glob("*.raw.clf"))}
    logs = [
        (name + " drawn" * drawn, lambda path=path, drawn=drawn: of_corrected(path, args.work, drawn))
        for name, path in corrected.items()
        for drawn in ([False, True] if has_odometry(path) else [True])
    ]
    logs += [(f"{name} raw", lambda n=name: of_raw(raw[n], corrected[n])) for name in raw if name in corrected]
    print("| log | scans | way, m | ATE, m | odometry | kept | beyond 3 sd | sd null | stretches | ms |\n|---" + "|---" * 9 + "|")
    broken = 0
    for name, load in logs:
        if args.names and not any(of in name for of in args.names):
            continue
        log = load()
        start = time.perf_counter()
        results = measured(args.crosscut, log, *(word for setting in args.set for word in ("--set", setting)))
        line, found, is_kept = row(name, log, results, time.perf_counter() - start)
        print(line, flush=True)
        broken += not is_kept
        relations = args.folder / f"{name.removesuffix(' raw')}.relations"
        if name.endswith(" raw") and relations.exists():
            print(of_relations(relations, log, found))
    print(f"{broken} worse than {PROPERTY} times the odometry")


if __name__ == "__main__":
    main()

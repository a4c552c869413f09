"""The pose graph of a map against scipy's least squares, and poses by scan matching against small_gicp's."""

import json
import math
from pathlib import Path

import numpy as np
import program
import small_gicp
from flights import Flights
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from verdicts import Verdicts

# A ring with a stub: the flight comes back to the first junction.
PLAN = {
    "nodes": [{"id": i, "x_m": x, "y_m": y} for i, (x, y) in enumerate([(0, 0), (18, 0), (40, 2), (38, 22), (17, 20), (52, 0), (6, 28)])],
    "edges": [{"from": a, "to": b, "width_m": 3} for a, b in [(0, 1), (1, 2), (2, 3), (3, 4), (4, 1), (2, 5), (4, 6)]],
    "roughness_m": 0.1,
}
STEP = 5  # scans between the two that are matched
MOST_APART_M, MOST_APART_RAD = 0.05, 0.01  # medians of the difference between the two matchers


def check(flights: Flights, verdicts: Verdicts):
    flight = flights.work / "ring.mcap"
    plan = flights.work / "ring.json"
    plan.write_text(json.dumps(PLAN))
    flights.crosscut("simulate", "--plan", plan, "--drift", 0.05, "--out", flight, "--quiet").expect(0)
    pose_graph(flights, verdicts, flight)
    scan_matching(flights, verdicts, flight)


def pose_graph(flights: Flights, verdicts: Verdicts, flight: Path):
    """The same edges from another start have the same optimum."""
    written = flights.work / "ring.g2o"
    flights.crosscut("run", flight, "--map", written, "--quiet").expect(0)
    rows = [line.split() for line in written.read_text().splitlines()]
    poses = np.array([[float(value) for value in row[2:5]] for row in rows if row[0] == "VERTEX_SE2"])
    edges = [(int(row[1]), int(row[2]), np.array([float(value) for value in row[3:]])) for row in rows if row[0] == "EDGE_SE2"]
    roots = [np.linalg.cholesky(information(values[3:])).T for _, _, values in edges]
    merges = len(edges) - (len(poses) - 1)
    verdicts.that(merges > 0, "the flight closes loops", f"{len(poses)} visits, {len(edges)} measurements")

    def errors(free: np.ndarray) -> np.ndarray:
        at = np.vstack([poses[0], free.reshape(-1, 3)])
        return np.concatenate([root @ error(at[a], at[b], values[:3]) for (a, b, values), root in zip(edges, roots)])

    found = least_squares(errors, chained(poses, edges)[1:].ravel(), method="lm", xtol=1e-12, ftol=1e-12)
    ours = float(np.sum(errors(poses[1:].ravel()) ** 2))
    off = np.abs(found.x.reshape(-1, 3) - poses[1:])
    off[:, 2] = np.abs(np.arctan2(np.sin(off[:, 2]), np.cos(off[:, 2])))
    verdicts.that(ours <= 2 * found.cost * (1 + 1e-6) + 1e-9, "the error is as small as scipy's", f"{ours:.6f}, scipy {2 * found.cost:.6f}")
    verdicts.that(off.max() < 1e-3, "the poses are scipy's", f"at most {off.max():.1e} m or rad apart")


def information(values: np.ndarray) -> np.ndarray:
    full = np.zeros((3, 3))
    full[np.triu_indices(3)] = values
    return full + np.triu(full, 1).T


def error(a: np.ndarray, b: np.ndarray, measured: np.ndarray) -> np.ndarray:
    turn = lambda angle: np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])  # noqa: E731
    off = turn(measured[2]) @ (turn(a[2]) @ (b[:2] - a[:2]) - measured[:2])
    angle = b[2] - a[2] - measured[2]
    return np.array([*off, math.atan2(math.sin(angle), math.cos(angle))])


def chained(poses: np.ndarray, edges: list) -> np.ndarray:
    """Poses by the measurements from each to the next alone."""
    at = poses.copy()
    for a, b, values in edges:
        if b == a + 1:
            c, s = math.cos(at[a][2]), math.sin(at[a][2])
            x, y, yaw = values[:3]
            at[b] = [at[a][0] + c * x - s * y, at[a][1] + s * x + c * y, at[a][2] + yaw]
    return at


def scan_matching(flights: Flights, verdicts: Verdicts, flight: Path):
    """Motions over a few scans, by scans alone: crosscut's, small_gicp's, and the true ones."""
    ran = flights.crosscut("run", flight, "--set", "flight.pose=scan_match", "--out", "-", "--quiet").expect(0)
    ours = [isometry(*(line["pose"][part] for part in ("x_m", "y_m", "yaw_rad"))) for line in program.lines(ran.stdout)]
    scans, truths = scans_and_truths(flight)
    true = [isometry(*(truth["pose"][part] for part in ("x_m", "y_m", "yaw_rad"))) for truth in truths]
    pairs = range(0, len(scans) - STEP, 2 * STEP)
    theirs_off, ours_off, apart = [], [], []
    for i in pairs:
        target, source = scans[i], scans[i + STEP]
        start = np.linalg.inv(true[i]) @ true[i + STEP]
        matched = small_gicp.align(target, source, init_T_target_source=start, registration_type="ICP", downsampling_resolution=0.05, max_correspondence_distance=0.5)
        ours_step = np.linalg.inv(ours[i]) @ ours[i + STEP]
        theirs_off.append(difference(matched.T_target_source, start))
        ours_off.append(difference(ours_step, start))
        apart.append(difference(matched.T_target_source, ours_step))
    (theirs_m, _), (ours_m, _), (apart_m, apart_rad) = (np.median(values, axis=0) for values in (theirs_off, ours_off, apart))
    verdicts.note("motions over 5 scans against the truth", f"crosscut {100 * ours_m:.1f} cm, small_gicp {100 * theirs_m:.1f} cm (medians of {len(pairs)})")
    is_near = apart_m < MOST_APART_M and apart_rad < MOST_APART_RAD
    verdicts.that(is_near, "scan matching agrees with small_gicp", f"{100 * apart_m:.1f} cm and {math.degrees(apart_rad):.2f}° apart in the median")
    verdicts.that(ours_m <= theirs_m + 0.01, "and is no worse", f"{100 * ours_m:.1f} cm against {100 * theirs_m:.1f} cm")


def isometry(x: float, y: float, yaw: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("z", yaw).as_matrix()
    matrix[:2, 3] = [x, y]
    return matrix


def difference(a: np.ndarray, b: np.ndarray) -> tuple[float, float]:
    off = np.linalg.inv(a) @ b
    return float(np.hypot(off[0, 3], off[1, 3])), float(abs(math.atan2(off[1, 0], off[0, 0])))


def scans_and_truths(flight: Path) -> tuple[list[np.ndarray], list[dict]]:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    scans, truths = [], []
    with flight.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, _, _, scan in reader.iter_decoded_messages(topics=["/scan"]):
            ranges = np.array(scan.ranges)
            bearings = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
            is_return = np.isfinite(ranges)
            points = np.stack([ranges * np.cos(bearings), ranges * np.sin(bearings), 0 * ranges], axis=1)[is_return]
            scans.append(points.astype(np.float64))
        for _, _, message in reader.iter_messages(topics=["/truth"]):
            truths.append(json.loads(message.data))
    return scans, truths

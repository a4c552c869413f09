use std::f64::consts::{FRAC_PI_2, TAU};

use crosscut_flight::{Held, Matched, Motion, ScanMatcher};
use crosscut_stage::{Beam, Point, Revolution, Sweep};
use nalgebra::{Isometry2, Matrix3, Vector2, Vector3};
use rand::SeedableRng as _;
use rand_distr::{Distribution as _, Normal};
use rand_pcg::Pcg64Mcg;

type Wall = [[f64; 2]; 2];

const BEAMS: usize = 360;
const RANGE_M: f64 = 15.0;
const NOISE_M: f64 = 0.01;

/// A corridor of 3 m along x that turns left at x = 20 m, with a niche on its left side.
const CORNER: [Wall; 10] = [
    [[-3.0, -1.5], [21.5, -1.5]],
    [[21.5, -1.5], [21.5, 30.0]],
    [[21.5, 30.0], [18.5, 30.0]],
    [[18.5, 30.0], [18.5, 1.5]],
    [[18.5, 1.5], [10.0, 1.5]],
    [[10.0, 1.5], [10.0, 2.5]],
    [[10.0, 2.5], [8.0, 2.5]],
    [[8.0, 2.5], [8.0, 1.5]],
    [[8.0, 1.5], [-3.0, 1.5]],
    [[-3.0, 1.5], [-3.0, -1.5]],
];

/// Two smooth walls without an end in sight.
const SMOOTH: [Wall; 2] = [[[-100.0, -1.5], [200.0, -1.5]], [[200.0, 1.5], [-100.0, 1.5]]];

fn scan(walls: &[Wall], pose: &Isometry2<f64>, rng: &mut Pcg64Mcg) -> Revolution {
    scan_within(RANGE_M, walls, pose, rng)
}

fn scan_within(most_m: f64, walls: &[Wall], pose: &Isometry2<f64>, rng: &mut Pcg64Mcg) -> Revolution {
    let noise = Normal::new(0.0, NOISE_M).expect("a deviation above 0");
    let beams = (0..BEAMS).map(|beam| TAU * beam as f64 / BEAMS as f64);
    let returns = beams.filter_map(|bearing_rad| {
        let direction = pose.rotation * Vector2::new(bearing_rad.cos(), bearing_rad.sin());
        let ranges_m = walls.iter().filter_map(|wall| range_m(wall, pose.translation.vector, direction));
        let range_m = ranges_m.fold(f64::INFINITY, f64::min) + noise.sample(rng);
        (range_m < most_m).then(|| Point::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin(), 0.0))
    });
    Revolution { points_m: returns.collect(), ..Revolution::default() }
}

fn range_m(wall: &Wall, from: Vector2<f64>, direction: Vector2<f64>) -> Option<f64> {
    let (start, along) = (Vector2::from(wall[0]), Vector2::from(wall[1]) - Vector2::from(wall[0]));
    let cross = direction.perp(&along);
    let to_start = start - from;
    let (range_m, share) = (to_start.perp(&along) / cross, to_start.perp(&direction) / cross);
    (range_m > 0.0 && (0.0..=1.0).contains(&share)).then_some(range_m)
}

/// Along the corridor, round the corner, and on: 0.1 m a revolution.
fn around_the_corner() -> Vec<Isometry2<f64>> {
    let along = (0..180).map(|i| Isometry2::new(Vector2::new(0.1 * f64::from(i), 0.0), 0.0));
    let turn = (0..=31).map(|i| {
        let yaw_rad = FRAC_PI_2 * f64::from(i) / 31.0;
        Isometry2::new(Vector2::new(18.0 + 2.0 * yaw_rad.sin(), 2.0 - 2.0 * yaw_rad.cos()), yaw_rad)
    });
    let on = (1..150).map(|i| Isometry2::new(Vector2::new(20.0, 2.0 + 0.1 * f64::from(i)), FRAC_PI_2));
    along.chain(turn).chain(on).collect()
}

/// Matches scans from `poses`; predicts by true motions times `drift`, if any.
fn fly(walls: &[Wall], poses: &[Isometry2<f64>], drift: Option<f64>) -> Vec<Matched> {
    let (mut rng, mut matcher) = (Pcg64Mcg::seed_from_u64(9), ScanMatcher::default());
    let mut before = poses[0];
    poses
        .iter()
        .map(|pose| {
            let step = before.inv_mul(pose);
            before = *pose;
            let predicted = drift.map(|drift| {
                let deviation_m = 0.005 + 0.05 * step.translation.vector.norm();
                let variances = Vector3::new(deviation_m, deviation_m, 0.01).map(|deviation| deviation * deviation);
                let step = Isometry2::new(step.translation.vector * drift, step.rotation.angle());
                Motion { step, covariance: Matrix3::from_diagonal(&variances) }
            });
            matcher.add(&scan(walls, pose, &mut rng), predicted)
        })
        .collect()
}

/// Matches scans with a range, by nothing else.
fn fly_within(most_m: f64, walls: &[Wall], poses: &[Isometry2<f64>]) -> Vec<Matched> {
    let (mut rng, mut matcher) = (Pcg64Mcg::seed_from_u64(9), ScanMatcher::default());
    poses.iter().map(|pose| matcher.add(&scan_within(most_m, walls, pose, &mut rng), None)).collect()
}

fn off_m(found: &Matched, pose: &Isometry2<f64>) -> f64 {
    (found.pose.translation.vector - pose.translation.vector).norm()
}

#[test]
fn a_corridor_with_a_corner_is_followed_without_odometry() {
    let poses = around_the_corner();
    let found = fly(&CORNER, &poses, None);
    assert!(found.iter().all(|matched| !matched.lost));
    let worst_m = found.iter().zip(&poses).map(|(found, pose)| off_m(found, pose)).fold(0.0, f64::max);
    assert!(worst_m < 0.35, "1 % of 36 m: {worst_m}");
    let (last, true_last) = (found.last().expect("some"), poses.last().expect("some"));
    assert!(last.pose.rotation.angle_to(&true_last.rotation).abs() < 0.01);
}

#[test]
fn in_a_smooth_tunnel_the_odometry_decides_how_far_and_the_walls_where_across() {
    let poses: Vec<_> = (0..200).map(|i| Isometry2::new(Vector2::new(0.1 * f64::from(i), 0.0), 0.0)).collect();
    let found = fly(&SMOOTH, &poses, Some(1.02));
    let last = found.last().expect("some");
    let [x, y] = [last.pose.translation.x, last.pose.translation.y];
    assert!((x - 1.02 * 19.9).abs() < 0.2, "{x}: the walls do not show how far");
    assert!(y.abs() < 0.03, "{y}");
    let [along_m, across_m] = [last.covariance[(0, 0)], last.covariance[(1, 1)]].map(f64::sqrt);
    // That of 200 predicted motions of 10 mm each, less what they earned: the walls add nothing along the tunnel.
    assert!((0.1..0.15).contains(&along_m) && across_m < 0.05 * along_m, "along {along_m}, across {across_m}");
}

#[test]
fn walls_correct_an_odometry_that_is_too_long() {
    let poses = around_the_corner();
    let found = fly(&CORNER, &poses, Some(1.05));
    let last_m = off_m(found.last().expect("some"), poses.last().expect("some"));
    assert!(last_m < 0.7, "odometry alone is 1.8 m off: {last_m}");
}

/// A small room far from the corridor, nowhere near as wide.
const ROOM: [Wall; 4] =
    [[[-1.0, -1.0], [1.0, -1.0]], [[1.0, -1.0], [1.0, 0.7]], [[1.0, 0.7], [-1.0, 0.7]], [[-1.0, 0.7], [-1.0, -1.0]]];

/// A matcher that has followed the corridor for 2 m.
fn in_the_corridor(rng: &mut Pcg64Mcg) -> ScanMatcher {
    let mut matcher = ScanMatcher::default();
    for i in 0..20 {
        let pose = Isometry2::new(Vector2::new(0.1 * f64::from(i), 0.0), 0.0);
        let matched = matcher.add(&scan(&CORNER, &pose, rng), None);
        assert!(!matched.lost && matched.surprise < 3.0, "{matched:?}");
    }
    matcher
}

#[test]
fn a_jump_to_other_walls_is_lost_and_the_map_begins_again() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut matcher = in_the_corridor(&mut rng);
    assert!(matcher.add(&scan(&ROOM, &Isometry2::identity(), &mut rng), None).lost);
    matcher.forget();
    assert!(!matcher.add(&scan(&ROOM, &Isometry2::identity(), &mut rng), None).lost);
}

/// The walls look the same there, so that the scan matches; the vehicle cannot have turned as far.
#[test]
fn a_turn_that_no_vehicle_makes_is_a_surprise() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut matcher = in_the_corridor(&mut rng);
    let elsewhere = Isometry2::new(Vector2::new(20.0, 20.0), 0.8);
    let matched = matcher.add(&scan(&CORNER, &elsewhere, &mut rng), None);
    assert!(matched.lost || matched.surprise > 6.0, "{matched:?}");
}

#[test]
fn wheels_that_slip_are_a_surprise_and_the_walls_hold_the_pose() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let mut matcher = in_the_corridor(&mut rng);
    let covariance = Matrix3::from_diagonal(&Vector3::new(4e-4, 4e-4, 1e-4)); // 2 cm
    let slipped = Motion { step: Isometry2::translation(0.3, 0.0), covariance };
    let stands = Isometry2::new(Vector2::new(1.9, 0.0), 0.0);
    let matched = matcher.add(&scan(&CORNER, &stands, &mut rng), Some(slipped));
    assert!(matched.surprise > 6.0 && off_m(&matched, &stands) < 0.15, "{matched:?}");
}

#[test]
fn a_revolution_without_returns_keeps_the_motion_and_the_walls() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut matcher = ScanMatcher::default();
    matcher.add(&Revolution::default(), None);
    matcher.add(&scan(&CORNER, &Isometry2::identity(), &mut rng), None);
    assert!(!matcher.add(&Revolution::default(), None).lost);
    let after = Isometry2::new(Vector2::new(0.1, 0.05), 0.02);
    let matched = matcher.add(&scan(&CORNER, &after, &mut rng), None);
    assert!(!matched.lost && matched.matched > 0.5 && off_m(&matched, &after) < 0.1, "{matched:?}");
}

/// A corridor from x = -30 m to its end wall at 30 m, with a side way on its left that begins at 12 m.
fn with_an_end(half_width_m: f64) -> Vec<Wall> {
    let h = half_width_m;
    vec![
        [[-30.0, h], [12.0, h]],
        [[12.0, h], [12.0, 20.0]],
        [[14.0, 20.0], [14.0, h]],
        [[14.0, h], [30.0, h]],
        [[30.0, h], [30.0, -h]],
        [[30.0, -h], [-30.0, -h]],
    ]
}

/// Two walls in pieces of 0.3 m whose ends lie up to 10 cm off.
fn rough(rng: &mut Pcg64Mcg) -> Vec<Wall> {
    let offset = Normal::new(0.0, 0.06).expect("a deviation above 0");
    let mut walls = Vec::new();
    for side_m in [1.8, -1.8] {
        let ends: Vec<_> = (-60..300).map(|i| [0.3 * f64::from(i), side_m + offset.sample(rng)]).collect();
        walls.extend(ends.windows(2).map(|two| [two[0], two[1]]));
    }
    walls
}

fn ahead(scans: usize, step_m: f64) -> Vec<Isometry2<f64>> {
    (0..scans).map(|i| Isometry2::translation(step_m * i as f64, 0.1)).collect()
}

/// How far the last pose is off from that of the first scan.
fn end_off_m(found: &[Matched], poses: &[Isometry2<f64>]) -> f64 {
    off_m(found.last().expect("some"), &poses[0].inv_mul(poses.last().expect("some")))
}

#[test]
fn an_end_wall_far_ahead_shows_the_way_from_the_first_scan() {
    for step_m in [0.05, 0.25, 0.6] {
        let poses = ahead(30, step_m);
        let found = fly_within(50.0, &with_an_end(1.2), &poses);
        assert!(end_off_m(&found, &poses) < 0.15, "{step_m} m a scan: {:?}", found.last());
    }
}

#[test]
fn a_side_way_that_comes_into_view_frees_the_pose() {
    for step_m in [0.1, 0.2, 0.3] {
        let poses = ahead((12.0 / step_m) as usize, step_m);
        let walls: Vec<_> = with_an_end(1.75).into_iter().map(|wall| wall.map(|[x, y]| [x - 5.0, y])).collect();
        let found = fly_within(10.0, &walls, &poses);
        assert!(end_off_m(&found, &poses) < 1.0, "{step_m} m a scan: {:?}", found.last());
    }
}

#[test]
fn steps_far_longer_than_the_kernel_is_wide_are_found_between_rough_walls() {
    for step_m in [0.5, 0.8, 1.2] {
        let walls = rough(&mut Pcg64Mcg::seed_from_u64(4));
        let poses = ahead(20, step_m);
        let found = fly_within(RANGE_M, &walls, &poses);
        assert!(end_off_m(&found, &poses) < 0.3, "{step_m} m a scan: {:?}", found.last());
    }
}

#[test]
fn a_turn_between_two_scans_is_found() {
    let room: Vec<Wall> = ROOM.iter().map(|wall| wall.map(|[x, y]| [5.0 * x, 4.0 * y])).collect();
    let step = Isometry2::new(Vector2::new(0.4, 0.0), 0.5);
    let poses: Vec<_> =
        (0..6).scan(Isometry2::translation(0.3, -0.8), |pose, _| Some(std::mem::replace(pose, *pose * step))).collect();
    let found = fly_within(RANGE_M, &room, &poses);
    assert!(found.iter().all(|matched| !matched.lost) && end_off_m(&found, &poses) < 0.1, "{found:?}");
}

/// Of 360 beams the 137 behind see the vehicle itself.
#[test]
fn the_vehicle_in_its_own_scans_does_not_hold_its_pose() {
    let walls = rough(&mut Pcg64Mcg::seed_from_u64(6));
    let (mut rng, mut matcher) = (Pcg64Mcg::seed_from_u64(7), ScanMatcher::default());
    let noise = Normal::new(0.0, NOISE_M).expect("a deviation above 0");
    let poses = ahead(60, 0.15);
    let found: Vec<_> = poses
        .iter()
        .map(|pose| {
            let mut scan = scan(&walls, pose, &mut rng);
            scan.points_m.retain(|point| point.y.atan2(point.x).abs() < 1.95);
            let behind = (112..=248).map(|degrees| f64::from(degrees).to_radians());
            scan.points_m.extend(behind.map(|bearing_rad| {
                let range_m = 0.43 + noise.sample(&mut rng);
                Point::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin(), 0.0)
            }));
            scan.sweep = Some(Sweep {
                beams: (0..scan.points_m.len() as u32).map(Beam::Return).collect(),
                bearings_rad: scan.points_m.iter().map(|point| point.y.atan2(point.x)).collect(),
                ranges_m: scan.points_m.iter().map(|point| point.x.hypot(point.y) as f32).collect(),
                ..Sweep::default()
            });
            matcher.add(&scan, None)
        })
        .collect();
    assert!(end_off_m(&found, &poses) < 0.5, "{:?}", found.last());
}

#[test]
fn how_far_a_vehicle_is_along_a_smooth_tunnel_is_not_known() {
    for step_m in [0.0, 0.2] {
        let found = fly_within(RANGE_M, &SMOOTH, &ahead(20, step_m));
        let is_doubtful = |of: &Matched| matches!(of.held, Held::ButAlong(_)) && of.covariance[(0, 0)] > 0.1;
        assert!(found[1..].iter().all(is_doubtful), "{step_m} m a scan: {:?}", found.last());
    }
}

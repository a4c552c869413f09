//! The graph of passages on clouds of tunnels 4 m wide and 3 m high, whose surface is sampled all over: also where the
//! vehicle in the middle does not see it.

use std::collections::BTreeMap;

use crate::components;
use crosscut_affinity::passage::KIND;
use crosscut_stage::{Affinity, Beam, Notes, Point, Revolution, Sweep, Value};

/// A wall, upright, from one end to the other, and the number of the wall that it is part of.
type Wall = ([[f64; 2]; 2], usize);

const LEFT: Wall = ([[-12.0, 2.0], [12.0, 2.0]], 0);
const RIGHT: Wall = ([[-12.0, -2.0], [12.0, -2.0]], 1);

/// Both walls of the right one split by a branch to the right, whose walls go on where they are not seen.
const TEE: [Wall; 5] = [
    LEFT,
    ([[-12.0, -2.0], [-2.0, -2.0]], 1),
    ([[-2.0, -2.0], [-2.0, -14.0]], 1),
    ([[12.0, -2.0], [2.0, -2.0]], 2),
    ([[2.0, -2.0], [2.0, -14.0]], 2),
];

/// Pseudo-random numbers in 0..1.
struct Spread(u64);

impl Spread {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A cloud of `n` returns: three quarters on the walls, by their lengths, the rest on floor and roof; and the wall of
/// each.
fn tube(walls: &[Wall], n: usize) -> (Revolution, Vec<Option<usize>>) {
    let mut spread = Spread(1);
    let length_m = |([a, b], _): &Wall| (b[0] - a[0]).hypot(b[1] - a[1]);
    let total_m: f64 = walls.iter().map(length_m).sum();
    let (mut points_m, mut truth) = (Vec::new(), Vec::new());
    for _ in 0..n {
        let mut at_m = spread.next() * total_m * 4.0 / 3.0;
        let wall = walls.iter().find(|wall| {
            at_m -= length_m(wall);
            at_m < 0.0
        });
        let height_m = 3.0 * (spread.next() - 0.5);
        points_m.push(match wall {
            Some(([a, b], _)) => {
                let share = spread.next();
                Point::new(a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), height_m)
            }
            None => Point::new(24.0 * (spread.next() - 0.5), 4.0 * (spread.next() - 0.5), 1.5f64.copysign(height_m)),
        });
        truth.push(wall.filter(|_| height_m.abs() <= 0.3).map(|(_, number)| *number));
    }
    (Revolution { points_m, ..Revolution::default() }, truth)
}

fn graph(revolution: &Revolution) -> Affinity {
    graph_with(revolution, &[])
}

fn graph_with(revolution: &Revolution, settings: &[(&'static str, Value)]) -> Affinity {
    let mut affinity = Affinity::default();
    let mut stage = KIND.with(settings).expect("allowed");
    stage.affinity(revolution, &mut affinity, &mut Notes::default()).expect("a cloud");
    affinity
}

#[test]
fn the_walls_of_a_tube_are_those_between_its_openings_and_floor_and_roof_join_none() {
    let dead_end = [LEFT, ([[-12.0, -2.0], [12.0, -2.0]], 0), ([[12.0, -2.0], [12.0, 2.0]], 0)];
    for (name, walls, count) in [("tunnel", &[LEFT, RIGHT][..], 2), ("dead end", &dead_end, 1), ("tee", &TEE, 3)] {
        for n in [10_000, 100_000] {
            let (cloud, truth) = tube(walls, n);
            let found = components(&graph(&cloud), 0.0);
            let mut walls_of: BTreeMap<usize, BTreeMap<Option<usize>, usize>> = BTreeMap::new();
            for (component, truth) in found.iter().zip(&truth) {
                *walls_of.entry(*component).or_default().entry(*truth).or_default() += 1;
            }
            walls_of.retain(|_, members| members.values().sum::<usize>() > 1);
            assert_eq!(walls_of.len(), count, "{name} of {n} returns: {walls_of:?}");
            assert!(
                walls_of.values().all(|members| members.len() == 1 && !members.contains_key(&None)),
                "{walls_of:?}"
            );
            let (tied, level): (usize, usize) =
                (walls_of.values().flat_map(BTreeMap::values).sum(), truth.iter().flatten().count());
            assert!(
                tied as f64 > 0.98 * level as f64,
                "{name} of {n} returns: {tied} of {level} level ones are of a wall"
            );
        }
    }
}

#[test]
fn a_wall_goes_on_past_a_gap_too_narrow_for_the_vehicle() {
    let parted = [LEFT, ([[-12.0, -2.0], [-0.25, -2.0]], 1), ([[0.25, -2.0], [12.0, -2.0]], 1)];
    let mut sizes: BTreeMap<usize, usize> = BTreeMap::new();
    for component in components(&graph(&tube(&parted, 30_000).0), 0.0) {
        *sizes.entry(component).or_default() += 1;
    }
    assert_eq!(sizes.values().filter(|&&size| size > 1).count(), 2);
}

#[test]
fn a_sweep_of_more_beams_than_ranges_are_exact_is_worked_on_as_a_cloud() {
    let n = 20_000;
    let step_rad = std::f64::consts::TAU / f64::from(n);
    let bearing_rad = |beam: u32| (f64::from(beam) + 0.5) * step_rad;
    let points_m = (0..n).map(|beam| {
        let (sin, cos) = bearing_rad(beam).sin_cos();
        let range_m = (2.0 / sin.abs()).min(14.0);
        Point::new(range_m * cos, range_m * sin, 0.0)
    });
    let sweep = Sweep {
        bearings_rad: (0..n).map(bearing_rad).collect(),
        beams: (0..n).map(Beam::Return).collect(),
        step_rad,
        full_turn: true,
        ..Sweep::default()
    };
    let cloud = Revolution { points_m: points_m.collect(), ..Revolution::default() };
    let scan = Revolution { sweep: Some(sweep), ..cloud.clone() };
    assert_eq!(graph(&scan).degrees, graph(&cloud).degrees);
    let largest = graph(&cloud).degrees.iter().fold(0.0, |a: f64, b| a.max(*b));
    assert!(largest < f64::from(n) / 50.0, "a return is tied to what is near it: {largest}");
}

#[test]
fn the_mirror_image_of_a_cloud_has_the_same_walls() {
    // Rubble in the shadow at the mouth of a branch is as many steps away from one of its walls as from the other.
    let branch =
        [([[-12.0, -2.0], [2.0, -2.0]], 1), ([[12.0, -2.0], [5.0, -2.0]], 2), ([[5.0, -2.0], [5.0, -14.0]], 2)];
    let (mut cloud, _) = tube(&[&[LEFT], &branch[..]].concat(), 6000);
    let mut spread = Spread(2);
    let mut rubble = || {
        let x = 2.0 + 3.0 * spread.next();
        Point::new(x, -x - 0.4 - 4.0 * spread.next(), 0.0)
    };
    cloud.points_m.extend(std::iter::repeat_with(&mut rubble).take(2000));
    // Beams pass between the few returns of the wall into the rubble, which may close the branch.
    let open = [("without", Value::Names(vec!["odds".to_owned()]))];
    let walls = components(&graph_with(&cloud, &open), 0.0);
    assert!(walls[6000..].iter().any(|&wall| wall != walls[6000]), "it is of both");
    cloud.points_m.iter_mut().for_each(|point_m| point_m.y = -point_m.y);
    let mirrored = components(&graph_with(&cloud, &open), 0.0);
    let differ = (0..walls.len()).filter(|&i| walls[i] != mirrored[i]).count();
    assert_eq!(differ, 0, "of {} returns", walls.len());
}

//! The width of a vehicle at which an opening closes, against the cheapest wall that would close it: the shortest path from
//! one wall to the next through free space, by Dijkstra on a polar grid, which knows the walls and nothing of gaps.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{FRAC_PI_2, TAU};

use crosscut_stage::{Point, Revolution};
use proptest::prelude::{ProptestConfig, prop_assert, proptest};

use super::{Segment, TUNNEL, all, components, scan_by};

const BEARINGS: i32 = 360;
const RINGS: i32 = 120;
const RING_M: f64 = 0.1;
/// Each cell has edges to those at most this many bearings and rings away.
const REACH: i32 = 4;
/// A cell this near to a wall has an edge to it.
const BESIDE_M: f64 = 0.25;
const WITHIN_M: f64 = 0.1;
/// A component of fewer is of no wall.
const LEAST_RETURNS: usize = 3;

/// All of one wall, also what is hidden.
type Wall = Vec<Segment>;

fn off_m(wall: &Wall, [x, y]: [f64; 2]) -> f64 {
    let to = |[[ax, ay], [bx, by]]: &Segment| {
        let (dx, dy) = (bx - ax, by - ay);
        let along = (((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        (x - ax - along * dx).hypot(y - ay - along * dy)
    };
    wall.iter().map(to).fold(f64::INFINITY, f64::min)
}

/// The length of the shortest wall from `from` to `to`.
fn cheapest_m(from: &Wall, to: &Wall) -> f64 {
    let position_m = |cell: i32| {
        let (bearing_rad, range_m) =
            (TAU * f64::from(cell / RINGS) / f64::from(BEARINGS), RING_M * f64::from(cell % RINGS));
        [range_m * bearing_rad.cos(), range_m * bearing_rad.sin()]
    };
    let positions_m: Vec<[f64; 2]> = (0..BEARINGS * RINGS).map(position_m).collect();
    let mut least_m: Vec<f64> = positions_m.iter().map(|at_m| off_m(from, *at_m)).collect();
    least_m.iter_mut().filter(|off_m| **off_m > BESIDE_M).for_each(|off_m| *off_m = f64::INFINITY);
    // Lengths are positive, so their bits are in their order.
    let mut next: BinaryHeap<Reverse<(u64, i32)>> =
        (0..).zip(&least_m).filter(|(_, m)| m.is_finite()).map(|(cell, m)| Reverse((m.to_bits(), cell))).collect();
    let mut closed_m = f64::INFINITY;
    while let Some(Reverse((bits, cell))) = next.pop() {
        let (here_m, at_m) = (f64::from_bits(bits), positions_m[cell as usize]);
        if here_m >= closed_m {
            break;
        }
        let end_m = off_m(to, at_m);
        if end_m <= BESIDE_M {
            closed_m = closed_m.min(here_m + end_m);
        }
        for (bearing, ring) in
            (-REACH..=REACH).flat_map(|b| (-REACH..=REACH).map(move |r| (cell / RINGS + b, cell % RINGS + r)))
        {
            if !(1..RINGS).contains(&ring) {
                continue;
            }
            let other = (bearing.rem_euclid(BEARINGS) * RINGS + ring) as usize;
            let there_m = here_m + (positions_m[other][0] - at_m[0]).hypot(positions_m[other][1] - at_m[1]);
            if there_m < least_m[other] {
                least_m[other] = there_m;
                next.push(Reverse((there_m.to_bits(), other as i32)));
            }
        }
    }
    closed_m
}

/// What the scan shows of each wall.
fn seen(walls: &[Wall], scan: &Revolution) -> Vec<Wall> {
    let shown = |segment: &Segment| {
        let on_it = |point: &&Point| off_m(&vec![*segment], [point.x, point.y]) < 1e-6;
        let mut along: Vec<[f64; 2]> = scan.points_m.iter().filter(on_it).map(|point| [point.x, point.y]).collect();
        let start_m = |at: &[f64; 2]| (at[0] - segment[0][0]).hypot(at[1] - segment[0][1]);
        along.sort_by(|a, b| start_m(a).total_cmp(&start_m(b)));
        Some([*along.first()?, *along.last()?])
    };
    walls.iter().map(|wall| wall.iter().filter_map(shown).collect()).collect()
}

/// The least length of a wall between any two of these.
fn cheapest_of_all_m(walls: &[Wall]) -> f64 {
    let pairs = (0..walls.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    pairs.map(|(a, b)| cheapest_m(&walls[a], &walls[b])).fold(f64::INFINITY, f64::min)
}

/// The width of the vehicle, from 0.6 m on, at which there are no longer as many walls.
fn closes_at_m(scan: &Revolution, walls: usize) -> f64 {
    let has_all = |width_m: &f64| {
        let sizes = components(scan, &[("width_m", (*width_m).into())]);
        sizes.iter().filter(|size| **size >= LEAST_RETURNS).count() == walls
    };
    let widths_m = (0..).map(|step| 0.6 * 1.02f64.powi(step)).take_while(|width_m| *width_m < 30.0);
    widths_m.take_while(has_all).last().expect("as many at 0.6 m")
}

/// A tunnel 4 m wide with a branch of that width to the left, whose near side begins there and which turns by this angle.
fn with_slanting_branch(near_m: f64, width_m: f64, turn_rad: f64) -> Vec<Wall> {
    let far_m = near_m + width_m / turn_rad.sin();
    let beyond = |x_m: f64| [x_m + 30.0 * turn_rad.cos(), 2.0 + 30.0 * turn_rad.sin()];
    let (near, far) = ([near_m, 2.0], [far_m, 2.0]);
    vec![
        vec![[[-30.0, 2.0], near], [near, beyond(near_m)]],
        vec![[beyond(far_m), far], [far, [30.0, 2.0]]],
        vec![TUNNEL[1]],
    ]
}

#[test]
fn an_opening_closes_at_the_length_of_the_cheapest_wall() {
    for (near_m, width_m) in [(1.0, 1.5), (1.0, 2.5), (2.0, 3.0), (3.0, 2.0), (3.0, 3.5)] {
        let walls = with_slanting_branch(near_m, width_m, FRAC_PI_2);
        let (by_grid_m, m) = (cheapest_of_all_m(&walls), closes_at_m(&scan_by(720, &walls.concat(), all), 3));
        assert!((by_grid_m - width_m).abs() < WITHIN_M, "{width_m} m, {near_m} m ahead: {by_grid_m} m by the grid");
        // Of a branch that hardly a return shows, one a tenth wider than the vehicle may count as too narrow.
        let closes = 0.9 * by_grid_m..by_grid_m + WITHIN_M;
        assert!(closes.contains(&m), "{width_m} m, {near_m} m ahead: {m} m, not {by_grid_m} m");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn no_slanting_branch_stays_open_beyond_the_cheapest_wall_between_what_is_seen(
        near_m in 0.5..3.0f64, width_m in 1.5..3.5f64, turn_deg in 50.0..130.0f64,
    ) {
        let walls = with_slanting_branch(near_m, width_m, turn_deg.to_radians());
        let scan = scan_by(720, &walls.concat(), all);
        let (by_grid_m, m) = (cheapest_of_all_m(&seen(&walls, &scan)), closes_at_m(&scan, 3));
        prop_assert!(m < by_grid_m + WITHIN_M, "{m} m, not {by_grid_m} m");
    }
}

//! The widths of the vehicle for which the count is reported to hold, against runs with vehicles of these widths.

use proptest::prelude::{ProptestConfig, prop_assert, prop_assert_eq, proptest};

use super::*;
use crate::components;

/// The number of walls (a lone return is none) for a vehicle of this width, and the widths for which that holds if they
/// are asked for.
fn count_at(width_m: f64, scan: &Revolution, widths: bool) -> (usize, Option<[f64; 2]>) {
    let mut affinity = Affinity::default();
    let mut stage = KIND.with(&[("width_m", width_m.into()), ("widths", widths.into())]).expect("allowed");
    stage.affinity(scan, &mut affinity, &mut Notes::default()).expect("a scan");
    let wall_of_return = components(&affinity, LEAK);
    let is_wall = |root: usize| wall_of_return.iter().filter(|other| **other == root).count() > 1;
    ((0..scan.len()).filter(|&root| is_wall(root)).count(), affinity.holds_for_width_m)
}

#[test]
fn widths_are_reported_only_if_they_are_asked_for() {
    let scan = scan(&TUNNEL, all);
    assert_eq!(count_at(0.6, &scan, false).1, None);
    assert!(count_at(0.6, &scan, true).1.is_some());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_vehicle_of_a_reported_width_finds_as_many_walls(
        near_m in 0.5..3.0f64, branch_m in 1.5..3.5f64, turn_deg in 70.0..110.0f64,
    ) {
        let turn_rad = turn_deg.to_radians();
        let far_m = near_m + branch_m / turn_rad.sin();
        let beyond = |x_m: f64| [x_m + 30.0 * turn_rad.cos(), 2.0 + 30.0 * turn_rad.sin()];
        let walls = [
            [[-30.0, 2.0], [near_m, 2.0]], [[near_m, 2.0], beyond(near_m)],
            [beyond(far_m), [far_m, 2.0]], [[far_m, 2.0], [30.0, 2.0]], TUNNEL[1],
        ];
        let scan = scan(&walls, all);
        let (count, holds_m) = count_at(0.6, &scan, true);
        let [least_m, most_m] = holds_m.expect("asked for");
        prop_assert!((0.1..=0.6).contains(&least_m) && (0.6..=100.0).contains(&most_m));
        for part in 0..=20 {
            let width_m = least_m * (most_m / least_m).powf(f64::from(part) / 20.0);
            prop_assert_eq!(count_at(width_m, &scan, false).0, count, "{} m of {} to {} m", width_m, least_m, most_m);
        }
    }
}

//! How doubtful a verdict is: leaks from wall to wall, and what is told.

use std::f64::consts::{PI, TAU};

use crosscut_affinity::passage::KIND;
use crosscut_stage::{Affinity, Notes, Revolution, Value, Verdict};

use super::{LEAK, TUNNEL, all, bumps, components, scan, with_branch, with_branch_at};

/// The edges weaker than any within a wall.
fn leaks(revolution: &Revolution, settings: &[(&'static str, Value)]) -> Vec<f64> {
    let mut affinity = Affinity::default();
    let mut stage = KIND.with(settings).expect("allowed");
    stage.affinity(revolution, &mut affinity, &mut Notes::default()).expect("a scan");
    let mut leaks = Vec::new();
    affinity.weights.for_each(|i, j, weight| {
        if i < j && weight < LEAK {
            leaks.push(weight);
        }
    });
    leaks
}

#[test]
fn a_doubtful_way_on_leaks_more_than_a_clear_one_and_none_does_without_leak() {
    let most = |width_m| leaks(&scan(&with_branch(width_m), bumps(0.06)), &[]).into_iter().fold(0.0, f64::max);
    assert_eq!(leaks(&scan(&TUNNEL, all), &[]).len(), 2);
    assert!(most(3.0) > 2.0 * most(7.0), "{} {}", most(3.0), most(7.0));
    assert!(leaks(&scan(&TUNNEL, all), &[("leak", Value::Float(0.0))]).is_empty());
}

#[test]
fn verdicts_say_where_walls_end_and_where_they_go_on_over_a_gap() {
    // A tee whose far wall has lost 5 beams straight ahead of the sensor.
    let patch = |beam: usize, range_m| if (88..93).contains(&beam) { None } else { range_m };
    let revolution = scan(&with_branch(3.0), patch);
    let mut affinity = Affinity::default();
    for _ in 0..2 {
        let mut stage = KIND.with(&[]).expect("allowed");
        stage.affinity(&revolution, &mut affinity, &mut Notes::default()).expect("a scan");
        let ways: Vec<_> = affinity.verdicts.iter().filter(|verdict| verdict.is_opening).collect();
        assert_eq!(ways.len(), 3, "ahead, behind and into the branch, in a used buffer too: {:?}", affinity.verdicts);
        // The room of an opening is at least 1.05 by definition; here all of them are wider than that.
        assert!(ways.iter().all(|way| way.room_ratio > 1.2), "{ways:?}");
        let closed: Vec<_> = affinity.verdicts.iter().filter(|verdict| !verdict.is_opening).collect();
        assert!(!closed.is_empty() && closed.iter().all(|gap| gap.room_ratio < 1.0), "{closed:?}");
    }
}

#[test]
fn odds_agree_with_plain_verdicts_and_stand_at_every_gap() {
    let verdicts = verdicts(&scan(&with_branch(4.0), bumps(0.02)));
    let odds = |is_opening| {
        let of = verdicts.iter().filter(move |verdict| verdict.is_opening == is_opening);
        of.map(|verdict| verdict.p.expect("walls have directions")).collect::<Vec<_>>()
    };
    let (ways, closed) = (odds(true), odds(false));
    assert_eq!(ways.len(), 3);
    assert!(ways.iter().all(|&p| p > 0.9), "{ways:?}");
    assert!(!closed.is_empty() && closed.iter().all(|&p| p < 0.1), "{closed:?}");
}

#[test]
fn the_gap_between_both_ends_of_an_only_wall_has_odds() {
    let end = [[[6.0, -2.0], [6.0, 2.0]]];
    let dead_end = scan(&[&TUNNEL[..], &end].concat(), all);
    let ways: Vec<_> = verdicts(&dead_end).into_iter().filter(|verdict| verdict.is_opening).collect();
    assert_eq!(components(&dead_end, &[]).len(), 1);
    let [way] = ways[..] else { panic!("{ways:?}") };
    assert!(way.p > Some(0.9), "{way:?}");
}

fn verdicts(revolution: &Revolution) -> Vec<Verdict> {
    let mut affinity = Affinity::default();
    let mut stage = KIND.with(&[]).expect("allowed");
    stage.affinity(revolution, &mut affinity, &mut Notes::default()).expect("a scan");
    affinity.verdicts
}

fn without(name: &str) -> [(&'static str, Value); 1] {
    [("without", vec![name].into())]
}

#[test]
fn a_rule_left_out_by_name_finds_no_way() {
    let face = [[[6.0, -2.0], [6.0, -0.7]], [[6.0, 0.7], [6.0, 2.0]]];
    let door = scan(&[&TUNNEL[..], &face].concat(), all);
    let walls = |settings: &[_]| components(&door, settings).len();
    assert_eq!((walls(&[]), walls(&without("doors")), walls(&without("line"))), (2, 1, 2));
}

#[test]
fn a_veto_left_out_by_name_closes_no_corner_of_a_dead_end() {
    let are_one_wall = |settings: &[_]| {
        (1..=24).map(|half| 0.5 * f64::from(half)).all(|end_m| {
            let side = |y_m: f64| [[-30.0, y_m], [end_m, y_m]];
            let dead_end = [side(-0.6), side(1.4), [[end_m, -0.6], [end_m, 1.4]]];
            components(&scan(&dead_end, all), settings).len() == 1
        })
    };
    assert!(are_one_wall(&[]) && !are_one_wall(&without("line")));
}

#[test]
fn a_dark_patch_in_a_side_wall_is_no_door_though_as_wide_as_one() {
    let sides = [3.0, -3.0].map(|y_m| [[-30.0, y_m], [30.0, y_m]]);
    for [x_m, y_m] in [[2.0, 3.0], [-2.0, 3.0], [2.0, -3.0], [-2.0, -3.0]] {
        let patch = |beam: usize, range_m: Option<f64>| {
            let (sin, cos) = (-PI + (beam as f64 + 0.5) * TAU / 360.0).sin_cos();
            let is_lost = |m: f64| (m * cos - x_m).abs() < 0.65 && (m * sin - y_m).abs() < 0.1;
            range_m.filter(|&m| !is_lost(m))
        };
        let walls = |settings: &[_]| components(&scan(&sides, patch), settings).len();
        assert_eq!((walls(&[]), walls(&without("odds"))), (2, 3), "the patch is at ({x_m}, {y_m})");
    }
    // Ahead or behind, in the wall that ends a tunnel, as much darkness is a door.
    for x_m in [6.0, -6.0] {
        let face = [[[x_m, -2.0], [x_m, -0.7]], [[x_m, 0.7], [x_m, 2.0]]];
        assert_eq!(components(&scan(&[&TUNNEL[..], &face].concat(), all), &[]).len(), 2, "{x_m} m ahead");
    }
}

#[test]
fn a_rule_that_does_not_exist_is_refused_with_those_that_do() {
    let refused = KIND.with(&without("door")).err().expect("must be refused").to_string();
    assert!(refused.contains(r#"without = ["door"]"#) && refused.contains("doors, blank, dark_end"), "{refused}");
}

#[test]
fn an_opening_measures_what_it_needs_and_a_slit_less_than_the_vehicle() {
    for branch_m in [2.0, 3.0, 5.0] {
        for way in verdicts(&scan(&with_branch(branch_m), bumps(0.02))).iter().filter(|verdict| verdict.is_opening) {
            let measured = way.measured.expect("walls have directions");
            assert!(measured.unit == "m" && measured.value >= measured.limit, "{branch_m} m: {measured}");
        }
    }
    let verdicts = verdicts(&scan(&with_branch_at(2.0, 0.5), all));
    let slit = verdicts.iter().find(|verdict| verdict.reason == "a slit").expect("the branch");
    let measured = slit.measured.expect("a width");
    assert!((measured.value - 0.5).abs() < 0.1 && measured.limit == 0.6 && !slit.is_opening, "{measured}");
}

//! `here` on simulated flights, against the network of the mine.

use std::collections::BTreeMap;

use crosscut_flight::{FlightAnswer, Here, HereKind};
use crosscut_messages::TruthPlace;
use crosscut_simulator::Scene;
use crosscut_stage::Frame;

use crate::{Flown, Follower, MINE, TUNNEL, follow, scenario};

fn is_right(here: &Here, truth: Option<TruthPlace>) -> bool {
    let kind = |truth: TruthPlace| format!("{:?}", truth.kind) == format!("{:?}", here.kind);
    truth.is_some_and(|truth| kind(truth) && truth.ways as usize == here.ways.len())
}

#[test]
fn kind_and_ways_are_right_in_nine_of_ten_revolutions() {
    let mut right: BTreeMap<String, [usize; 2]> = BTreeMap::new();
    let [tunnel, mine] = ["tunnel", "mine"].map(|name| Flown::of(name, 2, usize::MAX));
    for (name, flown) in [("tunnel", &*TUNNEL), ("tunnel", &tunnel), ("mine", &*MINE), ("mine", &mine)] {
        for seen in &flown.revolutions {
            let Some(TruthPlace { kind, ways }) = seen.true_here else { continue };
            let is_right = is_right(seen.answer.here.as_ref().expect("a full turn"), seen.true_here);
            let entry = right.entry(format!("{name} {kind:?} {ways}")).or_default();
            entry[0] += usize::from(is_right);
            entry[1] += 1;
        }
    }
    for (of, [right, all]) in &right {
        println!("{of}: {right} of {all}");
    }
    // A place that has not been seen at all would make the bound below empty.
    assert!(right.len() >= 6, "{right:?}");
    for (of, [right, all]) in &right {
        assert!(*right as f64 >= 0.9 * *all as f64, "{of}: {right} of {all}");
    }
}

/// Leaves the beams within an angle of straight ahead.
fn narrow(scene: &mut Scene, within_deg: f64) {
    let (first_rad, step_rad) = (f64::from(scene.scan.angle_min), f64::from(scene.scan.angle_increment));
    let beam_at = |bearing_deg: f64| ((bearing_deg.to_radians() - first_rad) / step_rad).round() as usize;
    let [first, last] = [beam_at(-within_deg), beam_at(within_deg)];
    let bearing_rad = |beam: usize| (first_rad + beam as f64 * step_rad) as f32;
    (scene.scan.angle_min, scene.scan.angle_max) = (bearing_rad(first), bearing_rad(last));
    scene.scan.ranges = scene.scan.ranges[first..=last].to_vec();
}

#[test]
fn a_limited_view_knows_what_earlier_scans_saw_behind() {
    let (mut unknown, mut judged) = (Vec::new(), Vec::new());
    for (name, seed) in [("tunnel", 1), ("mine", 1)] {
        let first = unknown.len();
        follow(
            name,
            seed,
            usize::MAX,
            |scene| narrow(scene, 120.0),
            |scene, frame| {
                unknown.push(FlightAnswer::of(frame).here.is_none());
                if let Some(found) = FlightAnswer::of(frame).here.as_ref().filter(|_| scene.truth.here.is_some()) {
                    judged.push(is_right(found, scene.truth.here));
                }
            },
        );
        assert!(unknown[first], "nothing is known of what lies behind");
    }
    let share = |of: &[bool]| of.iter().filter(|is| **is).count() as f64 / of.len() as f64;
    println!("{:.3} unknown, {:.3} right", share(&unknown), share(&judged));
    assert!(share(&unknown) < 0.1 && share(&judged) >= 0.9, "{} {}", share(&unknown), share(&judged));
}

#[test]
fn a_view_with_no_line_through_the_sensor_knows_no_place_at_first() {
    let mut here = Vec::new();
    follow("tunnel", 1, 3, |scene| narrow(scene, 60.0), |_, frame| here.push(FlightAnswer::of(frame).here.clone()));
    assert_eq!(here, [None, None, None]);
}

#[test]
fn what_lies_behind_the_start_of_a_limited_view_is_no_end_and_parts_no_mouth() {
    for within_deg in [90.0, 127.5] {
        let mut places = BTreeMap::new();
        let count = |_: &Scene, frame: &Frame| {
            let here = FlightAnswer::of(frame).here.as_ref();
            *places.entry(here.map(|here| (here.kind, here.ways.len()))).or_insert(0) += 1;
        };
        follow("tee", 1, 80, |scene| narrow(scene, within_deg), count);
        let passages = places[&Some((HereKind::Passage, 2))];
        assert!(passages >= 20 && places.keys().flatten().count() == 1, "{within_deg}: {places:?}");
    }
}

/// First scans of flights that begin along a flight, with a view of 255 degrees: all, those that know the place, and those
/// that are right.
fn first_places(name: &str, seed: u64) -> [usize; 3] {
    let mut found = [0; 3];
    for mut scene in (scenario(name).fly)(seed).step_by(5) {
        narrow(&mut scene, 127.5);
        let mut follower = Follower::default();
        let here = &FlightAnswer::of(follower.follow(&scene)).here;
        let is = here.as_ref().filter(|_| scene.truth.here.is_some()).map(|here| is_right(here, scene.truth.here));
        found = [found[0] + 1, found[1] + usize::from(is.is_some()), found[2] + usize::from(is == Some(true))];
    }
    found
}

#[test]
fn a_first_scan_with_a_limited_view_names_a_junction_or_nothing() {
    let mut sum = [0; 3];
    for (name, seed) in [("loops", 1), ("close", 1), ("tunnel", 1)] {
        let found = first_places(name, seed);
        println!("{name}: of {} first scans {} know the place, {} right", found[0], found[1], found[2]);
        (0..3).for_each(|at| sum[at] += found[at]);
    }
    let [_, known, right] = sum;
    assert!(known >= 20 && right as f64 >= 0.8 * known as f64, "{sum:?}");
}

/// The place in a scan, of a full turn of a beam a degree, of these walls, each from a point to another, in metres.
fn place_between(walls_m: &[[[f64; 2]; 2]]) -> Option<Here> {
    let mut scene = (scenario("tunnel").fly)(1).next().expect("a flight has scans");
    let far_m = f64::from(scene.scan.range_max);
    let free_m = |bearing_rad: f64| {
        let (y, x) = bearing_rad.sin_cos();
        let hit_m = |[from, to]: &[[f64; 2]; 2]| {
            let [along_x, along_y] = [to[0] - from[0], to[1] - from[1]];
            let across = x * along_y - y * along_x;
            let (range_m, at) =
                ((from[0] * along_y - from[1] * along_x) / across, (from[0] * y - from[1] * x) / across);
            (range_m > 0.0 && (0.0..=1.0).contains(&at)).then_some(range_m)
        };
        walls_m.iter().filter_map(hit_m).filter(|range_m| *range_m < far_m).fold(f64::INFINITY, f64::min)
    };
    let (first_rad, step_rad) = (f64::from(scene.scan.angle_min), f64::from(scene.scan.angle_increment));
    scene.scan.ranges =
        (0..scene.scan.ranges.len()).map(|beam| free_m(first_rad + beam as f64 * step_rad) as f32).collect();
    FlightAnswer::of(Follower::default().follow(&scene)).here.clone()
}

#[test]
fn beside_one_wall_in_the_open_no_place_is_known() {
    let [near, far] = [0.65, -1.5].map(|y_m| [[-30.0, y_m], [30.0, y_m]]);
    assert_eq!(place_between(&[near]), None);
    let passage = place_between(&[near, far]).expect("a full turn");
    assert_eq!((format!("{:?}", passage.kind), passage.ways.len()), ("Passage".to_owned(), 2));
}

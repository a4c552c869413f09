//! The steady answer on simulated flights, against the truth of each revolution.

use std::collections::BTreeSet;

use crosscut_flight::{FlightAnswer, Steady};
use crosscut_messages::Time;
use crosscut_simulator::Scene;

use crate::{Follower, follow, scenario};

struct Flown {
    truth: usize,
    single: usize,
    here: Option<(&'static str, usize)>,
    steady: Steady,
}

fn fly(name: &str, seed: u64, revolutions: usize, edit: impl Fn(&mut Scene)) -> Vec<Flown> {
    let mut flown = Vec::new();
    follow(name, seed, revolutions, edit, |scene, frame| {
        let here = FlightAnswer::of(frame).here.as_ref().map(|here| (here.kind.name(), here.ways.len()));
        let steady = FlightAnswer::of(frame).steady.clone().expect("there are returns");
        flown.push(Flown { truth: scene.truth.walls as usize, single: frame.junction.junctions, here, steady });
    });
    flown
}

/// Revolutions whose answer is not that before, although that after is.
fn flicker<A: PartialEq>(answers: &[A]) -> usize {
    answers.windows(3).filter(|three| three[0] == three[2] && three[0] != three[1]).count()
}

#[test]
fn the_steady_answer_does_not_flicker_and_is_nearly_as_right() {
    for (name, seed) in [("tunnel", 1), ("mine", 1)] {
        let flown = fly(name, seed, 800, |_| {});
        let right = |of: fn(&Flown) -> usize| flown.iter().filter(|flown| of(flown) == flown.truth).count();
        let (single, steady) = (right(|flown| flown.single), right(|flown| flown.steady.junctions));
        // In the tunnel the openings change faster than the belief; in the mine the single answers err.
        assert!(steady + 40 >= single, "{name}: single {single}, steady {steady}");
        let counts = |of: fn(&Flown) -> usize| flicker(&flown.iter().map(of).collect::<Vec<_>>());
        let (single, steady) = (counts(|flown| flown.single), counts(|flown| flown.steady.junctions));
        assert!(single > 10 && steady == 0, "{name}: single {single}, steady {steady}");
        let places: Vec<_> = flown
            .iter()
            .map(|flown| flown.steady.here.as_ref().map(|here| (here.kind.name(), here.ways.len())))
            .collect();
        assert_eq!(flicker(&places), 0, "{name}");
        let alike = flown.iter().zip(&places).filter(|(flown, place)| flown.here == **place).count();
        assert!(alike as f64 > 0.9 * flown.len() as f64, "{name}: {alike} places are those of the revolution");
    }
}

#[test]
fn openings_keep_their_tracks_and_ways_lead_to_them() {
    let flown = fly("tunnel", 1, 400, |_| {});
    let mut tracks = BTreeSet::new();
    let mut kept = [0, 0];
    let mut before: BTreeSet<u64> = BTreeSet::new();
    for Flown { steady, .. } in &flown {
        let now: BTreeSet<u64> = steady.openings.iter().map(|opening| opening.track).collect();
        assert_eq!(now.len(), steady.openings.len(), "a track stands for one opening");
        kept[0] += now.intersection(&before).count();
        kept[1] += now.len();
        tracks.extend(now.iter().copied());
        before = now;
        assert!(steady.openings.is_sorted_by(|a, b| a.bearing_rad <= b.bearing_rad));
        let ways = steady.here.iter().flat_map(|here| here.ways.iter().filter_map(|way| way.opening));
        assert!(ways.into_iter().all(|opening| opening < steady.openings.len()));
    }
    let share = kept[0] as f64 / kept[1] as f64;
    println!("{share:.3} of the openings have the track of the revolution before; {} tracks", tracks.len());
    assert!(share > 0.9 && tracks.len() < 60, "{share} {}", tracks.len());
}

#[test]
fn scans_without_stamps_move_the_steady_answer_too() {
    let held = |edit: fn(&mut Scene)| {
        let steady = fly("tunnel", 1, 200, edit).into_iter().map(|flown| flown.steady);
        steady.map(|steady| (steady.junctions, steady.here.map(|here| here.kind.name()))).collect::<BTreeSet<_>>()
    };
    assert_eq!(held(|scene| scene.scan.header.stamp = Time::default()), held(|_| {}));
}

#[test]
fn after_a_cut_the_steady_answer_is_that_of_the_scans_after_it() {
    // Of a flight without odometry, 40 scans in one place and then 40 in another, where another number of walls is seen.
    let mut follower = Follower::default();
    let is_of_the_cut = |at: &usize| (60..100).contains(at) || *at >= 300;
    let scenes = (scenario("mine").fly)(1).enumerate().filter(|(at, _)| is_of_the_cut(at)).take(42);
    let cut: Vec<_> = scenes
        .map(|(at, scene)| {
            let frame = follower.follow(&scene);
            let flown = FlightAnswer::of(frame);
            let stretch = flown.doubt.expect("a pose").stretch;
            (at, stretch, frame.junction.junctions, flown.steady.as_ref().map(|steady| steady.junctions))
        })
        .collect();
    let [before, after] = [cut[39], cut[40]];
    assert!(before.1 == 0 && after.1 == 1, "the cut is seen: {cut:?}");
    assert!(before.3 != Some(after.2), "the places differ: {before:?} {after:?}");
    assert_eq!(after.3, Some(after.2));
}

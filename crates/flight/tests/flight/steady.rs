//! The steady answer on simulated flights, against the truth of each revolution.

use std::collections::BTreeSet;

use crosscut_flight::{FlightAnswer, Here, Steady};
use crosscut_messages::Time;
use crosscut_simulator::Scene;

use crate::{Follower, MINE, Seen, TUNNEL, follow, scenario};

fn steady(answer: &FlightAnswer) -> &Steady {
    answer.steady.as_ref().expect("there are returns")
}

/// Revolutions whose answer is not that before, although that after is.
fn flicker<A: PartialEq>(answers: &[A]) -> usize {
    answers.windows(3).filter(|three| three[0] == three[2] && three[0] != three[1]).count()
}

#[test]
fn the_steady_answer_does_not_flicker_and_is_nearly_as_right() {
    for (name, flown) in [("tunnel", &TUNNEL), ("mine", &MINE)] {
        let flown = &flown.revolutions[..800];
        let single: fn(&Seen) -> usize = |seen| seen.junctions;
        let held: fn(&Seen) -> usize = |seen| steady(&seen.answer).junctions;
        let right = |of: fn(&Seen) -> usize| flown.iter().filter(|seen| of(seen) == seen.true_walls).count();
        // In the tunnel the openings change faster than the belief; in the mine the single answers err.
        let least = 0.97 * right(single) as f64;
        assert!(right(held) as f64 >= least, "{name}: single {}, steady {}", right(single), right(held));
        let flickers = |of: fn(&Seen) -> usize| flicker(&flown.iter().map(of).collect::<Vec<_>>());
        assert!(flickers(single) > 0 && flickers(held) == 0, "{name}: {} {}", flickers(single), flickers(held));
        let name_of = |here: &Option<Here>| here.as_ref().map(|here| (here.kind.name(), here.ways.len()));
        let places: Vec<_> = flown.iter().map(|seen| name_of(&steady(&seen.answer).here)).collect();
        assert_eq!(flicker(&places), 0, "{name}");
        let alike = flown.iter().zip(&places).filter(|(seen, place)| name_of(&seen.answer.here) == **place).count();
        assert!(alike as f64 > 0.9 * flown.len() as f64, "{name}: {alike} places are those of the revolution");
    }
}

#[test]
fn openings_keep_their_tracks() {
    let mut kept = [0, 0];
    let mut before: BTreeSet<u64> = BTreeSet::new();
    for seen in &TUNNEL.revolutions[..400] {
        let now: BTreeSet<u64> = steady(&seen.answer).openings.iter().map(|opening| opening.track).collect();
        kept[0] += now.intersection(&before).count();
        kept[1] += now.len();
        before = now;
    }
    let share = kept[0] as f64 / kept[1] as f64;
    assert!(share > 0.9, "{share} of the openings have the track of the revolution before");
}

#[test]
fn scans_without_stamps_move_the_steady_answer_too() {
    let name = |answer: &FlightAnswer| {
        let Steady { junctions, here, .. } = steady(answer);
        (*junctions, here.as_ref().map(|here| here.kind.name()))
    };
    let mut without = BTreeSet::new();
    let unstamped = |scene: &mut Scene| scene.scan.header.stamp = Time::default();
    follow("tunnel", 1, 200, unstamped, |_, frame| {
        without.insert(name(FlightAnswer::of(frame)));
    });
    assert_eq!(without, TUNNEL.revolutions[..200].iter().map(|seen| name(&seen.answer)).collect());
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

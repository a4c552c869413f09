//! Places that turn out to be one once the drift is corrected.

use super::Decided;
use super::candidate::{Best, Candidate, best};
use super::derived::Derived;
use super::legs::flown_to;
use super::log::{Link, Log};

/// Once the drift is corrected, two nodes nearer than this may be one.
const RECONSIDERED_M: f64 = 4.0;

/// After a correction, links the places that turn out to be one: those that lie on each other.
pub(super) fn reconsider(log: &mut Log) {
    let newest = log.visits.len() - 1;
    loop {
        let map = Derived::of(log);
        let Some((from, (Candidate { node, fit, .. }, runner_up))) = one_of_two(log, &map) else { return };
        let score = fit.share;
        let visits = [node, from].map(|node| map.places[node].first);
        let before = map.places[from].visits.iter().rfind(|visit| **visit != newest);
        let at_ns = before.map_or(0, |&visit| log.visits[visit].time_ns[1]);
        let why = format!("after the correction the walls of node {from} lie on its own by {score:.2}: they are one");
        log.fit(visits, &fit);
        log.links.push(Link { visits, decided: Decided { node, at_ns, score, runner_up, why } });
    }
}

/// A node that lies on an earlier one by its walls, better than on any other.
fn one_of_two(log: &Log, map: &Derived) -> Option<(usize, Best)> {
    (1..map.places.len()).rev().find_map(|from| {
        let of = map.places[from].first;
        let near = (0..from).filter(|&into| may_be_one(map, from, into)).collect::<Vec<_>>();
        let flown = if near.is_empty() { Vec::new() } else { flown_to(log, of) };
        // Where no way that is known leads, places lie near to each other by nothing but a guess.
        let known = near.into_iter().filter_map(|node| Some((node, flown[map.places[node].first].sd_m?)));
        let fits = known.flat_map(|(node, sd_m)| {
            let first = map.places[node].first;
            let apart = log.graph.poses[first].inv_mul(&log.graph.poses[of]);
            let fits = log.visits[first].walls.fits(&log.visits[of].walls, apart);
            fits.map(move |fit| Candidate::new(node, fit, &apart, sd_m, false))
        });
        best(fits.collect()).filter(|(_, is_clear)| *is_clear).map(|(found, _)| (from, found))
    })
}

/// Whether two nodes lie so near to each other that they may be one, and no passage leads from one to the other.
fn may_be_one(map: &Derived, a: usize, b: usize) -> bool {
    let [node, other] = [a, b].map(|node| &map.map.nodes[node]);
    let joins = |passage: &super::Passage| [[a, b], [b, a]].contains(&[passage.from, passage.to]);
    node.kind == other.kind
        && (node.position_m - other.position_m).norm() < RECONSIDERED_M
        && !map.map.passages.iter().any(joins)
}

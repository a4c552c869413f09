//! What was flown between visits, and so how visits lie to each other.

use std::collections::VecDeque;

use crosscut_stage::DisjointSets;

use super::log::{Known, Log};

/// For each visit the number of its group: within a group it is measured how visits lie to each other.
pub(super) fn groups(log: &Log) -> Vec<u32> {
    let mut sets = DisjointSets::default();
    sets.reset(log.visits.len());
    for (edge, _) in log.graph.edges.iter().zip(&log.known).filter(|(_, known)| known.is_measured) {
        sets.join(edge.from, edge.to);
    }
    sets.number_components().to_vec()
}

/// The best known way from each visit to one of them, over edges of the graph; infinite where there is none that is known.
pub(super) fn flown_to(log: &Log, visit: usize) -> Vec<Known> {
    let unknown = Known { is_measured: false, sd_m: None, heading_rad2: 0.0 };
    let mut flown = vec![unknown; log.visits.len()];
    let mut joined: Vec<Vec<(usize, f64, f64)>> = vec![Vec::new(); flown.len()];
    for (edge, of) in log.graph.edges.iter().zip(&log.known) {
        if let Some(sd_m) = of.sd_m {
            joined[edge.from].push((edge.to, sd_m, of.heading_rad2));
            joined[edge.to].push((edge.from, sd_m, of.heading_rad2));
        }
    }
    flown[visit] = Known { is_measured: true, sd_m: Some(0.0), heading_rad2: 0.0 };
    // Bellman and Ford's queue: few visits have more than two edges.
    let mut changed = VecDeque::from([visit]);
    while let Some(at) = changed.pop_front() {
        let Known { sd_m: Some(sd_m), heading_rad2, .. } = flown[at] else { continue };
        for &(to, more_m, more_rad2) in &joined[at] {
            if flown[to].sd_m.is_none_or(|known_m| sd_m + more_m < known_m) {
                let heading_rad2 = heading_rad2 + more_rad2;
                flown[to] = Known { is_measured: true, sd_m: Some(sd_m + more_m), heading_rad2 };
                changed.push_back(to);
            }
        }
    }
    flown
}

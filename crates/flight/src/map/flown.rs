//! What was flown between visits, and so how visits lie to each other.

use std::collections::VecDeque;

use super::Mapper;

/// The flight between two visits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flown {
    /// Not so between two stretches.
    pub(super) is_measured: bool,
    /// Standard deviation of where it led; `None` if that is not known.
    pub(super) sd_m: Option<f64>,
    /// Variance of the heading there.
    pub(super) heading_rad2: f64,
}

impl Mapper {
    /// For each visit the number of its group: within a group it is measured how visits lie to each other.
    pub(super) fn groups(&self) -> Vec<usize> {
        let mut groups: Vec<usize> = (0..self.graph.poses.len()).collect();
        for (edge, _) in self.graph.edges.iter().zip(&self.flown).filter(|(_, flown)| flown.is_measured) {
            let first = |mut visit: usize| {
                while groups[visit] != visit {
                    visit = groups[visit];
                }
                visit
            };
            let [from, to] = [edge.from, edge.to].map(first);
            groups[from.max(to)] = from.min(to);
        }
        for visit in 0..groups.len() {
            groups[visit] = groups[groups[visit]];
        }
        groups
    }

    /// The best known way from each visit to one of them, over edges of the graph; infinite where there is none that is known.
    pub(super) fn flown_to(&self, visit: usize) -> Vec<Flown> {
        let unknown = Flown { is_measured: false, sd_m: None, heading_rad2: 0.0 };
        let mut flown = vec![unknown; self.graph.poses.len()];
        let mut joined: Vec<Vec<(usize, f64, f64)>> = vec![Vec::new(); flown.len()];
        for (edge, of) in self.graph.edges.iter().zip(&self.flown) {
            if let Some(sd_m) = of.sd_m {
                joined[edge.from].push((edge.to, sd_m, of.heading_rad2));
                joined[edge.to].push((edge.from, sd_m, of.heading_rad2));
            }
        }
        flown[visit] = Flown { is_measured: true, sd_m: Some(0.0), heading_rad2: 0.0 };
        // Bellman and Ford's queue: few visits have more than two edges.
        let mut changed = VecDeque::from([visit]);
        while let Some(at) = changed.pop_front() {
            let Flown { sd_m: Some(sd_m), heading_rad2, .. } = flown[at] else { continue };
            for &(to, more_m, more_rad2) in &joined[at] {
                if flown[to].sd_m.is_none_or(|known_m| sd_m + more_m < known_m) {
                    let heading_rad2 = heading_rad2 + more_rad2;
                    flown[to] = Flown { is_measured: true, sd_m: Some(sd_m + more_m), heading_rad2 };
                    changed.push_back(to);
                }
            }
        }
        flown
    }
}

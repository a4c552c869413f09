//! The number of beams that each true wall shares with each reported wall.

use crosscut_messages::Truth;
use crosscut_stage::Frame;

use crate::assignment::best_matching;

// Truth and results use the same labels, so that a result can take the place of the truth.
const _: () = assert!(Truth::NO_RETURN == Frame::NO_RETURN && Truth::NO_WALL == Frame::NO_WALL);

/// The number of beams that each true wall shares with each reported one, in one scan. Islands count as walls.
#[derive(Debug)]
pub(crate) struct Contingency {
    /// Ids of the true walls that have beams, ascending.
    pub(crate) true_walls: Vec<i32>,
    /// Ids of the reported walls that have beams, ascending.
    pub(crate) reported_walls: Vec<i32>,
    /// |T_a ∩ R_b|, a row per true wall that has beams, a column per reported one.
    shared: Vec<Vec<usize>>,
    /// |T_a|.
    true_size: Vec<usize>,
    /// |R_b|.
    reported_size: Vec<usize>,
    /// Number of beams with a return by the truth, or with a wall by the result.
    pub(crate) beams: usize,
    /// Number of returns of no true wall (dust) that are in no reported wall.
    left_out: usize,
}

impl Contingency {
    /// Counts labels per beam, equally many on both sides: wall numbers from 0, [`Truth::NO_RETURN`], or no wall.
    pub(crate) fn of(truth: &[i32], reported: &[i32]) -> Self {
        let (true_walls, reported_walls) = (walls(truth), walls(reported));
        let (rows, columns) = (true_walls.len(), reported_walls.len());
        let mut table = Self {
            shared: vec![vec![0; columns]; rows],
            true_size: vec![0; rows],
            reported_size: vec![0; columns],
            beams: 0,
            left_out: 0,
            true_walls,
            reported_walls,
        };
        for (&t, &r) in truth.iter().zip(reported) {
            let row = table.true_walls.binary_search(&t).ok();
            let column = table.reported_walls.binary_search(&r).ok();
            if let Some(a) = row {
                table.true_size[a] += 1;
            }
            if let Some(b) = column {
                table.reported_size[b] += 1;
            }
            if let (Some(a), Some(b)) = (row, column) {
                table.shared[a][b] += 1;
            }
            table.beams += usize::from(t != Truth::NO_RETURN || column.is_some());
            table.left_out += usize::from(t != Truth::NO_RETURN && row.is_none() && column.is_none());
        }
        table
    }

    /// Pairs of a true and a reported wall with |T ∩ R| / |T ∪ R| >= `least`. For `least` above 1/2 no wall is in two
    /// pairs, because walls of one side share no beam.
    pub(crate) fn overlapping(&self, least: f64) -> impl Iterator<Item = (usize, usize)> {
        let iou = |a: usize, b: usize| {
            let shared = self.shared[a][b];
            shared as f64 / (self.true_size[a] + self.reported_size[b] - shared) as f64
        };
        (0..self.true_size.len())
            .flat_map(|a| (0..self.reported_size.len()).map(move |b| (a, b)))
            .filter(move |&(a, b)| iou(a, b) >= least)
    }

    /// Number of beams with the right label, under the one-to-one matching of walls that maximises it.
    pub(crate) fn beams_right(&self) -> usize {
        let pairs = best_matching(self.true_size.len(), self.reported_size.len(), |a, b| self.shared[a][b] as f64);
        self.left_out + pairs.iter().map(|&(a, b)| self.shared[a][b]).sum::<usize>()
    }

    /// Adjusted Rand index (Hubert and Arabie 1985) over the beams of true walls. Beams in no reported wall are one group.
    pub(crate) fn adjusted_rand_index(&self) -> f64 {
        let pairs = |n: usize| (n * n.saturating_sub(1) / 2) as f64;
        let left_out = |a: usize| self.true_size[a] - self.shared[a].iter().sum::<usize>();
        let columns = |b: usize| self.shared.iter().map(|row| row[b]).sum::<usize>();
        let all_left_out = (0..self.true_size.len()).map(left_out).sum::<usize>();

        let together: f64 = self.shared.iter().flatten().map(|&n| pairs(n)).sum::<f64>()
            + (0..self.true_size.len()).map(|a| pairs(left_out(a))).sum::<f64>();
        let in_truth: f64 = self.true_size.iter().map(|&n| pairs(n)).sum();
        let in_report: f64 =
            (0..self.reported_size.len()).map(|b| pairs(columns(b))).sum::<f64>() + pairs(all_left_out);
        let all = pairs(self.true_size.iter().sum());
        let expected = in_truth * in_report / all;
        let largest = 0.5 * (in_truth + in_report);
        // Both sides agree if both are one group, or all singletons, or have no pair.
        if all == 0.0 || largest == expected { 1.0 } else { (together - expected) / (largest - expected) }
    }
}

/// The distinct wall numbers, ascending.
fn walls(labels: &[i32]) -> Vec<i32> {
    let mut ids = Vec::new();
    for &label in labels.iter().filter(|label| **label >= 0) {
        if let Err(place) = ids.binary_search(&label) {
            ids.insert(place, label);
        }
    }
    ids
}

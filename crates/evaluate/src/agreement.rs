//! Two answers to the same scan, compared.

use crosscut_messages::TruthOpening;
use crosscut_report::{ResultsLine, WayLine};

use crate::assignment::best_matching;
use crate::contingency::Contingency;
use crate::openings::{self, OpeningsScore};
use crate::score::is_island;
use crate::{SAME_WALL_IOU, ScoreError};

/// Ways on are the same if their directions differ by at most this, rad (20°).
const SAME_WAY_RAD: f64 = std::f64::consts::PI / 9.0;

/// The agreement of two answers to the same scan. Arrays have a value for the first and one for the second answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement {
    /// Number of the revolution.
    pub seq: u64,
    /// The sensor's stamp.
    pub stamp_ns: u64,
    /// Number of walls, without islands.
    pub junctions: [usize; 2],
    /// Number of zero eigenvalues.
    pub k: [usize; 2],
    /// Reported confidence; `None` of an answer that has none.
    pub confidence: [Option<f64>; 2],
    /// Whether the counts are equal and all walls are paired, with an overlap of at least [`SAME_WALL_IOU`].
    pub same_walls: bool,
    /// Returns by either answer.
    pub returns: usize,
    /// Returns with the same label, under the best matching of the walls.
    pub same_returns: usize,
    /// The openings, with those of the first answer as truth.
    pub openings: OpeningsScore,
    /// The ways on of either answer, and how many both have: as many as possible within 20°; `None` unless both count ways.
    pub ways: Option<([usize; 2], usize)>,
}

impl Agreement {
    /// Compares `second` with `first`.
    ///
    /// # Errors
    /// If the answers are for different revolutions or have labels for different numbers of beams.
    pub fn of(first: &ResultsLine, second: &ResultsLine) -> Result<Self, ScoreError> {
        if first.seq != second.seq {
            return Err(ScoreError::Revolutions { first: first.seq, second: second.seq });
        }
        if first.labels.len() != second.labels.len() {
            return Err(ScoreError::Beams { seq: first.seq, truth: first.labels.len(), reported: second.labels.len() });
        }
        let table = Contingency::of(&first.labels, &second.labels);
        let openings_of_first: Vec<_> =
            first.openings.iter().map(|o| TruthOpening { bearing_rad: o.bearing_rad, width_m: o.width_m }).collect();
        Ok(Self {
            seq: first.seq,
            stamp_ns: first.stamp_ns,
            junctions: [first.junctions, second.junctions],
            k: [first.k, second.k],
            confidence: [first.confidence, second.confidence],
            same_walls: first.junctions == second.junctions && same_walls(&table, first, second) == first.junctions,
            returns: table.beams,
            same_returns: table.beams_right(),
            openings: openings::score(&openings_of_first, &second.openings),
            ways: first.ways.as_ref().zip(second.ways.as_ref()).map(|(a, b)| ([a.len(), b.len()], same_ways(a, b))),
        })
    }
}

impl Agreement {
    /// Whether the walls are the same, and the ways on where both answers count these.
    pub fn is_same(&self) -> bool {
        self.same_walls && self.ways.is_none_or(|(ways, both)| ways == [both; 2])
    }
}

/// Number of ways that both answers have.
fn same_ways(first: &[WayLine], second: &[WayLine]) -> usize {
    let cos = |a: &WayLine, b: &WayLine| a.direction.iter().zip(b.direction).map(|(a, b)| a * b).sum::<f64>();
    let is_same = |a: usize, b: usize| cos(&first[a], &second[b]) >= SAME_WAY_RAD.cos();
    let weight = |a, b| if is_same(a, b) { 1.0 } else { 0.0 };
    best_matching(first.len(), second.len(), weight).into_iter().filter(|(a, b)| is_same(*a, *b)).count()
}

/// Number of walls, without islands, that both answers have.
fn same_walls(table: &Contingency, first: &ResultsLine, second: &ResultsLine) -> usize {
    let pairs = table.overlapping(SAME_WALL_IOU);
    pairs
        .filter(|&(a, b)| !is_island(first, table.true_walls[a]) && !is_island(second, table.reported_walls[b]))
        .count()
}

//! One revolution: two answers for the same scan against each other.

use crosscut_messages::TruthOpening;
use crosscut_report::ResultsLine;

use crate::contingency::Contingency;
use crate::openings::{self, OpeningsScore};
use crate::score::is_island;
use crate::{SAME_WALL_IOU, ScoreError};

/// How far two answers for the same scan agree. Pairs are of the first and the second answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement {
    /// The revolution.
    pub seq: u64,
    /// The sensor's stamp.
    pub stamp_ns: u64,
    /// Walls that were counted, islands left out.
    pub junctions: [usize; 2],
    /// What the eigenvalues said.
    pub k: [usize; 2],
    /// How sure each answer said it is.
    pub confidence: [f64; 2],
    /// The counts are equal and the walls pair up, each two of them the same by [`SAME_WALL_IOU`].
    pub same_walls: bool,
    /// Returns, by either answer.
    pub returns: usize,
    /// Those labelled alike under the best matching of the walls.
    pub returns_alike: usize,
    /// The openings, the first answer's in the place of the true ones.
    pub openings: OpeningsScore,
}

impl Agreement {
    /// Compares `second` with `first`.
    ///
    /// # Errors
    /// When they are for different revolutions, or have labels for different numbers of beams.
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
            returns_alike: table.beams_right(),
            openings: openings::score(&openings_of_first, &second.openings),
        })
    }
}

/// How many walls, islands left out, both answers have.
fn same_walls(table: &Contingency, first: &ResultsLine, second: &ResultsLine) -> usize {
    let pairs = table.overlapping(SAME_WALL_IOU);
    pairs
        .filter(|&(a, b)| !is_island(first, table.true_walls[a]) && !is_island(second, table.reported_walls[b]))
        .count()
}

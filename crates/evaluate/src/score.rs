//! One revolution: the reported line against the truth.

use crosscut_messages::Truth;
use crosscut_report::ResultsLine;

use crate::contingency::Contingency;
use crate::openings::{self, OpeningsScore};

/// A reported wall is the true one if they overlap at least so much (intersection over union of their returns).
pub const SAME_WALL_IOU: f64 = 0.8;

/// How good the answer for one revolution is.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// True number of walls, islands left out.
    pub true_walls: usize,
    /// Reported number of junctions, islands left out.
    pub reported_walls: usize,
    /// The count is equal and every true wall is matched.
    pub right: bool,
    /// Returns whose label is compared.
    pub returns: usize,
    /// Those that are labelled right under the best matching.
    pub returns_right: usize,
    /// Adjusted Rand index over the returns of true walls; `None` below two walls.
    pub adjusted_rand_index: Option<f64>,
    /// The openings.
    pub openings: OpeningsScore,
    /// How sure the answer said it is.
    pub confidence: f64,
}

/// Why an answer cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ScoreError {
    /// Truth (or another answer) and answer are not of the same scan.
    #[error("revolution {seq}: {truth} labels against {reported}; they are not of the same scan")]
    Beams {
        /// The revolution.
        seq: u64,
        /// Labels in the truth.
        truth: usize,
        /// Labels in the result.
        reported: usize,
    },
    /// Two answers are for different scans.
    #[error("an answer for revolution {first} against one for revolution {second}; they are not of the same scan")]
    Revolutions {
        /// The revolution of the first answer.
        first: u64,
        /// That of the second.
        second: u64,
    },
}

impl Score {
    /// Compares the answer `line` with the `truth` of the same scan.
    ///
    /// # Errors
    /// When they have labels for different numbers of beams.
    pub fn of(truth: &Truth, line: &ResultsLine) -> Result<Self, ScoreError> {
        if truth.labels.len() != line.labels.len() {
            let (truth, reported) = (truth.labels.len(), line.labels.len());
            return Err(ScoreError::Beams { seq: line.seq, truth, reported });
        }
        let table = Contingency::of(&truth.labels, &line.labels);
        let true_walls = truth.walls as usize;
        let two_walls = true_walls >= 2 && table.true_walls.len() >= 2;
        Ok(Self {
            true_walls,
            reported_walls: line.junctions,
            right: line.junctions == true_walls && matched_walls(&table, line) == true_walls,
            returns: table.beams,
            returns_right: table.beams_right(),
            adjusted_rand_index: two_walls.then(|| table.adjusted_rand_index()),
            openings: openings::score(&truth.openings, &line.openings),
            confidence: line.confidence,
        })
    }

    /// The count is equal.
    pub fn right_count(&self) -> bool {
        self.true_walls == self.reported_walls
    }
}

/// Reported walls, islands left out, that are the same as a true one.
fn matched_walls(table: &Contingency, line: &ResultsLine) -> usize {
    table.overlapping(SAME_WALL_IOU).filter(|&(_, b)| !is_island(line, table.reported_walls[b])).count()
}

/// Whether the wall of this label was reported as an island.
pub(crate) fn is_island(line: &ResultsLine, label: i32) -> bool {
    line.walls.iter().any(|wall| wall.island && wall.id.cast_signed() == label)
}

//! The score of one revolution against its truth.

use crosscut_messages::Truth;
use crosscut_report::ResultsLine;
use crosscut_stage::KnownGaps;

use crate::contingency::Contingency;
use crate::openings::{self, OpeningsScore};

/// Two walls are the same if the intersection over union of their returns is at least this.
pub const SAME_WALL_IOU: f64 = 0.8;

/// The comparison of the answer for one revolution with the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// True number of walls, without islands.
    pub true_walls: usize,
    /// Reported number of walls, without islands.
    pub reported_walls: usize,
    /// Whether the count is equal and every true wall is matched.
    pub right: bool,
    /// Number of returns whose label is compared.
    pub returns: usize,
    /// Number of those with the right label, under the best matching of walls.
    pub returns_right: usize,
    /// Adjusted Rand index over the returns of true walls; `None` below two walls.
    pub adjusted_rand_index: Option<f64>,
    /// Comparison of the openings.
    pub openings: OpeningsScore,
    /// How the gaps of the answer are known.
    pub gaps: KnownGaps,
    /// Reported confidence; `None` if the answer has none.
    pub confidence: Option<f64>,
}

/// The reason that an answer cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ScoreError {
    /// Truth (or first answer) and answer have different numbers of beams, so they belong to different scans.
    #[error("revolution {seq}: {truth} labels against {reported}; they are not of the same scan")]
    Beams {
        /// The revolution.
        seq: u64,
        /// Labels in the truth.
        truth: usize,
        /// Labels in the result.
        reported: usize,
    },
    /// The two answers are for different revolutions.
    #[error("an answer for revolution {first} against one for revolution {second}; they are not of the same scan")]
    Revolutions {
        /// The revolution of the first answer.
        first: u64,
        /// The revolution of the second answer.
        second: u64,
    },
}

impl Score {
    /// Compares the answer `line` with the `truth` of the same scan.
    ///
    /// # Errors
    /// If truth and answer have labels for different numbers of beams.
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
            gaps: line.gaps,
            confidence: line.confidence,
        })
    }

    /// Whether the count is equal.
    pub fn right_count(&self) -> bool {
        self.true_walls == self.reported_walls
    }
}

/// Number of reported walls, without islands, that are the same as a true one.
fn matched_walls(table: &Contingency, line: &ResultsLine) -> usize {
    table.overlapping(SAME_WALL_IOU).filter(|&(_, b)| !is_island(line, table.reported_walls[b])).count()
}

/// Whether the wall of this label was reported as an island.
pub(crate) fn is_island(line: &ResultsLine, label: i32) -> bool {
    line.walls.iter().any(|of| of.wall.island && of.wall.id.cast_signed() == label)
}

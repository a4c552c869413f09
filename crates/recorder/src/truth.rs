//! The true number of walls, where the flight has a truth.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use rerun::{RecordingStream, RecordingStreamResult, Scalars, TextDocument};

use crate::colors::{TRUTH, series};
use crate::rows::Rows;
use crate::schema::{TRUTH_JSON, TRUTH_WALLS};

/// The true counts of the revolutions that the recorder has not seen yet. Clones share them: whoever reads the truth of the
/// flight tells it before the frame is observed.
#[derive(Clone, Debug, Default)]
pub struct TrueWalls(Arc<Mutex<BTreeMap<u64, (usize, String)>>>);

impl TrueWalls {
    /// Tells that revolution `seq` has this many walls, and its truth as JSON.
    pub fn tell(&self, seq: u64, walls: usize, json: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(seq, (walls, json));
    }

    /// The true count of revolution `seq` and its truth; those before it are forgotten.
    pub(crate) fn of(&self, seq: u64) -> Option<(usize, String)> {
        let mut told = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *told = told.split_off(&seq);
        told.get(&seq).cloned()
    }
}

/// A count that stays is written again at each multiple of this.
const AGAIN_EVERY: u64 = 10;

/// Name and colour of the line over time.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    rec.log_static(TRUTH_WALLS.path, &series("truth", TRUTH, 1.0))
}

/// The truth of revolution `seq`, if it is known, and its count if it differs from the one `before` or is due again.
pub(crate) fn log(rows: &mut Rows, seq: u64, truth: Option<&(usize, String)>, before: &mut Option<usize>) {
    let Some((walls, json)) = truth else { return };
    if before.replace(*walls) != Some(*walls) || seq.is_multiple_of(AGAIN_EVERY) {
        rows.log(&TRUTH_WALLS, &Scalars::single(*walls as f64));
    }
    rows.log(&TRUTH_JSON, &TextDocument::new(json.as_str()));
}

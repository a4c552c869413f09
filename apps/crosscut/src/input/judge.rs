//! The answers of a flight compared with their truths.

use std::path::Path;

use crosscut_evaluate::Score;
use crosscut_messages::{Truth, TruthError};
use crosscut_report::ResultsLine;
use crosscut_stage::{Frame, counted};

/// The truth of a revolution, if the flight has it.
pub(crate) type TruthAt = Result<Option<Truth>, TruthError>;

/// A truth, and how well an answer agrees with it.
pub(crate) struct Judged {
    pub(crate) truth: Truth,
    pub(crate) score: Score,
}

impl Judged {
    /// The truth as a recording holds it.
    pub(crate) fn json(&self) -> String {
        String::from_utf8(self.truth.to_json()).unwrap_or_default()
    }
}

/// Compares answers with truths, and counts those that cannot be compared.
#[derive(Default)]
pub(crate) struct Judge {
    without_truth: u64,
    /// The number of others, and the reason of the first.
    others: Option<(u64, String)>,
}

impl Judge {
    /// The truth of this revolution, unless it cannot be read or there is none.
    pub(crate) fn truth(&mut self, truth: TruthAt, seq: u64) -> Option<Truth> {
        match truth {
            Ok(Some(truth)) => return Some(truth),
            Ok(None) => self.without_truth += 1,
            Err(error) => self.cannot(format!("revolution {seq}: {error}")),
        }
        None
    }

    pub(crate) fn judged(&mut self, truth: TruthAt, frame: &Frame) -> Option<Judged> {
        let truth = self.truth(truth, frame.revolution.seq)?;
        match Score::of(&truth, &ResultsLine::of(frame)) {
            Ok(score) => return Some(Judged { truth, score }),
            Err(error) => self.cannot(error.to_string()),
        }
        None
    }

    /// Counts a revolution whose answer cannot be compared with its truth.
    pub(crate) fn cannot(&mut self, reason: String) {
        self.others.get_or_insert((0, reason)).0 += 1;
    }

    pub(crate) fn messages(self, path: &Path) -> Vec<String> {
        let path = path.display();
        let scans = |count| counted(count, "scan");
        let none = (self.without_truth > 0)
            .then(|| format!("no truth has the log time of {}, in {path}", scans(self.without_truth)));
        let others = self.others.map(|(count, first)| {
            format!("{} cannot be compared with the truth, the first: {first}, in {path}", scans(count))
        });
        none.into_iter().chain(others).collect()
    }
}

//! Wrong answers: a list of all, and drawings of the first, each beside the truth.

use std::path::{Path, PathBuf};

use anyhow::Context;
use crosscut_evaluate::Score;
use crosscut_messages::Truth;
use crosscut_stage::{Frame, counted};

use crosscut_evaluate::panel::{Panel, sheet};

/// The first scenes up to this number are drawn of one recording.
const MOST_SCENES: usize = 8;
/// Panels in a row of the drawing: two scenes, each with truth and answer.
const COLUMNS: usize = 4;

/// Header of the list.
const COLUMN_NAMES: &str = "seq,stamp_ns,true_walls,junctions,k,confidence,place";

/// The scenes of one recording that one configuration answers wrong.
#[derive(Default)]
pub(super) struct Wrong {
    panels: Vec<Panel>,
    first_seq: Option<u64>,
    /// One row of [`COLUMN_NAMES`] for each scene.
    rows: Vec<String>,
}

impl Wrong {
    /// Adds a scene if its answer is wrong.
    pub(super) fn take(&mut self, frame: &Frame, truth: &Truth, score: &Score) {
        if score.right {
            return;
        }
        let Frame { revolution, spectrum, junction, .. } = frame;
        self.first_seq = self.first_seq.or(Some(revolution.seq));
        self.rows.push(format!(
            "{},{},{},{},{},{},{}",
            revolution.seq,
            revolution.stamp_ns,
            score.true_walls,
            junction.junctions,
            spectrum.k,
            junction.confidence.map(|confidence| format!("{confidence:.3}")).unwrap_or_default(),
            junction.place
        ));
        if self.panels.len() >= 2 * MOST_SCENES {
            return;
        }
        let name = format!("scene {}: {}", revolution.seq, counted(score.true_walls as u64, "wall"));
        let answer =
            if score.right_count() { "other walls".to_owned() } else { counted(score.reported_walls as u64, "wall") };
        self.panels.push(Panel::of_truth(name, revolution, truth));
        self.panels.push(Panel::of_answer(format!("answer: {answer}"), frame));
    }

    /// The first wrong answer.
    pub(super) fn first_seq(&self) -> Option<u64> {
        self.first_seq
    }

    /// Number of wrong answers.
    pub(super) fn count(&self) -> usize {
        self.rows.len()
    }

    /// Writes `FAMILY-CONFIGURATION.svg` with the first wrong answers and `.csv` with all of them into the folder;
    /// nothing if there are none.
    pub(super) fn write(&self, folder: &Path, family: &str, configuration: &str) -> anyhow::Result<()> {
        if self.rows.is_empty() {
            return Ok(());
        }
        let list = format!("{COLUMN_NAMES}\n{}\n", self.rows.join("\n"));
        for (path, text) in paths(folder, family, configuration).into_iter().zip([sheet(&self.panels, COLUMNS), list]) {
            crosscut_outfile::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        }
        Ok(())
    }
}

/// The drawing and the list of a recording and a configuration.
pub(super) fn paths(folder: &Path, family: &str, configuration: &str) -> [PathBuf; 2] {
    let name = format!("{family}-{}", configuration.replace(['/', '\\'], "_"));
    ["svg", "csv"].map(|extension| folder.join(format!("{name}.{extension}")))
}

//! What is answered wrong, drawn: the truth, and beside it the answer.

use std::path::{Path, PathBuf};

use anyhow::Context;
use crosscut_evaluate::Score;
use crosscut_messages::Truth;
use crosscut_stage::{Frame, counted};

use crate::figure::{Panel, sheet};

/// So many scenes are drawn of one recording, the first.
const MOST_SCENES: usize = 8;
/// Two scenes in a row.
const COLUMNS: usize = 4;

/// The scenes of one recording that one configuration has wrong.
#[derive(Default)]
pub(crate) struct Wrong {
    panels: Vec<Panel>,
}

impl Wrong {
    /// Takes in a scene, if it is wrong and not one too many.
    pub(crate) fn take(&mut self, frame: &Frame, truth: &Truth, score: &Score) {
        if score.right || self.panels.len() >= 2 * MOST_SCENES {
            return;
        }
        let name = format!("scene {}: {}", frame.revolution.seq, counted(score.true_walls as u64, "wall"));
        let answer =
            if score.right_count() { "other walls".to_owned() } else { counted(score.reported_walls as u64, "wall") };
        self.panels.push(Panel::of_truth(name, &frame.revolution, truth));
        self.panels.push(Panel::of_answer(format!("answer: {answer}"), frame));
    }

    /// Writes `FAMILY-CONFIGURATION.svg` into the folder; nothing if all is right.
    pub(crate) fn write(&self, folder: &Path, family: &str, configuration: &str) -> anyhow::Result<()> {
        if self.panels.is_empty() {
            return Ok(());
        }
        let path: PathBuf = folder.join(format!("{family}-{}.svg", configuration.replace(['/', '\\'], "_")));
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
        std::fs::write(&path, sheet(&self.panels, COLUMNS)).with_context(|| format!("cannot write {}", path.display()))
    }
}

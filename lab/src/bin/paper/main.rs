//! Repeats the evaluation of the paper on simulated scenes: figures, tables, and a page `paper.md` that shows them. The
//! same program always writes the same bytes.
//!
//! `lab/run paper DIR [SCENES]`: SCENES of each family in the tables (600).

mod answers;
mod document;
mod figures;
mod tolerance;

use std::path::{Path, PathBuf};

use anyhow::Context;
use crosscut_detector::{Config, Preset, Registry};
use crosscut_simulator::SCENES;
use crosscut_spectral::ZERO_TOLERANCE;

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args().skip(1);
    let folder = args.next().map(PathBuf::from).context("name a folder to write to")?;
    let scenes = args.next().map_or(Ok(SCENES), |scenes| scenes.parse()).context("SCENES is a whole number")?;
    let registry = Registry::standard();
    let tolerance_of_preset = Config::preset(Preset::Paper, &registry)?.params("spectral").get(ZERO_TOLERANCE);
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let figures = figures::figures()?;
    for figure in &figures {
        write(&folder.join(figure.file()), &figure.svg())?;
    }
    let families = tolerance::families(scenes, &registry)?;
    write(&folder.join("paper.md"), &document::document(&figures, &families, tolerance_of_preset))
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

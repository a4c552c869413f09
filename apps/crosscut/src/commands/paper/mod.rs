//! `crosscut paper`: repeats the evaluation of the paper on simulated scenes.

mod answers;
mod document;
mod figures;
mod tolerance;

use std::path::Path;

use anyhow::Context;
use crosscut_pipeline::{Config, Preset, Registry, StopFlag, ZERO_TOLERANCE};
use crosscut_simulator::suites;

use crate::cli::PaperArgs;
use crate::exit::Outcome;
use crate::interrupt::stop_on_interrupt;
use crate::progress;
use crate::say::say;

/// Writes the figures, the tables, and a page that shows them. The same program always writes the same bytes.
pub(crate) fn paper(args: &PaperArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let tolerance_of_preset = Config::preset(Preset::Paper, registry)?.params("spectral").get(ZERO_TOLERANCE);
    let stop = StopFlag::default();
    stop_on_interrupt(stop.clone())?;
    std::fs::create_dir_all(&args.out).with_context(|| format!("cannot make the folder {}", args.out.display()))?;
    let figures = figures::figures(registry)?;
    for figure in &figures {
        write(&args.out.join(figure.file()), &figure.svg())?;
    }
    let bar = progress::bar(Some((args.scenes * suites().len()) as u64), args.quiet);
    let families = tolerance::families(args.scenes, registry, &stop, &bar)?;
    bar.finish_and_clear();
    let Some(families) = families else {
        say(format_args!(
            "interrupted: the figures are in {}; paper.md is not written because its tables need every scene",
            args.out.display()
        ));
        return Ok(Outcome::Interrupted);
    };
    write(&args.out.join("paper.md"), &document::document(&figures, &families, tolerance_of_preset))?;
    Ok(Outcome::Done)
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    crosscut_outfile::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

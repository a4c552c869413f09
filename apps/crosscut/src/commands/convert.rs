//! `crosscut convert`: any recording as an MCAP that other tools read.

use std::fs::File;
use std::io::BufWriter;

use anyhow::Context;
use crosscut_ingest::{CsvGeometry, ReadOptions, recordings_in};
use crosscut_pipeline::Registry;
use crosscut_stage::counted;

use crate::cli::ConvertArgs;
use crate::diagnostics::Diagnostics;
use crate::exit::Outcome;
use crate::say::say;
use crate::{config, outputs};

/// Writes the recording. What is at `--out` is replaced only when there is a whole recording to take its place.
pub(crate) fn convert(args: &ConvertArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let config = config::resolve(&args.config, registry)?;
    outputs::refuse(&[&args.out], &recordings_in(&args.input)?)?;
    let csv = CsvGeometry::new(config.params("csv"));
    let options = ReadOptions { topic: args.topic.clone(), csv, ..ReadOptions::default() };
    let unfinished = args.out.with_extension("mcap.unfinished");
    let cannot = || format!("cannot write {}", args.out.display());
    let file = BufWriter::new(File::create(&unfinished).with_context(cannot)?);
    let converted = match crosscut_ingest::convert(&args.input, &options, file) {
        Ok(converted) => converted,
        Err(error) => {
            std::fs::remove_file(&unfinished).ok(); // the first error says what is wrong
            return Err(error.into());
        }
    };
    std::fs::rename(&unfinished, &args.out).with_context(cannot)?;
    let written = converted.messages.iter().map(|(topic, count)| format!("{} on {topic}", counted(*count, "message")));
    say(format_args!("{}: {}", args.out.display(), written.collect::<Vec<_>>().join(", ")));
    let mut diagnostics = Diagnostics::default();
    for (topic, count) in &converted.undecodable {
        diagnostics.lost(format_args!("{} for {topic} cannot be decoded", counted(*count, "message")));
    }
    diagnostics.lost_all(&converted.losses);
    Ok(diagnostics.outcome())
}

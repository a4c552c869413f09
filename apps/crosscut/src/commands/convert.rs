//! `crosscut convert`: any recording as an MCAP that other tools read.

use std::path::Path;

use anyhow::Context;
use crosscut_detector::Registry;
use crosscut_outfile::{Keep, Whole};
use crosscut_stage::counted;

use crate::cli::convert::ConvertArgs;
use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError};
use crate::fly::{files_read, left_out_of_folders};
use crate::say::say;
use crate::{config, interrupt, outputs, progress};

/// Writes the recording. What is at `--out` is replaced only when there is a whole recording to take its place.
pub(crate) fn convert(args: &ConvertArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    if args.out == Path::new("-") {
        return Err(UsageError("convert writes to a file, not to standard output".to_owned()).into());
    }
    if args.input.topic.len() > 1 {
        return Err(UsageError("convert takes the scans of one topic".to_owned()).into());
    }
    let config = config::resolve("default", args.config.as_deref(), &[("--set", &args.set)], registry)?;
    let read = files_read(&args.input, args.config.clone())?;
    outputs::refuse(&[&args.out], &read)?;
    let options = args.input.read_options(&config);
    let echo = config.sensor().echo();
    let cannot = || format!("cannot write {}", args.out.display());
    let mut file = Whole::create(&args.out, Keep::ThroughKill).with_context(cannot)?;
    interrupt::quit_without(&file)?;
    let bar = progress::counter("messages", args.quiet);
    let converted = crosscut_ingest::convert(&args.input.recordings.input, &options, echo, &mut file, || bar.inc(1))?;
    bar.finish_and_clear();
    file.finish().with_context(cannot)?;
    let written = converted.messages.iter().map(|(topic, count)| format!("{} on {topic}", counted(*count, "message")));
    if !args.quiet {
        say(format_args!("{}: {}", args.out.display(), written.collect::<Vec<_>>().join(", ")));
    }
    let mut diagnostics = Diagnostics::default();
    for (topic, count) in &converted.undecodable {
        diagnostics.lost(format_args!("{} for {topic} cannot be decoded", counted(*count, "message")));
    }
    diagnostics.lost_all(&converted.losses);
    left_out_of_folders(&converted.left_out).iter().for_each(|note| diagnostics.note(note));
    Ok(diagnostics.outcome())
}

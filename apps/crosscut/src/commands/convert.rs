//! `crosscut convert`: any recording as an MCAP that other tools read.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser as _};
use crosscut_detector::Registry;
use crosscut_outfile::{Keep, Whole};
use crosscut_stage::counted;

use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError};
use crate::input::{CONFIGURATION, InputArgs, config, files_read, left_out_of_folders};
use crate::interrupt;
use crate::output::{files, progress, say};
use crate::values::has_extension;

#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    #[command(flatten)]
    input: InputArgs,
    /// MCAP file for the scans (/scan) or clouds (/points), odometry (/odom) and transforms (/tf).
    #[arg(short, long, value_name = "FLIGHT.mcap", value_parser = PathBufValueParser::new().try_map(converted_path))]
    out: PathBuf,
    /// File of settings, of which those of the section csv and ingest.echo count.
    #[arg(long, value_name = "FILE.toml|FLIGHT.rrd", help_heading = CONFIGURATION)]
    config: Option<PathBuf>,
    /// Single setting that overrides the file: ingest.echo=VALUE or csv.KEY=VALUE. May be repeated.
    #[arg(long, value_name = "SECTION.KEY=VALUE", value_parser = setting_of_conversion, help_heading = CONFIGURATION)]
    set: Vec<String>,
    /// Show no progress and no summary.
    #[arg(short, long)]
    quiet: bool,
}

/// Endings of recordings that are no MCAP.
const OTHER_FORMATS: [&str; 7] = ["rrd", "bag", "db3", "clf", "csv", "pcd", "ply"];

fn converted_path(path: PathBuf) -> Result<PathBuf, &'static str> {
    if OTHER_FORMATS.iter().any(|format| has_extension(&path, format)) {
        return Err("convert writes MCAP: FLIGHT.mcap");
    }
    Ok(path)
}

fn setting_of_conversion(setting: &str) -> Result<String, &'static str> {
    let key = setting.split('=').next().unwrap_or_default().trim();
    if key.starts_with("csv.") || key == "ingest.echo" {
        Ok(setting.to_owned())
    } else {
        Err("only csv.KEY and ingest.echo have an effect: scans are converted as they were recorded")
    }
}

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
    files::refuse(&[&args.out], &read)?;
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

//! `crosscut run`: a recorded flight through all stages.

use std::path::{Path, PathBuf};
use std::time::Duration;

use crosscut_detector::Registry;
use crosscut_pipeline::{End, StopFlag};
use crosscut_stage::counted;

use crate::cli::RunArgs;
use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError, is_closed_pipe};
use crate::fly::{Flight, Flown, How, files_read, fly};
use crate::interrupt::stop_on_interrupt;
use crate::say::{say, show};
use crate::written::Written;
use crate::{observers, outputs, progress, summary};

/// Runs the flight. The results of a revolution are written before any observer sees it; in an MCAP they are on disk
/// within a second of the flight.
pub(crate) fn run(args: &RunArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let config = args.config.resolve(registry)?;
    let read = files_read(&args.input, args.config.config.clone())?;
    refuse_overwriting(args, &read)?;
    let stop = stop_on_interrupt()?; // before any file is opened, so that none is left half written
    let mut flight = if args.follow {
        Flight::follow(&args.input, &config, stop.clone())?
    } else {
        Flight::open(&args.input.recordings.input, &args.input, &config)?
    };
    let mut diagnostics = Diagnostics::default();
    let mut written = Written::open(args.results.as_deref(), args.map.as_deref(), &config, &read, &mut diagnostics)?;
    let mut observers = observers::open(args, &config, &mut diagnostics)?;
    if diagnostics.outcome() != Outcome::Done && written.is_nothing() && observers.list.is_empty() {
        anyhow::bail!("no other output was requested");
    }

    let bar = progress::bar(if args.follow { None } else { flight.total_revolutions() }, args.quiet);
    let how = How { registry, stop: &stop, bar: &bar, rate: args.rate, has_poses: true };
    let flown = fly(flight, &config, &how, &mut observers.list, &mut |frame, _| written.take(frame))?;
    bar.finish_and_clear();
    if !args.quiet {
        say(summary::words(&flown));
        if !flown.is_empty() {
            say(format_args!("{}\n", written.map_summary()));
        }
    }
    if let Err(error) = written.finish(&flown, &mut diagnostics) {
        flown.report_lost(&error, &mut diagnostics);
    }
    flown.report(None, &mut diagnostics);
    if !flown.is_empty() && observers.recorded_nothing() {
        diagnostics.note("the recording is empty: no revolution lies within --record-revolutions or --record-seconds");
    }
    note_closed_pipe(&flown, args, &mut diagnostics);
    if args.follow && stop.is_set() {
        diagnostics.interrupt(); // the recording ended because of that
    }
    if !args.quiet && args.results.as_deref() != Some(Path::new("-")) {
        show(summary::tables(&flown.summary))?;
    }
    if observers.served {
        serve_until_interrupt(&stop);
    }
    Ok(diagnostics.outcome())
}

/// Refuses outputs that would replace an input or each other.
fn refuse_overwriting(args: &RunArgs, read: &[PathBuf]) -> Result<(), UsageError> {
    let written = args.record.save.iter().chain(&args.results).chain(&args.map);
    let written: Vec<&Path> = written.map(PathBuf::as_path).collect();
    outputs::refuse(&written, read)?;
    match &args.record.save {
        Some(save) => outputs::refuse_parts(save, read.iter().map(PathBuf::as_path).chain(written)),
        None => Ok(()),
    }
}

/// Notes that a recording is shorter because nobody reads the results any more.
fn note_closed_pipe(flown: &Flown, args: &RunArgs, diagnostics: &mut Diagnostics) {
    let is_closed = matches!(&flown.summary.end, End::ResultsLost(error) if is_closed_pipe(error));
    if is_closed && args.record.save.is_some() {
        let done = counted(flown.summary.revolutions, "revolution");
        diagnostics.note(format_args!("the reader of the results closed the pipe; the run ended after {done}"));
    }
}

/// Keeps the recording available to viewers until Ctrl-C.
fn serve_until_interrupt(stop: &StopFlag) {
    if !stop.is_set() {
        say("the run is over and still served; Ctrl-C ends it");
    }
    while !stop.is_set() {
        std::thread::sleep(Duration::from_millis(100));
    }
}

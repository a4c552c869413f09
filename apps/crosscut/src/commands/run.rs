//! `crosscut run`: a recorded flight through all stages.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context;
use crosscut_detector::Registry;
use crosscut_ingest::{Recording, recordings_in};
use crosscut_pipeline::{End, StopFlag, StreamOptions, Summary, stream};
use crosscut_stage::{Failure, FailureCause, Frame, Step, counted};

use crate::cli::RunArgs;
use crate::diagnostics::{Diagnostics, NO_RETURN};
use crate::exit::{Outcome, UsageError, is_closed_pipe};
use crate::interrupt::stop_on_interrupt;
use crate::observers::{self, Observers};
use crate::say::say;
use crate::written::Written;
use crate::{config, flight, outputs, progress, summary};

/// Runs the flight. The results of a revolution are written before any observer sees it; in an MCAP they are on disk
/// within a second of the flight.
pub(crate) fn run(args: &RunArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let config = config::resolve(&args.config, registry)?;
    let mut read = recordings_in(&args.flight.input)?;
    read.extend(args.config.config.clone());
    refuse_overwriting(args, &read)?;
    let stop = StopFlag::default();
    stop_on_interrupt(stop.clone())?; // before any file is opened, so that none is left half written
    let mut recording = if args.follow {
        flight::follow(&args.flight, &config, stop.clone())?
    } else {
        flight::open(&args.flight, &config)?
    };
    let mut diagnostics = Diagnostics::default();
    let mut written = Written::open(args, &config, &read, &mut diagnostics)?;
    let mut observers = observers::open(args, &config, &mut diagnostics)?;
    if diagnostics.outcome() != Outcome::Done && written.is_nothing() && observers.list.is_empty() {
        anyhow::bail!("no other output was requested");
    }

    let start = Instant::now();
    let total = if args.follow { None } else { recording.total_revolutions() };
    let bar = progress::bar(total, args.quiet);
    let mut sink = |frame: &Frame| {
        bar.inc(1);
        written.take(frame)
    };
    let options = StreamOptions { rate: args.rate, stop: stop.clone(), flight: true };
    let ran = stream(&mut recording, &config, registry, &mut sink, &mut observers.list, &options);
    bar.finish_and_clear();
    let summary = ran.context("a thread could not be started")?;
    if !args.quiet {
        say(summary::text(&summary, start.elapsed()).trim_end());
        say(format_args!("\n{}", written.map_summary()));
    }

    if let Err(error) = written.finish(&mut diagnostics) {
        report_lost_results(&error, &summary, args, &mut diagnostics);
    }
    diagnostics.lost_all(recording.losses());
    diagnostics.lost_all(&summary.observer_errors);
    note_left_out(&recording, &mut diagnostics);
    if summary.revolutions > 0 {
        note_empty_outputs(written.returns(), &observers, &mut diagnostics);
    }
    report_end(&summary, args, &mut diagnostics);
    if args.follow && stop.is_set() {
        diagnostics.interrupt(); // the recording ended because of that
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

/// Notes which scans of the inputs the run passed over.
fn note_left_out(recording: &Recording, diagnostics: &mut Diagnostics) {
    if recording.of_other_frames() > 0 {
        let scans = counted(recording.of_other_frames(), "scan");
        diagnostics.note(format_args!("left out {scans} whose frame is not ingest.frame_id"));
    }
    for part in recording.without_topic() {
        diagnostics.note(format_args!("there are no scans on {} in {}", recording.topic(), part.display()));
    }
}

/// Notes what is empty although every revolution was processed.
fn note_empty_outputs(returns: usize, observers: &Observers, diagnostics: &mut Diagnostics) {
    if returns == 0 {
        diagnostics.note(NO_RETURN);
    }
    if observers.recorded_nothing() {
        diagnostics.note("the recording is empty: no revolution lies within --record-revolutions or --record-seconds");
    }
}

/// Reports why the run ended, unless it reached the end of the input.
fn report_end(summary: &Summary, args: &RunArgs, diagnostics: &mut Diagnostics) {
    let done = counted(summary.revolutions, "revolution");
    match &summary.end {
        // No revolution is at fault: the reader's error states the place.
        End::Failed(Failure { step: Step::Ingest, cause: FailureCause::Error(cause), .. })
            if summary.revolutions == 0 =>
        {
            diagnostics.error(cause);
        }
        End::Failed(failure) => diagnostics.error(format_args!("{failure}; saved before it: {done}")),
        End::ResultsLost(error) => report_lost_results(error, summary, args, diagnostics),
        End::Interrupted => diagnostics.interrupt(),
        End::Complete if summary.revolutions == 0 => diagnostics.error("no scan could be read"),
        End::Complete => {}
    }
}

/// Reports that the results are not complete. A reader of them that closed the pipe wants no more.
fn report_lost_results(error: &io::Error, summary: &Summary, args: &RunArgs, diagnostics: &mut Diagnostics) {
    let done = counted(summary.revolutions, "revolution");
    if !is_closed_pipe(error) {
        diagnostics.error(format_args!("the results cannot be written after {done}: {error}"));
        return;
    }
    diagnostics.interrupt();
    if args.record.save.is_some() {
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

//! `crosscut run`: a recorded flight through all stages.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context;
use crosscut_ingest::recordings_in;
use crosscut_pipeline::{End, Registry, StopFlag, StreamOptions, Summary, stream};
use crosscut_report::ResultsLine;
use crosscut_stage::{Frame, counted};

use crate::cli::RunArgs;
use crate::exit::{Outcome, is_closed_pipe};
use crate::interrupt::stop_on_interrupt;
use crate::over_time::{self, OverTime};
use crate::say::say;
use crate::{config, flight, overwriting, progress, record, summary};

/// Runs the flight; results are on disk before anything else is done with a revolution.
pub(crate) fn run(args: &RunArgs) -> anyhow::Result<Outcome> {
    let registry = Registry::standard();
    let config = config::resolve(&args.config, &registry)?;
    let list = args.over_time.as_deref().map(over_time::list_beside);
    let outputs = args.record.save.iter().chain(&args.results).chain(&args.over_time).chain(&list);
    let outputs: Vec<&Path> = outputs.map(PathBuf::as_path).collect();
    let mut read = recordings_in(&args.flight.input)?;
    read.extend(args.config.config.clone());
    overwriting::refuse(&outputs, &read)?;
    if let Some(save) = &args.record.save {
        overwriting::refuse_parts(save, read.iter().map(PathBuf::as_path).chain(outputs))?;
    }
    let mut recording = flight::open(&args.flight, &config)?;
    let mut results = args.results.as_ref().map(|path| overwriting::create(path, &read)).transpose()?;
    let mut lost = Vec::new();
    let drawn = args.over_time.as_deref().filter(|svg| {
        let checked = overwriting::check_folder(svg);
        lost.extend(checked.as_ref().err().map(|error| format!("{error:#}")));
        checked.is_ok()
    });
    let mut over_time = drawn.map(|_| OverTime::new(config.params("vehicle").number("width_m")));
    let mut observers =
        record::observers(&args.record, &args.flight.input[0], &config, args.rate.is_some(), &mut lost)?;
    for loss in &lost {
        say(format_args!("lost: {loss}")); // now, when the flight can still be begun anew
    }
    let said = lost.len();

    let stop = StopFlag::default();
    stop_on_interrupt(stop.clone())?;
    let stopped = stop.clone();
    let bar = progress::bar(recording.total_messages(), args.quiet);
    let start = Instant::now();
    let mut returns = 0;
    let mut sink = |frame: &Frame| {
        returns += frame.revolution.len();
        if let Some(out) = &mut results {
            let mut line = Vec::new();
            ResultsLine::of(frame).write(&mut line)?;
            out.write_all(&line)?;
            out.flush()?;
        }
        if let Some(over_time) = &mut over_time {
            over_time.take(frame);
        }
        bar.inc(1);
        Ok(())
    };
    let options = StreamOptions { rate: args.rate, stop };
    let ran = stream(&mut recording, &config, &registry, &mut sink, &mut observers.list, &options);
    bar.finish_and_clear();
    let summary = ran.context("a thread could not be started")?;

    if !args.quiet {
        say(summary::table(&summary, start.elapsed()).trim_end());
    }
    if let (Some(over_time), Some(svg)) = (&over_time, drawn)
        && summary.revolutions > 0
        && let Err(error) = over_time.write(svg)
    {
        lost.push(format!("{error:#}"));
    }
    lost.extend(recording.losses().iter().map(ToString::to_string));
    lost.extend(summary.observer_errors.iter().cloned());
    for loss in &lost[said..] {
        say(format_args!("lost: {loss}"));
    }
    if summary.revolutions > 0 && returns == 0 {
        say("note: no scan has a return that can be used; the notes of the results say why");
    }
    if recording.of_other_frames() > 0 {
        let scans = counted(recording.of_other_frames(), "scan");
        say(format_args!("note: {scans} of another frame than ingest.frame_id left out"));
    }
    if summary.revolutions > 0 && observers.recorded_nothing() {
        say("note: nothing is recorded: no revolution lies within --record-revolutions or --record-seconds");
    }
    let outcome = outcome(&summary, !lost.is_empty());
    if observers.served && !stopped.is_set() {
        say("the flight is over and still served; Ctrl-C ends it");
        while !stopped.is_set() {
            std::thread::sleep(Duration::from_millis(100));
        }
    }
    Ok(outcome)
}

/// Says what went wrong, and what the exit code is.
fn outcome(summary: &Summary, something_lost: bool) -> Outcome {
    let made = counted(summary.revolutions, "revolution");
    match &summary.end {
        End::Failed(failure) => {
            say(format_args!("error: {failure}; saved before it: {made}"));
            Outcome::Failed
        }
        End::ResultsLost(error) if is_closed_pipe(error) => Outcome::Interrupted,
        End::ResultsLost(error) => {
            say(format_args!("error: results cannot be written after {made}: {error}"));
            Outcome::Failed
        }
        End::Interrupted => Outcome::Interrupted,
        End::Complete if summary.revolutions == 0 => {
            say("error: no scan could be read");
            Outcome::Failed
        }
        End::Complete if something_lost => Outcome::SomethingLost,
        End::Complete => Outcome::Done,
    }
}

//! `crosscut run`: a recorded flight through all stages.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context;
use crosscut_ingest::recordings_in;
use crosscut_pipeline::{Config, End, Registry, StopFlag, StreamOptions, Summary, stream};
use crosscut_report::ResultsLine;
use crosscut_stage::{Failure, FailureCause, Frame, Step, counted};

use crate::cli::RunArgs;
use crate::exit::{Outcome, UsageError, is_closed_pipe};
use crate::interrupt::stop_on_interrupt;
use crate::observers::{self, Observers};
use crate::over_time::{self, OverTime};
use crate::say::{NO_RETURN, say};
use crate::{config, flight, outputs, progress, summary};

/// Runs the flight; results are on disk before anything else is done with a revolution.
pub(crate) fn run(args: &RunArgs) -> anyhow::Result<Outcome> {
    let registry = Registry::standard();
    let config = config::resolve(&args.config, &registry)?;
    let mut read = recordings_in(&args.flight.input)?;
    read.extend(args.config.config.clone());
    refuse_overwriting(args, &read)?;
    let stop = StopFlag::default();
    stop_on_interrupt(stop.clone())?; // before there is a file that it would leave half made
    let mut recording = flight::open(&args.flight, &config)?;
    let mut lost = Vec::new();
    let mut written = Written::open(args, &config, &read, &mut lost)?;
    let mut observers =
        observers::observers(&args.record, &args.flight.input[0], &config, args.rate.is_some(), &mut lost)?;
    if !lost.is_empty() && written.is_nothing() && observers.list.is_empty() {
        anyhow::bail!("{}; nothing else was asked for", lost.join("; "));
    }
    for loss in &lost {
        say(format_args!("lost: {loss}")); // now, when the flight can still be begun anew
    }
    let said = lost.len();

    let bar = progress::bar(recording.total_messages(), args.quiet);
    let start = Instant::now();
    let mut sink = |frame: &Frame| {
        bar.inc(1);
        written.take(frame)
    };
    let options = StreamOptions { rate: args.rate, stop: stop.clone() };
    let ran = stream(&mut recording, &config, &registry, &mut sink, &mut observers.list, &options);
    bar.finish_and_clear();
    let summary = ran.context("a thread could not be started")?;

    if !args.quiet {
        say(summary::table(&summary, start.elapsed()).trim_end());
    }
    lost.extend(written.finish(recording.starts_at_s().unwrap_or(0.0)).err().map(|error| format!("{error:#}")));
    lost.extend(recording.losses().iter().map(ToString::to_string));
    lost.extend(summary.observer_errors.iter().cloned());
    for loss in &lost[said..] {
        say(format_args!("lost: {loss}"));
    }
    if summary.revolutions > 0 {
        say_what_is_missing(written.returns, &observers);
    }
    if recording.of_other_frames() > 0 {
        let scans = counted(recording.of_other_frames(), "scan");
        say(format_args!("note: {scans} of another frame than ingest.frame_id left out"));
    }
    for part in recording.without_topic() {
        say(format_args!("note: there are no scans on {} in {}", recording.topic(), part.display()));
    }
    if let End::ResultsLost(error) = &summary.end
        && is_closed_pipe(error)
        && (args.record.save.is_some() || args.over_time.is_some())
    {
        let made = counted(summary.revolutions, "revolution");
        say(format_args!("note: nobody reads the results any more, so the flight ended after {made}"));
    }
    let outcome = outcome(&summary, !lost.is_empty());
    if observers.served && !stop.is_set() {
        say("the flight is over and still served; Ctrl-C ends it");
        while !stop.is_set() {
            std::thread::sleep(Duration::from_millis(100));
        }
    }
    Ok(outcome)
}

/// Refuses outputs that would replace what is read, or each other.
fn refuse_overwriting(args: &RunArgs, read: &[PathBuf]) -> Result<(), UsageError> {
    let list = args.over_time.as_deref().map(over_time::list_beside);
    let written = args.record.save.iter().chain(&args.results).chain(&args.over_time).chain(&list);
    let written: Vec<&Path> = written.map(PathBuf::as_path).collect();
    outputs::refuse(&written, read)?;
    match &args.record.save {
        Some(save) => outputs::refuse_parts(save, read.iter().map(PathBuf::as_path).chain(written)),
        None => Ok(()),
    }
}

/// What is written of each revolution, on the report thread.
struct Written {
    results: Option<Box<dyn Write + Send>>,
    over_time: Option<OverTime>,
    /// Of all revolutions.
    returns: usize,
}

impl Written {
    /// Opens the files. Of a flight over time that cannot be written `lost` says why; without results there is no run.
    fn open(args: &RunArgs, config: &Config, read: &[PathBuf], lost: &mut Vec<String>) -> anyhow::Result<Self> {
        let results = args.results.as_ref().map(|path| outputs::create(path, read)).transpose()?;
        let vehicle_width_m = config.params("vehicle").get(crosscut_report::VEHICLE_WIDTH_M);
        let over_time = args.over_time.as_ref().map(|svg| OverTime::create(svg, read, vehicle_width_m)).transpose();
        lost.extend(over_time.as_ref().err().map(|error| format!("{error:#}")));
        Ok(Self { results, over_time: over_time.unwrap_or_default(), returns: 0 })
    }

    fn is_nothing(&self) -> bool {
        self.results.is_none() && self.over_time.is_none()
    }

    fn take(&mut self, frame: &Frame) -> io::Result<()> {
        self.returns += frame.revolution.len();
        if let Some(out) = &mut self.results {
            let mut line = Vec::new();
            ResultsLine::of(frame).write(&mut line)?;
            out.write_all(&line)?;
            out.flush()?;
        }
        if let Some(over_time) = &mut self.over_time {
            over_time.take(frame);
        }
        Ok(())
    }

    fn finish(&mut self, starts_at_s: f64) -> anyhow::Result<()> {
        self.over_time.as_mut().map_or(Ok(()), |over_time| over_time.write(starts_at_s))
    }
}

/// What is not there although every revolution was worked on.
fn say_what_is_missing(returns: usize, observers: &Observers) {
    if returns == 0 {
        say(NO_RETURN);
    }
    if observers.recorded_nothing() {
        say("note: nothing is recorded: no revolution lies within --record-revolutions or --record-seconds");
    }
}

/// Says what went wrong, and what the exit code is.
fn outcome(summary: &Summary, something_lost: bool) -> Outcome {
    let made = counted(summary.revolutions, "revolution");
    match &summary.end {
        // The source knows where it came to; there is no revolution yet that could be blamed.
        End::Failed(Failure { step: Step::Ingest, cause: FailureCause::Error(cause), .. })
            if summary.revolutions == 0 =>
        {
            say(format_args!("error: {cause}"));
            Outcome::Failed
        }
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

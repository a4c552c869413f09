//! `crosscut compare`: what a stage or a setting changes on a flight, without a truth.

mod shown;

use std::io::{self, Write};
use std::iter::Peekable;
use std::path::Path;
use std::thread::{Builder, ScopedJoinHandle};

use anyhow::Context;
use crossbeam_channel::{IntoIter, bounded};
use crosscut_evaluate::{Agreement, Differences};
use crosscut_ingest::{Recording, recordings_in};
use crosscut_pipeline::{End, Registry, StopFlag, StreamOptions, Summary, stream};
use crosscut_report::ResultsLine;
use crosscut_stage::{Frame, counted};
use indicatif::ProgressBar;

use crate::cli::CompareArgs;
use crate::configurations::{self, Configuration};
use crate::exit::{Outcome, UsageError};
use crate::interrupt::stop_on_interrupt;
use crate::say::{NO_RETURN, say};
use crate::{flight, outputs, progress, typeset};

/// Answers that a configuration may be ahead of the slowest.
const AHEAD: usize = 64;

/// What a configuration answers, by ascending `seq`; `None` when the flight is over. A channel that closes before that
/// is of one that stopped early.
type Answers = Peekable<IntoIter<Option<ResultsLine>>>;

/// What came of it.
struct Compared {
    /// Of every configuration but the first, against the first.
    differences: Vec<Differences>,
    /// Of every configuration.
    summaries: Vec<Summary>,
    /// Of the first scan that was compared.
    first_stamp_ns: u64,
    /// Whether any scan has one.
    any_return: bool,
}

/// Runs every configuration over the flight at the same time, and compares the answers scan by scan.
pub(crate) fn compare(args: &CompareArgs) -> anyhow::Result<Outcome> {
    let registry = Registry::standard();
    let configurations = configurations::named(&args.with, &args.set, &registry)?;
    if configurations.len() < 2 {
        let usage = "--with names one configuration; name the other as well: --with default --with paper";
        return Err(UsageError(usage.to_owned()).into());
    }
    let recordings = configurations.iter().map(|of| flight::open(&args.flight, &of.config));
    let mut recordings = recordings.collect::<anyhow::Result<Vec<_>>>()?;
    let mut read = recordings_in(&args.flight.input)?;
    read.extend(configurations::files(&args.with));
    let mut json = args.json.as_ref().map(|path| outputs::create(path, &read)).transpose()?;
    let stop = StopFlag::default();
    stop_on_interrupt(stop.clone())?;

    let bar = progress::bar(recordings[0].total_messages(), args.quiet);
    let compared = side_by_side(&configurations, &mut recordings, &registry, &stop, &bar)?;
    bar.finish_and_clear();

    let (problems, outcome) = problems(&configurations, &recordings, &compared.summaries);
    for problem in &problems {
        say(problem);
    }
    if !compared.any_return && compared.summaries.iter().any(|summary| summary.revolutions > 0) {
        say(NO_RETURN);
    }
    let failed = "the outcome cannot be written";
    if let Some(out) = &mut json {
        let document = shown::json(&configurations, &compared, &problems);
        out.write_all(document.as_bytes()).context(failed)?;
    }
    if !args.quiet && args.json.as_deref() != Some(Path::new("-")) {
        // A setting may leave out the scans that another begins with (`ingest.frame_id`).
        let starts_at_s = recordings.iter().filter_map(Recording::starts_at_s).reduce(f64::min).unwrap_or(0.0);
        let tables = shown::tables(&configurations, &compared, starts_at_s, args.all);
        io::stdout().write_all(typeset::text(&tables).as_bytes()).context(failed)?;
    }
    Ok(outcome)
}

/// Each configuration streams the flight on its own; answers for the same scan meet here. Where one stops, all do.
fn side_by_side(
    configurations: &[Configuration],
    recordings: &mut [Recording],
    registry: &Registry,
    stop: &StopFlag,
    bar: &ProgressBar,
) -> anyhow::Result<Compared> {
    std::thread::scope(|scope| {
        let (mut answers, mut streams) = (Vec::new(), Vec::new());
        for (Configuration { name, config }, recording) in configurations.iter().zip(recordings) {
            let (answer, of_configuration) = bounded(AHEAD);
            let options = StreamOptions { rate: None, stop: stop.clone() };
            let run = move || {
                let mut results = |frame: &Frame| answer.send(Some(ResultsLine::of(frame))).map_err(io::Error::other);
                let summary = stream(recording, config, registry, &mut results, &mut [], &options)?;
                if matches!(summary.end, End::Complete) {
                    answer.send(None).ok(); // nobody waits for it where another one stopped
                }
                Ok(summary)
            };
            streams.push(Builder::new().name(format!("compare {name}")).spawn_scoped(scope, run)?);
            answers.push(of_configuration.into_iter().peekable());
        }
        let (differences, first_stamp_ns, any_return) = meet(answers, bar)?;
        let joined = |stream: ScopedJoinHandle<'_, io::Result<Summary>>| stream.join().expect("streams catch panics");
        let summaries = streams.into_iter().map(joined).collect::<io::Result<_>>();
        let summaries = summaries.context("a thread could not be started")?;
        Ok(Compared { differences, summaries, first_stamp_ns, any_return })
    })
}

/// The differences of every configuration from the first, the stamp of the first scan, and whether any has a return.
///
/// A setting may leave scans out (`ingest.frame_id`), so answers meet by `seq`.
fn meet(mut answers: Vec<Answers>, bar: &ProgressBar) -> anyhow::Result<(Vec<Differences>, u64, bool)> {
    let mut differences = vec![Differences::default(); answers.len() - 1];
    let (mut first_stamp_ns, mut any_return) = (None, false);
    while let Some(seq) = next_seq(&mut answers) {
        let is_next = |answer: &Option<ResultsLine>| answer.as_ref().is_some_and(|line| line.seq == seq);
        let lines: Vec<_> = answers.iter_mut().map(|of| of.next_if(is_next).flatten()).collect();
        first_stamp_ns = first_stamp_ns.or_else(|| lines.iter().flatten().map(|line| line.stamp_ns).next());
        any_return |= lines.iter().flatten().any(|line| line.returns > 0);
        let (first, others) = lines.split_first().expect("there are two configurations at least");
        for (other, differences) in others.iter().zip(&mut differences) {
            match (first, other) {
                (Some(first), Some(other)) => differences.add(&Agreement::of(first, other)?),
                (Some(_), None) => differences.answered_by_one[0] += 1,
                (None, Some(_)) => differences.answered_by_one[1] += 1,
                (None, None) => {}
            }
        }
        bar.inc(1);
    }
    Ok((differences, first_stamp_ns.unwrap_or(0), any_return))
}

/// The next revolution that any of them answered; none if the flight is over, or one of them stopped early.
fn next_seq(answers: &mut [Answers]) -> Option<u64> {
    let next = answers.iter_mut().map(|of| Some(of.peek()?.as_ref().map(|line| line.seq)));
    next.collect::<Option<Vec<_>>>()?.into_iter().flatten().min()
}

/// What went wrong, and how the command ends for it.
fn problems(
    configurations: &[Configuration],
    recordings: &[Recording],
    summaries: &[Summary],
) -> (Vec<String>, Outcome) {
    let mut problems: Vec<_> = recordings[0].losses().iter().map(|loss| format!("lost: {loss}")).collect();
    let mut outcome = if problems.is_empty() { Outcome::Done } else { Outcome::SomethingLost };
    let reordered = recordings[0].reordered();
    if reordered > 0 {
        let scans = counted(reordered, "scan");
        problems.push(format!(
            "note: time goes back at {scans}; times mean little if these are not the parts of one flight, in order"
        ));
    }
    if summaries.iter().any(|summary| matches!(summary.end, End::Interrupted)) {
        outcome = Outcome::Interrupted;
        problems.push("interrupted: the figures are of the revolutions before that".to_owned());
    }
    for (Configuration { name, .. }, summary) in configurations.iter().zip(summaries) {
        if let End::Failed(failure) = &summary.end {
            problems.push(format!("error: {name}: {failure}; the revolutions before it are compared"));
            outcome = Outcome::Failed;
        }
    }
    if matches!(outcome, Outcome::Failed | Outcome::Interrupted) {
        return (problems, outcome); // the others were told to stop by `ResultsLost`
    }
    for (Configuration { name, .. }, summary) in configurations.iter().zip(summaries) {
        if let End::ResultsLost(error) = &summary.end {
            problems.push(format!("error: {name}: its answers cannot be compared: {error}"));
            outcome = Outcome::Failed;
        }
    }
    if summaries.iter().all(|summary| summary.revolutions == 0) {
        problems.push("error: no scan could be read".to_owned());
        outcome = Outcome::Failed;
    }
    (problems, outcome)
}

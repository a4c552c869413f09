//! `crosscut compare`: the effect of a stage or setting on a flight, without truth.

mod shown;

use std::io::{self, Write};
use std::iter::Peekable;
use std::path::Path;
use std::thread::{Builder, ScopedJoinHandle};

use anyhow::Context;
use crossbeam_channel::{IntoIter, bounded};
use crosscut_detector::Registry;
use crosscut_evaluate::{Agreement, Differences};
use crosscut_ingest::{Recording, recordings_in};
use crosscut_pipeline::{End, StopFlag, StreamOptions, Summary, stream};
use crosscut_report::ResultsLine;
use crosscut_stage::{Frame, counted};
use indicatif::ProgressBar;

use crate::cli::CompareArgs;
use crate::configurations::{self, Configuration};
use crate::diagnostics::{Diagnostics, NO_RETURN};
use crate::exit::{Outcome, UsageError};
use crate::interrupt::stop_on_interrupt;
use crate::{flight, outputs, progress, typeset};

/// A configuration may be this many answers ahead of the slowest.
const AHEAD: usize = 64;

/// The answers of a configuration by ascending `seq`, then `None` at the end of the flight. The channel closes without
/// `None` if the configuration stopped early.
type Answers = Peekable<IntoIter<Option<ResultsLine>>>;

/// The outcome of a comparison.
struct Compared {
    /// Differences of every configuration but the first from the first.
    differences: Vec<Differences>,
    /// Summaries of every configuration.
    summaries: Vec<Summary>,
    /// Stamp of the first scan that was compared.
    first_stamp_ns: u64,
    /// Whether any scan has a return.
    any_return: bool,
}

/// Runs every configuration over the flight at the same time, and compares the answers scan by scan.
pub(crate) fn compare(args: &CompareArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let configurations = configurations::named(&args.with, &args.set, registry)?;
    if configurations.len() < 2 {
        let usage = "compare needs at least two configurations: --with default --with paper";
        return Err(UsageError(usage.to_owned()).into());
    }
    let recordings = configurations.iter().map(|of| flight::open(&args.flight, &of.config));
    let mut recordings = recordings.collect::<anyhow::Result<Vec<_>>>()?;
    let mut read = recordings_in(&args.flight.input)?;
    read.extend(configurations::files(&args.with));
    let mut json = args.json.as_ref().map(|path| outputs::create(path, &read)).transpose()?;
    let stop = StopFlag::default();
    stop_on_interrupt(stop.clone())?;

    let bar = progress::bar(recordings[0].total_revolutions(), args.quiet);
    let compared = side_by_side(&configurations, &mut recordings, registry, &stop, &bar)?;
    bar.finish_and_clear();

    let mut diagnostics = Diagnostics::default();
    report(&configurations, &recordings[0], &compared, &mut diagnostics);
    let failed = "the comparison cannot be written";
    if let Some(out) = &mut json {
        let document = shown::json(&configurations, &compared, diagnostics.problems());
        out.write_all(document.as_bytes()).context(failed)?;
    }
    if !args.quiet && args.json.as_deref() != Some(Path::new("-")) {
        // Configurations may begin with different scans (`ingest.frame_id`).
        let starts_at_s = recordings.iter().filter_map(Recording::starts_at_s).reduce(f64::min).unwrap_or(0.0);
        let tables = shown::tables(&configurations, &compared, starts_at_s, args.all);
        io::stdout().write_all(typeset::text(&tables).as_bytes()).context(failed)?;
    }
    Ok(diagnostics.outcome())
}

/// Streams the flight through every configuration in threads of their own, and compares answers to the same scan. Where
/// one configuration stops, all stop.
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
            let (answer, answers_of_one) = bounded(AHEAD);
            let options = StreamOptions { stop: stop.clone(), ..StreamOptions::default() };
            let run = move || {
                let mut results = |frame: &Frame| answer.send(Some(ResultsLine::of(frame))).map_err(io::Error::other);
                let summary = stream(recording, config, registry, &mut results, &mut [], &options)?;
                if matches!(summary.end, End::Complete) {
                    answer.send(None).ok(); // the receiver is gone if another configuration stopped
                }
                Ok(summary)
            };
            streams.push(Builder::new().name(format!("compare {name}")).spawn_scoped(scope, run)?);
            answers.push(answers_of_one.into_iter().peekable());
        }
        let (differences, first_stamp_ns, any_return) = pair(answers, bar)?;
        let joined = |stream: ScopedJoinHandle<'_, io::Result<Summary>>| stream.join().expect("streams catch panics");
        let summaries = streams.into_iter().map(joined).collect::<io::Result<_>>();
        let summaries = summaries.context("a thread could not be started")?;
        Ok(Compared { differences, summaries, first_stamp_ns, any_return })
    })
}

/// Returns the differences of every configuration from the first, the stamp of the first scan, and whether any scan has
/// a return. Answers are paired by `seq`, because a setting may leave out scans (`ingest.frame_id`).
fn pair(mut answers: Vec<Answers>, bar: &ProgressBar) -> anyhow::Result<(Vec<Differences>, u64, bool)> {
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

/// The next revolution that any configuration answered; `None` at the end of the flight, or if one stopped early.
fn next_seq(answers: &mut [Answers]) -> Option<u64> {
    let next = answers.iter_mut().map(|of| Some(of.peek()?.as_ref().map(|line| line.seq)));
    next.collect::<Option<Vec<_>>>()?.into_iter().flatten().min()
}

/// Reports what is missing from the comparison, and why it ended early. Every configuration reads the same recording.
fn report(configurations: &[Configuration], recording: &Recording, compared: &Compared, diagnostics: &mut Diagnostics) {
    let named = || configurations.iter().map(|of| &of.name).zip(&compared.summaries);
    diagnostics.lost_all(recording.losses());
    if recording.reordered() > 0 {
        let scans = counted(recording.reordered(), "scan");
        diagnostics.note(format_args!(
            "time goes back at {scans}; times mean little if these are not the parts of one flight, in order"
        ));
    }
    if named().any(|(_, summary)| matches!(summary.end, End::Interrupted)) {
        diagnostics.interrupted("by Ctrl-C: the figures cover the revolutions before that");
    }
    for (name, summary) in named() {
        if let End::Failed(failure) = &summary.end {
            diagnostics.error(format_args!("{name}: {failure}; the revolutions before it are compared"));
        }
    }
    // Where one configuration stops, the others end with `ResultsLost`: that is no failure of theirs.
    if !diagnostics.ended_early() {
        for (name, summary) in named() {
            if let End::ResultsLost(error) = &summary.end {
                diagnostics.error(format_args!("{name}: its answers cannot be compared: {error}"));
            }
        }
        if named().all(|(_, summary)| summary.revolutions == 0) {
            diagnostics.error("no scan could be read");
        }
    }
    if !compared.any_return && named().any(|(_, summary)| summary.revolutions > 0) {
        diagnostics.note(NO_RETURN);
    }
}

//! `crosscut compare`: the effect of a stage or setting on a flight, without truth.

mod golden;
mod shown;

use std::io;
use std::iter::Peekable;
use std::path::Path;
use std::thread::{Builder, ScopedJoinHandle};

use anyhow::Context;
use crossbeam_channel::{IntoIter, bounded};
use crosscut_detector::Registry;
use crosscut_evaluate::experiment::{self, Experiment};
use crosscut_evaluate::times::Stopwatch;
use crosscut_evaluate::verdict::Surer;
use crosscut_evaluate::{Agreement, Differences};
use crosscut_outfile::Keep;
use crosscut_pipeline::{End, StopFlag};
use crosscut_report::{CONFIDENCE, ResultsLine};
use crosscut_stage::Timings;
use indicatif::ProgressBar;

use crate::cli::CompareArgs;
use crate::configurations::{self, Configuration};
use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError};
use crate::fly::{Flight, Flown, How, files_read, fly};
use crate::interrupt::stop_on_interrupt;
use crate::looking::{Look, Looks};
use crate::outputs::Document;
use crate::say::show;
use crate::{looking, progress, typeset};

/// A configuration may be this many answers ahead of the slowest.
const AHEAD: usize = 64;

/// An answer, whether it is right by the truth, if there is one, and what it took.
struct Judged {
    line: ResultsLine,
    is_right: Option<bool>,
    timings: Timings,
}

/// The answers of a configuration by ascending `seq`, then `None` at the end of the flight. The channel closes without
/// `None` if the configuration stopped early.
type Answers = Peekable<IntoIter<Option<Judged>>>;

/// The outcome of a comparison.
struct Compared {
    /// Differences of every configuration but the first from the first.
    differences: Vec<Differences>,
    /// Which of the two is surer where they differ, for the same configurations.
    surer: Vec<Surer>,
    /// What they mend and break against the truth, if there is one.
    outcomes: Vec<experiment::Outcome>,
    /// What each revolution took.
    stopwatch: Stopwatch,
    /// The flight by every configuration.
    flown: Vec<Flown>,
    /// Stamp of the first scan that was compared.
    first_stamp_ns: u64,
}

/// Runs every configuration over the flight at the same time, and compares the answers scan by scan.
pub(crate) fn compare(args: &CompareArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    if let Some(folder) = &args.golden {
        return golden::compare(args, folder, registry);
    }
    let configurations = configurations::named(&args.with, &args.set, registry)?;
    if configurations.len() < 2 {
        let usage = "compare needs at least two configurations: --with default --with paper";
        return Err(UsageError(usage.to_owned()).into());
    }
    let stop = stop_on_interrupt()?; // before any recording is looked through
    let read = files_read(&args.input, configurations::files(&args.with))?;
    let input = &args.input.recordings.input;
    let flights = configurations.iter().map(|of| Flight::open_with_truths(input, &args.input, &of.config));
    let mut flights = flights.collect::<anyhow::Result<Vec<_>>>()?;
    let mut json = args.json.as_ref().map(|path| Document::create(path, &read, Keep::ThroughKill)).transpose()?;

    let bar = progress::bar(flights[0].total_revolutions(), args.quiet);
    let compared = side_by_side(&configurations, flights, registry, &stop, &bar)?;
    bar.finish_and_clear();

    let mut diagnostics = Diagnostics::default();
    report(&configurations, &compared, &mut diagnostics);
    let options = configurations::run_options(&args.input, &args.with, &args.set);
    let looks = Looks { flights: input, options };
    let wrong = looks.wrong_answers(&compared.outcomes);
    if let Some(out) = &mut json {
        let document = shown::json(&configurations, &compared, &wrong, diagnostics.problems());
        out.write(&document)?;
    }
    if !args.quiet && args.json.as_deref() != Some(Path::new("-")) {
        let hint = looks.hint(&compared.outcomes, (!args.all).then_some("--all"));
        let sentences = shown::sentences(&configurations, &compared, hint);
        let mut tables = shown::tables(&configurations, &compared, args.all);
        tables.extend(looking::table(&wrong).filter(|_| args.all));
        let to_look = to_look(&looks, &configurations, &compared);
        show(format_args!("{sentences}\n{}{to_look}", typeset::text(&tables)))?;
    }
    Ok(diagnostics.outcome())
}

/// The commands that show the first stretch where the first two configurations differ.
fn to_look(looks: &Looks<'_>, configurations: &[Configuration], compared: &Compared) -> String {
    let stretches = compared.differences.first().map(|of| &of.stretches[..]).unwrap_or_default();
    let Some(first) = stretches.first() else { return String::new() };
    let [a, b] = [("A", 0), ("B", 1)].map(|(name, place)| Look::of(looks.flights, &looks.options[place], name));
    let commands = [a.record.clone(), b.record.clone(), Some(a.beside(&b, first.seq[0]))];
    let commands: Vec<String> = commands.into_iter().flatten().map(|command| format!("  {command}\n")).collect();
    let [of_a, of_b] = [0, 1].map(|place| &configurations[place].name);
    let other = if stretches.len() > 1 { "; --at takes any other" } else { "" };
    let from = first.seq[0];
    format!("\nto see where {of_a} and {of_b} differ, from revolution {from} on{other}:\n{}", commands.concat())
}

/// Streams the flight through every configuration in threads of their own, and compares answers to the same scan. Where
/// one configuration stops, all stop.
fn side_by_side(
    configurations: &[Configuration],
    flights: Vec<Flight>,
    registry: &Registry,
    stop: &StopFlag,
    bar: &ProgressBar,
) -> anyhow::Result<Compared> {
    let no_bar = ProgressBar::hidden();
    let how = How { registry, stop, bar: &no_bar, rate: None, has_poses: false };
    std::thread::scope(|scope| {
        let (mut answers, mut streams) = (Vec::new(), Vec::new());
        for (Configuration { name, config }, flight) in configurations.iter().zip(flights) {
            let (answer, answers_of_one) = bounded(AHEAD);
            let run = move || {
                let flown = fly(flight, config, &how, &mut [], &mut |frame, judged| {
                    let is_right = judged.map(|judged| judged.score.right);
                    let (line, timings) = (ResultsLine::of(frame), frame.timings);
                    answer.send(Some(Judged { line, is_right, timings })).map_err(io::Error::other)
                })?;
                if matches!(flown.summary.end, End::Complete) {
                    answer.send(None).ok(); // the receiver is gone if another configuration stopped
                }
                Ok(flown)
            };
            let thread = Builder::new().name(format!("compare {name}"));
            streams.push(thread.spawn_scoped(scope, run).context("a thread could not be started")?);
            answers.push(answers_of_one.into_iter().peekable());
        }
        let paired = pair(configurations, answers, bar)?;
        let joined = |stream: ScopedJoinHandle<'_, anyhow::Result<Flown>>| stream.join().expect("streams catch panics");
        let flown = streams.into_iter().map(joined).collect::<anyhow::Result<_>>()?;
        let Paired { differences, surer, experiment, stopwatch, first_stamp_ns } = paired;
        Ok(Compared { differences, surer, outcomes: experiment.outcomes(), stopwatch, flown, first_stamp_ns })
    })
}

/// The answers of all configurations, scan by scan.
struct Paired {
    differences: Vec<Differences>,
    surer: Vec<Surer>,
    experiment: Experiment,
    stopwatch: Stopwatch,
    first_stamp_ns: u64,
}

/// Compares every configuration with the first. Answers are paired by `seq`, because a setting may leave out scans
/// (`ingest.frame_id`).
fn pair(configurations: &[Configuration], mut answers: Vec<Answers>, bar: &ProgressBar) -> anyhow::Result<Paired> {
    let mut differences = vec![Differences::default(); answers.len() - 1];
    let rule = |of: &Configuration| of.config.params("report").get(CONFIDENCE).to_owned();
    let rules: Vec<String> = configurations.iter().map(rule).collect();
    let mut surer: Vec<_> = rules[1..].iter().map(|other| Surer::by([&rules[0], other])).collect();
    let names: Vec<String> = configurations.iter().map(|of| of.name.clone()).collect();
    let (mut experiment, mut stopwatch) = (Experiment::new(names.clone()), Stopwatch::new(names));
    let mut first_stamp_ns = None;
    while let Some(seq) = next_seq(&mut answers) {
        let is_next = |answer: &Option<Judged>| answer.as_ref().is_some_and(|judged| judged.line.seq == seq);
        let judged: Vec<_> = answers.iter_mut().map(|of| of.next_if(is_next).flatten()).collect();
        for (place, judged) in judged.iter().enumerate() {
            if let Some(Judged { is_right, timings, .. }) = judged {
                is_right.iter().for_each(|is_right| experiment.add("", place, seq, *is_right));
                stopwatch.add(place, 0, seq, timings);
            }
        }
        let lines: Vec<_> = judged.into_iter().map(|judged| Some(judged?.line)).collect();
        first_stamp_ns = first_stamp_ns.or_else(|| lines.iter().flatten().map(|line| line.stamp_ns).next());
        let (first, others) = lines.split_first().expect("there are two configurations at least");
        for ((other, differences), surer) in others.iter().zip(&mut differences).zip(&mut surer) {
            match (first, other) {
                (Some(first), Some(other)) => {
                    let agreement = Agreement::of(first, other)?;
                    surer.add(!agreement.same_walls, agreement.confidence);
                    differences.add(&agreement);
                }
                (Some(_), None) => differences.answered_by_one[0] += 1,
                (None, Some(_)) => differences.answered_by_one[1] += 1,
                (None, None) => {}
            }
        }
        bar.inc(1);
    }
    Ok(Paired { differences, surer, experiment, stopwatch, first_stamp_ns: first_stamp_ns.unwrap_or(0) })
}

/// The next revolution that any configuration answered; `None` at the end of the flight, or if one stopped early.
fn next_seq(answers: &mut [Answers]) -> Option<u64> {
    let next = answers.iter_mut().map(|of| Some(of.peek()?.as_ref().map(|judged| judged.line.seq)));
    next.collect::<Option<Vec<_>>>()?.into_iter().flatten().min()
}

/// Reports what is missing from the comparison, and why it ended early.
fn report(configurations: &[Configuration], compared: &Compared, diagnostics: &mut Diagnostics) {
    let named = || configurations.iter().map(|of| &of.name).zip(&compared.flown);
    // Every configuration reads the same recording.
    named().for_each(|(_, flown)| flown.report_missing(diagnostics));
    // Where one configuration stops, the others end with `ResultsLost`: that is no failure of theirs.
    let is_lost = |flown: &Flown| matches!(flown.summary.end, End::ResultsLost(_));
    let any_stopped = named().any(|(_, flown)| matches!(flown.summary.end, End::Failed(_) | End::Interrupted));
    for (name, flown) in named().filter(|(_, flown)| !(any_stopped && is_lost(flown))) {
        // That nothing can be read is reported once.
        let whose = (!matches!(flown.summary.end, End::Complete)).then_some(name.as_str());
        flown.report_end(whose, diagnostics);
    }
}

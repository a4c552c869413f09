//! `crosscut run`: a flight, recorded or live, through all stages.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser as _};
use crosscut_detector::Registry;
use crosscut_ingest::Truths;
use crosscut_pipeline::{RunEnd, StopFlag};
use crosscut_stage::counted;

use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError, is_closed_pipe};
use crate::fly::{Flown, How, fly};
use crate::input::live::{self, Robots};
use crate::input::{Coming, ConfigArgs, Flight, InputArgs, LiveArgs, files_of};
use crate::interrupt::stop_on_interrupt;
use crate::output::maps::FORMATS;
use crate::output::record::RecordArgs;
use crate::output::robot::Answered;
use crate::output::{Written, files, observers, progress, say, show, summary};
use crate::values::{has_extension, positive};

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    live: LiveArgs,
    #[command(flatten)]
    config: ConfigArgs,
    /// Results, one JSON object per scan; `-` is standard output. FILE.mcap has the scans beside them, and drawings for
    /// Foxglove.
    #[arg(short, long, value_name = "FILE.jsonl|FILE.mcap", value_parser = PathBufValueParser::new().try_map(results_path))]
    out: Option<PathBuf>,
    /// Write the map of the flight, junctions, dead ends and the passages between them: .svg (a drawing), .json, .geojson
    /// (for Nav2) or .g2o (the visits as a pose graph).
    #[arg(long, value_name = "FILE.svg|json|geojson|g2o", value_parser = PathBufValueParser::new().try_map(map_path))]
    map: Option<PathBuf>,
    /// Play at this multiple of the recorded pace (1 = as recorded); pauses of more than 10 s are skipped.
    #[arg(long, value_name = "X", value_parser = positive, allow_negative_numbers = true, conflicts_with = "follow")]
    rate: Option<f64>,
    /// Show no progress bar and no summary.
    #[arg(short, long)]
    quiet: bool,
    /// To a live robot, send JSON to KEY/results and KEY/map, and a drawing for RViz and Foxglove to the topic KEY/markers.
    #[arg(long, value_name = "KEY")]
    publish: Option<String>,
    #[command(flatten)]
    record: RecordArgs,
}

fn map_path(path: PathBuf) -> Result<PathBuf, String> {
    if FORMATS.iter().any(|format| has_extension(&path, format)) {
        Ok(path)
    } else {
        Err(format!("the name of a map ends in one of .{}", FORMATS.join(", .")))
    }
}

/// Endings of other files, each with what makes one.
const NO_RESULTS: [(&[&str], &str); 4] = [
    (&["rrd"], "results are JSON lines or an MCAP; a recording for the viewer is --save FLIGHT.rrd"),
    (&["svg", "geojson", "g2o"], "results are JSON lines or an MCAP; a map is --map FLIGHT.svg"),
    (&["html"], "results are JSON lines or an MCAP; a page is made by `crosscut report`"),
    (&["csv", "npy", "bag", "db3"], "results are JSON lines, an object a scan, or an MCAP: FILE.jsonl, FILE.mcap"),
];

/// Refuses the endings of other files, which would say something else than what is in the file.
fn results_path(path: PathBuf) -> Result<PathBuf, &'static str> {
    let refusal = NO_RESULTS.iter().find(|(endings, _)| endings.iter().any(|ending| has_extension(&path, ending)));
    refusal.map_or(Ok(path), |(_, why)| Err(why))
}

/// Runs the flight. The results of a revolution are written before any observer sees it; in an MCAP they are on disk
/// within a second of the flight.
pub(crate) fn run(args: &RunArgs, registry: &Registry, robots: Option<&dyn Robots>) -> anyhow::Result<Outcome> {
    let config = args.config.resolve(registry)?;
    let robot = live::robot_of(&args.input, &args.live, args.publish.as_ref(), &config)?;
    if robot.is_some() && args.rate.is_some() {
        return Err(UsageError("a live robot is followed at its own pace; leave out --rate".to_owned()).into());
    }
    let read = files_of(&args.input, &args.live, robot.as_ref(), args.config.config.clone())?;
    refuse_overwriting(args, &read)?;
    let stop = stop_on_interrupt()?; // before any file is opened, so that none is left half written
    let coming = Coming::open(&args.input, &args.live, robot.as_ref(), &config, &stop, robots)?;
    let (mut flight, heard, silence) = match coming {
        Some(Coming { flight, robot, silence }) => (flight, robot, silence),
        None => (Flight::open(&args.input.recordings.input, &args.input, &config)?, None, live::Silence::new()),
    };
    let is_stream = flight.is_stream();
    let mut diagnostics = Diagnostics::default();
    let (out, map, is_paced) = (args.out.as_deref(), args.map.as_deref(), is_stream || args.rate.is_some());
    let mut written = Written::open(out, map, &config, &read, is_paced, &mut diagnostics)?;
    let of = observers::Source { input: &args.input, settings: &args.config, is_paced: args.rate.is_some() };
    let mut observers = observers::open(&args.record, &of, &config, &mut diagnostics)?;
    if let ([only], false, false) = (&args.input.recordings.input[..], observers.list.is_empty(), is_stream) {
        flight = flight.with_shown_truths(Truths::open(only).ok());
    }
    if diagnostics.outcome() != Outcome::Done && written.is_nothing() && observers.list.is_empty() {
        anyhow::bail!("no other output was requested");
    }
    let sends = args.publish.is_some();
    let mut robot_answered = heard.map(|robot| Answered::new(robot, sends, config.sensor()));
    let is_numbered = robot.as_ref().is_none_or(|robot| robot.address.starts_with("zenoh"));
    let mut gaps = (!is_numbered).then(live::Gaps::default);

    let bar = progress::bar(if is_stream { None } else { flight.total_revolutions() }, args.quiet);
    // What comes as it comes is not cut short: it ends once what was read is answered.
    let cut_short = if is_stream { StopFlag::default() } else { stop.clone() };
    let how = How { registry, stop: &cut_short, bar: &bar, rate: args.rate, has_poses: true };
    let truth = observers.truth.take();
    let flown = fly(flight, &config, &how, &mut observers.list, &mut |frame, judged| {
        silence.end();
        if let (Some(tell), Some(judged)) = (&truth, judged) {
            tell(frame.revolution.seq, judged.score.true_walls, judged.json());
        }
        if let Some(gaps) = &mut gaps {
            gaps.take(frame.revolution.stamp_ns);
        }
        written.take(frame)?;
        if let Some(robot) = &mut robot_answered {
            robot.take(frame, written.mapper());
        }
        Ok(())
    })?;
    bar.finish_and_clear();
    let is_map_alone = is_map_alone(args);
    if !args.quiet {
        if !is_map_alone {
            say(summary::words(&flown));
        }
        if !flown.is_empty() {
            say(format_args!("{}{}", written.map_summary(), if is_map_alone { "" } else { "\n" }));
        }
    }
    if let Err(error) = written.finish(&flown, is_map_alone, &mut diagnostics) {
        flown.report_lost(&error, &mut diagnostics);
    }
    gaps.and_then(|gaps| gaps.note()).iter().for_each(|note| diagnostics.note(note));
    if let Some(robot) = &mut robot_answered {
        robot.send_map(written.mapper());
        diagnostics.lost_all(robot.failure.as_ref().map(|why| format!("answers could not be sent: {why}")));
    }
    flown.report(None, &mut diagnostics);
    if !flown.is_empty() && observers.recorded_nothing() {
        diagnostics
            .note("the recording is empty: no revolution lies within recording.revolutions and recording.spans_s");
    }
    note_closed_pipe(&flown, args, &mut diagnostics);
    if is_stream && robot.is_none() && stop.is_set() {
        diagnostics.interrupt(); // the recording ended because of that; a robot is heard until then
    }
    if !args.quiet && !is_map_alone && args.out.as_deref() != Some(Path::new("-")) {
        show(summary::tables(&flown.summary, is_stream))?;
    }
    if observers.served {
        serve_until_interrupt(&stop);
    }
    Ok(diagnostics.outcome())
}

/// Whether the map is all that was asked for: the summary is that of the map.
fn is_map_alone(args: &RunArgs) -> bool {
    args.map.is_some() && args.out.is_none() && args.publish.is_none() && !args.record.is_asked()
}

/// Refuses outputs that would replace an input or each other.
fn refuse_overwriting(args: &RunArgs, read: &[PathBuf]) -> Result<(), UsageError> {
    let written = args.record.save.iter().chain(&args.out).chain(&args.map);
    let written: Vec<&Path> = written.map(PathBuf::as_path).collect();
    files::refuse(&written, read)?;
    match &args.record.save {
        Some(save) => files::refuse_parts(save, read.iter().map(PathBuf::as_path).chain(written)),
        None => Ok(()),
    }
}

/// Notes that a recording is shorter because nobody reads the results any more.
fn note_closed_pipe(flown: &Flown, args: &RunArgs, diagnostics: &mut Diagnostics) {
    let is_closed = matches!(&flown.summary.end, RunEnd::ResultsLost(error) if is_closed_pipe(error));
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

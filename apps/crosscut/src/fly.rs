//! A flight on its way through the program, as every command flies it: opened, streamed through the stages, compared with
//! its truth where it has one. What is missing and why it ended is reported in one way.

use std::collections::VecDeque;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::Context;
use crosscut_detector::{Config, Registry};
use crosscut_evaluate::Score;
use crosscut_flight::check_live;
use crosscut_ingest::{Following, LiveFeed, ReadOptions, Recording, Truths, parts_in, recordings_in};
use crosscut_messages::{Truth, TruthError};
use crosscut_pipeline::{End, StopFlag, StreamOptions, Summary, stream};
use crosscut_report::ResultsLine;
use crosscut_sensor::Sensor;
use crosscut_stage::{Failure, FailureCause, Frame, Notes, Observer, Revolution, Source, SourceError, Step, counted};
use indicatif::ProgressBar;

use crate::cli::InputArgs;
use crate::diagnostics::Diagnostics;
use crate::exit::{UsageError, is_closed_pipe};
use crate::live::{RobotAddress, refuse_live};
use crate::recorded::{self, Recorded};
use crate::related::refuse_unrelated;

/// The recordings that a command reads and its files of settings, which no output may replace.
pub(crate) fn files_read(
    args: &InputArgs,
    settings: impl IntoIterator<Item = PathBuf>,
) -> anyhow::Result<Vec<PathBuf>> {
    refuse_empty_span(args.from, args.to)?;
    refuse_live(args)?;
    Ok(recordings_in(&args.recordings.input)?.into_iter().chain(settings).collect())
}

/// The same for inputs that are read as they come, which need not be there yet.
pub(crate) fn files_to_come(
    args: &InputArgs,
    settings: impl IntoIterator<Item = PathBuf>,
) -> anyhow::Result<Vec<PathBuf>> {
    refuse_empty_span(args.from, args.to)?;
    Ok(recordings_in(&args.recordings.input).unwrap_or_default().into_iter().chain(settings).collect())
}

/// A flight that is open.
pub(crate) struct Flight {
    scans: Read,
    truths: Option<Truths>,
    /// What cannot be compared with the truths is a loss.
    is_judged: bool,
    /// The last part.
    path: PathBuf,
    /// What is left out of the folders that were named, in words.
    left_out: Vec<String>,
}

/// Where the scans come from.
enum Read {
    /// Files of a robot, or what it sends.
    Flown(Box<Recording>),
    /// A recording of this program.
    Recorded(Recorded),
}

/// The truth of a revolution, if the flight has it.
type TruthAt = Result<Option<Truth>, TruthError>;

impl Flight {
    /// Opens the `parts` of a flight, of which `args` select scans, with the sensor of `config`.
    pub(crate) fn open(parts: &[PathBuf], args: &InputArgs, config: &Config) -> anyhow::Result<Self> {
        if let Some(path) = recorded::only(parts)? {
            let recorded = Recorded::open(path, args, config)?;
            let is_judged = recorded.has_truth();
            let (scans, path) = (Read::Recorded(recorded), path.to_owned());
            return Ok(Self { scans, truths: None, is_judged, path, left_out: Vec::new() });
        }
        refuse_unrelated(parts, args, config)?;
        let recording = Recording::open(parts, &args.read_options(config), Sensor::new(config.params("ingest")))?;
        let flight = Self::flown(recording, parts.last().cloned().unwrap_or_default());
        Ok(Self { left_out: left_out_of_folders(parts), ..flight })
    }

    /// Opens a flight as `open` does, with the truth of its scans if it is one recording that holds it.
    pub(crate) fn open_with_truths(parts: &[PathBuf], args: &InputArgs, config: &Config) -> anyhow::Result<Self> {
        let flight = Self::open(parts, args, config)?;
        Ok(match parts {
            [only] if !flight.has_truths() => flight.with_truths(Truths::open(only).ok()),
            _ => flight,
        })
    }

    /// Opens what is read as it comes: files that are still being written, or appear one after the other. It ends at the latest
    /// when `following` is over.
    pub(crate) fn follow(args: &InputArgs, config: &Config, following: &Following) -> anyhow::Result<Self> {
        let inputs = &args.recordings.input;
        if inputs.iter().any(|input| input.as_os_str() == "-") {
            return Err(UsageError("--follow reads files; standard input is read as it comes anyway".to_owned()).into());
        }
        check_live(config.params("flight")).map_err(|error| UsageError(error.to_string()))?;
        let sensor = Sensor::new(config.params("ingest"));
        let recording = Recording::follow(inputs, &args.read_options(config), &sensor, following)?;
        Ok(Self::flown(recording, inputs.last().cloned().unwrap_or_default()))
    }

    /// Opens standard input, to be read as it comes if it is an MCAP.
    pub(crate) fn of_standard_input(args: &InputArgs, config: &Config, following: &Following) -> anyhow::Result<Self> {
        let sensor = Sensor::new(config.params("ingest"));
        let streamed = match check_live(config.params("flight")) {
            Ok(()) => Recording::of_standard_input(&args.read_options(config), &sensor, following)?,
            Err(_) => None, // later scans are known once all of it is there
        };
        match streamed {
            Some(recording) => Ok(Self::flown(recording, PathBuf::from("-"))),
            None => Self::open(&args.recordings.input, args, config),
        }
    }

    /// Opens what `messages` has of a live robot.
    pub(crate) fn of_robot(
        robot: &RobotAddress,
        messages: LiveFeed,
        args: &InputArgs,
        config: &Config,
        following: &Following,
    ) -> anyhow::Result<Self> {
        check_live(config.params("flight")).map_err(|error| UsageError(error.to_string()))?;
        let sensor = Sensor::new(config.params("ingest"));
        // The topic is named by the address; those of --topic are scanners beside it.
        let options = ReadOptions {
            topic: Some(robot.topic.clone()),
            beside: args.topic.clone(),
            read_as: None,
            ..args.read_options(config)
        };
        let recording = Recording::of_robot(&robot.address, messages, &options, &sensor, following)?;
        Ok(Self::flown(recording, PathBuf::from(&robot.address)))
    }

    fn flown(recording: Recording, path: PathBuf) -> Self {
        Self { scans: Read::Flown(Box::new(recording)), truths: None, is_judged: false, path, left_out: Vec::new() }
    }

    /// This flight with the truth of its scans for what is shown of it: what cannot be compared is no loss.
    pub(crate) fn with_shown_truths(self, truths: Option<Truths>) -> Self {
        Self { truths, is_judged: false, ..self }
    }

    /// This flight with the truth of its scans, which its recording holds.
    pub(crate) fn with_truths(self, truths: Option<Truths>) -> Self {
        Self { is_judged: truths.is_some(), truths, ..self }
    }

    /// Whether its scans are compared with their truths. Those of a recording of this program have them from the start.
    pub(crate) fn has_truths(&self) -> bool {
        self.is_judged
    }

    /// Whether its scans are clouds of points.
    #[cfg(feature = "rerun")]
    pub(crate) fn gives_clouds(&self) -> bool {
        matches!(&self.scans, Read::Flown(recording) if recording.gives_clouds())
    }

    /// Whether it is read as it comes.
    pub(crate) fn is_stream(&self) -> bool {
        matches!(&self.scans, Read::Flown(recording) if recording.is_stream())
    }

    /// How many revolutions there will be, if that is known.
    pub(crate) fn total_revolutions(&mut self) -> Option<u64> {
        match &mut self.scans {
            Read::Flown(recording) => recording.total_revolutions(),
            Read::Recorded(_) => None,
        }
    }

    /// Reads the next revolution and its truth; `None` at the end.
    pub(crate) fn next(&mut self, out: &mut Revolution, notes: &mut Notes) -> Result<Option<TruthAt>, SourceError> {
        Ok(match &mut self.scans {
            Read::Flown(recording) => {
                let more = recording.next(out, notes)?;
                let at_ns = recording.last_log_time_ns();
                more.then(|| self.truths.as_mut().map_or(Ok(None), |truths| truths.at(at_ns)))
            }
            Read::Recorded(recorded) => recorded.next(out, notes)?.then(|| recorded.truth()),
        })
    }

    /// What was lost of the flight, now that it is read; with what `judge` could not compare.
    pub(crate) fn losses(&self, judge: Judge) -> Vec<String> {
        let mut lost: Vec<String> = match &self.scans {
            Read::Flown(recording) => recording.losses().iter().map(ToString::to_string).collect(),
            Read::Recorded(recorded) => recorded.losses().to_vec(),
        };
        lost.extend(judge.messages(&self.path).into_iter().filter(|_| self.is_judged));
        lost
    }

    fn starts_at_s(&self) -> Option<f64> {
        match &self.scans {
            Read::Flown(recording) => recording.starts_at_s(),
            Read::Recorded(recorded) => recorded.starts_at_s(),
        }
    }

    /// The scans of the inputs that were passed over, and what is odd about their times.
    pub(crate) fn left_out(&self) -> Vec<String> {
        let Read::Flown(recording) = &self.scans else { return Vec::new() };
        let mut notes = self.left_out.clone();
        if recording.of_other_frames() > 0 {
            let scans = counted(recording.of_other_frames(), "scan");
            notes.push(format!("left out {scans} whose frame is not ingest.frame_id"));
        }
        for part in recording.without_topic() {
            notes.push(format!("there are no scans on {} in {}", recording.topic(), part.display()));
        }
        if recording.reordered() > 0 {
            let scans = counted(recording.reordered(), "scan");
            notes.push(format!(
                "time goes back at {scans}; times mean little if these are not the parts of one flight, in order"
            ));
        }
        notes
    }
}

/// What is left out of the folders among these inputs: recordings of other kinds, and those of this program.
fn left_out_of_folders(inputs: &[PathBuf]) -> Vec<String> {
    let others = parts_in(inputs).map(|parts| parts.left_out).unwrap_or_default();
    let note = |(left_out, of): (Vec<PathBuf>, &str)| {
        let recordings = counted(left_out.len() as u64, "recording");
        Some(format!("left out {recordings} of {of}; name one to run it: {}", left_out.first()?.display()))
    };
    [(recorded_in_folders(inputs), "Rerun"), (others, "another kind")].into_iter().filter_map(note).collect()
}

/// The recordings of this program in the folders among these inputs, by name.
fn recorded_in_folders(inputs: &[PathBuf]) -> Vec<PathBuf> {
    let in_folder = |input: &PathBuf| std::fs::read_dir(input).ok();
    let files = inputs.iter().filter_map(in_folder).flatten().flatten().map(|entry| entry.path());
    let mut recorded: Vec<_> = files.filter(|path| path.extension().is_some_and(|ending| ending == "rrd")).collect();
    recorded.sort();
    recorded
}

/// How flights are flown.
#[derive(Clone, Copy)]
pub(crate) struct How<'a> {
    pub(crate) registry: &'a Registry,
    pub(crate) stop: &'a StopFlag,
    pub(crate) bar: &'a ProgressBar,
    /// This multiple of the recorded pace; `None`: as fast as the stages are.
    pub(crate) rate: Option<f64>,
    /// Whether frames get their poses, places and steady answers.
    pub(crate) has_poses: bool,
}

/// What becomes of each finished frame, which has a truth and its score if the flight has.
pub(crate) type Sink<'a> = dyn FnMut(&Frame, Option<&Judged>) -> io::Result<()> + Send + 'a;

/// Streams a flight through the stages of `config`: each frame to `sink`, then to the observers.
pub(crate) fn fly(
    mut flight: Flight,
    config: &Config,
    how: &How<'_>,
    observers: &mut [Box<dyn Observer>],
    sink: &mut Sink<'_>,
) -> anyhow::Result<Flown> {
    let start = Instant::now();
    let (truths, mut judge, mut returns) = (Mutex::default(), Judge::default(), 0);
    let mut results = |frame: &Frame| {
        how.bar.inc(1);
        returns += frame.revolution.len();
        let truth = lock(&truths).pop_front().unwrap_or(Ok(None));
        sink(frame, judge.judged(truth, frame).as_ref())
    };
    let options = StreamOptions { rate: how.rate, stop: how.stop.clone(), flight: how.has_poses };
    let mut source = Scans { flight: &mut flight, truths: &truths };
    let ran = stream(&mut source, config, how.registry, &mut results, observers, &options);
    Ok(Flown {
        summary: ran.context("a thread could not be started")?,
        elapsed: start.elapsed(),
        starts_at_s: flight.starts_at_s().unwrap_or(0.0),
        losses: flight.losses(judge),
        left_out: flight.left_out(),
        returns,
    })
}

/// The scans of a flight. Their truths wait for the answers, which come in the same order.
struct Scans<'a> {
    flight: &'a mut Flight,
    truths: &'a Mutex<VecDeque<TruthAt>>,
}

impl Source for Scans<'_> {
    fn next(&mut self, out: &mut Revolution, notes: &mut Notes) -> Result<bool, SourceError> {
        let truth = self.flight.next(out, notes)?;
        let more = truth.is_some();
        lock(self.truths).extend(truth);
        Ok(more)
    }
}

fn lock(truths: &Mutex<VecDeque<TruthAt>>) -> std::sync::MutexGuard<'_, VecDeque<TruthAt>> {
    truths.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A truth, and how well an answer agrees with it.
pub(crate) struct Judged {
    pub(crate) truth: Truth,
    pub(crate) score: Score,
}

impl Judged {
    /// The truth as a recording holds it.
    pub(crate) fn json(&self) -> String {
        String::from_utf8(self.truth.to_json()).unwrap_or_default()
    }
}

/// Compares answers with truths, and counts those that cannot be compared.
#[derive(Default)]
pub(crate) struct Judge {
    without_truth: u64,
    /// The number of others, and the reason of the first.
    others: Option<(u64, String)>,
}

impl Judge {
    /// The truth of this revolution, unless it cannot be read or there is none.
    pub(crate) fn truth(&mut self, truth: TruthAt, seq: u64) -> Option<Truth> {
        match truth {
            Ok(Some(truth)) => return Some(truth),
            Ok(None) => self.without_truth += 1,
            Err(error) => self.cannot(format!("revolution {seq}: {error}")),
        }
        None
    }

    fn judged(&mut self, truth: TruthAt, frame: &Frame) -> Option<Judged> {
        let truth = self.truth(truth, frame.revolution.seq)?;
        match Score::of(&truth, &ResultsLine::of(frame)) {
            Ok(score) => return Some(Judged { truth, score }),
            Err(error) => self.cannot(error.to_string()),
        }
        None
    }

    /// Counts a revolution whose answer cannot be compared with its truth.
    pub(crate) fn cannot(&mut self, reason: String) {
        self.others.get_or_insert((0, reason)).0 += 1;
    }

    fn messages(self, path: &Path) -> Vec<String> {
        let path = path.display();
        let scans = |count| counted(count, "scan");
        let none = (self.without_truth > 0)
            .then(|| format!("no truth has the log time of {}, in {path}", scans(self.without_truth)));
        let others = self.others.map(|(count, first)| {
            format!("{} cannot be compared with the truth, the first: {first}, in {path}", scans(count))
        });
        none.into_iter().chain(others).collect()
    }
}

/// A flight that was flown.
pub(crate) struct Flown {
    pub(crate) summary: Summary,
    pub(crate) elapsed: Duration,
    /// When its first revolution was recorded, seconds after its first scan.
    pub(crate) starts_at_s: f64,
    /// What was lost of it, or could not be compared with its truth.
    pub(crate) losses: Vec<String>,
    left_out: Vec<String>,
    /// Of all revolutions.
    returns: usize,
}

/// A note on a flight in which no scan has a return.
const NO_RETURN: &str =
    "no scan has a usable return: either nothing was in range, or the notes in the results give the reason";

impl Flown {
    /// Whether it has no revolution.
    pub(crate) fn is_empty(&self) -> bool {
        self.summary.revolutions == 0
    }

    /// Reports what is missing and why the flight ended; `whose` names it where there are several.
    pub(crate) fn report(&self, whose: Option<&str>, diagnostics: &mut Diagnostics) {
        self.report_missing(diagnostics);
        self.report_end(whose, diagnostics);
    }

    /// Reports what was lost, and what is odd.
    pub(crate) fn report_missing(&self, diagnostics: &mut Diagnostics) {
        diagnostics.lost_all(&self.losses);
        diagnostics.lost_all(&self.summary.observer_errors);
        self.left_out.iter().for_each(|note| diagnostics.note(note));
        if !self.is_empty() && self.returns == 0 {
            diagnostics.note(NO_RETURN);
        }
    }

    /// Reports why the flight ended, unless that is its end.
    pub(crate) fn report_end(&self, whose: Option<&str>, diagnostics: &mut Diagnostics) {
        let done = counted(self.summary.revolutions, "revolution");
        let of = whose.map_or_else(String::new, |whose| format!("{whose}: "));
        match &self.summary.end {
            // No revolution is at fault: the reader's error states the place.
            End::Failed(Failure { step: Step::Ingest, cause: FailureCause::Error(cause), .. }) if self.is_empty() => {
                diagnostics.error(cause);
            }
            End::Failed(failure) => diagnostics.error(format_args!("{of}{failure}; before it: {done}")),
            End::ResultsLost(error) => report_lost_results(&of, error, &done, diagnostics),
            End::Interrupted => {
                let at = whose.map_or_else(String::new, |whose| format!("at {whose}, "));
                diagnostics.interrupted(format_args!("{at}after {done}; what is written covers what came before"));
            }
            End::Complete if self.is_empty() => diagnostics.error(format_args!("{of}no scan could be read")),
            End::Complete => {}
        }
    }

    /// Reports that the results cannot be written to their end.
    pub(crate) fn report_lost(&self, error: &io::Error, diagnostics: &mut Diagnostics) {
        report_lost_results("", error, &counted(self.summary.revolutions, "revolution"), diagnostics);
    }
}

/// A reader of results that closed the pipe wants no more.
fn report_lost_results(of: &str, error: &io::Error, done: &str, diagnostics: &mut Diagnostics) {
    if is_closed_pipe(error) {
        diagnostics.interrupt();
    } else {
        diagnostics.error(format_args!("{of}the results cannot be written after {done}: {error}"));
    }
}

/// Refuses a span of time that ends before it begins.
pub(crate) fn refuse_empty_span(from_s: Option<f64>, to_s: Option<f64>) -> Result<(), UsageError> {
    match (from_s, to_s) {
        (Some(from), Some(to)) if from > to => Err(UsageError(format!("--from {from} is after --to {to}"))),
        _ => Ok(()),
    }
}

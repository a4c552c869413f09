//! `crosscut evaluate`: configurations side by side, against the truth in recordings.

use std::collections::VecDeque;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::Context;
use crosscut_evaluate::{Comparison, Evaluation, Score, tables};
use crosscut_ingest::{ReadOptions, Recording, Sensor, Truths, recordings_in};
use crosscut_messages::{Truth, TruthError};
use crosscut_pipeline::{Config, End, PRESETS, Registry, StopFlag, StreamOptions, stream};
use crosscut_report::ResultsLine;
use crosscut_stage::{Frame, Notes, Revolution, Source, SourceError};
use indicatif::ProgressBar;

use crate::cli::{ConfigArgs, EvaluateArgs};
use crate::exit::{Outcome, UsageError};
use crate::run::stop_on_interrupt;
use crate::{comparison, config, progress};

/// One column of the tables.
struct Column {
    name: String,
    config: Config,
}

/// Runs every configuration over every recording, and compares the results with the truth.
pub(crate) fn evaluate(args: &EvaluateArgs) -> anyhow::Result<Outcome> {
    let registry = Registry::standard();
    let columns = columns(args, &registry)?;
    let recordings = recordings_in(&args.input)?;
    let revolutions = revolutions_in(&recordings, args, &columns)?;
    let mut outputs = Outputs::open(args, &recordings)?;

    let stop = StopFlag::default();
    stop_on_interrupt(stop.clone())?;
    let bar = progress::bar(revolutions, args.quiet);
    let mut comparison = Comparison::new(columns.iter().map(|column| column.name.clone()).collect());
    let mut run = Evaluating { args, registry, stop, bar, said: Vec::new(), outcome: Outcome::Done };
    'all: for path in &recordings {
        let family = path.file_stem().unwrap_or_default().to_string_lossy();
        for (place, column) in columns.iter().enumerate() {
            comparison.merge(&family, place, &run.one(path, column)?);
            if run.stop.is_set() {
                run.outcome = Outcome::Interrupted;
                break 'all;
            }
        }
    }
    run.bar.finish_and_clear();
    for sentence in &run.said {
        eprintln!("{sentence}");
    }
    let configurations = columns.iter().map(|column| (column.name.as_str(), column.config.to_string()));
    outputs.write(&comparison, configurations.collect(), &run.said)?;
    Ok(run.outcome)
}

/// What `--with` names, each with `--set` on top.
fn columns(args: &EvaluateArgs, registry: &Registry) -> anyhow::Result<Vec<Column>> {
    let default = ["default".to_owned()];
    let with = if args.with.is_empty() { &default[..] } else { &args.with };
    let column = |text: &String| {
        let is_preset = PRESETS.iter().any(|(preset, _)| preset == text);
        let path = Path::new(text);
        if !is_preset && !path.exists() {
            let presets: Vec<_> = PRESETS.iter().map(|(preset, _)| *preset).collect();
            let presets = presets.join(", ");
            return Err(UsageError(format!("--with {text}: no preset (there are: {presets}) and no such file")).into());
        }
        let layers = ConfigArgs {
            preset: if is_preset { text.clone() } else { "default".to_owned() },
            config: (!is_preset).then(|| path.to_owned()),
            set: args.set.clone(),
        };
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Column { name, config: config::resolve(&layers, registry)? })
    };
    with.iter().map(column).collect()
}

/// How many revolutions there are to go through, if that is known. Refuses what cannot be evaluated, before hours are
/// spent on the rest.
fn revolutions_in(recordings: &[PathBuf], args: &EvaluateArgs, columns: &[Column]) -> anyhow::Result<Option<u64>> {
    let mut sum = Some(0);
    for path in recordings {
        Truths::open(path)?;
        let messages = open(path, args, &columns[0].config)?.total_messages();
        sum = sum.zip(messages).map(|(sum, messages)| sum + messages * columns.len() as u64);
    }
    Ok(sum)
}

fn open(path: &Path, args: &EvaluateArgs, config: &Config) -> anyhow::Result<Recording> {
    let options = ReadOptions { topic: args.topic.clone(), ..ReadOptions::default() };
    Ok(Recording::open(&[path.to_owned()], &options, Sensor::new(config.params("ingest")))?)
}

/// What goes with every run of a configuration over a recording.
struct Evaluating<'a> {
    args: &'a EvaluateArgs,
    registry: Registry,
    stop: StopFlag,
    bar: ProgressBar,
    /// What went wrong, each once, however many configurations met it.
    said: Vec<String>,
    outcome: Outcome,
}

impl Evaluating<'_> {
    /// One configuration over one recording.
    fn one(&mut self, path: &Path, column: &Column) -> anyhow::Result<Evaluation> {
        let truths_of_results = Mutex::new(VecDeque::new());
        let mut source = WithTruth {
            recording: open(path, self.args, &column.config)?,
            truths: Truths::open(path)?,
            truths_of_results: &truths_of_results,
        };
        let mut scored = Scored::default();
        let mut results = |frame: &Frame| {
            let truth = truths_of_results.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
            scored.add(frame, truth.unwrap_or(Ok(None)));
            self.bar.inc(1);
            Ok(())
        };
        let options = StreamOptions { rate: None, stop: self.stop.clone() };
        let ran = stream(&mut source, &column.config, &self.registry, &mut results, &mut [], &options);
        let end = ran.context("a thread could not be started")?.end;

        for loss in source.recording.losses() {
            self.lost(loss.to_string());
        }
        scored.losses(path).into_iter().for_each(|loss| self.lost(loss));
        if let End::Failed(failure) = end {
            let (name, revolutions) = (&column.name, scored.evaluation.figures().revolutions);
            let sentence = format!("error: {name}: {failure}; {revolutions} before it count: {}", path.display());
            self.say(sentence, Outcome::Failed);
        } else if scored.evaluation.figures().revolutions == 0 && !self.stop.is_set() {
            let why = "no truth has the log time of a scan and a label for each of its beams";
            self.say(format!("error: {why}: {}", path.display()), Outcome::Failed);
        }
        Ok(scored.evaluation)
    }

    fn lost(&mut self, what: String) {
        self.say(format!("lost: {what}"), Outcome::SomethingLost);
    }

    fn say(&mut self, sentence: String, outcome: Outcome) {
        if !self.said.contains(&sentence) {
            self.said.push(sentence);
        }
        if self.outcome != Outcome::Failed {
            self.outcome = outcome;
        }
    }
}

type TruthAt = Result<Option<Truth>, TruthError>;

/// A recording that puts the truth of each revolution into a queue: results come out in the order of the source.
struct WithTruth<'a> {
    recording: Recording,
    truths: Truths,
    truths_of_results: &'a Mutex<VecDeque<TruthAt>>,
}

impl Source for WithTruth<'_> {
    fn next(&mut self, out: &mut Revolution, notes: &mut Notes) -> Result<bool, SourceError> {
        let more = self.recording.next(out, notes)?;
        if more {
            let truth = self.truths.at(self.recording.last_log_time_ns());
            self.truths_of_results.lock().unwrap_or_else(PoisonError::into_inner).push_back(truth);
        }
        Ok(more)
    }
}

/// Revolutions that were compared with their truth, and those that could not be.
#[derive(Default)]
struct Scored {
    evaluation: Evaluation,
    without_truth: u64,
    /// How many, and why the first.
    not_compared: Option<(u64, String)>,
}

impl Scored {
    fn add(&mut self, frame: &Frame, truth: TruthAt) {
        let why_not = match truth {
            Ok(None) => {
                self.without_truth += 1;
                return;
            }
            Ok(Some(truth)) => match Score::of(&truth, &ResultsLine::of(frame)) {
                Ok(score) => return self.evaluation.add(&score),
                Err(error) => error.to_string(),
            },
            Err(error) => format!("revolution {}: {error}", frame.revolution.seq),
        };
        self.not_compared.get_or_insert((0, why_not)).0 += 1;
    }

    fn losses(&self, path: &Path) -> Vec<String> {
        let path = path.display();
        let mut losses = Vec::new();
        if self.without_truth > 0 {
            losses.push(format!("{} scans have no truth of the same log time, in {path}", self.without_truth));
        }
        if let Some((count, first)) = &self.not_compared {
            losses.push(format!("{count} scans cannot be compared with their truth, the first: {first}, in {path}"));
        }
        losses
    }
}

/// Where the outcome goes; opened before the work begins.
struct Outputs<'a> {
    args: &'a EvaluateArgs,
    json: Option<Box<dyn Write>>,
    markdown: Option<Box<dyn Write>>,
}

impl<'a> Outputs<'a> {
    fn open(args: &'a EvaluateArgs, recordings: &[PathBuf]) -> anyhow::Result<Self> {
        let (json, markdown) = (args.json.as_deref(), args.markdown.as_deref());
        if json.is_some() && json == markdown {
            return Err(UsageError("--json and --markdown name the same place".to_owned()).into());
        }
        let open = |path: &Path| -> anyhow::Result<Box<dyn Write>> {
            if path == Path::new("-") {
                return Ok(Box::new(std::io::stdout()));
            }
            let place = path.canonicalize();
            if place.is_ok_and(|place| recordings.iter().any(|r| r.canonicalize().is_ok_and(|r| r == place))) {
                let message = format!("{} would be overwritten; write to another file", path.display());
                return Err(UsageError(message).into());
            }
            Ok(Box::new(File::create(path).with_context(|| format!("cannot write {}", path.display()))?))
        };
        Ok(Self { args, json: json.map(open).transpose()?, markdown: markdown.map(open).transpose()? })
    }

    fn write(
        &mut self,
        outcome: &Comparison,
        configurations: Vec<(&str, String)>,
        said: &[String],
    ) -> anyhow::Result<()> {
        let mut shown = tables::overview(outcome);
        if self.args.details {
            shown.extend(tables::details(outcome));
        }
        let failed = "the outcome cannot be written";
        if let Some(out) = &mut self.json {
            out.write_all(comparison::json(outcome, &configurations, said).as_bytes()).context(failed)?;
        }
        if let Some(out) = &mut self.markdown {
            out.write_all(comparison::markdown(&shown).as_bytes()).context(failed)?;
        }
        let text = comparison::text(&shown);
        let stdout_is_taken = [&self.args.json, &self.args.markdown].into_iter().flatten().any(|p| p == Path::new("-"));
        match (self.args.quiet, stdout_is_taken) {
            (true, _) => Ok(()),
            (false, true) => std::io::stderr().write_all(text.as_bytes()).context(failed),
            (false, false) => std::io::stdout().write_all(text.as_bytes()).context(failed),
        }
    }
}

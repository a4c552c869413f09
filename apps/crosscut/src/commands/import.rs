//! The importer: a recorded flight that the stock Rerun viewer is asked to open becomes a recording of all stages.
//!
//! The viewer calls every executable `rerun-importer-*` on the PATH with each file that it opens. It reads a recording from
//! the standard output of one that knows the file; the others leave with a certain exit code.

use std::path::{Path, PathBuf};

use clap::Args;
use crosscut_detector::{Config, Registry};
use crosscut_ingest::{IngestError, Truths};
use crosscut_pipeline::StopFlag;
use crosscut_recorder::{Recorder, RecorderOptions, StoreIds};
use crosscut_stage::{Frame, Observer, ObserverError};

use crate::diagnostics::Diagnostics;
use crate::exit::Outcome;
use crate::fly::{How, fly};
use crate::input::{Flight, InputArgs, RecordingsArgs, config};
use crate::output::{files, observers, progress};

/// What the viewer calls an importer with.
#[derive(Debug, Args)]
pub(crate) struct ImportArgs {
    /// The file that the viewer opens.
    pub(crate) file: PathBuf,
    /// What else the viewer says. Later viewers may say more, which changes nothing here.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    said: Vec<String>,
}

impl ImportArgs {
    /// The value of an option.
    fn value(&self, option: &str) -> Option<&str> {
        let mut said = self.said.iter();
        while let Some(word) = said.next() {
            if word == option {
                return said.next().map(String::as_str);
            }
            if let Some(value) = word.strip_prefix(option).and_then(|rest| rest.strip_prefix('=')) {
                return Some(value);
            }
        }
        None
    }
}

/// The endings of recordings that may be flights. Tables, PCD and PLY are not among them: few of them are.
const ENDINGS: [&str; 5] = ["bag", "db3", "clf", "log", "mcap"];
/// Of those, the endings that other files have as well.
const SHARED_ENDINGS: [&str; 2] = ["log", "mcap"];

/// Writes the recording of a flight to standard output, with the settings of the preset `default`.
pub(crate) fn import(args: &ImportArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let config = config::resolve("default", None, &[], registry)?;
    let Some(flight) = opened(&args.file, &config)? else { return Ok(Outcome::NotOurs) };
    let application = args.value("--opened-application-id").or(args.value("--application-id"));
    let recording = args.value("--opened-recording-id").or(args.value("--recording-id"));
    let ids = application.zip(recording).map(|(application, recording)| StoreIds {
        application: application.to_owned(),
        recording: recording.to_owned(),
    });
    let name = args.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let options = RecorderOptions { ids, ..observers::recorder_options(name, &config) };
    let (flight, truth) = (flight.with_shown_truths(Truths::open(&args.file).ok()), options.truth.clone());
    let recorder = Recorder::piped(options, files::standard_output()?)?;
    let stop = StopFlag::default();
    let mut observers: Vec<Box<dyn Observer>> = vec![Box::new(WhileRead { recorder, stop: stop.clone() })];
    let how = How { registry, stop: &stop, bar: &progress::bar(None, true), rate: None, has_poses: true };
    let flown = fly(flight, &config, &how, &mut observers, &mut |frame, judged| {
        if let Some(judged) = judged {
            truth.tell(frame.revolution.seq, judged.score.true_walls, judged.json());
        }
        Ok(())
    })?;
    let mut diagnostics = Diagnostics::default();
    flown.report(None, &mut diagnostics);
    Ok(diagnostics.outcome())
}

/// The flight in a file; `None` if it is not for us: another kind of file, or clouds that the viewer itself shows.
fn opened(file: &Path, config: &Config) -> anyhow::Result<Option<Flight>> {
    let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if !ENDINGS.contains(&ending.as_str()) || !file.is_file() {
        return Ok(None);
    }
    let open = |topic: Option<String>| Flight::open(&[file.to_owned()], &input(file, topic), config);
    let opened = open(None).or_else(|error| match error.downcast_ref() {
        // Nobody can be asked: the scanner that sent most.
        Some(IngestError::SeveralScanTopics { topics }) => {
            open(topics.0.iter().max_by_key(|topic| topic.messages).map(|topic| topic.name.clone()))
        }
        _ => Err(error),
    });
    match opened {
        Ok(flight) => Ok(Some(flight).filter(|flight| ending != "mcap" || !flight.gives_clouds())),
        Err(error) if SHARED_ENDINGS.contains(&ending.as_str()) || is_without_scans(&error) => Ok(None),
        Err(error) => Err(error),
    }
}

fn is_without_scans(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(IngestError::NoScanTopic { .. } | IngestError::NoScans { .. }))
}

fn input(file: &Path, topic: Option<String>) -> InputArgs {
    InputArgs {
        recordings: RecordingsArgs { input: vec![file.to_owned()], read_as: None },
        topic: topic.into_iter().collect(),
        from: None,
        to: None,
        every: std::num::NonZeroU64::MIN,
        join: false,
    }
}

/// Records until the viewer is closed, which ends the flight.
struct WhileRead {
    recorder: Recorder,
    stop: StopFlag,
}

impl Observer for WhileRead {
    fn observe(&mut self, frame: &Frame) -> Result<(), ObserverError> {
        self.recorder.observe(frame).inspect_err(|_| self.stop.set())
    }

    fn finish(&mut self) -> Result<(), ObserverError> {
        self.recorder.finish()
    }
}

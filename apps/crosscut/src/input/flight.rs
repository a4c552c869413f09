//! A flight that is open: where its scans and their truths come from.

use std::path::PathBuf;

use crosscut_detector::Config;
use crosscut_ingest::{Following, LiveFeed, ReadOptions, Recording, Truths};
use crosscut_stage::{Notes, Revolution, Source, SourceError, counted};

use super::files::left_out_of_folders;
use super::judge::{Judge, TruthAt};
use crate::exit::UsageError;
use crate::input::InputArgs;
use crate::input::live::RobotAddress;
use crate::input::recorded::{self, Recorded};
use crate::input::related::refuse_unrelated;

/// A flight that is open.
pub(crate) struct Flight {
    scans: Read,
    truths: Option<Truths>,
    /// What cannot be compared with the truths is a loss.
    is_judged: bool,
    /// The last part.
    path: PathBuf,
}

/// Where the scans come from.
enum Read {
    /// Files of a robot, or what it sends.
    Flown(Box<Recording>),
    /// A recording of this program.
    Recorded(Recorded),
}

impl Flight {
    /// Opens the `parts` of a flight, of which `args` select scans, with the sensor of `config`.
    pub(crate) fn open(parts: &[PathBuf], args: &InputArgs, config: &Config) -> anyhow::Result<Self> {
        if let Some(path) = recorded::only(parts)? {
            let recorded = Recorded::open(path, args, config)?;
            let is_judged = recorded.has_truth();
            let (scans, path) = (Read::Recorded(recorded), path.to_owned());
            return Ok(Self { scans, truths: None, is_judged, path });
        }
        refuse_unrelated(parts, args, config)?;
        let recording = Recording::open(parts, &args.read_options(config), config.sensor())?;
        Ok(Self::flown(recording, parts.last().cloned().unwrap_or_default()))
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
        let sensor = config.sensor();
        let recording = Recording::follow(inputs, &args.read_options(config), &sensor, following)?;
        Ok(Self::flown(recording, inputs.last().cloned().unwrap_or_default()))
    }

    /// Opens standard input, to be read as it comes if it is an MCAP.
    pub(crate) fn of_standard_input(args: &InputArgs, config: &Config, following: &Following) -> anyhow::Result<Self> {
        let sensor = config.sensor();
        match Recording::of_standard_input(&args.read_options(config), &sensor, following)? {
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
        let sensor = config.sensor();
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
        Self { scans: Read::Flown(Box::new(recording)), truths: None, is_judged: false, path }
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

    pub(crate) fn starts_at_s(&self) -> Option<f64> {
        match &self.scans {
            Read::Flown(recording) => recording.starts_at_s(),
            Read::Recorded(recorded) => recorded.starts_at_s(),
        }
    }

    /// The scans of the inputs that were passed over, and what is odd about their times.
    pub(crate) fn left_out(&self) -> Vec<String> {
        let Read::Flown(recording) = &self.scans else { return Vec::new() };
        let mut notes: Vec<String> = left_out_of_folders(recording.left_out()).into_iter().collect();
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

//! The scans of a recording that the program made itself: they are as ingest gave them to the stages, to the last bit.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::Builder;

use anyhow::Context;
use crosscut_detector::{Config, Layer, Registry};
use crosscut_evaluate::settings_of_step;
use crosscut_messages::{Truth, TruthError};
use crosscut_rrd::schema::{Entity, SCAN_CLOUD, SCAN_ENTRIES, TRUTH_JSON};
use crosscut_rrd::{ReadError, RecordedScan, Recording};
use crosscut_stage::{Notes, Revolution, SourceError, Step};

use crate::exit::UsageError;
use crate::input::InputArgs;
use crate::output::say;

/// Scans that wait to be taken.
const WAITING: usize = 64;

/// The scans of a recording, which a thread reads.
pub(crate) struct Recorded {
    scans: Receiver<Result<RecordedScan, ReadError>>,
    from_s: Option<f64>,
    to_s: Option<f64>,
    every: u64,
    first_ns: Option<u64>,
    starts_at_s: Option<f64>,
    losses: Vec<String>,
    truth: Option<String>,
    has_truth: bool,
}

impl Recorded {
    /// Opens the recording at `path`, of which `args` select scans.
    ///
    /// # Errors
    /// When it cannot be read, was written by a version that did not record all of a scan, or `config` asks for other scans.
    pub(crate) fn open(path: &Path, args: &InputArgs, config: &Config) -> anyhow::Result<Self> {
        if !args.topic.is_empty() || args.recordings.read_as.is_some() {
            let text = "the scans of a recording (.rrd) are those of one topic: leave out --topic and --as";
            return Err(UsageError(text.to_owned()).into());
        }
        let recording = opened(path)?;
        refuse_other_ingest(path, &recording, config)?;
        if let Err(error) = recording.revolutions() {
            let why = format!("{} does not hold all of its scans: record it again: {error}", path.display());
            return Err(lacking(&recording, why));
        }
        let holds = |entity: Entity| recording.entities().contains_key(entity.path);
        if config.takes_cloud() && holds(SCAN_ENTRIES) && !holds(SCAN_CLOUD) {
            let path = path.display();
            let text = format!(
                "{path} holds of its clouds what a level vehicle sees; their ways on need the file that was flown"
            );
            return Err(UsageError(text).into());
        }
        let losses = recording.damages().iter().map(ToString::to_string).collect();
        let has_truth = holds(TRUTH_JSON);
        let (give, scans) = sync_channel(WAITING);
        let read = move || {
            let Ok(revolutions) = recording.revolutions() else { return };
            for scan in revolutions {
                if give.send(scan).is_err() {
                    return; // nobody takes more
                }
            }
        };
        Builder::new().name("recorded".to_owned()).spawn(read).context("a thread could not be started")?;
        Ok(Self {
            scans,
            from_s: args.from,
            to_s: args.to,
            every: args.every.get(),
            first_ns: None,
            starts_at_s: None,
            losses,
            truth: None,
            has_truth,
        })
    }

    /// Reads the next revolution; `false` at the end.
    pub(crate) fn next(&mut self, out: &mut Revolution, notes: &mut Notes) -> Result<bool, SourceError> {
        while let Ok(scan) = self.scans.recv() {
            let scan = scan.map_err(|error| SourceError(error.to_string()))?;
            let stamp_ns = scan.revolution.stamp_ns;
            let first_ns = *self.first_ns.get_or_insert(stamp_ns);
            let since_first_s = (i128::from(stamp_ns) - i128::from(first_ns)) as f64 * 1e-9;
            let is_within = self.from_s.is_none_or(|from_s| since_first_s >= from_s)
                && self.to_s.is_none_or(|to_s| since_first_s <= to_s);
            if is_within && scan.revolution.seq.is_multiple_of(self.every) {
                self.starts_at_s.get_or_insert(since_first_s);
                (*out, *notes, self.truth) = (scan.revolution, scan.notes, scan.truth);
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The truth of the last revolution.
    pub(crate) fn truth(&mut self) -> Result<Option<Truth>, TruthError> {
        self.truth.take().map(|json| Truth::from_json(json.as_bytes())).transpose()
    }

    /// Whether any revolution has a truth.
    pub(crate) fn has_truth(&self) -> bool {
        self.has_truth
    }

    /// What the recording lacks.
    pub(crate) fn losses(&self) -> &[String] {
        &self.losses
    }

    /// When the first revolution that was given was taken, seconds after the first that was recorded.
    pub(crate) fn starts_at_s(&self) -> Option<f64> {
        self.starts_at_s
    }
}

/// The only input, if it is a recording of the program.
///
/// # Errors
/// When there are others beside it.
pub(crate) fn only(inputs: &[PathBuf]) -> Result<Option<&Path>, UsageError> {
    let is_recorded = |path: &PathBuf| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("rrd"));
    match inputs {
        [only] if is_recorded(only) => Ok(Some(only)),
        _ if inputs.iter().any(is_recorded) => Err(UsageError(
            "a recording (.rrd) is a flight of its own: give it alone; its later parts are found".to_owned(),
        )),
        _ => Ok(None),
    }
}

/// The only recording of a file.
fn opened(path: &Path) -> anyhow::Result<Recording> {
    Recording::open(path).map_err(|error| match error {
        ReadError::Several { .. } => {
            UsageError(format!("{error}; they are flights of their own: give one at a time")).into()
        }
        error => error.into(),
    })
}

/// Why a recording cannot be used: that it was cut off, or else `why`.
fn lacking(recording: &Recording, why: String) -> anyhow::Error {
    let cut = recording.damages().iter().find(|damage| damage.is_cut());
    anyhow::anyhow!(cut.map_or(why, ToString::to_string))
}

/// The settings that the recording was made with.
pub(crate) fn settings(path: &Path) -> anyhow::Result<Layer> {
    let recording = opened(path)?;
    let none = || lacking(&recording, format!("the recording has no /config: {}", path.display()));
    let toml = recording.config_toml().ok_or_else(none)?;
    Ok(Layer::recorded(path, &toml)?)
}

/// Scans are recorded as ingest made them: other settings of ingest cannot be tried on them. Those that nobody but a preset
/// set are passed over with a note.
fn refuse_other_ingest(path: &Path, recording: &Recording, config: &Config) -> anyhow::Result<()> {
    let toml = recording.config_toml().unwrap_or_default();
    let Ok(recorded) = Layer::recorded(path, &toml).and_then(|layer| Config::resolve(&Registry::standard(), &[layer]))
    else {
        return Ok(()); // with kinds of one's own
    };
    let recorded = settings_of_step(&recorded, Step::Ingest);
    let of_ingest = settings_of_step(config, Step::Ingest);
    let (mut refused, mut passed_over) = (Vec::new(), Vec::new());
    for [key, value, layer] in config.set_by_layers() {
        let setting = format!("{key}={value}");
        if of_ingest.lines().any(|line| line == setting) && !recorded.lines().any(|line| line == setting) {
            if layer.starts_with("preset ") { &mut passed_over } else { &mut refused }.push(setting);
        }
    }
    let path = path.display();
    if !passed_over.is_empty() {
        let settings = passed_over.join(", ");
        say(format_args!("note: {path} holds its scans as ingest made them; {settings} of the preset has no effect"));
    }
    if refused.is_empty() {
        return Ok(());
    }
    let settings = refused.join(", ");
    Err(UsageError(format!("{path} holds its scans as ingest made them; {settings} needs the file that was flown"))
        .into())
}

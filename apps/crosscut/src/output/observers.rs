//! The observers of a run: the recorder for the Rerun viewer.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crosscut_detector::Config;
use crosscut_stage::Observer;

use crate::diagnostics::Diagnostics;
use crate::input::{ConfigArgs, InputArgs};
#[cfg(feature = "rerun")]
use crate::input::{live_input, without_query};
use crate::output::record::RecordArgs;
#[cfg(feature = "rerun")]
use crate::output::say::say;

/// What is recorded: a flight with the settings of a command, and whether it is played at a pace.
#[cfg_attr(not(feature = "rerun"), allow(dead_code))] // recordings need the feature
pub(crate) struct Source<'a> {
    pub(crate) input: &'a InputArgs,
    pub(crate) settings: &'a ConfigArgs,
    pub(crate) is_paced: bool,
}

/// Tells the `seq` of a revolution, its true number of walls and its truth as JSON.
pub(crate) type TellTruth = Box<dyn Fn(u64, usize, String) + Send + Sync>;

/// The observers that receive each frame after its results are written.
#[derive(Default)]
pub(crate) struct Observers {
    pub(crate) list: Vec<Box<dyn Observer>>,
    /// Whether viewers can connect after the run as well.
    pub(crate) served: bool,
    /// Tells the recorder the truth of a revolution with its number of walls, before it observes its frame.
    pub(crate) truth: Option<TellTruth>,
    /// Number of revolutions recorded so far, if there is a recorder.
    recorded: Option<Arc<AtomicU64>>,
}

impl Observers {
    /// Whether there is a recorder and no revolution lay within what it was asked to record.
    pub(crate) fn recorded_nothing(&self) -> bool {
        self.recorded.as_ref().is_some_and(|recorded| recorded.load(Ordering::Relaxed) == 0)
    }
}

/// Opens the recorder, if one is requested. If it cannot be opened, the run continues without it.
#[cfg(feature = "rerun")]
pub(crate) fn open(
    args: &RecordArgs,
    source: &Source<'_>,
    config: &Config,
    diagnostics: &mut Diagnostics,
) -> anyhow::Result<Observers> {
    use crosscut_recorder::{Recorder, RecorderError, RecorderOptions};

    if !args.is_asked() {
        return Ok(Observers::default());
    }
    let options = RecorderOptions {
        path: args.save.clone(),
        view: args.view,
        serve: args.serve,
        live: source.is_paced || live_input(source.input).is_some(),
        source: words(source),
        ..recorder_options(source.input.name(), config)
    };
    let truth = options.truth.clone();
    let mut recorder = Recorder::new(options.clone());
    if let Err(error @ (RecorderError::NoViewer | RecorderError::Viewer(_) | RecorderError::Serve { .. })) = &recorder
        && args.save.is_some()
    {
        diagnostics.lost(error);
        recorder = Recorder::new(RecorderOptions { view: false, serve: None, ..options });
    }
    Ok(match recorder {
        Ok(recorder) => {
            recorder.served().inspect(|served| say_where(served));
            let (served, recorded) = (recorder.served().is_some(), Some(recorder.recorded()));
            let truth: TellTruth = Box::new(move |seq, walls, json| truth.tell(seq, walls, json));
            Observers { list: vec![Box::new(recorder)], served, truth: Some(truth), recorded }
        }
        Err(error) => {
            diagnostics.lost(error);
            Observers::default()
        }
    })
}

/// The file and the preset: "tee.mcap, preset paper with 2 settings changed".
#[cfg(feature = "rerun")]
fn words(source: &Source<'_>) -> String {
    let file = without_query(&source.input.recordings.input[0]).file_name().unwrap_or_default().to_string_lossy();
    let ConfigArgs { config, set, .. } = source.settings;
    let preset = source.settings.preset();
    let over = config.as_ref().and_then(|config| config.file_name()).map(|name| name.to_string_lossy());
    let over = over.map_or_else(String::new, |name| format!(" with {name}"));
    // What is recorded changes no answer.
    let set: Vec<&str> = set.iter().map(String::as_str).filter(|setting| !setting.starts_with("recording.")).collect();
    let changed = if set.is_empty() { String::new() } else { format!(", --set {}", set.join(" ")) };
    format!("{file}, preset {preset}{over}{changed}")
}

/// A recording of a flight of this name and configuration, without a file and a viewer.
#[cfg(feature = "rerun")]
pub fn recorder_options(name: String, config: &Config) -> crosscut_recorder::RecorderOptions {
    use crosscut_recorder::{Mounting, RecorderOptions};
    use crosscut_sensor::{UPSIDE_DOWN, YAW_RAD};

    let ingest = config.params("ingest");
    RecorderOptions {
        name,
        config_toml: format!("# crosscut {}\n{config}", env!("CARGO_PKG_VERSION")),
        scope: scope(config.params("recording")),
        mounting: Mounting { yaw_rad: ingest.get(YAW_RAD), upside_down: ingest.get(UPSIDE_DOWN) },
        ..RecorderOptions::default()
    }
}

/// What is recorded, by the settings of section `recording`.
#[cfg(feature = "rerun")]
fn scope(recording: &crosscut_stage::Params) -> crosscut_recorder::Scope {
    use crosscut_detector::recording::{DETAIL, EXACT_EVERY, PART_REVOLUTIONS, REVOLUTIONS, SPANS_S};
    use crosscut_recorder::{Detail, Scope};
    use std::num::NonZeroU64;

    Scope {
        detail: match recording.get(DETAIL).as_str() {
            "light" => Detail::Light,
            "full" => Detail::Full,
            _ => Detail::Default,
        },
        exact_every: NonZeroU64::new(recording.get(EXACT_EVERY) as u64),
        revolutions: recording.get(REVOLUTIONS).into_iter().map(|[from, to]| from as u64..=to as u64).collect(),
        seconds: recording.get(SPANS_S).into_iter().map(|[from, to]| from..=to).collect(),
        part_revolutions: NonZeroU64::new(recording.get(PART_REVOLUTIONS) as u64).unwrap_or(NonZeroU64::MIN),
    }
}

#[cfg(not(feature = "rerun"))]
pub(crate) fn open(args: &RecordArgs, _: &Source<'_>, _: &Config, _: &mut Diagnostics) -> anyhow::Result<Observers> {
    if args.is_asked() {
        return Err(crate::gate::without_rerun());
    }
    Ok(Observers::default())
}

/// Prints the addresses at which viewers can connect.
#[cfg(feature = "rerun")]
pub(crate) fn say_where(served: &crosscut_recorder::Served) {
    say(format_args!("serving; to view it: rerun --connect {}", served.url));
    if let Some(page) = &served.web_url {
        say(format_args!("or in a browser: {page}"));
    }
    if served.at_every_address {
        say("from another machine: put this machine's address in place of 127.0.0.1");
    }
}

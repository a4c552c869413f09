//! What is recorded for the Rerun viewer, and how it is looked at.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crosscut_pipeline::Config;
use crosscut_stage::Observer;

use crate::cli::record::RecordArgs;

/// Who sees the frames.
#[derive(Default)]
pub(crate) struct Observers {
    pub(crate) list: Vec<Box<dyn Observer>>,
    /// Viewers can still connect when the flight is over.
    pub(crate) served: bool,
    /// Revolutions that the recorder has taken, if there is one.
    recorded: Option<Arc<AtomicU64>>,
}

impl Observers {
    /// Whether there is a recorder, and of the whole flight nothing lay within what it was to record.
    pub(crate) fn recorded_nothing(&self) -> bool {
        self.recorded.as_ref().is_some_and(|recorded| recorded.load(Ordering::Relaxed) == 0)
    }
}

/// The recorder, if one is asked for. A recording or a view that cannot be had is lost, the rest is not.
#[cfg(feature = "rerun")]
pub(crate) fn observers(
    args: &RecordArgs,
    input: &Path,
    config: &Config,
    live: bool,
    lost: &mut Vec<String>,
) -> anyhow::Result<Observers> {
    use crosscut_ingest::{UPSIDE_DOWN, YAW_RAD};
    use crosscut_recorder::{Mounting, Recorder, RecorderError, RecorderOptions};

    if args.save.is_none() && !args.view && args.serve.is_none() {
        return Ok(Observers::default());
    }
    let ingest = config.params("ingest");
    let options = RecorderOptions {
        path: args.save.clone(),
        view: args.view,
        serve: args.serve,
        live,
        name: input.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        config_toml: format!("# crosscut {}\n{config}", env!("CARGO_PKG_VERSION")),
        mounting: Mounting { yaw_rad: ingest.get(YAW_RAD), upside_down: ingest.get(UPSIDE_DOWN) },
        layout: args.layout.into(),
        scope: args.scope(),
    };
    let mut recorder = Recorder::new(options.clone());
    if let Err(error @ (RecorderError::NoViewer | RecorderError::Viewer(_) | RecorderError::Serve { .. })) = &recorder
        && args.save.is_some()
    {
        lost.push(error.to_string());
        recorder = Recorder::new(RecorderOptions { view: false, serve: None, ..options });
    }
    Ok(match recorder {
        Ok(recorder) => {
            recorder.served().inspect(|served| crate::commands::view::say_where(served));
            let (served, recorded) = (recorder.served().is_some(), Some(recorder.recorded()));
            Observers { list: vec![Box::new(recorder)], served, recorded }
        }
        Err(error) => {
            lost.push(error.to_string());
            Observers::default()
        }
    })
}

#[cfg(not(feature = "rerun"))]
pub(crate) fn observers(
    args: &RecordArgs,
    _: &Path,
    _: &Config,
    _: bool,
    _: &mut Vec<String>,
) -> anyhow::Result<Observers> {
    if args.save.is_some() || args.view || args.serve.is_some() {
        return Err(crate::exit::without_rerun());
    }
    Ok(Observers::default())
}

#[cfg(feature = "rerun")]
mod of_the_recorder {
    use crosscut_recorder::{Detail, Layout, Scope};

    use crate::cli::record::{DetailArg, LayoutArg, RecordArgs};

    impl From<LayoutArg> for Layout {
        fn from(layout: LayoutArg) -> Self {
            match layout {
                LayoutArg::Overview => Self::Overview,
                LayoutArg::Stages => Self::Stages,
                LayoutArg::Speed => Self::Speed,
            }
        }
    }

    impl From<DetailArg> for Detail {
        fn from(detail: DetailArg) -> Self {
            match detail {
                DetailArg::Light => Self::Light,
                DetailArg::Default => Self::Default,
                DetailArg::Full => Self::Full,
            }
        }
    }

    impl RecordArgs {
        pub(super) fn scope(&self) -> Scope {
            let all = Scope::default();
            Scope {
                detail: self.record.into(),
                exact_every: self.record_every,
                revolutions: self.record_revolutions.clone().unwrap_or(all.revolutions),
                seconds: self.record_seconds.clone().unwrap_or(all.seconds),
                part_revolutions: self.record_part,
            }
        }
    }
}

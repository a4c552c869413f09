//! The configuration of every command.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use crosscut_detector::{Config, Layer, Preset, Registry};

use crate::exit::UsageError;
use crate::input::text_file;
use crate::values::has_extension;

/// The heading of what configures.
pub(crate) const CONFIGURATION: &str = "Configuration";

#[derive(Debug, Args)]
pub(crate) struct ConfigArgs {
    /// Settings to start from: paper, default, 3d, or one of the baselines clear_width, threshold, breakpoint.
    /// [default: default]
    #[arg(long, help_heading = CONFIGURATION)]
    pub(crate) preset: Option<String>,
    /// Settings that override the preset and crosscut.toml: a TOML file, or a recording made with `run --save` to use its
    /// settings. (crosscut.toml is looked for in this folder and those above it, unless $CROSSCUT_CONFIG names a file.)
    #[arg(long, help_heading = CONFIGURATION, value_name = "FILE.toml|FLIGHT.rrd")]
    pub(crate) config: Option<PathBuf>,
    /// Single setting that overrides the files, such as vehicle.width_m=0.8. May be repeated.
    #[arg(long, help_heading = CONFIGURATION, value_name = "SECTION.KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

/// Settings of a folder and all below it.
const FILE_NAME: &str = "crosscut.toml";
/// Names a file of settings in place of [`FILE_NAME`].
const VARIABLE: &str = "CROSSCUT_CONFIG";
/// A found file of more bytes is not taken: nobody asked for the time that its keys would take.
const MOST_FOUND_BYTES: u64 = 1 << 20;

/// Resolves the layers preset < the file that is found < `file` < single settings; messages name the option of the settings.
pub(crate) fn resolve(
    preset: &str,
    file: Option<&Path>,
    settings: &[(&str, &[String])],
    registry: &Registry,
) -> Result<Config, UsageError> {
    Config::resolve(registry, &layers(preset, file, settings)?).map_err(usage)
}

/// The layers of settings before they are resolved.
pub(crate) fn layers(
    preset: &str,
    file: Option<&Path>,
    settings: &[(&str, &[String])],
) -> Result<Vec<Layer>, UsageError> {
    let mut layers = vec![Preset::named(preset).map_err(usage)?.into()];
    if let Some(found) = found().filter(|found| found.refused().is_none()) {
        let (path, text) = (&found.path, settings_in(&found.path)?);
        let layer = if found.is_named { Layer::file(path, &text) } else { Layer::unasked(path, &text) };
        layers.push(layer.map_err(usage)?);
    }
    if let Some(path) = file {
        let text = settings_in(path)?;
        let layer = if has_extension(path, "rrd") { Layer::recorded(path, &text) } else { Layer::file(path, &text) };
        layers.push(layer.map_err(usage)?);
    }
    for (option, settings) in settings {
        layers.push(Layer::settings(option, settings).map_err(usage)?);
    }
    Ok(layers)
}

/// A file of settings that every configuration starts with.
pub(crate) struct Found {
    pub(crate) path: PathBuf,
    /// The environment names it.
    is_named: bool,
}

/// The file that the environment names, or the nearest of its name in this folder and those above it.
pub(crate) fn found() -> Option<Found> {
    if let Some(named) = std::env::var_os(VARIABLE) {
        return (!named.is_empty()).then(|| Found { path: named.into(), is_named: true });
    }
    let folder = std::env::current_dir().ok()?;
    let path = folder.ancestors().map(|folder| folder.join(FILE_NAME)).find(|file| file.is_file())?;
    Some(Found { path, is_named: false })
}

impl Found {
    /// Why its settings do not count, if they do not: those that somebody else put there, or may change, or too many.
    pub(crate) fn refused(&self) -> Option<&'static str> {
        let is_small = || self.path.metadata().is_ok_and(|file| file.len() <= MOST_FOUND_BYTES);
        match self.is_named {
            false if !is_own(&self.path) => Some("is another user's, or anybody may write to it"),
            false if !is_small() => Some("is larger than the 1 MiB that a found file may have"),
            _ => None,
        }
    }
}

/// Whether a file is the user's or root's, and nobody else may write to it.
#[cfg(unix)]
fn is_own(file: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    const ALL_MAY_WRITE: u32 = 0o002;
    let of_user = [Some("/proc/self".into()), std::env::home_dir()];
    let user = of_user.into_iter().flatten().find_map(|path| path.metadata().ok()).map(|of_user| of_user.uid());
    let is_of = |uid| uid == 0 || Some(uid) == user;
    file.symlink_metadata().is_ok_and(|link| is_of(link.uid()))
        && file.metadata().is_ok_and(|file| is_of(file.uid()) && file.mode() & ALL_MAY_WRITE == 0)
}

#[cfg(not(unix))]
fn is_own(_: &Path) -> bool {
    true
}

impl ConfigArgs {
    /// The preset, whether it was given or not.
    pub(crate) fn preset(&self) -> &str {
        self.preset.as_deref().unwrap_or("default")
    }

    pub(crate) fn resolve(&self, registry: &Registry) -> Result<Config, UsageError> {
        resolve(self.preset(), self.config.as_deref(), &[("--set", &self.set)], registry)
    }
}

/// The text of a TOML file, or the settings stored in a recording.
fn settings_in(path: &Path) -> Result<String, UsageError> {
    if has_extension(path, "rrd") {
        return settings_in_recording(path);
    }
    text_file::read(path).map_err(|error| match error.kind() {
        io::ErrorKind::InvalidData => usage(format!(
            "not UTF-8 text; settings are read from a TOML file or a recording (.rrd): {}",
            path.display()
        )),
        _ => usage(format!("{}: {error}", path.display())),
    })
}

#[cfg(feature = "rerun")]
fn settings_in_recording(path: &Path) -> Result<String, UsageError> {
    let recording = crosscut_rrd::Recording::open(path).map_err(usage)?;
    recording.config_toml().ok_or_else(|| usage(format!("the recording has no /config: {}", path.display())))
}

#[cfg(not(feature = "rerun"))]
fn settings_in_recording(path: &Path) -> Result<String, UsageError> {
    Err(usage(format!("{}: {}", path.display(), crate::gate::without_rerun())))
}

fn usage(error: impl ToString) -> UsageError {
    UsageError(error.to_string())
}

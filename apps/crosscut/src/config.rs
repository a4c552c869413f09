//! `crosscut config`, and the resolution of the configuration for all commands.

use std::io::{self, Write};
use std::path::Path;

use anyhow::Context;
use crosscut_detector::{Config, Layer, Preset, Registry};
use crosscut_sensor::{MAX_RANGE_M, MIN_RANGE_M};

use crate::cli::ConfigArgs;
use crate::exit::{Outcome, UsageError};

/// Prints the resolved configuration.
pub(crate) fn print(args: &ConfigArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let config = resolve(args, registry)?;
    write!(std::io::stdout(), "{config}").context("standard output")?;
    Ok(Outcome::Done)
}

/// Resolves the layers preset < file < single settings.
pub(crate) fn resolve(args: &ConfigArgs, registry: &Registry) -> anyhow::Result<Config> {
    resolve_with(args, "", &[], registry)
}

/// Resolves the layers preset < file < settings of another option, such as one `--with` < single settings.
pub(crate) fn resolve_with(
    args: &ConfigArgs,
    option: &str,
    own: &[String],
    registry: &Registry,
) -> anyhow::Result<Config> {
    let mut layers = vec![Preset::named(&args.preset).map_err(usage)?.into()];
    if let Some(path) = &args.config {
        layers.push(Layer::file(path, &settings_in(path)?).map_err(usage)?);
    }
    layers.push(Layer::settings(option, own).map_err(usage)?);
    layers.push(Layer::settings("--set", &args.set).map_err(usage)?);
    let config = Config::resolve(registry, &layers).map_err(usage)?;
    let ingest = config.params("ingest");
    let (nearest_m, farthest_m) = (ingest.get(MIN_RANGE_M), ingest.get(MAX_RANGE_M));
    if nearest_m >= farthest_m {
        return Err(usage(format!(
            "ingest.min_range_m ({nearest_m}) is not below ingest.max_range_m ({farthest_m}), so no return would be left"
        ))
        .into());
    }
    Ok(config)
}

/// The text of a TOML file, or the settings stored in a recording.
fn settings_in(path: &Path) -> Result<String, UsageError> {
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("rrd")) {
        return settings_in_recording(path);
    }
    std::fs::read_to_string(path).map_err(|error| match error.kind() {
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
    Err(usage(format!("{}: {}", path.display(), crate::exit::without_rerun())))
}

fn usage(error: impl ToString) -> UsageError {
    UsageError(error.to_string())
}

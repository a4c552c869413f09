//! `crosscut config`, and the configuration of the other commands.

use std::io::{self, Write};
use std::path::Path;

use anyhow::Context;
use crosscut_pipeline::{Config, Layer, Registry, Schema};

use crate::cli::ConfigArgs;
use crate::exit::{Outcome, UsageError};

/// Prints the resolved configuration.
pub(crate) fn print(args: &ConfigArgs) -> anyhow::Result<Outcome> {
    let config = resolve(args, &Registry::standard())?;
    write!(std::io::stdout(), "{config}").context("standard output")?;
    Ok(Outcome::Done)
}

/// Preset < file < single settings.
pub(crate) fn resolve(args: &ConfigArgs, registry: &Registry) -> anyhow::Result<Config> {
    resolve_with(args, &[], registry)
}

/// Preset < file < the settings of one `--with` < single settings for all.
pub(crate) fn resolve_with(args: &ConfigArgs, own: &[String], registry: &Registry) -> anyhow::Result<Config> {
    let schema = schema(registry);
    let mut layers = vec![Layer::preset(&args.preset).map_err(usage)?];
    if let Some(path) = &args.config {
        layers.push(Layer::file(path, &settings_in(path)?).map_err(usage)?);
    }
    layers.push(Layer::settings("--with", own).map_err(usage)?);
    layers.push(Layer::settings("--set", &args.set).map_err(usage)?);
    let config = Config::resolve(&schema, &layers).map_err(usage)?;
    let [nearest_m, farthest_m] = ["min_range_m", "max_range_m"].map(|limit| config.params("ingest").number(limit));
    if nearest_m >= farthest_m {
        return Err(usage(format!(
            "ingest.min_range_m ({nearest_m}) is not below ingest.max_range_m ({farthest_m}): no return would be left"
        ))
        .into());
    }
    Ok(config)
}

/// The text of a file of settings, or that of the settings which a recording was made with.
fn settings_in(path: &Path) -> Result<String, UsageError> {
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("rrd")) {
        return settings_of_recording(path);
    }
    std::fs::read_to_string(path).map_err(|error| match error.kind() {
        io::ErrorKind::InvalidData => usage(format!(
            "not a text in UTF-8: settings stand in a TOML file or a recording (.rrd): {}",
            path.display()
        )),
        _ => usage(format!("{}: {error}", path.display())),
    })
}

#[cfg(feature = "rerun")]
fn settings_of_recording(path: &Path) -> Result<String, UsageError> {
    let recording = crosscut_recorder::Recording::open(path).map_err(usage)?;
    recording.config_toml().ok_or_else(|| usage(format!("the recording has no /config: {}", path.display())))
}

#[cfg(not(feature = "rerun"))]
fn settings_of_recording(path: &Path) -> Result<String, UsageError> {
    Err(usage(format!("{}: {}", path.display(), crate::exit::without_rerun())))
}

/// All settings there are.
pub(crate) fn schema(registry: &Registry) -> Schema {
    Schema::new(registry)
        .with_section("ingest", crosscut_ingest::PARAMS)
        .with_section("csv", crosscut_ingest::CSV_PARAMS)
}

fn usage(error: impl ToString) -> UsageError {
    UsageError(error.to_string())
}

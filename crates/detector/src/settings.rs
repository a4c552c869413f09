//! The settings of a program of one's own.

use std::path::PathBuf;

use crosscut_stage::{AffinityStage, KmeansStage, SpectralStage, Value};

use crate::engine::OwnStages;
use crate::{Config, ConfigError, Engine, Layer, Preset, Registry};

/// A preset with overrides, and stages of one's own. Values that are set win over those of files, which win over the preset.
#[derive(Default)]
pub struct Settings {
    preset: Preset,
    files: Vec<PathBuf>,
    /// By `section.name`.
    changes: Vec<(String, Value)>,
    own: OwnStages,
}

impl Settings {
    /// The settings of a preset.
    pub fn new(preset: Preset) -> Self {
        Self::default().preset(preset)
    }

    /// The preset to start from.
    pub fn preset(mut self, preset: Preset) -> Self {
        self.preset = preset;
        self
    }

    /// A file of settings in TOML, as `crosscut run --config` takes it. Later files win.
    pub fn config_file(mut self, path: impl Into<PathBuf>) -> Self {
        self.files.push(path.into());
        self
    }

    /// An affinity of one's own, in place of the one that the settings choose. Its W may be dense: memory is admitted for
    /// that.
    pub fn affinity(mut self, stage: Box<dyn AffinityStage>) -> Self {
        self.own.affinity = Some(stage);
        self
    }

    /// A solver of one's own, in place of the one that the settings choose.
    pub fn spectral(mut self, stage: Box<dyn SpectralStage>) -> Self {
        self.own.spectral = Some(stage);
        self
    }

    /// A clustering of one's own, in place of the one that the settings choose.
    pub fn kmeans(mut self, stage: Box<dyn KmeansStage>) -> Self {
        self.own.kmeans = Some(stage);
        self
    }

    /// The vehicle's width, metres: narrower gaps are no openings.
    pub fn vehicle_width_m(self, width_m: f64) -> Self {
        self.set("vehicle.width_m", width_m)
    }

    /// Any other setting, `section.name`, as `crosscut config` lists them. What is set later wins.
    pub fn set(mut self, setting: &str, value: impl Into<Value>) -> Self {
        self.changes.push((setting.to_owned(), value.into()));
        self
    }

    /// The checked configuration, with the stages of `registry` to choose from.
    ///
    /// # Errors
    /// The first setting that there is not, or whose value is not allowed, or a file that cannot be read.
    pub fn config(&self, registry: &Registry) -> Result<Config, ConfigError> {
        let read = |path: &PathBuf| match std::fs::read_to_string(path) {
            Ok(text) => Layer::file(path, &text),
            Err(error) => Err(ConfigError::Unreadable { path: path.clone(), why: error.to_string() }),
        };
        let mut layers = vec![self.preset.into()];
        layers.extend(self.files.iter().map(read).collect::<Result<Vec<_>, _>>()?);
        layers.push(Layer::values("settings", &self.changes)?);
        Config::resolve(registry, &layers)
    }

    /// The method alone: an engine.
    ///
    /// # Errors
    /// As [`Settings::config`].
    pub fn engine(self) -> Result<Engine, ConfigError> {
        Ok(self.engine_and_config()?.0)
    }

    pub(crate) fn engine_and_config(self) -> Result<(Engine, Config), ConfigError> {
        let registry = Registry::standard();
        let config = self.config(&registry)?;
        Ok((Engine::of(self.own, &config, &registry, [1, 1]), config))
    }
}

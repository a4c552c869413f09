//! The settings of a program of one's own.

use std::path::PathBuf;

use crosscut_stage::{AffinityStage, KmeansStage, SpectralStage, Value};

use crate::engine::Stages;
use crate::{Config, ConfigError, Detector, Engine, Layer, Preset, Registry};

/// A preset with overrides, and stages of one's own. Values that are set win over those of files, which win over the preset.
#[derive(Default)]
pub struct Settings {
    preset: Preset,
    files: Vec<PathBuf>,
    /// By `section.name`.
    changes: Vec<(String, Value)>,
    affinity: Option<Box<dyn AffinityStage>>,
    spectral: Option<Box<dyn SpectralStage>>,
    kmeans: Option<Box<dyn KmeansStage>>,
}

impl Settings {
    /// Those of a preset.
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
        self.affinity = Some(stage);
        self
    }

    /// A solver of one's own, in place of the one that the settings choose.
    pub fn spectral(mut self, stage: Box<dyn SpectralStage>) -> Self {
        self.spectral = Some(stage);
        self
    }

    /// A clustering of one's own, in place of the one that the settings choose.
    pub fn kmeans(mut self, stage: Box<dyn KmeansStage>) -> Self {
        self.kmeans = Some(stage);
        self
    }

    /// The vehicle's width, metres: narrower gaps are no openings.
    pub fn vehicle_width_m(self, width_m: f64) -> Self {
        self.set("vehicle.width_m", width_m)
    }

    /// The vehicle's height, metres; of clouds alone.
    pub fn vehicle_height_m(self, height_m: f64) -> Self {
        self.set("vehicle.height_m", height_m)
    }

    /// The direction of the sensor's zero bearing in the body frame, anticlockwise.
    pub fn sensor_yaw_rad(self, yaw_rad: f64) -> Self {
        self.set("ingest.yaw_rad", yaw_rad)
    }

    /// Whether the sensor hangs upside down.
    pub fn sensor_upside_down(self, upside_down: bool) -> Self {
        self.set("ingest.upside_down", upside_down)
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
        let registry = Registry::standard();
        let config = self.config(&registry)?;
        Ok(self.engine_of(&config, &registry))
    }

    /// All of it: a scan in, its answer out.
    ///
    /// # Errors
    /// As [`Settings::config`].
    pub fn build(self) -> Result<Detector, ConfigError> {
        let registry = Registry::standard();
        let config = self.config(&registry)?;
        Ok(Detector::of(self.engine_of(&config, &registry), config))
    }

    fn engine_of(self, config: &Config, registry: &Registry) -> Engine {
        let mut stages = Stages::chosen(config, registry);
        stages.is_calibrated &= self.affinity.is_none() && self.spectral.is_none() && self.kmeans.is_none();
        if let Some(affinity) = self.affinity {
            (stages.affinity, stages.is_w_sparse) = (affinity, false);
        }
        stages.stays_sparse &= self.spectral.is_none();
        stages.finds_zeros_alone &= self.spectral.is_none();
        stages.spectral = self.spectral.unwrap_or(stages.spectral);
        stages.kmeans = self.kmeans.unwrap_or(stages.kmeans);
        Engine::of(stages, config, 1, 1)
    }
}

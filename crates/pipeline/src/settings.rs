//! The settings of a program of one's own.

use crosscut_flight::Flight;
use crosscut_report::VEHICLE_WIDTH_M;
use crosscut_sensor::Sensor;
use crosscut_stage::Value;

use crate::{Config, ConfigError, Engine, Layer, Preset, Registry};

/// A preset and what is to be different from it.
///
/// ```
/// use crosscut_pipeline::{Frame, LaserScan, Preset, Settings};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let settings = Settings::new(Preset::Default).vehicle_width_m(0.8).set("affinity.island_m", 1.5);
/// let (sensor, mut engine) = (settings.sensor()?, settings.engine()?);
///
/// let scan = LaserScan { angle_increment: 0.1, range_max: 30.0, ranges: vec![2.0; 62], ..LaserScan::default() };
/// let mut frame = Frame::default();
/// sensor.revolution(&scan, &mut frame.revolution, &mut frame.notes);
/// engine.process(&mut frame)?;
/// assert_eq!(frame.junction.junctions, 1);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Settings {
    preset: Preset,
    /// By `section.name`.
    changes: Vec<(String, Value)>,
}

impl Settings {
    /// Those of a preset.
    pub fn new(preset: Preset) -> Self {
        Self { preset, changes: Vec::new() }
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
    /// The first setting that there is not, or whose value is not allowed.
    pub fn config(&self, registry: &Registry) -> Result<Config, ConfigError> {
        Config::resolve(registry, &[self.preset.into(), Layer::values("settings", &self.changes)?])
    }

    /// The method, of the stages that ship.
    ///
    /// # Errors
    /// As [`Settings::config`].
    pub fn engine(&self) -> Result<Engine, ConfigError> {
        let registry = Registry::standard();
        Ok(Engine::new(&self.config(&registry)?, &registry))
    }

    /// The flight, which adds poses, places and the steady answer to frames in order, after the engine.
    ///
    /// # Errors
    /// As [`Settings::config`].
    pub fn flight(&self) -> Result<Flight, ConfigError> {
        let config = self.config(&Registry::standard())?;
        Ok(Flight::new(config.params("flight"), config.params("vehicle").get(VEHICLE_WIDTH_M)))
    }

    /// The sensor with its mounting.
    ///
    /// # Errors
    /// As [`Settings::config`].
    pub fn sensor(&self) -> Result<Sensor, ConfigError> {
        Ok(Sensor::new(self.config(&Registry::standard())?.params("ingest")))
    }
}

//! The door for a program of one's own.

use crosscut_messages::LaserScan;
use crosscut_sensor::Sensor;
use crosscut_stage::{Failure, Frame, Junction};

use crate::{Config, ConfigError, Engine, Registry, Settings};

/// Finds walls and openings in scans, one after the other, in the calling thread. No files, no threads; buffers are reused.
///
/// ```
/// use crosscut_detector::{Detector, LaserScan};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mut detector = Detector::builder().vehicle_width_m(0.8).set("report.island_m", 1.5).build()?;
///
/// let scan = LaserScan { angle_increment: 0.1, range_max: 30.0, ranges: vec![2.0; 62], ..LaserScan::default() };
/// assert_eq!(detector.detect(&scan)?.junctions, 1);
///
/// // Every matrix of the last scan stays in reach.
/// let frame = detector.frame();
/// assert_eq!(frame.affinity.weights.n(), 62);
/// assert!(frame.spectrum.eigenvalues[0].abs() < 1e-12);
/// # Ok(())
/// # }
/// ```
pub struct Detector {
    config: Config,
    sensor: Sensor,
    engine: Engine,
    frame: Frame,
    scans: u64,
}

impl Detector {
    /// Settings to choose, beginning with those of preset `default`; [`Settings::build`] makes the detector.
    pub fn builder() -> Settings {
        Settings::default()
    }

    /// The stages that `config` chose among those of `registry`.
    pub fn new(config: Config, registry: &Registry) -> Self {
        Self::of(Engine::new(&config, registry), config)
    }

    fn of(engine: Engine, config: Config) -> Self {
        Self { sensor: config.sensor(), engine, frame: Frame::default(), scans: 0, config }
    }

    /// The walls and openings that a scan shows.
    ///
    /// # Errors
    /// When a stage fails or panics. The next scan is as good as any.
    pub fn detect(&mut self, scan: &LaserScan) -> Result<&Junction, Failure> {
        self.detect_with(|sensor, frame| sensor.revolution(scan, &mut frame.revolution, &mut frame.notes))?;
        Ok(&self.frame.junction)
    }

    /// Fills the frame by the revolution that `write` writes into it, with its notes: for clouds
    /// ([`Sensor::cloud`]), and for scans of a vehicle that moves ([`Live`](crosscut_sensor::Live)).
    ///
    /// # Errors
    /// As [`Detector::detect`].
    pub fn detect_with(&mut self, write: impl FnOnce(&Sensor, &mut Frame)) -> Result<&mut Frame, Failure> {
        write(&self.sensor, &mut self.frame);
        self.frame.revolution.seq = self.scans;
        self.scans += 1;
        self.engine.process(&mut self.frame)?;
        Ok(&mut self.frame)
    }

    /// All that is known of the last scan: the revolution, W, L, the eigenvalues, U, the clusters, the answer, its notes.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The configuration, whose text is TOML.
    pub fn config(&self) -> &Config {
        &self.config
    }
}

impl Settings {
    /// All of it: a scan in, its answer out.
    ///
    /// # Errors
    /// As [`Settings::config`].
    pub fn build(self) -> Result<Detector, ConfigError> {
        let (engine, config) = self.engine_and_config()?;
        Ok(Detector::of(engine, config))
    }
}

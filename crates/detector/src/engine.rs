//! All stages of the method on one revolution.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use crosscut_report::Reporter;
use crosscut_stage::{
    AffinityStage, Eigenvalues, Failure, FailureCause, Frame, Kind, KmeansStage, SpectralStage, StageError, StageKind,
    Step,
};

use crate::{Config, Registry};

/// Runs the paper's Algorithm 1, and the report after it, on one revolution in the calling thread.
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use crosscut_detector::{Frame, Preset, Settings};
/// use crosscut_stage::Point;
///
/// let mut engine = Settings::new(Preset::Paper).engine()?;
///
/// // Two walls, 6 m apart: each a row of returns 20 cm apart.
/// let mut frame = Frame::default();
/// let rows = [-3.0, 3.0].into_iter().flat_map(|y| (0..20).map(move |i| Point::new(0.2 * f64::from(i), y, 0.0)));
/// frame.revolution.points_m.extend(rows);
///
/// engine.process(&mut frame)?;
/// assert_eq!(frame.junction.junctions, 2);
/// # Ok(())
/// # }
/// ```
pub struct Engine {
    weigh: Worker,
    decompose: Worker,
    cluster: Worker,
    report: Worker,
}

/// Stages of a program of one's own, in place of those that the configuration chose.
#[derive(Default)]
pub(crate) struct OwnStages {
    pub(crate) affinity: Option<Box<dyn AffinityStage>>,
    pub(crate) spectral: Option<Box<dyn SpectralStage>>,
    pub(crate) kmeans: Option<Box<dyn KmeansStage>>,
}

fn is_among<S: StageKind + ?Sized>(kind: &Kind<S>, kinds: &[Kind<S>]) -> bool {
    kinds.iter().any(|known| known.name == kind.name)
}

impl Engine {
    /// The stages that `config` chose.
    pub fn new(config: &Config, registry: &Registry) -> Self {
        Self::for_many(config, registry, 1, 1)
    }

    /// One of `workers` engines that share this many frames, and the memory that `config` allows.
    pub fn for_many(config: &Config, registry: &Registry, frames: usize, workers: usize) -> Self {
        Self::of(OwnStages::default(), config, registry, [frames, workers])
    }

    pub(crate) fn of(own: OwnStages, config: &Config, registry: &Registry, shared_by: [usize; 2]) -> Self {
        let (affinity, solver) = (config.kind(&registry.affinity), config.kind(&registry.spectral).properties);
        // W has few entries in a row if the affinity needs beams, or takes the whole cloud. A solver that stays sparse takes no
        // n×n matrix for such a W, and one that decomposes nothing takes none for any.
        let is_w_sparse =
            own.affinity.is_none() && (affinity.properties.needs_beams || affinity.properties.takes_cloud);
        let stays_sparse = solver.eigenvalues == Eigenvalues::Zeros || is_w_sparse && solver.stays_sparse;
        let has_matrices = own.spectral.is_some() || !stays_sparse;
        let shipped = Registry::standard();
        // Confidences were calibrated for the kinds that ship.
        let is_calibrated = own.affinity.is_none()
            && own.spectral.is_none()
            && own.kmeans.is_none()
            && is_among(affinity, &shipped.affinity)
            && is_among(config.kind(&registry.spectral), &shipped.spectral)
            && is_among(config.kind(&registry.kmeans), &shipped.kmeans);
        let mut affinity = own.affinity.unwrap_or_else(|| config.build(&registry.affinity));
        let mut spectral = own.spectral.unwrap_or_else(|| config.build(&registry.spectral));
        let mut kmeans = own.kmeans.unwrap_or_else(|| config.build(&registry.kmeans));
        let config_of_w = config.clone();
        let reporter = Reporter::new(config.params("report"), config.params("vehicle"));
        let mut reporter = if is_calibrated { reporter } else { reporter.without_confidence() };
        Self {
            weigh: Worker::new(Step::Affinity, move |f| {
                config_of_w.admit(f.revolution.len(), shared_by, is_w_sparse, has_matrices)?;
                affinity.affinity(&f.revolution, &mut f.affinity, &mut f.notes)
            }),
            decompose: Worker::new(Step::Spectral, move |f| {
                spectral.spectrum(&f.affinity, &mut f.spectrum, &mut f.notes)
            }),
            cluster: Worker::new(Step::Kmeans, move |f| kmeans.partition(&f.spectrum, &mut f.partition, &mut f.notes)),
            report: Worker::new(Step::Report, move |f| {
                let Frame { revolution, affinity, spectrum, partition, junction, notes, .. } = f;
                reporter.report(revolution, affinity, spectrum, partition, junction, notes)
            }),
        }
    }

    /// Fills every part of `frame` after its revolution, whatever they held before. What was noted of the revolution itself
    /// stays.
    ///
    /// # Errors
    /// When a stage returns an error or panics; the same failure is left in `frame.failure`.
    pub fn process(&mut self, frame: &mut Frame) -> Result<(), Failure> {
        frame.failure = None;
        frame.notes.begin_stages();
        // Line 1: the adjacency W_ij = exp(-σ ‖x_i - x_j‖²), equation (1).
        self.weigh.work(frame)?;
        // Lines 2 to 4: L = I - D^-1/2 W D^-1/2, equation (2); its eigenvalues ascending, equation (3); k zeros.
        self.decompose.work(frame)?;
        // Line 5: k-means++ on the rows of U, equation (4).
        self.cluster.work(frame)?;
        // "The number of junctions, which is equal to the number of walls", and the openings between them.
        self.report.work(frame)
    }

    /// Runs one step of [`Engine::process`] alone, for steps that run in processes of their own. `frame` holds what the
    /// steps before it gave; ingest does nothing here.
    ///
    /// # Errors
    /// When the stage returns an error or panics, or `frame` has failed before; the failure is in `frame.failure`.
    pub fn run_step(&mut self, step: Step, frame: &mut Frame) -> Result<(), Failure> {
        let worker = match step {
            Step::Ingest => return Ok(()),
            Step::Affinity => &mut self.weigh,
            Step::Spectral => &mut self.decompose,
            Step::Kmeans => &mut self.cluster,
            Step::Report => &mut self.report,
        };
        worker.work(frame)
    }
}

/// The steps of [`Engine::process`], in order, for threads of their own.
impl From<Engine> for [Worker; 4] {
    fn from(engine: Engine) -> Self {
        let Engine { weigh, decompose, cluster, report } = engine;
        [weigh, decompose, cluster, report]
    }
}

/// Reads and writes the parts of a frame that belong to a stage.
type Work = dyn FnMut(&mut Frame) -> Result<(), StageError> + Send;

/// A stage with the parts of a frame that it reads and writes.
pub struct Worker {
    step: Step,
    run: Box<Work>,
}

impl Worker {
    /// What `run` does, as the work of a step.
    pub fn new(step: Step, run: impl FnMut(&mut Frame) -> Result<(), StageError> + Send + 'static) -> Self {
        Self { step, run: Box::new(run) }
    }

    /// Which step it is.
    pub fn step(&self) -> Step {
        self.step
    }

    /// Runs the stage and times it. A failure, also a panic, is left in the frame. A frame that has failed before is not
    /// worked on.
    ///
    /// # Errors
    /// The failure in the frame.
    pub fn work(&mut self, frame: &mut Frame) -> Result<(), Failure> {
        if let Some(failure) = &frame.failure {
            return Err(failure.clone());
        }
        let (step, seq, start) = (self.step, frame.revolution.seq, Instant::now());
        let done = catch_unwind(AssertUnwindSafe(|| (self.run)(frame)));
        frame.timings.set_ns(step, elapsed_ns(start));
        let cause = match done {
            Ok(Ok(())) => return Ok(()),
            Ok(Err(error)) => FailureCause::Error(error.to_string()),
            Err(panic) => FailureCause::Panic(panic_text(panic.as_ref())),
        };
        Err(frame.failure.insert(Failure { step, seq, cause }).clone())
    }
}

/// The time since `start`, nanoseconds.
pub fn elapsed_ns(start: Instant) -> u64 {
    u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX)
}

/// The message of a caught panic.
pub fn panic_text(panic: &(dyn Any + Send)) -> String {
    let message = panic.downcast_ref::<&str>().map(ToString::to_string);
    message.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".to_owned())
}

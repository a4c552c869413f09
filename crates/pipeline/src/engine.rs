//! All steps of the method on one revolution.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use crosscut_report::Reporter;
use crosscut_stage::{
    AffinityStage, Failure, FailureCause, Frame, KmeansStage, ReportStage, SpectralStage, StageError, Step,
};

use crate::memory::MemoryBudget;
use crate::{Config, Registry};

/// Runs the paper's Algorithm 1, and the report after it, on one revolution in the calling thread.
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use crosscut_pipeline::{Config, Engine, Registry};
/// use crosscut_stage::{Frame, Point};
///
/// let registry = Registry::standard();
/// let mut engine = Engine::new(&Config::preset("paper", &registry)?, &registry);
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
    stages: [Stage; 4],
}

impl Engine {
    /// The stages that `config` chose, in the order of Algorithm 1.
    pub fn new(config: &Config, registry: &Registry) -> Self {
        Self::with_budget(config, registry, MemoryBudget::for_one(config))
    }

    pub(crate) fn with_budget(config: &Config, registry: &Registry, budget: MemoryBudget) -> Self {
        let report = Reporter::new(config.params("report"), config.params("vehicle"));
        Self {
            stages: [
                Stage::Affinity(config.build(&registry.affinity), budget),
                Stage::Spectral(config.build(&registry.spectral), budget),
                Stage::Kmeans(config.build(&registry.kmeans)),
                Stage::Report(Box::new(report)),
            ],
        }
    }

    /// Fills every part of `frame` after its revolution. Notes are added to those that are there: clear them before the
    /// next revolution.
    ///
    /// # Errors
    /// When a stage returns an error or panics; the same failure is left in `frame.failure`.
    pub fn process(&mut self, frame: &mut Frame) -> Result<(), Failure> {
        frame.failure = None;
        for stage in &mut self.stages {
            stage.work(frame);
        }
        frame.failure.clone().map_or(Ok(()), Err)
    }

    /// The stages one by one, in order, for workers that run them in threads of their own.
    pub(crate) fn into_stages(self) -> [Stage; 4] {
        self.stages
    }
}

/// One step of the method with what does it.
pub(crate) enum Stage {
    Affinity(Box<dyn AffinityStage>, MemoryBudget),
    Spectral(Box<dyn SpectralStage>, MemoryBudget),
    Kmeans(Box<dyn KmeansStage>),
    Report(Box<dyn ReportStage>),
}

impl Stage {
    pub(crate) fn step(&self) -> Step {
        match self {
            Self::Affinity(..) => Step::Affinity,
            Self::Spectral(..) => Step::Spectral,
            Self::Kmeans(_) => Step::Kmeans,
            Self::Report(_) => Step::Report,
        }
    }

    /// Algorithm 1, a line or two each.
    fn run(&mut self, frame: &mut Frame) -> Result<(), StageError> {
        let Frame { revolution, affinity, spectrum, partition, junction, notes, .. } = frame;
        match self {
            // Line 1: the adjacency W_ij = exp(-σ ‖x_i - x_j‖²), equation (1).
            Self::Affinity(stage, budget) => {
                budget.admit_affinity(stage.as_ref(), revolution.len())?;
                affinity.verdicts.clear(); // kinds that tell none need not know of them
                stage.affinity(revolution, affinity, notes)
            }
            // Lines 2 to 4: L = I - D^-1/2 W D^-1/2, equation (2); its eigenvalues ascending, equation (3); k zeros.
            Self::Spectral(stage, budget) => {
                budget.admit_spectral(stage.as_ref(), affinity)?;
                stage.spectrum(affinity, spectrum, notes)
            }
            // Line 5: k-means++ on the rows of U, equation (4).
            Self::Kmeans(stage) => stage.partition(spectrum, partition, notes),
            // "The number of junctions, which is equal to the number of walls", and the ways on between them.
            Self::Report(stage) => stage.report(revolution, spectrum, partition, junction, notes),
        }
    }

    /// Runs the step and times it. A failure, also a panic, goes into the frame; a frame that has failed passes by.
    pub(crate) fn work(&mut self, frame: &mut Frame) {
        if frame.failure.is_some() {
            return;
        }
        let (step, seq, start) = (self.step(), frame.revolution.seq, Instant::now());
        let cause = match catch_unwind(AssertUnwindSafe(|| self.run(frame))) {
            Ok(Ok(())) => None,
            Ok(Err(error)) => Some(FailureCause::Error(error.to_string())),
            Err(panic) => Some(FailureCause::Panic(panic_text(panic.as_ref()))),
        };
        frame.timings.set_ns(step, elapsed_ns(start));
        frame.failure = cause.map(|cause| Failure { step, seq, cause });
    }
}

pub(crate) fn elapsed_ns(start: Instant) -> u64 {
    u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX)
}

/// What a caught panic said.
pub(crate) fn panic_text(panic: &(dyn Any + Send)) -> String {
    let said = panic.downcast_ref::<&str>().map(ToString::to_string);
    said.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "it did not say why".to_owned())
}

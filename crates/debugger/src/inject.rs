//! Outputs of stages that are replaced.

use crosscut_detector::Engine;
use crosscut_stage::NoteCode::N100;
use crosscut_stage::{Failure, FailureCause, Frame, Step, Weights};
use faer::Mat;

/// Outputs of the stages of one revolution that are replaced; the later stages go on from them.
#[derive(Clone, Debug, Default)]
pub struct Injected {
    /// W, n×n. Stored as that of the affinity stage is. The verdicts stay those of the stage.
    pub w: Option<Mat<f64>>,
    /// U, n×k, whose number of columns becomes k.
    pub u: Option<Mat<f64>>,
    /// The cluster of each return; none if negative.
    pub labels: Option<Vec<i64>>,
}

impl Injected {
    /// Whether nothing is replaced.
    pub fn is_nothing(&self) -> bool {
        self.w.is_none() && self.u.is_none() && self.labels.is_none()
    }

    /// The names of what is replaced.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let is_there = [(self.w.is_some(), "W"), (self.u.is_some(), "U"), (self.labels.is_some(), "labels")];
        is_there.into_iter().filter_map(|(is_there, name)| is_there.then_some(name)).collect()
    }

    /// Runs the stages on `frame`, whose revolution is there and whose other parts are of any revolution.
    pub(crate) fn process(&self, engine: &mut Engine, frame: &mut Frame) -> Result<(), Failure> {
        if self.is_nothing() {
            return engine.process(frame);
        }
        frame.failure = None;
        frame.notes.begin_stages();
        self.affinity(engine, frame)?;
        self.spectrum(engine, frame)?;
        self.partition(engine, frame)?;
        engine.run_step(Step::Report, frame)
    }

    fn affinity(&self, engine: &mut Engine, frame: &mut Frame) -> Result<(), Failure> {
        let done = engine.run_step(Step::Affinity, frame);
        let Some(w) = &self.w else { return done };
        if done.is_err() {
            (frame.failure, frame.affinity) = (None, Default::default());
        }
        let n = frame.revolution.len();
        refuse_shape(frame, Step::Affinity, "W", [w.nrows(), w.ncols()], [n, n])?;
        match &mut frame.affinity.weights {
            Weights::Sparse(_) => {
                let sparse = frame.affinity.weights.make_sparse();
                for i in 0..n {
                    (0..n).filter(|&j| w[(i, j)] != 0.0).for_each(|j| sparse.push(j as u32, w[(i, j)]));
                    sparse.end_row();
                }
            }
            _ => frame.affinity.weights.make_dense(n).copy_from(w),
        }
        frame.affinity.sum_degrees();
        frame.notes.add(N100, "W was injected");
        Ok(())
    }

    fn spectrum(&self, engine: &mut Engine, frame: &mut Frame) -> Result<(), Failure> {
        let done = engine.run_step(Step::Spectral, frame);
        let Some(u) = &self.u else { return done };
        if done.is_err() {
            (frame.failure, frame.spectrum) = (None, Default::default());
        }
        let n = frame.revolution.len();
        refuse_shape(frame, Step::Spectral, "U", [u.nrows(), u.ncols()], [n, u.ncols()])?;
        frame.spectrum.u.clone_from(u);
        frame.spectrum.k = u.ncols();
        frame.notes.add(N100, "U was injected; its number of columns is k");
        Ok(())
    }

    fn partition(&self, engine: &mut Engine, frame: &mut Frame) -> Result<(), Failure> {
        let done = engine.run_step(Step::Kmeans, frame);
        let Some(labels) = &self.labels else { return done };
        frame.failure = None;
        let n = frame.revolution.len();
        refuse_shape(frame, Step::Kmeans, "labels", [labels.len(), 1], [n, 1])?;
        frame.partition.labels = labels.iter().map(|&label| u32::try_from(label).ok()).collect();
        let largest = frame.partition.labels.iter().flatten().max();
        frame.partition.clusters = largest.map_or(0, |&largest| largest as usize + 1);
        frame.notes.add(N100, "labels were injected");
        Ok(())
    }
}

/// Fails the frame where what is injected does not fit its revolution.
fn refuse_shape(frame: &mut Frame, step: Step, name: &str, has: [usize; 2], takes: [usize; 2]) -> Result<(), Failure> {
    if has == takes {
        return Ok(());
    }
    let ([rows, columns], [n, m]) = (has, takes);
    let cause = FailureCause::Error(format!("the injected {name} is {rows}x{columns}; {n}x{m} fits this revolution"));
    let failure = Failure { step, seq: frame.revolution.seq, cause };
    frame.failure = Some(failure.clone());
    Err(failure)
}

//! The traits at the joints of the pipeline.

use crate::{Affinity, Frame, Notes, Partition, Point, Revolution, Spectrum};

/// Why a stage cannot answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StageError {
    /// The decomposition did not converge.
    #[error("the eigendecomposition of the {n}x{n} Laplacian did not converge")]
    NoConvergence {
        /// Number of returns.
        n: usize,
    },
    /// A value that has to be finite is not.
    #[error("{what} is not finite at return {index}")]
    NotFinite {
        /// Which value.
        what: &'static str,
        /// At which return.
        index: usize,
    },
    /// The stage does not work on revolutions of this kind.
    #[error("{0}")]
    Unsupported(String),
    /// The stage would take more memory than is allowed: how much, and what to do.
    #[error("{0}")]
    TooLarge(String),
    /// Parts of the frame do not belong together.
    #[error("{0}")]
    Mismatch(String),
}

impl StageError {
    /// The error of an affinity of this name, which needs beams, for points without any.
    #[must_use]
    pub fn without_beams(affinity: &str) -> Self {
        Self::Unsupported(format!(
            "affinity `{affinity}` needs the beams of a sweep, and these points have none: Sensor::cloud makes a sweep of \
             the points of a cloud"
        ))
    }
}

/// First stage: the weighted graph over the returns.
pub trait AffinityStage: Send {
    /// Writes W of `revolution`, whose points are finite, into `out.weights`, whatever that held before, and its verdicts,
    /// if it makes any, into the empty `out.verdicts`. A row is a return, or a direction of `out.dual`, which is `None` before. `affinity` calls it and does the rest,
    /// for every kind alike.
    ///
    /// n = 0 gives an empty W. The result depends on nothing but `revolution` and the stage's parameters.
    ///
    /// # Errors
    /// When no graph can be made of the returns.
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, notes: &mut Notes) -> Result<(), StageError>;
}

/// What is done for every kind alike; no kind can override it.
impl dyn AffinityStage + '_ {
    /// Writes W and D of `revolution` into `out`, whatever `out` held before.
    ///
    /// # Errors
    /// When a point is not finite, no graph can be made of the returns, or W has not a row for each return, or direction.
    pub fn affinity(
        &mut self,
        revolution: &Revolution,
        out: &mut Affinity,
        notes: &mut Notes,
    ) -> Result<(), StageError> {
        let not_finite = |points_m: &Vec<Point>| points_m.iter().position(|p| !p.iter().all(|x| x.is_finite()));
        if let Some(index) = [&revolution.points_m, &revolution.cloud_m].into_iter().find_map(not_finite) {
            return Err(StageError::NotFinite { what: "the point", index });
        }
        out.verdicts.clear();
        out.holds_for_width_m = None;
        out.dual = None;
        self.weigh(revolution, out, notes)?;
        out.sum_degrees();
        let (n, what) = match &out.dual {
            Some(dual) => (dual.rows().count(), "directions"),
            None => (revolution.len(), "returns"),
        };
        match out.degrees.len() {
            rows if rows == n => Ok(()),
            rows => Err(StageError::Mismatch(format!("W has {rows} rows for {n} {what}"))),
        }
    }
}

/// Second stage: eigenvalues of the Laplacian, how many are zero, and their eigenvectors.
pub trait SpectralStage: Send {
    /// Writes λ, k, margin and U into `out`, whatever `out` held before.
    ///
    /// # Errors
    /// When the decomposition fails.
    fn spectrum(&mut self, affinity: &Affinity, out: &mut Spectrum, notes: &mut Notes) -> Result<(), StageError>;
}

/// Third stage: the clusters of the rows of U.
pub trait KmeansStage: Send {
    /// Writes a cluster for each return into `out`, whatever `out` held before; clusters are numbered by their first
    /// return. Randomness restarts from the configured seed at every call.
    ///
    /// # Errors
    /// When the rows of U cannot be clustered.
    fn partition(&mut self, spectrum: &Spectrum, out: &mut Partition, notes: &mut Notes) -> Result<(), StageError>;
}

/// Where revolutions come from: a recording, a simulator, a live sensor.
pub trait Source: Send {
    /// Writes the next revolution into `out`, whatever `out` held before; `false` at the end.
    ///
    /// # Errors
    /// When nothing more can be read. What was read before stays valid.
    fn next(&mut self, out: &mut Revolution, notes: &mut Notes) -> Result<bool, SourceError>;
}

/// Why a source ended early: what was wrong, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct SourceError(pub String);

/// Sees every finished frame, in order, on a thread of its own, after the results were written.
///
/// If a stage fails, its frame comes last. Its `revolution`, `notes` and `failure` are valid; the parts that the failed
/// stage and those after it fill may be of an earlier revolution.
pub trait Observer: Send {
    /// Looks at one frame.
    ///
    /// # Errors
    /// When the observer can do no more. It then sees no further frame; the run continues.
    fn observe(&mut self, frame: &Frame) -> Result<(), ObserverError>;

    /// Called once, after the last frame.
    ///
    /// # Errors
    /// When what was observed could not be completed.
    fn finish(&mut self) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// Why an observer gave up: what was wrong, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ObserverError(pub String);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Point, Verdict};

    /// Writes W = 1 over as many rows as it has, and a verdict.
    struct AllOnes(usize);

    impl AffinityStage for AllOnes {
        fn weigh(&mut self, _: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
            out.weights.make_dense(self.0).fill(1.0);
            out.verdicts.push(Verdict {
                returns: [0, 1],
                is_opening: true,
                room_ratio: 1.0,
                p: None,
                reason: "",
                measured: None,
            });
            Ok(())
        }
    }

    fn affinity(rows: usize, revolution: &Revolution, out: &mut Affinity) -> Result<(), StageError> {
        let stage: &mut dyn AffinityStage = &mut AllOnes(rows);
        stage.affinity(revolution, out, &mut Notes::default())
    }

    #[test]
    fn a_point_that_is_not_finite_is_refused_by_its_index() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for (index, axis) in [(0, 0), (1, 1), (2, 2)] {
                let mut revolution = Revolution { points_m: vec![Point::origin(); 3], ..Revolution::default() };
                revolution.points_m[index][axis] = bad;
                let refused = affinity(3, &revolution, &mut Affinity::default());
                assert_eq!(refused, Err(StageError::NotFinite { what: "the point", index }));
            }
        }
    }

    #[test]
    fn degrees_are_summed_and_nothing_is_left_of_an_earlier_revolution() {
        let revolution = Revolution { points_m: vec![Point::origin(); 3], ..Revolution::default() };
        let mut out = Affinity { degrees: vec![7.0; 5], ..Affinity::default() };
        for _ in 0..2 {
            affinity(3, &revolution, &mut out).expect("three rows for three returns");
            assert_eq!((&out.degrees[..], out.verdicts.len()), (&[3.0; 3][..], 1));
        }
        let refused = affinity(2, &revolution, &mut out);
        assert_eq!(refused, Err(StageError::Mismatch("W has 2 rows for 3 returns".to_owned())));
    }
}

//! The share of right answers by zero tolerance, from one eigendecomposition per scene.
//!
//! k at a tolerance τ is the number of eigenvalues below τ. An answer can be right only if k is the true number of walls,
//! and U then does not depend on which τ gave that k. So the returns of a scene are clustered once, for that k, and the
//! verdict holds at every such τ. This is exact: the counts are those of the preset `paper` with
//! `spectral.zero_tolerance` set to τ.

use crosscut_detector::{Preset, Registry, Settings};
use crosscut_evaluate::{Proportion, Score};
use crosscut_report::{Reporter, ResultsLine};
use crosscut_sensor::Sensor;
use crosscut_simulator::{Scene, Split, suites};
use crosscut_stage::{AffinityStage, Frame, KmeansStage, SpectralStage};

/// The tolerances are the powers of ten with these exponents.
pub(crate) const EXPONENTS: [i32; 16] = [-16, -15, -14, -13, -12, -11, -10, -9, -8, -7, -6, -5, -4, -3, -2, -1];

/// The shares of right answers of one family at each tolerance.
#[derive(Clone)]
pub(crate) struct ToleranceShares {
    pub(crate) name: &'static str,
    pub(crate) right_count: [Proportion; EXPONENTS.len()],
    pub(crate) right: [Proportion; EXPONENTS.len()],
}

/// Counts the first `scenes` development scenes of every family, on which the tolerance of the preset was chosen.
pub(crate) fn families(scenes: usize, registry: &Registry) -> anyhow::Result<Vec<ToleranceShares>> {
    let mut method = Method::new(registry)?;
    let nothing = [Proportion::default(); EXPONENTS.len()];
    let mut families = Vec::new();
    for suite in suites() {
        let mut family = ToleranceShares { name: suite.name, right_count: nothing, right: nothing };
        for scene in suite.scenes(Split::Dev).take(scenes) {
            let (right_counts, walls_right) = method.judge(&scene)?;
            for (at, &right_count) in right_counts.iter().enumerate() {
                family.right_count[at].count(right_count);
                family.right[at].count(right_count && walls_right);
            }
        }
        families.push(family);
    }
    Ok(families)
}

/// The preset `paper`, step by step.
struct Method {
    sensor: Sensor,
    affinity: Box<dyn AffinityStage>,
    spectral: Box<dyn SpectralStage>,
    kmeans: Box<dyn KmeansStage>,
    report: Reporter,
    frame: Frame,
}

impl Method {
    fn new(registry: &Registry) -> anyhow::Result<Self> {
        // The eigenvalues of an L whose W has ones on its diagonal are below 2: every one counts as zero, and U holds
        // all eigenvectors.
        let settings = Settings::new(Preset::Paper).set("spectral.kind", "faer").set("spectral.zero_tolerance", 2.0);
        let config = settings.config(registry)?;
        Ok(Self {
            sensor: config.sensor(),
            affinity: config.build(&registry.affinity),
            spectral: config.build(&registry.spectral),
            kmeans: config.build(&registry.kmeans),
            report: Reporter::new(config.params("report"), config.params("vehicle")),
            frame: Frame::default(),
        })
    }

    /// Whether the count is right at each tolerance, and whether the walls are right where it is.
    fn judge(&mut self, scene: &Scene) -> anyhow::Result<([bool; EXPONENTS.len()], bool)> {
        let Frame { revolution, affinity, spectrum, partition, junction, notes, .. } = &mut self.frame;
        notes.clear();
        self.sensor.revolution(&scene.scan, revolution, notes);
        self.affinity.affinity(revolution, affinity, notes)?;
        self.spectral.spectrum(affinity, spectrum, notes)?;
        let walls = scene.truth.walls as usize;
        let zeros = |tolerance: f64| spectrum.eigenvalues.partition_point(|&eigenvalue| eigenvalue < tolerance);
        let right_counts = EXPONENTS.map(|exponent| zeros(10_f64.powi(exponent)) == walls);
        if !right_counts.contains(&true) {
            return Ok((right_counts, false));
        }
        spectrum.k = walls;
        spectrum.u = spectrum.u.subcols(0, walls).to_owned();
        self.kmeans.partition(spectrum, partition, notes)?;
        self.report.report(revolution, &affinity.verdicts, spectrum, partition, junction, notes)?;
        Ok((right_counts, Score::of(&scene.truth, &ResultsLine::of(&self.frame))?.right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_decomposition_agrees_with_a_run_at_every_tolerance() {
        let registry = Registry::standard();
        let mut method = Method::new(&registry).expect("a preset");
        let (mut right, mut wrong) = (0, 0);
        for suite in suites().iter().filter(|suite| ["clean35", "narrow", "pillars"].contains(&suite.name)) {
            for scene in suite.scenes(Split::Dev).take(3) {
                let (right_counts, walls_right) = method.judge(&scene).expect("it answers");
                for (exponent, right_count) in EXPONENTS.into_iter().zip(right_counts).skip(2) {
                    let settings = Settings::new(Preset::Paper).set("spectral.zero_tolerance", 10_f64.powi(exponent));
                    let mut detector = settings.build().expect("allowed");
                    detector.detect(&scene.scan).expect("it answers");
                    let score = Score::of(&scene.truth, &ResultsLine::of(detector.frame())).expect("the same scan");
                    let verdict = (score.right_count(), score.right);
                    assert_eq!((right_count, right_count && walls_right), verdict, "{}, 1e{exponent}", suite.name);
                    *if score.right { &mut right } else { &mut wrong } += 1;
                }
            }
        }
        assert!(right > 0 && wrong > 0, "{right} right, {wrong} wrong: both are compared");
    }
}

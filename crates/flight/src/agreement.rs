//! Odometry against scans, over metres: one of them may lie.
//!
//! Two poses that are matched to walls are each off by what roughness, noise and the walls remembered allow, however far
//! apart they are; the error of the odometry grows with the way. Over the last steps they differ by d, of which the
//! variance is the sum of all three:
//!
//! ```text
//! Σ = P_odometry + 2 M,   a slip or a jump: dᵀ Σ⁻¹ d > 6²
//! ```

use std::collections::VecDeque;

use nalgebra::{Isometry2, Vector2, Vector3};

use crate::Motion;

/// The two are compared each time one of them has moved this far.
const COMPARED_M: f64 = 3.0;

/// They contradict each other if they end up farther apart than this share of that.
const APART_SHARE: f64 = 0.2;

/// The error of the odometry is what was set until this many comparisons were made.
const FIRST_COMPARISONS: f64 = 2.0;

/// What is taken to be its error at most, as a share: scans may be wrong as well.
const MOST_SHARE: f64 = 0.3;

/// What a comparison counts for after another one.
const KEPT: f64 = 0.8;

/// Odometry and scans that differ by this many standard deviations show a slip or a jump.
const SURPRISING: f64 = 6.0;

/// A slip is looked for over the last steps whose way is at most this.
const SLIP_M: f64 = 2.5;

/// A slip is looked for over at most this many steps: a vehicle that stands makes no way.
const SLIP_STEPS: usize = 30;

/// Worst-case error of the position of a matched pose (M, standard deviation): between rough walls the cost has side minima
/// along the passage.
const MATCHED_M: f64 = 0.05;

/// Worst-case error of the heading of a matched pose (M, standard deviation).
const MATCHED_RAD: f64 = 0.01;

/// Compares the motions that odometry and scans show between the same revolutions.
#[derive(Clone, Debug, Default)]
pub(crate) struct OdometryAgreement {
    /// The last steps, the latest first.
    steps: VecDeque<Steps>,
    /// Odometry less scans, in the frame of each step's beginning.
    apart_m: Vector2<f64>,
    odometry_m: f64,
    scans_m: f64,
    contradicts: bool,
    /// Over all comparisons, each [`KEPT`] times what the next one counts for: the squares of what the two were apart by, as a
    /// share, and the number of comparisons.
    squares: f64,
    comparisons: f64,
}

/// The steps of both from one revolution to the next.
#[derive(Clone, Copy, Debug)]
struct Steps {
    /// x, y and yaw of the scans' less those of the odometry's.
    apart: Vector3<f64>,
    /// How far each moved, metres, and turned, radians anticlockwise.
    odometry: [f64; 2],
    scans: [f64; 2],
    /// Of the odometry's.
    variances: Vector3<f64>,
}

/// A motion of the odometry that the scans do not show, or the other way round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slip {
    /// How far each moved, metres, and turned, radians anticlockwise.
    pub(crate) odometry: [f64; 2],
    pub(crate) scans: [f64; 2],
    /// How far they lie apart, in standard deviations of the two together.
    pub(crate) deviations: f64,
}

/// What a comparison shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Compared {
    pub(crate) odometry_m: f64,
    pub(crate) scans_m: f64,
    pub(crate) contradicts: bool,
    /// It did not before.
    pub(crate) is_new: bool,
}

impl OdometryAgreement {
    /// Adds the steps of both from one revolution to the next. What they show once they have moved far enough.
    pub(crate) fn add(&mut self, odometry: &Isometry2<f64>, scans: &Isometry2<f64>) -> Option<Compared> {
        self.apart_m += odometry.translation.vector - scans.translation.vector;
        self.odometry_m += odometry.translation.vector.norm();
        self.scans_m += scans.translation.vector.norm();
        let way_m = self.odometry_m.max(self.scans_m);
        if way_m < COMPARED_M {
            return None;
        }
        let apart = self.apart_m.norm() / way_m;
        let contradicts = apart > APART_SHARE;
        let compared = Compared {
            odometry_m: self.odometry_m,
            scans_m: self.scans_m,
            contradicts,
            is_new: contradicts != self.contradicts,
        };
        let squares = KEPT * self.squares + apart.min(MOST_SHARE).powi(2);
        let comparisons = KEPT * self.comparisons + 1.0;
        let steps = std::mem::take(&mut self.steps);
        *self = Self { steps, contradicts, squares, comparisons, ..Self::default() };
        Some(compared)
    }

    /// Adds the steps of both from one revolution to the next. A slip or a jump in the last of them, over whatever way it shows
    /// best; each is found once.
    pub(crate) fn slip(&mut self, odometry: &Motion, scans: &Isometry2<f64>, set: f64) -> Option<Slip> {
        let apart = scans.translation.vector - odometry.step.translation.vector;
        self.steps.push_front(Steps {
            apart: apart.push(odometry.step.rotation.angle_to(&scans.rotation)),
            odometry: [odometry.step.translation.vector.norm(), odometry.step.rotation.angle()],
            scans: [scans.translation.vector.norm(), scans.rotation.angle()],
            variances: odometry.covariance.diagonal(),
        });
        self.steps.truncate(SLIP_STEPS);
        let (share, matched) = (self.share(set), Vector3::new(MATCHED_M, MATCHED_M, MATCHED_RAD));
        let (mut apart, mut variances) = (Vector3::zeros(), matched.component_mul(&matched) * 2.0);
        let mut slip = Slip { odometry: [0.0; 2], scans: [0.0; 2], deviations: 0.0 };
        let mut turned_rad = 0.0;
        for step in &self.steps {
            apart += step.apart;
            variances += step.variances;
            turned_rad += step.odometry[1].abs();
            for at in 0..2 {
                slip.odometry[at] += step.odometry[at];
                slip.scans[at] += step.scans[at];
            }
            if slip.odometry[0].max(slip.scans[0]) > SLIP_M {
                break;
            }
            // What is wrong with the odometry's scale is wrong with it in each step.
            let lasting = Vector3::new(slip.odometry[0], slip.odometry[0], turned_rad) * share;
            let variances = variances + lasting.component_mul(&lasting);
            slip.deviations = apart.component_mul(&apart).component_div(&variances).sum().sqrt();
            if slip.deviations > SURPRISING {
                self.steps.clear();
                return Some(slip);
            }
        }
        None
    }

    /// The steps that follow do not go with those before.
    pub(crate) fn interrupt(&mut self) {
        self.steps.clear();
    }

    /// Whether the odometry contradicted the scans when the two were compared last.
    pub(crate) fn contradicts(&self) -> bool {
        self.contradicts
    }

    /// The error of the odometry as a share of its motion: what was `set`, until comparisons show it.
    pub(crate) fn share(&self, set: f64) -> f64 {
        let squares = FIRST_COMPARISONS * set * set + self.squares;
        (squares / (FIRST_COMPARISONS + self.comparisons)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    fn compare(agreement: &mut OdometryAgreement, odometry_m: f64, scans_m: f64) -> Vec<Compared> {
        let [odometry, scans] = [odometry_m, scans_m].map(|step_m| Isometry2::translation(step_m, 0.0));
        (0..100).filter_map(|_| agreement.add(&odometry, &scans)).collect()
    }

    #[test]
    fn odometry_that_stands_still_contradicts_scans_that_move_and_is_believed_again() {
        let mut agreement = OdometryAgreement::default();
        let compared = compare(&mut agreement, 0.0, 0.1);
        assert!(compared.len() == 3 && compared.iter().all(|compared| compared.contradicts), "{compared:?}");
        assert!(compared[0].is_new && !compared[1].is_new && agreement.contradicts());
        assert!(compared[0].odometry_m == 0.0 && (compared[0].scans_m - 3.0).abs() < 0.11);
        assert!(compare(&mut agreement, 0.1, 0.1).iter().any(|compared| compared.is_new && !compared.contradicts));
    }

    /// The steps, of 100 of 0.1 m each, at which a slip is found where the odometry moves by more than the scans in some.
    fn slips(excess_m: impl Fn(i32) -> f64) -> Vec<i32> {
        let mut agreement = OdometryAgreement::default();
        let covariance = Matrix3::from_diagonal_element(0.01 * 0.01);
        let scans = Isometry2::translation(0.1, 0.0);
        let slip = |at: &i32| {
            let odometry = Motion { step: Isometry2::translation(0.1 + excess_m(*at), 0.0), covariance };
            agreement.slip(&odometry, &scans, 0.05).is_some()
        };
        (0..100).filter(slip).collect()
    }

    #[test]
    fn wheels_that_slip_are_found_once_and_poses_that_tremble_never() {
        let spin = slips(|at| if (50..54).contains(&at) { 0.2 } else { 0.0 });
        assert!(matches!(spin[..], [at] if (52..54).contains(&at)), "{spin:?}");
        assert_eq!(slips(|at| if at == 50 { 0.6 } else { 0.0 }), [50], "a jump");
        assert!(slips(|at| if at % 2 == 0 { 0.2 } else { -0.2 }).is_empty());
        assert!(slips(|_| 0.01).is_empty(), "a scale that is a tenth too long");
    }

    #[test]
    fn the_share_of_an_exact_odometry_falls_and_that_of_a_long_one_is_its_own() {
        let mut exact = OdometryAgreement::default();
        compare(&mut exact, 0.1, 0.1);
        assert!(exact.share(0.05) < 0.04, "{}", exact.share(0.05));
        let mut long = OdometryAgreement::default();
        (0..10).for_each(|_| drop(compare(&mut long, 0.11, 0.1)));
        assert!((long.share(0.05) - 0.09).abs() < 0.01, "{}", long.share(0.05));
    }
}

//! Odometry against scans, over metres: one of them may lie.

use nalgebra::{Isometry2, Vector2};

/// The two are compared each time one of them has moved this far.
const COMPARED_M: f64 = 3.0;

/// They contradict each other if they end up farther apart than this share of that.
const APART_SHARE: f64 = 0.3;

/// The error of the odometry is what was set until this many comparisons were made.
const FIRST_COMPARISONS: f64 = 2.0;

/// Compares the motions that odometry and scans show between the same revolutions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Agreement {
    /// Odometry less scans, in the frame of each step's beginning.
    apart_m: Vector2<f64>,
    odometry_m: f64,
    scans_m: f64,
    contradicts: bool,
    /// The squares of what the two were apart by, as a share, where they agreed, and their number.
    squares: f64,
    comparisons: f64,
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

impl Agreement {
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
        let (squares, comparisons) = match contradicts {
            true => (self.squares, self.comparisons),
            false => (self.squares + apart * apart, self.comparisons + 1.0),
        };
        *self = Self { contradicts, squares, comparisons, ..Self::default() };
        Some(compared)
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
    use super::*;

    fn compare(agreement: &mut Agreement, odometry_m: f64, scans_m: f64) -> Vec<Compared> {
        let [odometry, scans] = [odometry_m, scans_m].map(|step_m| Isometry2::translation(step_m, 0.0));
        (0..100).filter_map(|_| agreement.add(&odometry, &scans)).collect()
    }

    #[test]
    fn odometry_that_stands_still_contradicts_scans_that_move_and_is_believed_again() {
        let mut agreement = Agreement::default();
        let compared = compare(&mut agreement, 0.0, 0.1);
        assert!(compared.len() == 3 && compared.iter().all(|compared| compared.contradicts), "{compared:?}");
        assert!(compared[0].is_new && !compared[1].is_new && agreement.contradicts());
        assert!(compared[0].odometry_m == 0.0 && (compared[0].scans_m - 3.0).abs() < 0.11);
        assert!(compare(&mut agreement, 0.1, 0.1).iter().any(|compared| compared.is_new && !compared.contradicts));
    }

    #[test]
    fn the_share_of_an_exact_odometry_falls_and_that_of_a_long_one_is_its_own() {
        let mut exact = Agreement::default();
        compare(&mut exact, 0.1, 0.1);
        assert!(exact.share(0.05) < 0.04, "{}", exact.share(0.05));
        let mut long = Agreement::default();
        (0..10).for_each(|_| drop(compare(&mut long, 0.11, 0.1)));
        assert!((long.share(0.05) - 0.09).abs() < 0.01, "{}", long.share(0.05));
    }
}

//! How far a tracked pose may be off.

use nalgebra::{Matrix2, Point2, Vector2};

/// A motion that nothing measured is a guess. Beyond this standard deviation of all guesses together, metres, a position
/// is not known.
const GUESSED_M: f64 = 2.0;

/// What a tracked pose may be off by since its stretch began. It adds up from motion to motion, so that the doubt of a part
/// of the flight is a difference ([`PoseDoubt::since`]). Positions are those of the tracked poses, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseDoubt {
    /// Number of the stretch. How the poses of two stretches lie to each other is not known.
    pub stretch: u32,
    independent_m2: Matrix2<f64>,
    lasting_m: Vector2<f64>,
    guessed_m: f64,
    /// Σ r, Σ r x and Σ r x xᵀ over errors of heading with variance r at positions x.
    turn_rad2: f64,
    turn_m: Vector2<f64>,
    turn_m2: Matrix2<f64>,
}

/// What one motion adds to the doubt, in the axes of the tracked poses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionDoubt {
    /// Covariance of errors that are independent from motion to motion, m².
    pub independent_m2: Matrix2<f64>,
    /// Standard deviation of an error that is the same share of every motion, along its direction, metres.
    pub lasting_m: Vector2<f64>,
    /// Standard deviation where nothing was measured, metres.
    pub guessed_m: f64,
    /// Variance of the heading, rad².
    pub turn_rad2: f64,
}

impl PoseDoubt {
    /// At the beginning of a stretch.
    pub fn of_stretch(stretch: u32) -> Self {
        Self { stretch, ..Self::default() }
    }

    /// Adds a motion that ended at a position.
    pub fn add(&mut self, motion: &MotionDoubt, end: Point2<f64>) {
        self.independent_m2 += motion.independent_m2;
        self.lasting_m += motion.lasting_m;
        self.guessed_m += motion.guessed_m;
        self.turn_rad2 += motion.turn_rad2;
        self.turn_m += motion.turn_rad2 * end.coords;
        self.turn_m2 += motion.turn_rad2 * end.coords * end.coords.transpose();
    }

    /// What was guessed since an earlier time of the same stretch is measured now: returns whether something was.
    pub fn measured(&mut self, since: &Self) -> bool {
        let is_guess = self.stretch == since.stretch && self.guessed_m > since.guessed_m;
        if is_guess {
            self.guessed_m = since.guessed_m;
        }
        is_guess
    }

    /// What was added since an earlier time; `None` if another stretch began in between.
    pub fn since(&self, earlier: &Self) -> Option<Self> {
        (self.stretch == earlier.stretch).then(|| Self {
            stretch: self.stretch,
            independent_m2: self.independent_m2 - earlier.independent_m2,
            lasting_m: self.lasting_m - earlier.lasting_m,
            guessed_m: self.guessed_m - earlier.guessed_m,
            turn_rad2: self.turn_rad2 - earlier.turn_rad2,
            turn_m: self.turn_m - earlier.turn_m,
            turn_m2: self.turn_m2 - earlier.turn_m2,
        })
    }

    /// Covariance of the position `end` that was reached, m²; `None` if it is not known.
    ///
    /// An error of heading δ at x moves the end e by δ J (e - x) with J a quarter turn: Σ r J (e - x)(e - x)ᵀ Jᵀ.
    pub fn covariance_m2(&self, end: Point2<f64>) -> Option<Matrix2<f64>> {
        let e = end.coords;
        let arms = self.turn_m2 - self.turn_m * e.transpose() - e * self.turn_m.transpose()
            + self.turn_rad2 * e * e.transpose();
        let by_turns = Matrix2::new(arms[(1, 1)], -arms[(0, 1)], -arms[(0, 1)], arms[(0, 0)]);
        let lasting = self.lasting_m * self.lasting_m.transpose();
        let guessed = Matrix2::identity() * self.guessed_m * self.guessed_m;
        (self.guessed_m <= GUESSED_M).then(|| self.independent_m2 + lasting + guessed + by_turns)
    }

    /// Variance of the heading, rad².
    pub fn heading_rad2(&self) -> f64 {
        self.turn_rad2
    }

    /// As [`PoseDoubt::sd_m`], from the first pose of the flight; `None` in later stretches.
    pub fn from_start_sd_m(&self, end: Point2<f64>) -> Option<f64> {
        self.sd_m(end).filter(|_| self.stretch == 0)
    }

    /// Standard deviation of the position `end` in the direction in which it is known least, metres; `None` if it is not
    /// known.
    pub fn sd_m(&self, end: Point2<f64>) -> Option<f64> {
        let variance_m2 = self.covariance_m2(end)?.symmetric_eigenvalues().max();
        Some(variance_m2.max(0.0).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 100 motions of 1 m along x, each with an error of heading of 0.01 rad.
    fn ahead(motion: &MotionDoubt) -> [PoseDoubt; 2] {
        let (mut doubt, mut half) = (PoseDoubt::default(), PoseDoubt::default());
        for step in 0..100 {
            if step == 50 {
                half = doubt;
            }
            doubt.add(motion, Point2::new(f64::from(step), 3.0));
        }
        [half, doubt]
    }

    #[test]
    fn errors_of_heading_grow_across_the_way_as_independent_ones_do() {
        let [half, doubt] = ahead(&MotionDoubt { turn_rad2: 1e-4, ..MotionDoubt::default() });
        let covariance = doubt.covariance_m2(Point2::new(99.0, 3.0)).expect("known");
        let expected: f64 = (0..100).map(|step| 1e-4 * f64::from(99 - step).powi(2)).sum();
        assert!((covariance[(1, 1)] - expected).abs() < 1e-9 && covariance[(0, 0)].abs() < 1e-9, "{covariance}");
        let second = doubt.since(&half).and_then(|since| since.sd_m(Point2::new(99.0, 3.0))).expect("known");
        let expected: f64 = (50..100).map(|step| 1e-4 * f64::from(99 - step).powi(2)).sum();
        assert!((second * second - expected).abs() < 1e-9, "{second}");
    }

    #[test]
    fn a_lasting_error_grows_with_the_way_and_is_gone_on_the_way_back() {
        let lasting = |x_m: f64| MotionDoubt { lasting_m: Vector2::new(x_m, 0.0), ..MotionDoubt::default() };
        let [_, mut doubt] = ahead(&lasting(0.05));
        let end = Point2::new(99.0, 3.0);
        assert!((doubt.sd_m(end).expect("known") - 5.0).abs() < 1e-9);
        (0..100).for_each(|_| doubt.add(&lasting(-0.05), end));
        assert!(doubt.sd_m(end).expect("known") < 1e-6);
    }

    #[test]
    fn what_is_guessed_for_long_is_not_known_and_no_stretch_is_known_to_another() {
        let [half, doubt] = ahead(&MotionDoubt { guessed_m: 0.03, ..MotionDoubt::default() });
        let end = Point2::new(99.0, 3.0);
        assert_eq!(doubt.sd_m(end), None);
        assert!(doubt.since(&half).expect("one stretch").sd_m(end).is_some());
        assert_eq!(doubt.since(&PoseDoubt::of_stretch(1)), None);
    }
}

//! A place that a visit may be to.

use nalgebra::Isometry2;

use crosscut_stage::wrap_angle_rad;

use super::outline::Fit;

/// Two anchors of one place are at most max(2.5 m, 0.75 looks) + 3 standard deviations of the pose apart.
pub(super) const ANCHORS_M: f64 = 2.5;

/// The directions of the ways of one place agree to within this.
pub(super) const WAYS_APART_RAD: f64 = 0.6;

/// Two fits on one node whose positions differ by less are the same.
const SAME_M: f64 = 1.5;

/// Two fits on one node whose headings differ by less are the same.
const SAME_RAD: f64 = 0.4;

/// Log odds that two visits are to one place: so much more for each share that their outlines lie on each other more, from
/// this share on.
const OF_SHARE: f64 = 20.0;
const EVEN_SHARE: f64 = 0.72;

/// Where a known passage ends, whose length the vehicle has flown, its place is expected: so much more.
const OF_EXPECTED: f64 = 3.4;

/// Where poses are known worse than to this standard deviation, others than the known places are as rare.
const MOST_SD_M: f64 = 1.5;

/// Walls show where an anchor is to within this, standard deviation.
const FIT_M: f64 = 0.3;

/// A visit is to a place from these log odds on, if each other place has so much less.
const LEAST_ODDS: f64 = -1.5;
const LEAST_LEAD: f64 = 1.6;

/// A place that a visit may be to.
pub(super) struct Candidate {
    pub(super) node: usize,
    pub(super) fit: Fit,
    pub(super) odds: f64,
}

/// A place, and the share of the runner-up.
pub(super) type Best = (Candidate, Option<f64>);

/// The best of these places, and whether its lead is clear.
pub(super) fn best(mut candidates: Vec<Candidate>) -> Option<(Best, bool)> {
    candidates.sort_by(|a, b| b.odds.total_cmp(&a.odds));
    let mut candidates = candidates.into_iter();
    let best = candidates.next()?;
    let runner_up = candidates.find(|other| other.is_elsewhere(&best));
    let has_clear_lead = runner_up.as_ref().is_none_or(|other| best.odds - other.odds >= LEAST_LEAD);
    let runner_up = runner_up.map(|other| other.fit.share);
    let is_clear = best.odds >= LEAST_ODDS && has_clear_lead;
    Some(((best, runner_up), is_clear))
}

impl Candidate {
    /// A place by a fit, where poses have the visit at `apart` with a standard deviation of `sd_m`. With the share s of a fit and
    /// its distance d from `apart`, whose variance together with that of a fit is σ², the log odds are c (s - s₀) - d² / 2σ² - ln σ²,
    /// σ in the last term up to [`MOST_SD_M`], and [`OF_EXPECTED`] more for the place that is expected.
    pub(super) fn new(node: usize, fit: Fit, apart: &Isometry2<f64>, sd_m: f64, is_expected: bool) -> Self {
        let variance_m2 = sd_m * sd_m + FIT_M * FIT_M;
        let off_m2 = (fit.pose.translation.vector - apart.translation.vector).norm_squared();
        let odds = OF_SHARE * (fit.share - EVEN_SHARE)
            - 0.5 * off_m2 / variance_m2
            - variance_m2.min(MOST_SD_M * MOST_SD_M).ln()
            + if is_expected { OF_EXPECTED } else { 0.0 };
        Self { node, fit, odds }
    }

    /// It is another place than `other`, or the same one turned.
    fn is_elsewhere(&self, other: &Self) -> bool {
        let apart = self.fit.pose.inv_mul(&other.fit.pose);
        let is_same = apart.rotation.angle().abs() < SAME_RAD && apart.translation.vector.norm() < SAME_M;
        self.node != other.node || !is_same
    }
}

/// The turns that bring the ways of a visit onto those of a node.
pub(super) fn turns_rad<'w>(bearings_rad: &'w [f64], ways_rad: &'w [f64]) -> impl Iterator<Item = f64> + 'w {
    (0..bearings_rad.len()).filter_map(|shift| turn_rad(bearings_rad, ways_rad, shift))
}

/// The turn that brings the ways of a visit onto those of a node, way i onto way i + `shift`; `None` if they do not
/// agree.
fn turn_rad(bearings_rad: &[f64], ways_rad: &[f64], shift: usize) -> Option<f64> {
    let ways = bearings_rad.len();
    if ways != ways_rad.len() {
        return None;
    }
    let off_rad = |i: usize| ways_rad[(i + shift) % ways] - bearings_rad[i];
    let first_rad = off_rad(0);
    let mean_rad = first_rad + (0..ways).map(|i| wrap_angle_rad(off_rad(i) - first_rad)).sum::<f64>() / ways as f64;
    let agree = (0..ways).all(|i| wrap_angle_rad(off_rad(i) - mean_rad).abs() <= WAYS_APART_RAD);
    agree.then(|| wrap_angle_rad(mean_rad))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a visit is taken to be to a place whose fit has this share and lies so far from where poses have it, which are
    /// known to within `sd_m`.
    fn is_taken(share: f64, off_m: f64, sd_m: f64) -> bool {
        let fit = Fit { pose: Isometry2::translation(off_m, 0.0), share };
        best(vec![Candidate::new(0, fit, &Isometry2::identity(), sd_m, false)]).is_some_and(|(_, is_clear)| is_clear)
    }

    #[test]
    fn a_twin_farther_off_than_poses_allow_is_another_place() {
        for sd_m in [0.1, 0.5, 2.0] {
            assert!(is_taken(1.0, sd_m, sd_m));
            assert!(!is_taken(1.0, 11.0, sd_m), "the next drift, 11 m on, at {sd_m}");
        }
    }

    #[test]
    fn where_poses_are_well_known_less_of_the_walls_suffices() {
        assert!(is_taken(0.6, 0.0, 0.1) && !is_taken(0.6, 0.0, 2.0));
        assert!(is_taken(0.75, 0.0, 2.0) && is_taken(0.75, 0.0, 20.0), "where nothing else is known to be near");
        assert!(!is_taken(0.4, 0.0, 0.1), "other walls");
    }

    #[test]
    fn two_places_that_fit_alike_are_told_by_the_poses_or_not_at_all() {
        let at = |node: usize, x_m: f64, sd_m: f64| {
            let fit = Fit { pose: Isometry2::translation(x_m, 0.0), share: 0.9 };
            Candidate::new(node, fit, &Isometry2::identity(), sd_m, false)
        };
        let found =
            |sd_m: f64| best(vec![at(0, 0.2, sd_m), at(1, 4.0, sd_m)]).map(|((of, _), is_clear)| (of.node, is_clear));
        assert_eq!((found(0.5), found(5.0)), (Some((0, true)), Some((0, false))));
    }
}

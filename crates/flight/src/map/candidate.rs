//! A place that a visit may be to.

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

/// Outlines of one place lie on each other by at least this share of their line points.
pub(super) const LEAST_SHARE: f64 = 0.72;

/// The outline of a visit lies on that of its place by this much more of its line points than on any other place.
const LEAST_LEAD: f64 = 0.08;

/// A place that a visit may be to.
pub(super) struct Candidate {
    pub(super) node: usize,
    pub(super) fit: Fit,
}

/// A place, and the share of the runner-up.
pub(super) type Best = (Candidate, Option<f64>);

/// The best of these places, unless another one is preferred; and whether its lead is clear.
pub(super) fn best(
    mut candidates: Vec<Candidate>,
    is_preferred: impl Fn(&Candidate, f64) -> bool,
) -> Option<(Best, bool)> {
    candidates.sort_by(|a, b| b.fit.share.total_cmp(&a.fit.share));
    let most = candidates.first()?.fit.share;
    let preferred = candidates.iter().position(|candidate| is_preferred(candidate, most));
    let best = candidates.remove(preferred.unwrap_or(0));
    let share = best.fit.share;
    let runner_up = candidates.iter().find(|other| other.is_elsewhere(&best)).map(|other| other.fit.share);
    let has_clear_lead = runner_up.is_none_or(|other| share - other >= LEAST_LEAD);
    let is_clear = preferred.is_some() || share >= LEAST_SHARE && has_clear_lead;
    Some(((best, runner_up), is_clear))
}

impl Candidate {
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

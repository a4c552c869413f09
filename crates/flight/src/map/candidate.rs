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

/// A place that a visit may be to.
pub(super) struct Candidate {
    pub(super) node: usize,
    pub(super) fit: Fit,
}

impl Candidate {
    /// It is another place than `other`, or the same one turned.
    pub(super) fn is_elsewhere(&self, other: &Self) -> bool {
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

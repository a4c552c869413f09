//! Home as the vehicle saw it where it started.

use crosscut_flight::{Here, HereKind, Look};
use crosscut_stage::{Frame, wrap_angle_rad};
use nalgebra::{Isometry2, Point2};

/// The walls around the start are those in view within this of it, m.
const START_WITHIN_M: f64 = 1.5;

/// The walls around the start are taken from places that are this far apart, m.
const START_EVERY_M: f64 = 0.7;

/// The vehicle left the start towards where it was this far from it first, m.
const LEFT_M: f64 = 5.0;

/// A way of the start that is farther than this from the direction in which the vehicle left is another one.
const OTHER_WAY_RAD: f64 = 1.0;

/// What the vehicle saw where it started, which is home.
#[derive(Clone, Debug, Default)]
pub(super) struct Start {
    pub(super) look: Look,
    /// Where the walls were seen from.
    from_m: Vec<Point2<f64>>,
    /// Of each revolution: how sure its place is, and the directions of the ways of a passage that are not seen to end.
    open_rad: Vec<(f64, Vec<f64>)>,
    has_left: bool,
}

impl Start {
    /// Takes what is seen around the start, until the vehicle has left it.
    pub(super) fn add(&mut self, frame: &Frame, seen: Option<&Here>, pose: &Isometry2<f64>) {
        let here_m = Point2::from(pose.translation.vector);
        self.has_left |= here_m.coords.norm() > START_WITHIN_M;
        if self.has_left {
            return;
        }
        if self.from_m.iter().all(|from_m| (from_m - here_m).norm() >= START_EVERY_M) {
            self.from_m.push(here_m);
            self.look.add(frame, pose);
        }
        if let Some(here) = seen {
            let is_passage = here.kind == HereKind::Passage;
            let open = here.ways.iter().filter(|way| is_passage && way.opening.is_some());
            let open_rad = open.map(|way| wrap_angle_rad(way.bearing_rad + pose.rotation.angle())).collect();
            self.open_rad.push((here.confidence, open_rad));
        }
    }

    /// Whether the start is in a passage that leads on behind the vehicle, whose trail this is.
    pub(super) fn leads_on_behind(&self, trail_m: &[Point2<f64>]) -> bool {
        let Some(left) = trail_m.iter().find(|place_m| place_m.coords.norm() > LEFT_M) else { return false };
        let left_rad = left.y.atan2(left.x);
        let is_other = |way_rad: &f64| wrap_angle_rad(way_rad - left_rad).abs() > OTHER_WAY_RAD;
        let votes =
            self.open_rad.iter().map(|(sure, open_rad)| if open_rad.iter().any(is_other) { *sure } else { -sure });
        votes.sum::<f64>() > 0.0
    }
}

#[cfg(test)]
mod tests {
    use crosscut_flight::Way;

    use super::*;

    #[test]
    fn a_start_in_a_passage_leads_on_behind_unless_its_end_is_seen() {
        let way = |bearing_rad: f64, opening: Option<usize>| Way { bearing_rad, width_m: 3.0, opening };
        let trail_m = [0.0, 3.0, 6.0].map(|x_m| Point2::new(x_m, 0.0));
        for (kind, behind, leads_on) in
            [(HereKind::Passage, Some(1), true), (HereKind::Passage, None, false), (HereKind::Junction, Some(1), false)]
        {
            let ways = vec![way(0.1, Some(0)), way(3.0, behind)];
            let here = Here { kind, look_m: 4.5, ways, is_middle: false, confidence: 0.9 };
            let mut start = Start::default();
            start.add(&Frame::default(), Some(&here), &Isometry2::identity());
            assert_eq!(start.leads_on_behind(&trail_m), leads_on, "{kind:?} {behind:?}");
        }
    }
}

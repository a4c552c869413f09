//! Whether two visits in a row are one stay.

use crosscut_stage::wrap_angle_rad;
use nalgebra::{Isometry2, Point2};

use super::draft::{Departure, Draft};
use super::visit::Visit;

/// Two visits in a row are one stay if all of the way between them is nearer to the first visit than this many looks. The three
/// values are for visits of which none, one, both were in the middle of the place.
const NEAR_LOOKS: [f64; 3] = [1.2, 0.9, 0.6];

/// Two visits in a row that are nearer to each other than this many looks are one stay, whatever ways they saw.
const SURELY_NEAR_LOOKS: f64 = 0.5;

/// A mouth of one visit is one of another if it lies within this of its direction.
const SAME_MOUTH_RAD: f64 = 0.6;

/// A mouth that is nearer to an anchor than this many of its looks need not be a mouth from there.
const MOUTH_OUTSIDE: f64 = 0.7;

impl Draft {
    /// Whether the vehicle is still at the node that it left last: a place is what lies within the look, and the two looks
    /// are of much the same space.
    pub(super) fn is_still_at(&self, last: &Departure, visit: &Visit, predicted: &Isometry2<f64>) -> bool {
        let apart = self.graph.poses[last.visit].inv_mul(predicted);
        let look_m = last.look_m.min(visit.look_m);
        let is_alike = self.map.nodes[last.node].kind == visit.kind;
        let near_looks = NEAR_LOOKS[usize::from(last.has_middle) + usize::from(visit.has_middle)];
        let is_near = |off_m: f64| off_m < near_looks * look_m;
        let mut between = self.way.via.iter().filter(|(way_m, _)| (last.at_m..visit.reached_at_m).contains(way_m));
        let to_last = last.tracked.inverse();
        self.flown_sd_m(last, visit).is_some()
            && (apart.translation.vector.norm() < SURELY_NEAR_LOOKS * look_m || is_alike && has_mouths_of(last, visit))
            && is_near(apart.translation.vector.norm())
            && between.all(|(_, place_m)| is_near((to_last * place_m).coords.norm()))
    }
}

/// Whether a visit saw the mouths that the one before saw, or the other way round, of those that are not within the other's
/// look: two places that stand close each have a mouth of their own.
fn has_mouths_of(last: &Departure, visit: &Visit) -> bool {
    let sees = |anchor: &Isometry2<f64>, look_m: f64, own_m: &[Point2<f64>], other_m: &[Point2<f64>]| {
        let bearing_rad = |mouth_m: &Point2<f64>| {
            let seen = anchor.inverse() * mouth_m;
            seen.y.atan2(seen.x)
        };
        let own_rad: Vec<f64> = own_m.iter().map(bearing_rad).collect();
        let is_outside = |mouth_m: &&Point2<f64>| (anchor.inverse() * *mouth_m).coords.norm() > MOUTH_OUTSIDE * look_m;
        other_m.iter().filter(is_outside).all(|mouth_m| {
            let bearing_rad = bearing_rad(mouth_m);
            own_rad.iter().any(|own_rad| wrap_angle_rad(own_rad - bearing_rad).abs() < SAME_MOUTH_RAD)
        })
    };
    let mouths_m = visit.mouths_m();
    sees(&visit.anchor, visit.look_m, &mouths_m, &last.mouths_m)
        || sees(&last.tracked, last.look_m, &last.mouths_m, &mouths_m)
}

//! Whether two visits in a row are one stay.

use crosscut_stage::wrap_angle_rad;
use nalgebra::Point2;

use super::log::{Log, flown_sd_m};
use super::travelled::Travelled;
use super::visit::Visit;
use crate::HereKind;

/// Two visits in a row are one stay if all of the way between them is nearer to the first visit than this many looks.
/// The three values are for visits of which none, one, both were in the middle of the place.
const NEAR_LOOKS: [f64; 3] = [1.2, 0.9, 0.6];

/// Two visits in a row that are nearer to each other than this many looks are one stay, whatever ways they saw.
const SURELY_NEAR_LOOKS: f64 = 0.5;

/// A mouth of one visit is one of another if it lies within this of its direction.
const SAME_MOUTH_RAD: f64 = 0.6;

/// A mouth that is nearer to an anchor than this many of its looks need not be a mouth from there.
const MOUTH_OUTSIDE: f64 = 0.7;

/// Whether the vehicle is still at the node that it left last, of this kind: a place is what lies within the look, and
/// the two looks are of much the same space. Each earlier visit of the stay is as near: places in a row are not one by those in between.
pub(super) fn is_still_at(log: &Log, kind: HereKind, visit: &Visit, way: &Travelled) -> bool {
    let Some(number) = log.last() else { return false };
    let mut stay = (0..number).rev().take_while(|&leg| log.legs[leg].is_stay).chain([number]);
    let (last, placed) = (&log.visits[number], log.placed(&visit.anchor));
    let off_m = |of: usize| log.graph.poses[of].inv_mul(&placed).translation.vector.norm();
    let look_m = |of: usize| log.visits[of].look_m.min(visit.look_m);
    let near_looks = |of: usize| NEAR_LOOKS[usize::from(log.visits[of].has_middle) + usize::from(visit.has_middle)];
    let is_near = |of: usize, off_m: f64| off_m < near_looks(of) * look_m(of);
    let to_last = last.anchor.inverse();
    flown_sd_m(last, visit).is_some()
        && (off_m(number) < SURELY_NEAR_LOOKS * look_m(number) || kind == visit.kind && has_mouths_of(last, visit))
        && stay.all(|of| is_near(of, off_m(of)))
        && way.between(last, visit).all(|place_m| is_near(number, (to_last * place_m).coords.norm()))
}

/// Whether a visit saw the mouths that the one before saw, or the other way round, of those that are not within the
/// other's look: two places that stand close each have a mouth of their own.
fn has_mouths_of(last: &Visit, visit: &Visit) -> bool {
    let sees = |own: &Visit, other: &Visit| {
        let seen = |mouth_m: &Point2<f64>| (own.anchor.inverse() * mouth_m).coords;
        let bearing_rad = |mouth_m: &Point2<f64>| seen(mouth_m).y.atan2(seen(mouth_m).x);
        let own_rad: Vec<f64> = own.mouths_m().iter().map(bearing_rad).collect();
        let other_m = other.mouths_m().into_iter();
        other_m.filter(|mouth_m| seen(mouth_m).norm() > MOUTH_OUTSIDE * own.look_m).all(|mouth_m| {
            let bearing_rad = bearing_rad(&mouth_m);
            own_rad.iter().any(|own_rad| wrap_angle_rad(own_rad - bearing_rad).abs() < SAME_MOUTH_RAD)
        })
    };
    sees(visit, last) || sees(last, visit)
}

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
/// the two looks are of much the same space. So it is for each visit of that stay: places in a row are not one by those in between.
pub(super) fn is_still_at(log: &Log, kind: HereKind, visit: &Visit, way: &Travelled) -> bool {
    let Some(number) = log.last() else { return false };
    let stay = (0..number).rev().take_while(|&leg| log.legs[leg].is_stay).chain([number]);
    let last = &log.visits[number];
    let placed = log.placed(&visit.anchor);
    let near_m = |part: usize| {
        let part = &log.visits[part];
        NEAR_LOOKS[usize::from(part.has_middle) + usize::from(visit.has_middle)] * part.look_m.min(visit.look_m)
    };
    let off_m = |part: usize| log.graph.poses[part].inv_mul(&placed).translation.vector.norm();
    let to_last = last.anchor.inverse();
    let is_near = |place_m: &Point2<f64>| (to_last * place_m).coords.norm() < near_m(number);
    let surely_m = SURELY_NEAR_LOOKS * last.look_m.min(visit.look_m);
    flown_sd_m(last, visit).is_some()
        && (off_m(number) < surely_m || kind == visit.kind && has_mouths_of(last, visit))
        && stay.into_iter().all(|part| off_m(part) < near_m(part))
        && way.between(last, visit).all(is_near)
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

//! A gap in the line of one wall in which nothing is seen, where no other beams get lost: a doorway that leads out of
//! range, or a dark surface. One scan cannot tell the two apart.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::edge::clearance_m;
use super::sides::Sides;
use crate::outline::Outline;

/// Beams lost in a row over less than this angle show nothing.
const LOST_RAD: f64 = 1.5 * PI / 180.0;
/// Walls that lose several beams in a row at more places than this lose them anywhere.
const LOSSY_PLACES: usize = 2;
/// Lost beams explain a dark gap, if elsewhere in the walls more than this share of its beams are lost in a row.
const LOST_SHARE: f64 = 1.0 / 3.0;
/// The beams that came back with nothing span at least this share of the width of the vehicle.
const DARK_SHARE: f64 = 0.5;
/// A doorway lies across the line of sight: the sine of the angle between the two is more than this.
const ACROSS: f64 = FRAC_1_SQRT_2;

/// The widest gap in the line of a wall that could be a doorway, if there is one.
pub(crate) fn doorway(outline: &Outline, vehicle_width_m: f64) -> Option<Sides<'_>> {
    let (mut widest, mut widest_beams, mut others_beams, mut places) = (None, 0, 0, 0);
    let within_walls = outline.pairs().filter(|[from, to]| from != to && outline.wall(*from) == outline.wall(*to));
    for [from, to] in within_walls {
        let beams = outline.ring.dark_between(from, to);
        if beams < 2 || f64::from(beams) * outline.ring.step_rad < LOST_RAD {
            continue;
        }
        let sides = Sides::of(outline, from, to);
        // Where the walls leave each other's line, the gap is an opening or a corner.
        if sides.seen_at_rad() >= PI || clearance_m(&sides) >= vehicle_width_m {
            continue;
        }
        if !is_like_doorway(&sides, vehicle_width_m) {
            (others_beams, places) = (beams.max(others_beams), places + 1);
        } else if beams > widest_beams {
            (widest, widest_beams) = (Some(sides), beams);
        }
    }
    let is_lost = places > LOSSY_PLACES || f64::from(others_beams) > LOST_SHARE * f64::from(widest_beams);
    widest.filter(|_| !is_lost)
}

fn is_like_doorway(sides: &Sides<'_>, vehicle_width_m: f64) -> bool {
    let [from_m, to_m] = sides.edge_m();
    let (chord, middle_m) = (to_m - from_m, 0.5 * (from_m + to_m));
    let fits = chord.norm() >= vehicle_width_m && sides.dark_m() >= DARK_SHARE * vehicle_width_m;
    let is_across = chord.perp(&middle_m).abs() > ACROSS * chord.norm() * middle_m.norm();
    fits && is_across && sides.is_mostly_dark()
}

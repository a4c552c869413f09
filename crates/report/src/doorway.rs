//! A gap in the line of one wall in which nothing is seen, where no other beams get lost: a doorway that leads out of
//! range, or a dark surface. One scan cannot tell the two apart, so an answer beside one is less sure.

use std::f64::consts::PI;

use crosscut_scan::{LostBeams, lies_across};

use crate::openings::FreeEdge;
use crate::wall_ring::WallRing;

/// The beams that came back with nothing span at least this share of the width of the vehicle.
const DARK_SHARE: f64 = 0.5;

/// The widest gap in the line of a wall that could be a doorway, if there is one.
pub(crate) fn doorway(outline: &WallRing, vehicle_width_m: f64) -> Option<FreeEdge<'_>> {
    let (mut widest, mut widest_beams, mut others) = (None, 0, LostBeams::default());
    for pair in outline.pairs_within_walls() {
        let beams = outline.ring.dark_between(pair[0], pair[1]);
        if beams < 2 {
            continue;
        }
        let edge = FreeEdge::between(outline, pair);
        // Where the walls leave each other's line, the gap is an opening or a corner.
        if edge.seen_at_rad() >= PI || edge.clearance_m() >= vehicle_width_m {
            continue;
        }
        if !is_like_doorway(&edge, lies_across(&outline.ring, pair), vehicle_width_m) {
            others.count(&outline.ring, beams);
        } else if beams > widest_beams {
            (widest, widest_beams) = (Some(edge), beams);
        }
    }
    widest.filter(|_| !others.are_anywhere() && !others.explain(widest_beams))
}

fn is_like_doorway(edge: &FreeEdge<'_>, lies_across: bool, vehicle_width_m: f64) -> bool {
    let [from_m, to_m] = edge.ends_m();
    let fits = (to_m - from_m).norm() >= vehicle_width_m && edge.dark_m() >= DARK_SHARE * vehicle_width_m;
    fits && lies_across && edge.is_mostly_dark()
}

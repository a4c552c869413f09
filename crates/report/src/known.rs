//! How each gap is known: seen through, proved to be closed, or judged.
//!
//! With w the width of the vehicle, c the clear width of the gap and d the depth at which the farther wall is seen behind
//! the line of the nearer one ([`Clearance`](crosscut_scan::Clearance)), an opening is **seen** if
//!
//! - the farther wall leads away from that line, and d (1 - w/c) >= 3 m: a wall that stood directly behind the line of
//!   sight would still leave a way as wide as the vehicle and 3 m long; or
//! - neighbouring beams into it, w wide at its nearer end, came back with nothing, the range ends 3 m behind that end or
//!   later, and no wall of the scan loses half as many beams in a row.
//!
//! A gap within a wall is **proved** to be closed if a return is nearer than w/2 wherever the vehicle's centre could cross
//! it ([`is_closed_by_returns`]). All other gaps are **judged**.

use crosscut_scan::{LostBeams, is_closed_by_returns};
use crosscut_stage::{Beam, DEPTH_M, Junction, Known, KnownGaps, Opening, Verdict};

use crate::openings::{self, FreeEdge};
use crate::wall_ring::WallRing;

/// Sets `known` of each opening of `out`, and counts its gaps.
pub(crate) fn mark(verdicts: &[Verdict], outline: &WallRing, vehicle_width_m: f64, out: &mut Junction) {
    let lost = lost_within_walls(outline, &out.openings);
    let mut gaps = KnownGaps::default();
    for opening in &mut out.openings {
        let mut edges = openings::edges_of(opening, outline).into_iter();
        let is_seen = edges.any(|edge| is_seen_through(&edge, lost, vehicle_width_m));
        opening.known = if is_seen { Known::Seen } else { Known::Judged };
        gaps.add(opening.known);
    }
    let closed = verdicts.iter().filter(|verdict| !verdict.is_opening);
    for pair in closed.filter_map(|verdict| outline.places_of(verdict.returns)) {
        let is_proved = is_closed_by_returns(&outline.ring, pair, vehicle_width_m);
        gaps.add(if is_proved { Known::Proved } else { Known::Judged });
    }
    out.gaps = gaps;
}

/// The beams that came back with nothing between two neighbouring returns of a wall, where no opening is.
fn lost_within_walls(outline: &WallRing, openings: &[Opening]) -> LostBeams {
    let (ring, mut lost) = (&outline.ring, LostBeams::default());
    for [from, to] in outline.pairs_within_walls() {
        let beams = ring.dark_between(from, to);
        let numbers = [from, to].map(|at| ring.returns[at].number);
        if beams > 0 && !openings.iter().any(|opening| opening.shares_end_with(numbers)) {
            lost.count(ring, beams);
        }
    }
    lost
}

fn is_seen_through(edge: &FreeEdge<'_>, lost: LostBeams, vehicle_width_m: f64) -> bool {
    let shows_depth = edge.clearance_of_branch().is_some_and(|clearance| {
        clearance.depth_m * (1.0 - vehicle_width_m / clearance.clear_m) >= DEPTH_M
            && clearance.clear_m > vehicle_width_m
    });
    shows_depth || lets_beams_pass(edge, lost, vehicle_width_m)
}

/// Whether enough neighbouring beams came back with nothing, more than the walls of the scan lose.
fn lets_beams_pass(edge: &FreeEdge<'_>, lost: LostBeams, vehicle_width_m: f64) -> bool {
    let (ring, near_m) = (&edge.outline.ring, edge.range_m());
    let (mut run, mut longest) = (0, 0);
    for beam in edge.between_beams() {
        run = if beam == Beam::NoReturn { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    let wide_m = f64::from(longest) * ring.step_rad * near_m;
    wide_m >= vehicle_width_m && ring.range_max_m >= near_m + DEPTH_M && !lost.explain(longest)
}

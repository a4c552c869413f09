//! For which widths of the vehicle the count stays the same.
//!
//! Each gap has one critical width. An opening closes for a vehicle that is wider than its clear width, or that its rules
//! no longer give room; a gap within a wall opens for one that is narrow enough to pass there. The count is another one
//! from the least critical width of an opening on, and from the largest one of a gap within a wall downward. Each gap is
//! decided again at other widths with the walls as they are, so no piece is cut or joined anew: that costs a few decisions.

use crosscut_scan::{Pieces, Ring};

use super::context::{ScanContext, Thresholds};
use super::gap::Gap;
use super::judge::Judge;

/// No vehicle is narrower.
const LEAST_M: f64 = 0.1;
/// No vehicle is wider: the most that `vehicle.width_m` may be.
const MOST_M: f64 = 100.0;
/// Critical widths are found to within this.
const WITHIN_M: f64 = 0.02;

/// The widths of the vehicle, about the configured one, for which there are as many walls.
pub(super) fn hold_m(judge: &mut Judge<'_>, walls: &Pieces) -> [f64; 2] {
    let width_m = judge.context.passage_m();
    let full_turn = judge.context.scan.ring.full_turn;
    // One wall all around is one wall, whether its one opening closes or not.
    let most_m = if walls.len() >= 2 { least_closing_m(judge, walls, width_m) } else { MOST_M };
    let may_split = !full_turn || walls.len() >= 2 || has_opening(judge, walls);
    let least_m = if may_split { most_opening_m(judge, walls, width_m) } else { LEAST_M.min(width_m) };
    [least_m, most_m]
}

/// Whether the only wall ends at an opening.
fn has_opening(judge: &mut Judge<'_>, walls: &Pieces) -> bool {
    let [wall] = walls.iter().collect::<Vec<_>>()[..] else { return false };
    let (first, last) = (wall[0], wall[wall.len() - 1]);
    first != last && judge.context.is_gap(last, first) && judge.joint(wall, wall).cost.is_none()
}

/// The width above which the first opening closes.
fn least_closing_m(judge: &mut Judge<'_>, walls: &Pieces, width_m: f64) -> f64 {
    let gaps = if judge.context.scan.ring.full_turn { walls.len() } else { walls.len() - 1 };
    let mut least_m = MOST_M;
    for at in 0..gaps {
        let (a, b) = (&walls[at], &walls[walls.next(at)]);
        let chord_m = judge.context.scan.ring.distance_m(a[a.len() - 1], b[0]);
        let closes_m = match judge.gap(a, b) {
            Some(gap) if is_opening_at(&gap, width_m) => closing_m(&gap, width_m, chord_m.min(least_m)),
            // What no rule decided closes when its ends are neighbours.
            _ => chord_m,
        };
        least_m = least_m.min(closes_m.max(width_m));
    }
    least_m
}

/// The width from `open_m` to `most_m` above which an opening closes; `most_m` if it does not below.
fn closing_m(gap: &Gap<'_>, open_m: f64, most_m: f64) -> f64 {
    if most_m <= open_m || is_opening_at(gap, most_m) {
        return most_m;
    }
    // Nearly always the clear width closes it.
    let clear_m = gap.clear_m.clamp(open_m, most_m);
    if is_opening_at(gap, clear_m) && !is_opening_at(gap, (clear_m + WITHIN_M).min(most_m)) {
        return clear_m;
    }
    bisect(open_m, most_m, |width_m| is_opening_at(gap, width_m))
}

/// The largest width, at most `width_m`, at which a gap within a wall is an opening.
fn most_opening_m(judge: &mut Judge<'_>, walls: &Pieces, width_m: f64) -> f64 {
    let mut most_m = LEAST_M.min(width_m);
    for wall in walls.iter() {
        for at in 1..wall.len() {
            let (ring, ends) = (&judge.context.scan.ring, [wall[at - 1], wall[at]]);
            if !ring.are_apart(ends[0], ends[1], most_m + WITHIN_M) || !leaves_line(ring, wall, at, most_m) {
                continue;
            }
            let chord_m = ring.distance_m(ends[0], ends[1]).min(width_m);
            let Some(gap) = judge.gap(&wall[..at], &wall[at..]) else { continue };
            // What the walls were joined across nevertheless does not open for a narrower vehicle.
            if is_opening_at(&gap, most_m + WITHIN_M) && !is_opening_at(&gap, width_m) {
                most_m = bisect(most_m + WITHIN_M, chord_m, |width_m| is_opening_at(&gap, width_m));
            }
        }
    }
    most_m.min(width_m)
}

/// Whether the nearer end of the gap before return number `at` of a wall is this far off the line of the two returns at the
/// other end, or beams into the gap came back with nothing: elsewhere there is no clear width, and nothing needs to be
/// measured.
fn leaves_line(ring: &Ring, wall: &[usize], at: usize, least_m: f64) -> bool {
    if at < 2 || at + 1 >= wall.len() {
        return false;
    }
    let [before, p, q, after] = [wall[at - 2], wall[at - 1], wall[at], wall[at + 1]].map(|i| ring.position_m(i));
    let off_m = |line: crosscut_scan::Position, chord: crosscut_scan::Position| {
        line.perp(&chord).abs() / line.norm().max(f64::MIN_POSITIVE)
    };
    let line = if ring.range_m(wall[at - 1]) <= ring.range_m(wall[at]) { after - q } else { p - before };
    ring.dark_between(wall[at - 1], wall[at]) > 0 || off_m(line, q - p) >= least_m
}

/// Whether a vehicle of another width finds an opening.
fn is_opening_at(gap: &Gap<'_>, width_m: f64) -> bool {
    if gap.chord_m() < width_m {
        return false;
    }
    let lengths = crosscut_scan::Lengths { passage_m: width_m, ..gap.context.thresholds.lengths };
    let context = ScanContext { thresholds: Thresholds { lengths, ..gap.context.thresholds }, ..*gap.context };
    let mut gap: Gap<'_> = *gap;
    gap.context = &context;
    gap.decide().is_opening()
}

/// Where something that holds at `yes_m` and not at `no_m` ends to hold.
fn bisect(mut yes_m: f64, mut no_m: f64, holds: impl Fn(f64) -> bool) -> f64 {
    while no_m - yes_m > WITHIN_M {
        let middle_m = f64::midpoint(yes_m, no_m);
        if holds(middle_m) { yes_m = middle_m } else { no_m = middle_m }
    }
    yes_m
}

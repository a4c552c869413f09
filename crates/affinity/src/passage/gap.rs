//! Whether a wall goes on across a gap, or a vehicle can pass.

use std::f64::consts::{PI, TAU};

use super::ring::{Place, Ring, turn_rad};
use super::tangent::{End, has_direction, tangent};

/// A wall whose end leaves the line of the other by this much on the far side hides a branch.
const ASIDE_M: f64 = 0.8;
/// A piece without a direction belongs to a wall if it lies within this of its line, plus a share of the distance.
const OFF_LINE_M: f64 = 0.3;
const OFF_LINE_SHARE: f64 = 0.15;
/// Two pieces without direction belong together along a line of sight: a wall at grazing incidence. Share of their
/// distance that is along the beams, and the largest distance.
const GRAZING_SHARE: f64 = 0.8;
const GRAZING_M: f64 = 3.0;
/// Directions that differ by less are parallel: their sine.
const PARALLEL: f64 = 0.2;
/// In the shadow of an island nothing is seen, so a corner may be farther off, and blunter.
const SHADOW_CORNER_M: f64 = 9.0;
const SHADOW_CORNER_RAD: f64 = 110.0 * PI / 180.0;

/// What is asked of a gap; see the parameters of the stage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) passage_m: f64,
    pub(super) stretch_m: f64,
    pub(super) straight_rad: f64,
    pub(super) corner_rad: f64,
    pub(super) corner_m: f64,
    pub(super) unseen_rad: f64,
}

/// The cost at which one wall goes on from the end of piece `a` to the start of piece `b`, anticlockwise; `None` where a
/// vehicle could pass between them.
pub(super) fn cost(ring: &Ring, island_beams: &[bool], a: &[usize], b: &[usize], limits: &Limits) -> Option<f64> {
    let (p, q) = (a[a.len() - 1], b[0]);
    let chord = ring.place_m(q) - ring.place_m(p);
    let chord_m = chord.norm();
    if chord_m < limits.passage_m {
        return Some(0.0);
    }
    let before = has_direction(ring, a).then(|| tangent(ring, a, End::Last, limits.stretch_m));
    let after = has_direction(ring, b).then(|| tangent(ring, b, End::First, limits.stretch_m));
    match (before, after) {
        (Some(before), Some(after)) => {
            let bends = [turn_rad(before, chord), turn_rad(chord, after)];
            let turn_rad = whole_turn_rad(bends);
            let goes_on =
                turn_rad < limits.straight_rad || closes(ring, island_beams, (p, q), [before, after], turn_rad, limits);
            let detour = 0.2 * bends[0].abs().min(bends[1].abs());
            goes_on.then(|| 0.1 + turn_rad.abs() + detour + if chord_m > 3.0 { 0.05 * chord_m } else { 0.0 })
        }
        (None, None) => {
            let along_m = (ring.range_m(q) - ring.range_m(p)).abs();
            let grazing = along_m > GRAZING_SHARE * chord_m && chord_m < GRAZING_M;
            grazing.then_some(1.0 + 0.1 * chord_m)
        }
        (before, after) => {
            let line = before.or(after)?;
            let along_m = line.dot(&chord);
            let off = line.perp(&chord).abs() / (OFF_LINE_M + OFF_LINE_SHARE * along_m);
            (along_m > 0.0 && off < 1.0).then_some(0.3 + off + 0.05 * chord_m)
        }
    }
}

/// How far a wall turns at a gap, to the left; around a tip it may turn right by more than π.
fn whole_turn_rad([first, second]: [f64; 2]) -> f64 {
    let turn_rad = first + second;
    if turn_rad < -1.15 * PI {
        turn_rad + TAU
    } else if turn_rad > 1.5 * PI {
        turn_rad - TAU
    } else {
        turn_rad
    }
}

/// Whether the two walls meet in a corner of which only the returns are missing: both lines run on to it, it is not far,
/// and neither wall is seen to go on behind the other.
fn closes(
    ring: &Ring,
    island_beams: &[bool],
    (p, q): (usize, usize),
    [before, after]: [Place; 2],
    turn_rad: f64,
    limits: &Limits,
) -> bool {
    let (unseen, shaded) = ring
        .beams_between(p, q)
        .fold((0, 0), |(unseen, shaded), beam| (unseen + 1, shaded + usize::from(island_beams[beam])));
    let shadow = unseen > 0 && 2 * shaded >= unseen;
    let angle_rad = ring.beams_apart(p, q) as f64 * ring.step_rad;
    let (corner_rad, corner_m, unseen_rad) = if shadow {
        (SHADOW_CORNER_RAD, SHADOW_CORNER_M, PI)
    } else {
        (limits.corner_rad, limits.corner_m, limits.unseen_rad)
    };
    let chord = ring.place_m(q) - ring.place_m(p);
    let behind = before.perp(&chord) < -ASIDE_M || after.perp(&-chord) < -ASIDE_M;
    if turn_rad >= corner_rad || behind {
        return false;
    }
    let sine = before.perp(&after);
    if sine.abs() <= PARALLEL {
        return true;
    }
    // p + s·before = q - u·after.
    let (s, u) = (chord.perp(&after) / sine, before.perp(&chord) / sine);
    [s, u].iter().all(|length_m| (-ASIDE_M..corner_m).contains(length_m)) && angle_rad < unseen_rad
}

//! How sure an answer is.
//!
//! By the zero rule: 1 - 10^-margin, where margin is the distance in decades between the zero tolerance and the nearest
//! eigenvalue. It shows how firmly this rule stands by its count.
//!
//! By the scene: an answer is wrong where one verdict between "the wall continues" and "a vehicle can pass" is wrong, so
//! it is as sure as its verdicts are clear ([`Grounds`]):
//! ```text
//! P(right) = 1 / (1 + exp(-β·x)),  x = (1, -ln e, ln(o/w), ln(g/w), φ, i, m)
//! ```
//! with e how many gaps are decided wrongly, to be expected by their odds ([`crate::odds`]), and w the width of the vehicle. Where
//! returns are more than 4° apart on average, walls do not show as lines, and P is lowered by a factor. A dark gap in the
//! line of a wall that could be a doorway lowers it too, and so does a counted wall of which only a handful of returns is
//! seen: they could be of anything. β is a logistic regression of right against wrong over the
//! development scenes and places of another generator, close calls among them: recesses and niches about as deep as a way. The example `confidence` checks it and writes what it means.

use std::f64::consts::{FRAC_PI_4, TAU};

use crosscut_stage::{Junction, Opening, Revolution, Verdict, Wall, wrap_angle_rad};

use crate::odds;
use crate::openings::{self, FreeEdge};
use crate::wall_ring::WallRing;

/// Clearances are limited to these multiples of the vehicle's width.
const CLEARANCES: [f64; 2] = [0.2, 15.0];
/// As many gaps, at least, are expected to be decided wrongly.
const LEAST_WRONG: f64 = 0.01;
/// Openings that are this far apart, or farther, are clearly apart.
const APART_RAD: f64 = FRAC_PI_4;
/// The length of an island is limited to this many times the vehicle's width.
const MOST_ISLAND: f64 = 3.0;
/// The margin is limited to this.
const MARGIN_DECADES: f64 = 1.0;
/// β.
pub const BETA: [f64; Grounds::INPUTS] = [-1.56, 0.91, 0.07, -0.15, 1.75, -0.2, 0.76];

/// Returns up to this far apart, 90 a turn with room for rounding, show walls as lines; fewer do not.
pub(crate) const COARSE_RAD: f64 = TAU / 89.5;

/// The share of right answers, about, where a gap in a wall could be a doorway.
const OF_DOORWAY: f64 = 0.6;

/// A wall with this many returns, or more, is no less sure than a longer one.
const RETURNS_OF_WALL: usize = 24;
/// What remains of the share of right answers where the smallest wall has fewer, m, is 1 - (1 - m/24) to this power: answers
/// that a wall of fewer than 6 decides are not sure. In simulated scenes the count is right in three of four answers with a
/// wall of 3 to 5 returns that would be called sure without this.
const POWER_OF_FEW: i32 = 9;

/// What an answer rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grounds {
    /// e: how many gaps the answer decides wrongly, to be expected by the odds of the gaps.
    pub wrong_gaps: f64,
    /// o: how far the walls leave each other's line at an opening, or where one ends and another begins, metres; the
    /// least of all.
    pub least_at_openings_m: f64,
    /// g: how far a wall leaves its own line at a gap, or how deep the space behind the gap is, if that is less,
    /// metres; the most of all gaps of the vehicle's width.
    pub most_within_walls_m: f64,
    /// φ: the least angle between the bearings of two openings, or of two gaps that are seen through a doorway.
    pub apart_rad: f64,
    /// i: how long the longest pillar in view is seen to be, metres; 0 without one. What stands behind its ends is hidden: it may
    /// be the end of a wall.
    pub longest_island_m: f64,
    /// m: how far the zero tolerance could be moved before k changes, decades; `None` if the spectrum has none.
    pub margin_decades: Option<f64>,
}

impl Grounds {
    /// The length of x.
    pub const INPUTS: usize = 7;

    /// Of an answer that has walls, with the verdicts of its affinity and the margin of its spectrum; `None` without a
    /// wall, or without beams.
    pub fn of(
        revolution: &Revolution,
        verdicts: &[Verdict],
        vehicle_width_m: f64,
        margin_decades: Option<f64>,
        answer: &Junction,
    ) -> Option<Self> {
        let of_no_island = |wall: &Option<u32>| wall.filter(|&id| !answer.walls[id as usize].island);
        let wall_of_return: Vec<_> = answer.wall_of_return.iter().map(of_no_island).collect();
        let mut outline = WallRing::default();
        outline.fill(revolution, revolution.beams()?, &wall_of_return).ok()?;
        Self::on(&outline, revolution, verdicts, vehicle_width_m, margin_decades, answer)
    }

    /// The grounds of an answer, from the outline of its walls that are no islands; `None` without one.
    pub(crate) fn on(
        outline: &WallRing,
        revolution: &Revolution,
        verdicts: &[Verdict],
        vehicle_width_m: f64,
        margin_decades: Option<f64>,
        answer: &Junction,
    ) -> Option<Self> {
        if outline.is_empty() {
            return None;
        }
        let mut grounds = Self {
            wrong_gaps: odds::wrong_gaps(verdicts, answer),
            least_at_openings_m: f64::INFINITY,
            most_within_walls_m: 0.0,
            apart_rad: std::f64::consts::PI,
            longest_island_m: longest_island_m(revolution, answer),
            margin_decades,
        };
        let mut bearings_rad = Vec::new();
        for opening in &answer.openings {
            let edges = openings::edges_of(opening, outline);
            for edge in &edges {
                grounds.least_at_openings_m = grounds.least_at_openings_m.min(edge.clearance_m());
            }
            if opening.gaps.is_empty() {
                bearings_rad.push(opening.bearing_rad);
            } else {
                bearings_rad.extend(edges.iter().map(|edge| edge.opening().0.bearing_rad));
            }
        }
        grounds.apart_rad = apart_rad(bearings_rad);
        // No opening within a wall is narrower than the vehicle.
        let others =
            FreeEdge::all(outline, vehicle_width_m).filter(|edge| !is_at_opening(edge.returns(), &answer.openings));
        for edge in others {
            if edge.is_between_walls() {
                // It counts although it may be too narrow for an opening.
                if edge.is_known() {
                    grounds.least_at_openings_m = grounds.least_at_openings_m.min(edge.clearance_m());
                }
                continue;
            }
            let clearance_m = edge.clearance_m();
            if clearance_m > grounds.most_within_walls_m {
                let returns_m = revolution.points_m.iter().map(|point| point.coords.xy());
                let room_m = clearance_m.min(edge.depth_m(returns_m, vehicle_width_m));
                grounds.most_within_walls_m = grounds.most_within_walls_m.max(room_m);
            }
        }
        Some(grounds)
    }

    /// x, for a vehicle of this width.
    pub fn inputs(&self, vehicle_width_m: f64) -> [f64; Self::INPUTS] {
        let clearance = |length_m: f64| (length_m / vehicle_width_m).clamp(CLEARANCES[0], CLEARANCES[1]).ln();
        let (opening, gap) = (clearance(self.least_at_openings_m), clearance(self.most_within_walls_m));
        let margin = self.margin_decades.unwrap_or(MARGIN_DECADES).clamp(0.0, MARGIN_DECADES);
        let (apart, island) =
            (self.apart_rad.min(APART_RAD), (self.longest_island_m / vehicle_width_m).min(MOST_ISLAND));
        [1.0, -self.wrong_gaps.max(LEAST_WRONG).ln(), opening, gap, apart, island, margin]
    }

    /// β·x, for a vehicle of this width: the log odds of a right answer.
    pub(crate) fn log_odds(&self, vehicle_width_m: f64) -> f64 {
        BETA.iter().zip(self.inputs(vehicle_width_m)).map(|(beta, x)| beta * x).sum()
    }
}

/// The length of the longest island, from end to end.
fn longest_island_m(revolution: &Revolution, answer: &Junction) -> f64 {
    let islands = answer.walls.iter().filter(|wall| wall.island);
    let ends_m = islands.filter_map(|island| answer.ends_m(island.id, &revolution.points_m));
    ends_m.map(|[start_m, end_m]| (end_m - start_m).norm()).fold(0.0, f64::max)
}

/// The least angle between two bearings; π with fewer than two.
fn apart_rad(mut bearings_rad: Vec<f64>) -> f64 {
    bearings_rad.sort_by(f64::total_cmp);
    let next = bearings_rad.iter().cycle().skip(1);
    let apart = bearings_rad.iter().zip(next).map(|(a, b)| wrap_angle_rad(b - a).abs());
    if bearings_rad.len() < 2 { std::f64::consts::PI } else { apart.fold(std::f64::consts::PI, f64::min) }
}

/// What remains of the share of right answers where returns are this far apart, and if a gap in a wall could be a doorway.
pub(crate) fn remains(spacing_rad: f64, may_have_doorway: bool) -> f64 {
    of_spacing(spacing_rad) * if may_have_doorway { OF_DOORWAY } else { 1.0 }
}

/// What remains of the share of right answers for the number of returns of the smallest wall that is counted.
pub(crate) fn of_smallest_wall(walls: &[Wall]) -> f64 {
    let returns = walls.iter().filter(|wall| !wall.island).map(|wall| wall.returns).min();
    let few = returns.filter(|&returns| returns < RETURNS_OF_WALL);
    few.map_or(1.0, |returns| 1.0 - (1.0 - returns as f64 / RETURNS_OF_WALL as f64).powi(POWER_OF_FEW))
}

/// The average angle from one return of a wall to the next: more than that of the beams where some are lost. Beams into
/// openings are not lost.
pub(crate) fn spacing_rad(outline: &WallRing, openings: &[Opening]) -> f64 {
    let ring = &outline.ring;
    let [mut beams, mut spacings] = [0, 0];
    for [from, to] in outline.pairs_within_walls() {
        let apart = ring.beams_from(from, to);
        if apart == 1 || !is_at_opening([from, to].map(|at| ring.returns[at].number), openings) {
            (beams, spacings) = (beams + apart, spacings + 1);
        }
    }
    ring.step_rad * beams.max(1) as f64 / spacings.max(1) as f64
}

/// Whether the edge between two returns is an opening, or part of one.
fn is_at_opening(returns: [u32; 2], openings: &[Opening]) -> bool {
    openings.iter().any(|opening| opening.shares_end_with(returns))
}

/// What remains of the share of right answers when returns are this far apart: 1 up to [`COARSE_RAD`], half at 60
/// returns a turn, an eighth at 24. This is about what is found when beams are left out of scans, regularly or at
/// random.
fn of_spacing(spacing_rad: f64) -> f64 {
    (COARSE_RAD / spacing_rad).powf(1.5).min(1.0)
}

/// 1 - 10^-margin: 0 on the tolerance, 0.9 one decade away, 0.99 two.
pub(crate) fn of_margin(margin_decades: Option<f64>) -> f64 {
    margin_decades.map_or(0.0, |margin| 1.0 - 10f64.powf(-margin.max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn confidence_grows_with_the_margin_and_is_none_without_a_spectrum() {
        assert_eq!(of_margin(None), 0.0);
        assert_eq!(of_margin(Some(-1.0)), 0.0);
        assert!((of_margin(Some(2.0)) - 0.99).abs() < 1e-12);
    }

    #[test]
    fn returns_too_far_apart_to_tell_walls_from_gaps_make_no_answer_sure() {
        let of_beams = |beams: f64| of_spacing(TAU / beams);
        assert_eq!((of_beams(4096.0), of_beams(90.0)), (1.0, 1.0));
        assert!((0.5..0.6).contains(&of_beams(60.0)) && of_beams(24.0) < 0.14);
    }

    #[test]
    fn an_answer_with_a_wall_of_a_handful_of_returns_is_not_sure() {
        let wall = |returns, island| Wall { id: 0, returns, bearing_rad: [0.0; 2], island };
        let of = |small: usize, is_island| of_smallest_wall(&[wall(200, false), wall(small, is_island)]);
        assert!(of(5, false) < crosscut_stage::SURE && of(24, false) == 1.0);
        assert_eq!(of(5, true), 1.0, "an island is not counted");
        assert!((3..24).all(|returns| of(returns, false) < of(returns + 1, false)));
        assert_eq!(of_smallest_wall(&[]), 1.0);
    }

    #[test]
    fn openings_are_as_far_apart_as_the_nearest_two_also_across_the_turn() {
        let apart_deg = |bearings_deg: &[f64]| {
            apart_rad(bearings_deg.iter().map(|deg| deg.to_radians()).collect()).to_degrees().round()
        };
        assert_eq!(apart_deg(&[-170.0, 0.0, 60.0]), 60.0);
        assert_eq!(apart_deg(&[-170.0, 0.0, 160.0]), 30.0);
        assert_eq!((apart_deg(&[]), apart_deg(&[10.0])), (180.0, 180.0));
    }

    #[test]
    fn an_answer_without_walls_or_without_beams_has_no_grounds() {
        let cloud = Revolution { points_m: vec![crosscut_stage::Point::origin()], ..Revolution::default() };
        let empty = (WallRing::default(), Revolution::default(), Junction::default());
        assert_eq!(Grounds::on(&empty.0, &empty.1, &[], 0.6, None, &empty.2), None);
        assert_eq!(
            Grounds::of(&cloud, &[], 0.6, None, &Junction { wall_of_return: vec![None], ..Junction::default() }),
            None
        );
    }
}

//! The difference between the walls of a revolution and those of its neighbours.

use std::f64::consts::{PI, TAU};

use crosscut_stage::{Junction, wrap_angle_rad};

/// A wall as seen from the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WallArc {
    pub(super) returns: usize,
    /// Anticlockwise from its first to its last return.
    pub(super) bearing_rad: [f64; 2],
}

/// The walls of an answer that are no islands.
pub(super) fn arcs(answer: &Junction) -> Vec<WallArc> {
    let walls = answer.walls.iter().filter(|wall| !wall.island);
    walls.map(|wall| WallArc { returns: wall.returns, bearing_rad: wall.bearing_rad }).collect()
}

/// Explains why a revolution has another count than a neighbour with the usual count. Each wall of the answer with more
/// walls is looked up in the other answer by its direction: either one has no counterpart, or two share one.
pub(super) fn of_flip(walls: &[WallArc], around: &[WallArc], limited_view: bool) -> String {
    let is_more = walls.len() > around.len();
    let (more, fewer) = if is_more { (walls, around) } else { (around, walls) };
    let found: Vec<Option<usize>> = more.iter().map(|wall| most_overlapping(wall, fewer)).collect();
    if let Some(lost) = (0..more.len()).filter(|&at| found[at].is_none()).max_by_key(|&at| more[at].returns) {
        let WallArc { returns, bearing_rad } = more[lost];
        let at = degrees(middle_rad(bearing_rad));
        let end = if limited_view && is_outermost(lost, more) { ", at the end of the view" } else { "" };
        return if is_more {
            format!("a wall of {returns} returns at {at} where those around it have none{end}")
        } else {
            format!("no wall at {at}, where those around it have {returns} returns{end}")
        };
    }
    let pairs = (0..more.len()).flat_map(|a| (0..a).map(move |b| [b, a])).filter(|&[b, a]| found[a] == found[b]);
    let nearest = pairs.min_by(|&p, &q| gap_rad(p.map(|at| &more[at])).total_cmp(&gap_rad(q.map(|at| &more[at]))));
    let Some(pair) = nearest.map(|pair| pair.map(|at| &more[at])) else { return "other walls".to_owned() };
    let [a, b] = pair.map(|wall| degrees(middle_rad(wall.bearing_rad)));
    let [n, m] = pair.map(|wall| wall.returns);
    if is_more {
        format!("walls of {n} and {m} returns at {a} and {b} that are one around it")
    } else {
        format!("one wall at {a} and {b}, where those around it have two, of {n} and {m} returns")
    }
}

/// The wall whose arc overlaps that of `wall` most, if any does.
fn most_overlapping(wall: &WallArc, others: &[WallArc]) -> Option<usize> {
    let overlaps = others.iter().enumerate().map(|(at, other)| (overlap_rad(wall, other), at));
    overlaps.filter(|(overlap_rad, _)| *overlap_rad > 0.0).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, at)| at)
}

fn overlap_rad(a: &WallArc, b: &WallArc) -> f64 {
    let length_rad = |arc: &WallArc| (arc.bearing_rad[1] - arc.bearing_rad[0]).rem_euclid(TAU);
    let from_rad = (b.bearing_rad[0] - a.bearing_rad[0]).rem_euclid(TAU);
    // b begins `from_rad` after a, which is also `TAU - from_rad` before it.
    let overlap_from = |from_rad: f64| (length_rad(a).min(from_rad + length_rad(b)) - from_rad.max(0.0)).max(0.0);
    overlap_from(from_rad) + overlap_from(from_rad - TAU)
}

/// The angle between two walls, the shorter way round.
fn gap_rad([a, b]: [&WallArc; 2]) -> f64 {
    let from_to = |a: &WallArc, b: &WallArc| (b.bearing_rad[0] - a.bearing_rad[1]).rem_euclid(TAU);
    from_to(a, b).min(from_to(b, a))
}

/// Whether no other wall is farther from straight ahead on its side.
fn is_outermost(at: usize, walls: &[WallArc]) -> bool {
    let middles_rad = || walls.iter().map(|wall| middle_rad(wall.bearing_rad));
    let own_rad = middle_rad(walls[at].bearing_rad);
    middles_rad().all(|other_rad| other_rad >= own_rad) || middles_rad().all(|other_rad| other_rad <= own_rad)
}

/// The bearing halfway from one bearing anticlockwise to the other.
fn middle_rad([from, to]: [f64; 2]) -> f64 {
    wrap_angle_rad(from + 0.5 * (to - from).rem_euclid(2.0 * PI))
}

fn degrees(rad: f64) -> String {
    format!("{:+.0}°", rad.to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(returns: usize, from_deg: f64, to_deg: f64) -> WallArc {
        WallArc { returns, bearing_rad: [from_deg, to_deg].map(f64::to_radians) }
    }

    #[test]
    fn a_missing_wall_is_distinguished_from_two_joined_ones() {
        let around = [wall(80, -100.0, -20.0), wall(60, 10.0, 70.0), wall(9, 100.0, 108.0)];
        let missing = of_flip(&around[..2], &around, true);
        assert_eq!(missing, "no wall at +104°, where those around it have 9 returns, at the end of the view");
        let joined = of_flip(&[wall(140, -100.0, 70.0), around[2]], &around, true);
        assert_eq!(joined, "one wall at -60° and +40°, where those around it have two, of 80 and 60 returns");
        let split = of_flip(&around, &[wall(140, -100.0, 70.0), around[2]], true);
        assert_eq!(split, "walls of 80 and 60 returns at -60° and +40° that are one around it");
        assert_eq!(
            of_flip(&around, &around[1..], false),
            "a wall of 80 returns at -60° where those around it have none"
        );
    }

    #[test]
    fn arcs_behind_the_sensor_overlap_across_plus_minus_pi() {
        let behind = wall(50, 150.0, -150.0);
        assert!((overlap_rad(&behind, &wall(5, -175.0, -170.0)).to_degrees() - 5.0).abs() < 1e-9);
        assert!((overlap_rad(&wall(5, 170.0, 175.0), &behind).to_degrees() - 5.0).abs() < 1e-9);
        assert_eq!(overlap_rad(&behind, &wall(5, 0.0, 10.0)), 0.0);
        assert_eq!(degrees(middle_rad(behind.bearing_rad)).replace(['+', '-'], ""), "180°");
    }
}

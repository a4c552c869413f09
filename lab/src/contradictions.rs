//! What no answer may claim, whatever the truth is: found in an answer and its returns alone, so it needs no label.

use std::f64::consts::TAU;
use std::fmt;

use crosscut_stage::{Frame, Opening, Point, SURE};

/// A strip is full where no gap across it is wider than this share of its width.
const FULL_SHARE: f64 = 0.25;
/// Strips are tried in this many directions and one.
const STRIPS: u32 = 32;
/// Islands are no longer than this beside the sensor where they stand in line with a wall.
const ISLAND_M: f64 = 1.5;
/// An island stands in line with a wall of which as much lies within [`OFF_LINE_M`] of its line, metres.
const IN_LINE_M: f64 = 1.0;
/// See [`IN_LINE_M`].
const OFF_LINE_M: f64 = 0.15;
/// Returns farther from each other along the line are of places where a wall crosses it, metres.
const MOST_SPACING_M: f64 = 0.5;
/// A wall with fewer returns is decided by a handful of them.
const HANDFUL: usize = 6;

/// A claim that its own returns contradict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contradiction {
    /// Every strip of the vehicle's width from the sensor to an opening is full of returns that are nearer than the opening.
    BlockedOpening {
        /// Towards the opening.
        bearing_rad: f64,
        /// How far off the first return in the strip is, metres.
        blocked_at_m: f64,
    },
    /// An island longer than 1.5 m is nearest to the sensor, in line with a wall.
    WallAsIsland {
        /// Its length, metres.
        length_m: f64,
    },
    /// An answer is sure, although a wall that it counts has fewer than 6 returns.
    SureOfHandful {
        /// The returns of the smallest wall.
        returns: usize,
    },
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BlockedOpening { bearing_rad, blocked_at_m } => {
                let bearing_deg = bearing_rad.to_degrees();
                write!(
                    f,
                    "the strip to the opening at {bearing_deg:.0}° is full of returns from {blocked_at_m:.2} m on"
                )
            }
            Self::WallAsIsland { length_m } => write!(f, "the nearest wall, {length_m:.1} m long, is an island"),
            Self::SureOfHandful { returns } => write!(f, "sure, though a wall has {returns} returns"),
        }
    }
}

/// The contradictions in the answer of a frame, for a vehicle of this width.
pub fn contradictions(frame: &Frame, vehicle_width_m: f64) -> Vec<Contradiction> {
    let openings = frame.junction.openings.iter();
    let blocked = openings.filter_map(|opening| {
        let blocked_at_m = blocked_at_m(&frame.revolution.points_m, opening, vehicle_width_m)?;
        Some(Contradiction::BlockedOpening { bearing_rad: opening.bearing_rad, blocked_at_m })
    });
    let island = wall_as_island_m(frame).map(|length_m| Contradiction::WallAsIsland { length_m });
    let is_sure = frame.junction.confidence.is_some_and(|confidence| confidence >= SURE);
    let smallest = frame.junction.walls.iter().filter(|wall| !wall.island).map(|wall| wall.returns).min();
    let handful = smallest.filter(|&returns| is_sure && returns < HANDFUL);
    blocked.chain(island).chain(handful.map(|returns| Contradiction::SureOfHandful { returns })).collect()
}

/// How far off the nearest return is in the strip of this width towards an opening, if returns that are nearer than the
/// opening fill it, and the strips to all other places of its edge.
fn blocked_at_m(points_m: &[Point], opening: &Opening, width_m: f64) -> Option<f64> {
    if opening.is_cut_by_view() {
        return None;
    }
    let nearer: Vec<&Point> = points_m.iter().filter(|point| point.coords.norm() < opening.range_m()).collect();
    let at_m = first_of_full_strip_m(&nearer, opening.bearing_rad, width_m)?;
    let [from_rad, to_rad] = opening.edge_m.map(|end_m| end_m.y.atan2(end_m.x));
    let seen_at_rad = (to_rad - from_rad).rem_euclid(TAU);
    let mut others = (0..=STRIPS).map(|step| from_rad + seen_at_rad * f64::from(step) / f64::from(STRIPS));
    others.all(|bearing_rad| first_of_full_strip_m(&nearer, bearing_rad, width_m).is_some()).then_some(at_m)
}

/// How far off the nearest return is in the strip of this width in a direction, if the returns fill it; `None` if they do
/// not.
fn first_of_full_strip_m(points_m: &[&Point], bearing_rad: f64, width_m: f64) -> Option<f64> {
    let (sin, cos) = bearing_rad.sin_cos();
    let in_strip = points_m.iter().filter_map(|point| {
        let (along_m, across_m) = (point.x * cos + point.y * sin, point.y * cos - point.x * sin);
        (along_m > 0.0 && across_m.abs() < width_m / 2.0).then_some((across_m, along_m))
    });
    let mut in_strip: Vec<(f64, f64)> = in_strip.collect();
    in_strip.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut across_m = vec![-width_m / 2.0];
    across_m.extend(in_strip.iter().map(|(across_m, _)| *across_m));
    across_m.push(width_m / 2.0);
    let is_full = across_m.windows(2).all(|pair| pair[1] - pair[0] <= FULL_SHARE * width_m);
    is_full.then(|| in_strip.iter().map(|(_, along_m)| *along_m).fold(f64::INFINITY, f64::min))
}

/// The length of the nearest wall, if it is an island longer than [`ISLAND_M`] in line with another wall.
fn wall_as_island_m(frame: &Frame) -> Option<f64> {
    let (points_m, junction) = (&frame.revolution.points_m, &frame.junction);
    let of_walls = || points_m.iter().zip(&junction.wall_of_return).filter_map(|(point, wall)| Some((point, (*wall)?)));
    let (_, nearest) = of_walls().min_by(|a, b| a.0.coords.norm().total_cmp(&b.0.coords.norm()))?;
    if !junction.walls[nearest as usize].island {
        return None;
    }
    let [start, end] = junction.ends_m(nearest, points_m)?;
    let line = (end - start).xy();
    let length_m = line.norm();
    if length_m <= ISLAND_M {
        return None;
    }
    let in_line_m = |id: u32| {
        let offsets_m = of_walls().filter(|(_, wall)| *wall == id).map(|(point, _)| (point - start).xy());
        let on_line_m = offsets_m.filter(|offset_m| offset_m.perp(&line).abs() < OFF_LINE_M * length_m);
        let mut along_m: Vec<f64> = on_line_m.map(|offset_m| offset_m.dot(&line) / length_m).collect();
        along_m.sort_by(f64::total_cmp);
        let spacings_m = along_m.windows(2).map(|pair| pair[1] - pair[0]);
        spacings_m.filter(|spacing_m| *spacing_m < MOST_SPACING_M).sum::<f64>()
    };
    let mut others = junction.walls.iter().filter(|wall| !wall.island);
    others.any(|wall| in_line_m(wall.id) >= IN_LINE_M).then_some(length_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::{Evidence, Wall};

    /// An answer with these walls, each the returns along a line from one point to another, and whether it is an island.
    fn answer(walls: &[([[f64; 2]; 2], usize, bool)]) -> Frame {
        let mut frame = Frame::default();
        for (id, &([from, to], returns, island)) in (0..).zip(walls) {
            for step in 0..returns {
                let share = step as f64 / (returns - 1) as f64;
                let [x, y] = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
                frame.revolution.points_m.push(Point::new(x, y, 0.0));
                frame.junction.wall_of_return.push(Some(id));
            }
            frame.junction.walls.push(Wall { id, returns, bearing_rad: [0.0; 2], island });
        }
        frame
    }

    /// An opening ahead, 4 m off, from 1 m to the right to 1 m to the left.
    fn opening_ahead() -> Opening {
        Opening {
            bearing_rad: 0.0,
            width_m: 2.0,
            walls: [0, 0],
            returns: [Some(0), Some(1)],
            gaps: Vec::new(),
            evidence: Evidence::SeenThrough,
            known: crosscut_stage::Known::Judged,
            edge_m: [Point::new(4.0, -1.0, 0.0), Point::new(4.0, 1.0, 0.0)],
            p: None,
        }
    }

    #[test]
    fn a_wall_before_all_of_an_opening_blocks_it_and_one_beside_does_not() {
        let blocked = |half_m: f64| {
            let mut frame = answer(&[([[1.5, -half_m], [1.5, half_m]], 200, false)]);
            frame.junction.openings.push(opening_ahead());
            !contradictions(&frame, 0.6).is_empty()
        };
        assert!(blocked(1.5));
        assert!(!blocked(0.4), "there is room beside it");
    }

    #[test]
    fn the_nearest_wall_is_no_long_island_in_line_with_a_wall() {
        let found = |length_m: f64, off_m: f64| {
            let island = ([[-1.0, 1.0], [-1.0 + length_m, 1.0]], 50, true);
            !contradictions(&answer(&[island, ([[2.0, 1.0 + off_m], [4.0, 1.0 + off_m]], 50, false)]), 0.6).is_empty()
        };
        assert!(found(1.6, 0.05));
        assert!(!found(1.4, 0.05) && !found(1.6, 0.8));
    }

    #[test]
    fn a_handful_of_returns_makes_no_sure_wall() {
        let found = |returns: usize, confidence: f64| {
            let mut frame =
                answer(&[([[-1.0, 1.0], [2.0, 1.0]], 90, false), ([[-1.0, -1.0], [2.0, -1.0]], returns, false)]);
            frame.junction.confidence = Some(confidence);
            !contradictions(&frame, 0.6).is_empty()
        };
        assert!(found(5, 0.95));
        assert!(!found(6, 0.95) && !found(5, 0.85));
    }
}

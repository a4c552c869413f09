//! Walls and openings of the noise-free view, by the definitions of the vocabulary.
//!
//! *An opening* is a place where a centreline of the network leaves the visible region on a walk outward from the sensor,
//! behind the shadow of a corner or at the end of the range. Each centreline counts once, where it first leaves.
//! - A centreline that becomes visible again within 3 m has not left: a bump hid it. Pillars hide no centreline.
//! - A dead end whose face is visible is closed. Otherwise it is an opening, whatever the length of the tunnel beyond.
//! - The edge of the visible region and the branch there are at least 0.6 m wide, so that a vehicle can pass.
//! - Centrelines that leave without a visible wall between them are one opening.
//! - Outside the field of view nothing is known. A centreline that leaves there at the end of the range is an opening
//!   if at least 0.6 m of the same edge is in view.
//! - Bearing and width are those of the branch, the part of the centreline that leads only to this opening, at 8 m from
//!   the sensor; or at its last visible place, if that is nearer or the branch begins farther away. The width is measured
//!   from wall to wall across the branch, ignoring pillars.
//!
//! *A wall* is what the beams between two consecutive openings hit, *an island* is a pillar. Both are numbered together,
//! by their smallest beam. Counts and numbers are those of the noise-free view: a wall whose beams are all lost counts,
//! although no label names it. Floor and roof, seen by a tilted sensor, are no wall. While the sensor moves, visibility is
//! computed for its position halfway through the sweep, and bearings for its position at that beam.

use crosscut_messages::{Truth, TruthOpening};

use crate::exits::{Exit, Sight, exits};
use crate::lidar::{Echo, Lidar};
use crate::mine::Mine;
use crosscut_stage::unit;

use crate::network::{Point, Vector, left_of};
use crate::pose::Motion;
use crate::reading::Reading;

/// A disc of this width can cross an opening.
const VEHICLE_WIDTH_M: f64 = 0.6;
/// Bearing and width of an opening are those of its branch at this distance from the sensor.
const BRANCH_AT_M: f64 = 8.0;

/// Walls and openings of one view, before any beam is lost.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenery {
    /// Number of walls, without pillars.
    pub walls: u32,
    /// Number of pillars in view.
    pub islands: u32,
    /// The openings, by ascending bearing.
    pub openings: Vec<TruthOpening>,
    /// The wall or pillar that each beam hits, if any.
    pub wall_of_beam: Vec<Option<u32>>,
}

/// An opening between two walls, with its exits: those without a wall between them.
struct Cut {
    beam: f64,
    exits: Vec<Exit>,
}

impl Mine {
    /// Walls and openings of the noise-free `view` of `lidar` during `motion`.
    pub fn scenery(&self, lidar: &Lidar, motion: &Motion, view: &[Echo]) -> Scenery {
        let from_m = motion.at(0.5 * lidar.field_of_view_rad / std::f64::consts::TAU).position_m;
        let sight = Sight { surface: self.surface(), from_m, range_m: lidar.range_max_m };
        let on_wall = |beam: usize| self.is_wall(&view[beam]);
        let mut cuts: Vec<Cut> = exits(self.skeleton(), &sight)
            .into_iter()
            .filter(|exit| self.lets_vehicle_through(exit))
            .filter_map(|exit| Some(Cut { beam: self.cut_beam(lidar, motion, view, &exit)?, exits: vec![exit] }))
            .collect();
        cuts.sort_by(|a, b| a.beam.total_cmp(&b.beam));
        merge(&mut cuts, view.len(), lidar.full_turn(), on_wall);
        let (walls, islands, wall_of_beam) = self.walls(&cuts, lidar.full_turn(), view);
        let mut openings: Vec<TruthOpening> =
            (0..cuts.len()).map(|cut| self.opening(lidar, motion, from_m, &cuts, cut)).collect();
        openings.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
        Scenery { walls, islands, openings, wall_of_beam }
    }

    fn is_wall(&self, echo: &Echo) -> bool {
        matches!(*echo, Echo::Rock { segment, .. } if self.surface().segments()[segment].pillar.is_none())
    }

    fn lets_vehicle_through(&self, exit: &Exit) -> bool {
        exit.shadow_m >= VEHICLE_WIDTH_M
            && self.clear_width_m(exit.at_m, exit.outward, exit.half_width_m) >= VEHICLE_WIDTH_M
    }

    /// Width from wall to wall across a branch of direction `along`. On a side that is open to another tunnel or a chamber,
    /// half the nominal width counts.
    fn clear_width_m(&self, at_m: Point, along: Vector, half_width_m: f64) -> f64 {
        let open_from_m = 1.5 * half_width_m + 0.5;
        [left_of(along), -left_of(along)]
            .into_iter()
            .map(|side| {
                self.surface().cast_past_pillars(at_m, side, open_from_m).map_or(half_width_m, |hit| hit.range_m)
            })
            .sum()
    }

    /// The beam, as a fractional number, that points at an exit. For an exit outside the field of view it is the middle of
    /// the beams without echo that reach from the exit into the view, if they are wide enough for the vehicle.
    fn cut_beam(&self, lidar: &Lidar, motion: &Motion, view: &[Echo], exit: &Exit) -> Option<f64> {
        let beam = lidar.beam_towards(motion, exit.at_m);
        let last = (view.len() - 1) as f64;
        if lidar.full_turn() || (0.0..=last).contains(&beam) {
            return Some(beam);
        }
        let has_no_echo = |beam: f64| {
            let pose = lidar.pose_at(motion, beam);
            let direction = unit(pose.heading_rad + lidar.bearing_rad(beam));
            self.surface().cast_past_pillars(pose.position_m, direction, lidar.range_max_m).is_none()
        };
        let outside = if beam < 0.0 { -beam } else { beam - last };
        let inward = if beam < 0.0 { 1.0 } else { -1.0 };
        let edge = if beam < 0.0 { 0.0 } else { last };
        if exit.shadow_m.is_finite() || !(0..outside as usize).all(|step| has_no_echo(edge - inward * step as f64)) {
            return None;
        }
        let seen = (0..view.len()).take_while(|&step| has_no_echo(edge + inward * step as f64)).count() as f64;
        let width_m = 2.0 * lidar.range_max_m * (0.5 * (seen - 1.0).max(0.0) * lidar.step_rad()).sin();
        (width_m >= VEHICLE_WIDTH_M).then_some(edge + inward * 0.5 * seen)
    }

    /// Numbers the walls between the cuts, and the pillars, by their smallest beam.
    fn walls(&self, cuts: &[Cut], full_turn: bool, view: &[Echo]) -> (u32, u32, Vec<Option<u32>>) {
        // Numbers given so far: to walls, by the cut before them, and to pillars.
        let (mut between, mut pillars) = (vec![None; cuts.len() + 1], Vec::<(u32, u32)>::new());
        let mut known = 0;
        let mut number = || {
            known += 1;
            known - 1
        };
        let mut wall_of_beam = Vec::with_capacity(view.len());
        for (beam, echo) in view.iter().enumerate() {
            let Echo::Rock { segment, .. } = *echo else {
                wall_of_beam.push(None);
                continue;
            };
            let wall = match self.surface().segments()[segment].pillar {
                Some(pillar) => match pillars.iter().find(|(known, _)| *known == pillar) {
                    Some(&(_, wall)) => wall,
                    None => {
                        let wall = number();
                        pillars.push((pillar, wall));
                        wall
                    }
                },
                None => {
                    let before = cuts.partition_point(|cut| cut.beam <= beam as f64);
                    // In a full turn the wall after the last cut is the one before the first.
                    let before = if full_turn && before == cuts.len() { 0 } else { before };
                    *between[before].get_or_insert_with(&mut number)
                }
            };
            wall_of_beam.push(Some(wall));
        }
        (between.iter().flatten().count() as u32, pillars.len() as u32, wall_of_beam)
    }

    /// Bearing and width of the branch of cut `own`.
    fn opening(&self, lidar: &Lidar, motion: &Motion, from_m: Point, cuts: &[Cut], own: usize) -> TruthOpening {
        let exit = &cuts[own].exits[0];
        let shared = |point: &usize| {
            cuts.iter().enumerate().any(|(cut, other)| cut != own && other.exits.iter().any(|e| e.path.contains(point)))
        };
        // The branch is the part of the path that leads to no other cut.
        let first = exit.path.iter().position(|point| !shared(point)).unwrap_or(exit.path.len());
        let branch = exit.path[first..].iter().map(|&point| {
            let point = &self.skeleton().points[point];
            (point.position_m, point.half_width_m)
        });
        let branch: Vec<(Point, f64)> = branch.chain([(exit.at_m, exit.half_width_m)]).collect();
        let (mut at_m, mut along, mut half_width_m) = (exit.at_m, exit.outward, exit.half_width_m);
        for pair in branch.windows(2) {
            let (near_m, far_m) = ((pair[0].0 - from_m).norm(), (pair[1].0 - from_m).norm());
            if near_m <= BRANCH_AT_M && far_m > BRANCH_AT_M {
                let share = (BRANCH_AT_M - near_m) / (far_m - near_m);
                at_m = pair[0].0 + (pair[1].0 - pair[0].0) * share;
                along = (pair[1].0 - pair[0].0).normalize();
                half_width_m = pair[0].1 + (pair[1].1 - pair[0].1) * share;
                break;
            }
        }
        let beam = lidar.beam_towards(motion, at_m);
        let in_view = lidar.full_turn() || (0.0..=(lidar.beams - 1) as f64).contains(&beam);
        let bearing_rad = lidar.bearing_rad(if in_view { beam } else { cuts[own].beam });
        TruthOpening {
            bearing_rad: crosscut_stage::wrap_angle_rad(bearing_rad),
            width_m: self.clear_width_m(at_m, along, half_width_m),
        }
    }
}

/// Joins consecutive cuts that have no wall between them.
fn merge(cuts: &mut Vec<Cut>, beams: usize, full_turn: bool, on_wall: impl Fn(usize) -> bool) {
    let any_wall = |from: f64, to: f64| {
        let (from, to) = (from.ceil() as usize, to.ceil() as usize);
        (from..to).any(|beam| on_wall(beam % beams))
    };
    let mut merged: Vec<Cut> = Vec::with_capacity(cuts.len());
    for cut in cuts.drain(..) {
        match merged.last_mut() {
            Some(last) if !any_wall(last.beam, cut.beam) => last.exits.extend(cut.exits),
            _ => merged.push(cut),
        }
    }
    // In a full turn the last cut and the first are neighbours.
    if full_turn && merged.len() > 1 && !any_wall(merged[merged.len() - 1].beam, merged[0].beam + beams as f64) {
        let last = merged.pop().map(|cut| cut.exits).unwrap_or_default();
        merged[0].exits.extend(last);
    }
    *cuts = merged;
}

impl Scenery {
    /// Number of beams of the wall or pillar with the fewest beams.
    pub(crate) fn fewest_beams(&self) -> usize {
        let mut beams = vec![0; (self.walls + self.islands) as usize];
        self.wall_of_beam.iter().flatten().for_each(|&wall| beams[wall as usize] += 1);
        beams.into_iter().min().unwrap_or(0)
    }

    /// The truth of a scan with these readings of the view.
    pub fn truth(&self, readings: &[Reading]) -> Truth {
        let labels = self.wall_of_beam.iter().zip(readings).map(|(wall, reading)| match (reading, wall) {
            (Reading::Nothing, _) => Truth::NO_RETURN,
            (Reading::Echo(_), Some(wall)) => *wall as i32,
            (Reading::Echo(_), None) | (Reading::Dust(_) | Reading::Mixed(_), _) => Truth::NO_WALL,
        });
        let openings = self.openings.clone();
        Truth { walls: self.walls, islands: self.islands, openings, labels: labels.collect(), ..Truth::default() }
    }
}

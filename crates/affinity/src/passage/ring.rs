//! The returns of one sweep as a ring, anticlockwise around the sensor.

use crosscut_stage::{Beam, Point, StageError, Sweep};
use nalgebra::Vector2;

/// Points of the plane, metres.
pub(super) type Place = Vector2<f64>;

/// The returns in the order in which an anticlockwise look around the sensor meets them.
#[derive(Clone, Debug, Default)]
pub(super) struct Ring {
    pub(super) returns: Vec<Entry>,
    /// Number of beams, with or without a return.
    pub(super) beams: usize,
    pub(super) step_rad: f64,
    /// The last return is followed by the first.
    pub(super) full_turn: bool,
}

/// One return.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) place_m: Place,
    pub(super) range_m: f64,
    /// Its beam, counted anticlockwise.
    pub(super) beam: usize,
    /// Its number in the revolution.
    pub(super) number: u32,
}

impl Ring {
    /// # Errors
    /// When the beams and the returns do not belong together.
    pub(super) fn fill(&mut self, sweep: &Sweep, points_m: &[Point]) -> Result<(), StageError> {
        self.returns.clear();
        (self.beams, self.step_rad, self.full_turn) = (sweep.len(), sweep.step_rad, sweep.full_turn);
        for (beam, seen) in sweep.beams.iter().enumerate() {
            let Beam::Return(number) = *seen else { continue };
            if number as usize != self.returns.len() || number as usize >= points_m.len() {
                let message = format!("beam {beam} has return {number}: not in beam order, or not there");
                return Err(StageError::Unsupported(message));
            }
            let place_m = points_m[number as usize].coords.xy();
            self.returns.push(Entry { place_m, range_m: place_m.norm(), beam, number });
        }
        if self.returns.len() != points_m.len() {
            let (beams, returns) = (self.returns.len(), points_m.len());
            return Err(StageError::Unsupported(format!("{beams} beams with a return, but {returns} returns")));
        }
        if sweep.is_clockwise() {
            self.returns.reverse();
            self.returns.iter_mut().for_each(|entry| entry.beam = sweep.len() - 1 - entry.beam);
        }
        Ok(())
    }

    pub(super) fn len(&self) -> usize {
        self.returns.len()
    }

    pub(super) fn place_m(&self, i: usize) -> Place {
        self.returns[i].place_m
    }

    pub(super) fn range_m(&self, i: usize) -> f64 {
        self.returns[i].range_m
    }

    pub(super) fn distance_m(&self, i: usize, j: usize) -> f64 {
        (self.place_m(j) - self.place_m(i)).norm()
    }

    /// The return `steps` after `i` (before it, if negative), if the view goes so far.
    pub(super) fn after(&self, i: usize, steps: isize) -> Option<usize> {
        let (n, at) = (self.len() as isize, i as isize + steps);
        if self.full_turn { Some(at.rem_euclid(n) as usize) } else { (0..n).contains(&at).then_some(at as usize) }
    }

    /// How many beams it is from one return to the other, the shorter way round.
    pub(super) fn beams_apart(&self, i: usize, j: usize) -> usize {
        let apart = self.returns[i].beam.abs_diff(self.returns[j].beam);
        if self.full_turn { apart.min(self.beams - apart) } else { apart }
    }

    /// The beams between a return and a later one.
    pub(super) fn beams_between(&self, from: usize, to: usize) -> impl Iterator<Item = usize> {
        let (from, to, beams) = (self.returns[from].beam, self.returns[to].beam, self.beams);
        (1..(to + beams - from) % beams).map(move |step| (from + step) % beams)
    }
}

/// The angle from one direction to another, anticlockwise, in [-π, π].
pub(super) fn turn_rad(from: Place, to: Place) -> f64 {
    from.perp(&to).atan2(from.dot(&to))
}

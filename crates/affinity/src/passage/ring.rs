//! The returns of one sweep as a ring, anticlockwise around the sensor.

use crosscut_stage::{Beam, Point, StageError, Sweep};
use nalgebra::Vector2;

use super::roughness::Roughness;

/// Points of the plane, metres.
pub(super) type Position = Vector2<f64>;

/// The returns in the order in which an anticlockwise look around the sensor meets them.
#[derive(Clone, Debug, Default)]
pub(super) struct Ring {
    pub(super) returns: Vec<Entry>,
    /// Number of beams in view, with or without a return.
    pub(super) beams: usize,
    pub(super) step_rad: f64,
    /// The last return is followed by the first.
    pub(super) full_turn: bool,
    pub(super) range_max_m: f64,
    /// Of its walls, once it is cut into pieces.
    pub(super) roughness: Roughness,
    /// The returns are numbered clockwise.
    pub(super) clockwise: bool,
    /// How many beams came back with nothing.
    dark: u32,
}

/// One return.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) position_m: Position,
    pub(super) range_m: f64,
    /// Its beam, counted anticlockwise.
    pub(super) beam: usize,
    /// Its number in the revolution.
    pub(super) number: u32,
    /// How many beams before its own came back with nothing.
    dark_before: u32,
    /// It is of an island, and casts a shadow.
    is_of_island: bool,
}

impl Ring {
    /// # Errors
    /// When the beams and the returns do not belong together.
    pub(super) fn fill(&mut self, sweep: &Sweep, points_m: &[Point]) -> Result<(), StageError> {
        let view = sweep.view();
        (self.beams, self.step_rad, self.full_turn) = (view.len, sweep.step_rad, view.full_turn);
        (self.clockwise, self.range_max_m) = (view.clockwise, sweep.range_max_m);
        self.roughness = Roughness::default();
        self.returns.clear();
        self.dark = 0;
        let n = points_m.len();
        // Returns are numbered in message order, which clockwise runs backward: n - 1 on is one back.
        let wrapped = |number: usize| if number < n { number } else { number - n };
        let before = sweep.beams[..view.first].iter().filter(|seen| matches!(seen, Beam::Return(_))).count();
        let step = if view.clockwise { n.saturating_sub(1) } else { 1 };
        let mut expected = if view.clockwise { wrapped(before + step) } else { wrapped(before) };
        for (beam, seen) in sweep.anticlockwise(view).enumerate() {
            match seen {
                Beam::Return(number) => {
                    let Some(point_m) = points_m.get(expected).filter(|_| number as usize == expected) else {
                        let message = format!("beam {beam} has return {number}: not in beam order, or not there");
                        return Err(StageError::Mismatch(message));
                    };
                    expected = wrapped(expected + step);
                    let position_m = point_m.coords.xy();
                    let (range_m, dark_before) = (position_m.norm(), self.dark);
                    self.returns.push(Entry { position_m, range_m, beam, number, dark_before, is_of_island: false });
                }
                Beam::NoReturn => self.dark += 1,
                Beam::Unknown => {}
            }
        }
        if self.returns.len() != n {
            let beams = self.returns.len();
            return Err(StageError::Mismatch(format!("beams with a return: {beams}, returns: {n}")));
        }
        Ok(())
    }

    pub(super) fn len(&self) -> usize {
        self.returns.len()
    }

    pub(super) fn position_m(&self, i: usize) -> Position {
        self.returns[i].position_m
    }

    pub(super) fn range_m(&self, i: usize) -> f64 {
        self.returns[i].range_m
    }

    pub(super) fn distance_m(&self, i: usize, j: usize) -> f64 {
        (self.position_m(j) - self.position_m(i)).norm()
    }

    /// The chord from the return before a return to the one after it: that return's distance from it times its length, and
    /// its length squared.
    pub(super) fn off_chord(&self, [before, i, after]: [usize; 3]) -> (f64, f64) {
        let before_m = self.position_m(before);
        let chord = self.position_m(after) - before_m;
        ((self.position_m(i) - before_m).perp(&chord).abs(), chord.norm_squared())
    }

    /// Whether two returns are at least so far from each other.
    pub(super) fn are_apart(&self, i: usize, j: usize, least_m: f64) -> bool {
        (self.position_m(j) - self.position_m(i)).norm_squared() >= least_m * least_m
    }

    /// The return `steps` after `i` (before it, if negative), if the view goes so far.
    pub(super) fn after(&self, i: usize, steps: isize) -> Option<usize> {
        let (n, at) = (self.len() as isize, i as isize + steps);
        match at {
            _ if (0..n).contains(&at) => Some(at as usize),
            _ if self.full_turn => Some(at.rem_euclid(n) as usize),
            _ => None,
        }
    }

    /// How many beams it is from one return to the other, the shorter way round.
    pub(super) fn beams_apart(&self, i: usize, j: usize) -> usize {
        let apart = self.returns[i].beam.abs_diff(self.returns[j].beam);
        if self.full_turn { apart.min(self.beams - apart) } else { apart }
    }

    /// How far it is from one return to the other for each beam between them.
    pub(super) fn spacing_m(&self, i: usize, j: usize) -> f64 {
        self.distance_m(i, j) / self.beams_apart(i, j).max(1) as f64
    }

    /// How many beams it is from a return anticlockwise to another.
    pub(super) fn beams_from(&self, from: usize, to: usize) -> usize {
        (self.returns[to].beam + self.beams - self.returns[from].beam) % self.beams
    }

    /// From now on a return is of an island.
    pub(super) fn take_for_island(&mut self, i: usize) {
        self.returns[i].is_of_island = true;
    }

    /// Whether more than half of the beams after a return and before another one end at islands.
    pub(super) fn is_shaded(&self, from: usize, to: usize) -> bool {
        if to == from || to == from + 1 {
            return false; // most often: none is between them
        }
        let between = (from + 1..self.len()).chain(0..from).take_while(|&i| i != to);
        let shaded = between.filter(|&i| self.returns[i].is_of_island).count();
        2 * shaded >= self.beams_from(from, to)
    }

    /// How many beams between a return and a later one came back with nothing.
    pub(super) fn dark_between(&self, from: usize, to: usize) -> u32 {
        let (from, to) = (&self.returns[from], &self.returns[to]);
        let around = if to.beam < from.beam { self.dark } else { 0 };
        around + to.dark_before - from.dark_before
    }

    /// Whether an end of a limited view cuts a piece: beyond it there is no return, and no beam that came back with
    /// nothing.
    pub(super) fn ends_with_view(&self, piece: &[usize]) -> bool {
        let (first, last) = (piece[0], piece[piece.len() - 1]);
        let begins = first == 0 && self.returns[first].dark_before == 0;
        let ends = last + 1 == self.len() && self.returns[last].dark_before == self.dark;
        !self.full_turn && (begins || ends)
    }
}

/// The angle from one direction to another, anticlockwise, in [-π, π].
pub(super) fn turn_rad(from: Position, to: Position) -> f64 {
    from.perp(&to).atan2(from.dot(&to))
}

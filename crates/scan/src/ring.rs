//! The returns of one sweep as a ring, anticlockwise around the sensor.

use crosscut_stage::{Beam, Point, StageError, Sweep};
use nalgebra::Vector2;

/// A point of the plane, metres.
pub type Position = Vector2<f64>;

/// The returns of a sweep in the order in which an anticlockwise look around the sensor meets them, and what its beams
/// saw between them. The view begins behind the widest blind sector ([`Sweep::view`]).
#[derive(Clone, Debug, Default)]
pub struct Ring {
    /// The returns, anticlockwise.
    pub returns: Vec<Return>,
    /// What each beam in view saw, anticlockwise.
    pub beams: Vec<Beam>,
    /// Angle from one beam to the next.
    pub step_rad: f64,
    /// The last return is followed by the first.
    pub full_turn: bool,
    /// A beam without a return saw free space up to this range.
    pub range_max_m: f64,
    /// The revolution numbers its returns clockwise.
    pub clockwise: bool,
    /// How many beams in view came back with nothing.
    dark: u32,
}

/// One return of a ring.
#[derive(Clone, Copy, Debug)]
pub struct Return {
    /// Its place in the plane.
    pub position_m: Position,
    /// Its distance from the sensor.
    pub range_m: f64,
    /// Its beam, counted anticlockwise from the first in view.
    pub beam: usize,
    /// Its number in the revolution.
    pub number: u32,
    /// How many beams in view before its own came back with nothing.
    dark_before: u32,
}

impl Ring {
    /// Fills the ring with the returns of a sweep, whose points these are; nothing of an earlier one is left.
    ///
    /// # Errors
    /// When the beams do not list all points in message order.
    pub fn fill(&mut self, sweep: &Sweep, points_m: &[Point]) -> Result<(), StageError> {
        let view = sweep.view();
        (self.step_rad, self.full_turn) = (sweep.step_rad, view.full_turn);
        (self.clockwise, self.range_max_m) = (view.clockwise, sweep.range_max_m);
        self.beams.clear();
        self.beams.extend(sweep.anticlockwise(view));
        self.returns.clear();
        self.dark = 0;
        let n = points_m.len();
        // Returns are numbered in message order, which clockwise runs backward: a step of n - 1 is one back.
        let wrapped = |number: usize| if number < n { number } else { number - n };
        let before = sweep.beams[..view.first].iter().filter(|seen| matches!(seen, Beam::Return(_))).count();
        let step = if view.clockwise { n.saturating_sub(1) } else { 1 };
        let mut expected = if view.clockwise { wrapped(before + step) } else { wrapped(before) };
        for (beam, seen) in self.beams.iter().enumerate() {
            match *seen {
                Beam::Return(number) => {
                    let Some(point_m) = points_m.get(expected).filter(|_| number as usize == expected) else {
                        let message = format!("beam {beam} has return {number}: not in beam order, or not there");
                        return Err(StageError::Mismatch(message));
                    };
                    expected = wrapped(expected + step);
                    let position_m = point_m.coords.xy();
                    let (range_m, dark_before) = (position_m.norm(), self.dark);
                    self.returns.push(Return { position_m, range_m, beam, number, dark_before });
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

    /// Number of returns.
    #[inline]
    pub fn len(&self) -> usize {
        self.returns.len()
    }

    /// Whether there is no return.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.returns.is_empty()
    }

    /// The place of return `i`.
    #[inline]
    pub fn position_m(&self, i: usize) -> Position {
        self.returns[i].position_m
    }

    /// The distance of return `i` from the sensor.
    #[inline]
    pub fn range_m(&self, i: usize) -> f64 {
        self.returns[i].range_m
    }

    /// The distance between two returns.
    #[inline]
    pub fn distance_m(&self, i: usize, j: usize) -> f64 {
        (self.position_m(j) - self.position_m(i)).norm()
    }

    /// Whether the distance between two returns is at least this.
    #[inline]
    pub fn are_apart(&self, i: usize, j: usize, least_m: f64) -> bool {
        (self.position_m(j) - self.position_m(i)).norm_squared() >= least_m * least_m
    }

    /// The return `steps` after `i`, or before it if negative; `None` beyond the end of a limited view.
    #[inline]
    pub fn after(&self, i: usize, steps: isize) -> Option<usize> {
        let (n, at) = (self.len() as isize, i as isize + steps);
        match at {
            _ if (0..n).contains(&at) => Some(at as usize),
            _ if self.full_turn => Some(at.rem_euclid(n) as usize),
            _ => None,
        }
    }

    /// How many beams lie from one return to another, the shorter way around the sensor.
    #[inline]
    pub fn beams_apart(&self, i: usize, j: usize) -> usize {
        let apart = self.returns[i].beam.abs_diff(self.returns[j].beam);
        if self.full_turn { apart.min(self.beams.len() - apart) } else { apart }
    }

    /// How many beams lie from one return anticlockwise to another.
    #[inline]
    pub fn beams_from(&self, from: usize, to: usize) -> usize {
        let (from, to) = (self.returns[from].beam, self.returns[to].beam);
        if from <= to { to - from } else { to + self.beams.len() - from }
    }

    /// The angle at the sensor from one return anticlockwise to another, radians.
    #[inline]
    pub fn span_rad(&self, from: usize, to: usize) -> f64 {
        self.beams_from(from, to) as f64 * self.step_rad
    }

    /// The distance between two returns, divided by the number of beams between them.
    #[inline]
    pub fn spacing_m(&self, i: usize, j: usize) -> f64 {
        self.distance_m(i, j) / self.beams_apart(i, j).max(1) as f64
    }

    /// How many beams from one return anticlockwise to another came back with nothing.
    #[inline]
    pub fn dark_between(&self, from: usize, to: usize) -> u32 {
        let (from, to) = (&self.returns[from], &self.returns[to]);
        let around = if to.beam < from.beam { self.dark } else { 0 };
        around + to.dark_before - from.dark_before
    }

    /// What the beams between one return and another, anticlockwise, saw.
    pub fn between(&self, from: usize, to: usize) -> impl Iterator<Item = Beam> + Clone {
        let (from, to, beams) = (self.returns[from].beam, self.returns[to].beam, &self.beams[..]);
        // From the one to the other, or on to the last beam and from the first.
        let (ahead, around) =
            if from < to { (&beams[from + 1..to], &[][..]) } else { (&beams[from + 1..], &beams[..to]) };
        ahead.iter().chain(around).copied()
    }

    /// Whether an end of a limited view cuts a piece: beyond it there is neither a return nor a beam that came back
    /// with nothing.
    pub fn ends_with_view(&self, piece: &[usize]) -> bool {
        let (first, last) = (piece[0], piece[piece.len() - 1]);
        let begins = first == 0 && self.returns[first].dark_before == 0;
        let ends = last + 1 == self.len() && self.returns[last].dark_before == self.dark;
        !self.full_turn && (begins || ends)
    }

    /// How far the middle one of three returns lies off the chord between the other two: the product of that distance
    /// and the length of the chord, and that length squared.
    pub(crate) fn off_chord(&self, [before, i, after]: [usize; 3]) -> (f64, f64) {
        let before_m = self.position_m(before);
        let chord = self.position_m(after) - before_m;
        ((self.position_m(i) - before_m).perp(&chord).abs(), chord.norm_squared())
    }
}

/// The angle from one direction anticlockwise to another, in [-π, π].
#[inline]
pub fn turn_rad(from: Position, to: Position) -> f64 {
    from.perp(&to).atan2(from.dot(&to))
}

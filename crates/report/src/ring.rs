//! The returns of walls as a ring, anticlockwise around the sensor.

use std::f64::consts::FRAC_PI_2;

use crosscut_stage::{Beam, Revolution, Sweep};
use nalgebra::Vector2;

/// A point of the plane, metres.
pub(crate) type Position = Vector2<f64>;

/// Returns that belong to a wall, in the order in which an anticlockwise look around the sensor meets them.
#[derive(Clone, Debug, Default)]
pub struct Ring {
    pub(crate) entries: Vec<Entry>,
    /// What each beam in view saw, anticlockwise.
    pub(crate) beams: Vec<Beam>,
    /// Angle from one beam to the next.
    pub(crate) step_rad: f64,
    /// The last entry is followed by the first.
    pub(crate) full_turn: bool,
}

/// One return.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) position_m: Position,
    pub(crate) range_m: f64,
    /// Its beam, counted anticlockwise.
    pub(crate) beam: usize,
    pub(crate) wall: u32,
}

impl Ring {
    /// Takes in the returns of walls, whatever was there before; those that `wall_of_return` (n entries) gives no wall
    /// are passed over.
    pub fn fill(&mut self, revolution: &Revolution, sweep: &Sweep, wall_of_return: &[Option<u32>]) {
        let view = sweep.view();
        (self.step_rad, self.full_turn) = (sweep.step_rad, view.full_turn);
        self.beams.clear();
        self.beams.extend(sweep.anticlockwise(view));
        self.entries.clear();
        for (beam, seen) in self.beams.iter().enumerate() {
            if let Beam::Return(i) = *seen
                && let Some(wall) = wall_of_return[i as usize]
            {
                let position_m = revolution.points_m[i as usize].coords.xy();
                self.entries.push(Entry { position_m, range_m: position_m.norm(), beam, wall });
            }
        }
    }

    /// Takes a wall out.
    pub(crate) fn remove(&mut self, wall: u32) {
        self.entries.retain(|entry| entry.wall != wall);
    }

    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// How many pairs of entries follow each other; an entry that is alone follows itself.
    pub(crate) fn edges(&self) -> usize {
        if self.full_turn { self.len() } else { self.len().saturating_sub(1) }
    }

    /// The entry after one, anticlockwise.
    pub(crate) fn after(&self, at: usize) -> usize {
        if at + 1 == self.len() { 0 } else { at + 1 }
    }

    /// The entry before one.
    pub(crate) fn before(&self, at: usize) -> usize {
        if at == 0 { self.len() - 1 } else { at - 1 }
    }

    /// The entries from one on, around the whole turn or to the end of a limited view.
    pub(crate) fn onward(&self, at: usize, anticlockwise: bool) -> impl Iterator<Item = &Entry> {
        let count = match (self.full_turn, anticlockwise) {
            (true, _) => self.len(),
            (false, true) => self.len() - at,
            (false, false) => at + 1,
        };
        let next = move |&at: &usize| Some(if anticlockwise { self.after(at) } else { self.before(at) });
        std::iter::successors(Some(at), next).take(count).map(|at| &self.entries[at])
    }

    /// What the beams saw between the first or the last entry of a limited view and that end of it.
    pub(crate) fn beams_to_end(&self, at: usize, anticlockwise: bool) -> &[Beam] {
        let beam = self.entries[at].beam;
        if anticlockwise { &self.beams[beam + 1..] } else { &self.beams[..beam] }
    }

    /// How far the first or the last entry of a limited view is from that end of it, across the beams; 0 unless most between
    /// the two came back with nothing, and no two beside each other are unknown: a single one may have met dust or the edge of
    /// a wall, more are a sector that was not looked at.
    pub(crate) fn room_to_end_m(&self, at: usize, anticlockwise: bool) -> f64 {
        let (end, beams) = (&self.entries[at], self.beams_to_end(at, anticlockwise));
        let dark = beams.iter().filter(|beam| **beam == Beam::NoReturn).count();
        let is_masked = beams.windows(2).any(|two| two == [Beam::Unknown; 2]);
        if is_masked || 2 * dark <= beams.len() {
            return 0.0;
        }
        // What is free is known from the first to the last of the beams.
        let turn_rad = (beams.len() - 1) as f64 * self.step_rad;
        end.range_m * turn_rad.min(FRAC_PI_2).sin()
    }

    /// What the beams saw between an entry and a later one.
    pub(crate) fn between(&self, from: usize, to: usize) -> impl Iterator<Item = Beam> + Clone {
        let (from, to, beams) = (self.entries[from].beam, self.entries[to].beam, &self.beams[..]);
        // From the one to the other, or on to the last beam and from the first.
        let (ahead, around) =
            if from < to { (&beams[from + 1..to], &[][..]) } else { (&beams[from + 1..], &beams[..to]) };
        ahead.iter().chain(around).copied()
    }
}

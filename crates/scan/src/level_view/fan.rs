//! Beams all around the sensor.

use std::f64::consts::TAU;

use crosscut_stage::{Beam, Sweep, wrap_angle_rad};
use nalgebra::{UnitComplex, Vector2};

/// Beams all around, as wide as the angle from one to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct LevelBeams {
    /// The bearing of the middle of the first one.
    pub(super) first_rad: f64,
    pub(super) beams: usize,
    /// The directions in which the beams begin, anticlockwise, and that in which the last one ends.
    edges: Vec<Vector2<f64>>,
}

impl LevelBeams {
    pub(super) fn open(&mut self, first_rad: f64, beams: usize) {
        (self.first_rad, self.beams) = (first_rad, beams);
        let step_rad = self.step_rad();
        let (step, first) = (UnitComplex::new(step_rad), UnitComplex::new(first_rad - 0.5 * step_rad));
        self.edges.clear();
        let edges = std::iter::successors(Some(first * Vector2::x()), |edge| Some(step * edge));
        self.edges.extend(edges.take(beams + 1));
    }

    pub(super) fn step_rad(&self) -> f64 {
        TAU / self.beams.max(1) as f64
    }

    /// The bearing of the middle of a beam, which may be counted on around the turn.
    pub(super) fn bearing_rad(&self, beam: usize) -> f64 {
        wrap_angle_rad(self.first_rad + beam as f64 * self.step_rad())
    }

    /// The beam in which a place lies. Most clouds list their points beam by beam, so the beams around a `guess`, that
    /// of the point before, are tried first; if none of them holds the place, an arc tangent finds it.
    pub(super) fn beam(&self, place_m: Vector2<f64>, guess: usize) -> usize {
        let next = if guess + 1 == self.beams { 0 } else { guess + 1 };
        let previous = if guess == 0 { self.beams - 1 } else { guess - 1 };
        let found = [guess, next, previous].into_iter().find(|&beam| self.holds(beam, place_m));
        found.unwrap_or_else(|| {
            let offset_rad = wrap_angle_rad(place_m.y.atan2(place_m.x) - self.first_rad);
            let offset = (offset_rad / TAU * self.beams as f64).round() as isize;
            offset.rem_euclid(self.beams as isize) as usize
        })
    }

    /// Marks the beams in which a beam of `sweep` came back with nothing.
    pub(super) fn mark_free(&self, sweep: &Sweep, beams: &mut [Beam]) {
        let mut beam = 0;
        let free = sweep.beams.iter().zip(&sweep.bearings_rad).filter(|(seen, _)| **seen == Beam::NoReturn);
        for (_, bearing_rad) in free.take_while(|_| self.beams > 0) {
            beam = self.beam(UnitComplex::new(*bearing_rad) * Vector2::x(), beam);
            beams[beam] = Beam::NoReturn;
        }
    }

    fn holds(&self, beam: usize, place_m: Vector2<f64>) -> bool {
        self.edges[beam].perp(&place_m) >= 0.0 && self.edges[beam + 1].perp(&place_m) < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_guess_finds_the_beam_of_a_place() {
        let mut fan = LevelBeams::default();
        for (first_rad, beams) in [(0.0, 1), (-2.0, 2), (1.0, 3), (3.0, 7), (-3.1, 720)] {
            fan.open(first_rad, beams);
            for beam in 0..beams {
                for share in [-0.49, 0.0, 0.49] {
                    let bearing_rad = first_rad + (beam as f64 + share) * fan.step_rad();
                    let place_m = 3.0 * Vector2::new(bearing_rad.cos(), bearing_rad.sin());
                    let found = |guess: usize| fan.beam(place_m, guess % beams);
                    assert!((beam..beam + 4).chain([beam + beams - 1]).all(|guess| found(guess) == beam));
                }
            }
        }
    }
}

//! The returns of walls as a ring, each with its wall.

use std::f64::consts::FRAC_PI_2;

use crosscut_scan::{Position, Return, Ring};
use crosscut_stage::{Beam, Revolution, StageError, Sweep};

/// The returns of walls in the order in which an anticlockwise look around the sensor meets them. Returns of no wall
/// are seen only as beams between them.
#[derive(Clone, Debug, Default)]
pub struct WallRing {
    pub(crate) ring: Ring,
    /// The wall of each return of the ring.
    walls: Vec<u32>,
}

impl WallRing {
    /// Fills the outline with the returns that `wall_of_return` (n entries) gives a wall; nothing of an earlier one is
    /// left.
    ///
    /// # Errors
    /// When the beams do not list all returns in message order.
    pub fn fill(
        &mut self,
        revolution: &Revolution,
        sweep: &Sweep,
        wall_of_return: &[Option<u32>],
    ) -> Result<(), StageError> {
        let Self { ring, walls } = self;
        ring.fill(sweep, &revolution.points_m)?;
        walls.clear();
        ring.returns.retain(|one| {
            let wall = wall_of_return[one.number as usize];
            walls.extend(wall);
            wall.is_some()
        });
        Ok(())
    }

    /// Takes a wall out.
    pub(crate) fn remove(&mut self, wall: u32) {
        let mut walls = self.walls.iter();
        self.ring.returns.retain(|_| walls.next() != Some(&wall));
        self.walls.retain(|&other| other != wall);
    }

    /// Number of returns.
    pub(crate) fn len(&self) -> usize {
        self.ring.len()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.ring.is_empty()
    }

    /// The wall of each return.
    pub(crate) fn walls(&self) -> &[u32] {
        &self.walls
    }

    pub(crate) fn wall(&self, at: usize) -> u32 {
        self.walls[at]
    }

    /// The place in the ring of a return by its number in the revolution; `None` if it is of no wall.
    pub(crate) fn place_of(&self, number: u32) -> Option<usize> {
        let first = self.ring.returns.first()?.number;
        let order = |number: u32| self.order_from(first, number);
        self.ring.returns.binary_search_by_key(&order(number), |one| order(one.number)).ok()
    }

    /// The places of two returns, if both are of walls.
    pub(crate) fn places_of(&self, [from, to]: [u32; 2]) -> Option<[usize; 2]> {
        Some([self.place_of(from)?, self.place_of(to)?])
    }

    /// By this, the returns that follow one anticlockwise are in order. Returns are numbered in message order.
    pub(crate) fn order_from(&self, from: u32, to: u32) -> u32 {
        if self.ring.clockwise { from.wrapping_sub(to) } else { to.wrapping_sub(from) }
    }

    pub(crate) fn position_m(&self, at: usize) -> Position {
        self.ring.position_m(at)
    }

    pub(crate) fn range_m(&self, at: usize) -> f64 {
        self.ring.range_m(at)
    }

    /// Each return with the next one anticlockwise; a return that is alone is followed by itself.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        let pairs = if self.ring.full_turn { self.len() } else { self.len().saturating_sub(1) };
        (0..pairs).map(|at| [at, self.after(at)])
    }

    /// Each return of a wall with the next one anticlockwise, if that is another one of the same wall.
    pub(crate) fn pairs_within_walls(&self) -> impl Iterator<Item = [usize; 2]> {
        self.pairs().filter(|&[from, to]| from != to && self.wall(from) == self.wall(to))
    }

    /// The returns of one wall from one of them on, around the whole turn or to the end of a limited view.
    pub(crate) fn wall_from(&self, at: usize, anticlockwise: bool) -> impl Iterator<Item = &Return> {
        let count = match (self.ring.full_turn, anticlockwise) {
            (true, _) => self.len(),
            (false, true) => self.len() - at,
            (false, false) => at + 1,
        };
        let next = move |&at: &usize| Some(if anticlockwise { self.after(at) } else { self.before(at) });
        let onward = std::iter::successors(Some(at), next).take(count);
        onward.take_while(move |&other| self.walls[other] == self.walls[at]).map(|at| &self.ring.returns[at])
    }

    /// The next return anticlockwise.
    fn after(&self, at: usize) -> usize {
        if at + 1 == self.len() { 0 } else { at + 1 }
    }

    /// The next return clockwise.
    fn before(&self, at: usize) -> usize {
        if at == 0 { self.len() - 1 } else { at - 1 }
    }

    /// What the beams saw between the first or the last return of a limited view and that end of the view.
    pub(crate) fn beams_to_end(&self, at: usize, anticlockwise: bool) -> &[Beam] {
        let beam = self.ring.returns[at].beam;
        if anticlockwise { &self.ring.beams[beam + 1..] } else { &self.ring.beams[..beam] }
    }

    /// How far the first or the last return of a limited view is from that end of the view, across the beams, metres.
    /// The distance is 0 unless most beams between the two came back with nothing, and no two neighbours of them are unknown: a
    /// single unknown beam may have met dust or the edge of a wall, more are a sector that the sensor did not look at.
    pub(crate) fn room_to_end_m(&self, at: usize, anticlockwise: bool) -> f64 {
        let beams = self.beams_to_end(at, anticlockwise);
        let dark = beams.iter().filter(|beam| **beam == Beam::NoReturn).count();
        let is_masked = beams.windows(2).any(|two| two == [Beam::Unknown; 2]);
        if is_masked || 2 * dark <= beams.len() {
            return 0.0;
        }
        // Free space is known from the first of the beams to the last.
        let turn_rad = (beams.len() - 1) as f64 * self.ring.step_rad;
        self.range_m(at) * turn_rad.min(FRAC_PI_2).sin()
    }
}

//! The place of each row of W along the sides of the pictures: of a return, the index of its beam; directions follow each other.
//!
//! A picture of n×n returns would change its size with every revolution, which the viewer takes for a broken video, and
//! its walls would jump. By beam, walls stay in place and openings are dark bands.

use crosscut_stage::{Beam, Frame, Revolution};

/// Longest side of a picture, pixels.
pub(crate) const LARGEST_SIDE: usize = 1024;

/// Sides are multiples of this, so that one beam more or less does not change them.
const SIDE_STEP: usize = 64;

/// The places of the returns of one revolution along the side of a square picture.
pub(crate) struct BeamOrder {
    /// Pixels of a side; those from `used` on are dark.
    pub(crate) side: usize,
    /// Number of places that a return can have.
    pub(crate) used: usize,
    /// Where each row begins, ascending.
    pub(crate) places: Vec<usize>,
    /// Pixels that a row takes.
    pub(crate) pixels: usize,
}

impl BeamOrder {
    /// Of the rows of W: of directions, all along the largest side; of returns, by beam up to [`LARGEST_SIDE`] beams; with more of
    /// them, or without beams, by return.
    pub(crate) fn of(frame: &Frame) -> Self {
        match &frame.affinity.dual {
            None => Self::of_returns(&frame.revolution),
            Some(_) => {
                let n = frame.affinity.weights.n();
                let pixels = (LARGEST_SIDE / n.max(1)).max(1);
                let places = (0..n).map(|row| row * pixels).collect();
                Self { side: LARGEST_SIDE, used: LARGEST_SIDE, places, pixels }
            }
        }
    }

    fn of_returns(revolution: &Revolution) -> Self {
        let n = revolution.len();
        let used = match beams_of_returns(revolution) {
            Some((beams, places)) if beams <= LARGEST_SIDE => {
                return Self { side: beams.next_multiple_of(SIDE_STEP), used: beams, places, pixels: 1 };
            }
            Some(_) => LARGEST_SIDE, // fits any number of returns
            None => n.min(LARGEST_SIDE),
        };
        Self { side: LARGEST_SIDE, used, places: (0..n).collect(), pixels: 1 }
    }
}

/// The number of beams, and the beam of each return; `None` without beams.
pub(crate) fn beams_of_returns(revolution: &Revolution) -> Option<(usize, Vec<usize>)> {
    let beams = &revolution.beams()?.beams;
    let hit = |(place, beam): (usize, &Beam)| matches!(beam, Beam::Return(_)).then_some(place);
    let places: Vec<usize> = beams.iter().enumerate().filter_map(hit).collect();
    (!beams.is_empty() && places.len() == revolution.len()).then_some((beams.len(), places))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::{Point, Sweep};

    fn revolution(beams: Vec<Beam>) -> Revolution {
        let returns = beams.iter().filter(|beam| matches!(beam, Beam::Return(_))).count();
        let sweep = Some(Sweep { beams, ..Sweep::default() });
        Revolution { points_m: vec![Point::origin(); returns], sweep, ..Revolution::default() }
    }

    #[test]
    fn returns_are_placed_at_their_beams() {
        let order =
            BeamOrder::of_returns(&revolution(vec![Beam::NoReturn, Beam::Return(0), Beam::Unknown, Beam::Return(1)]));
        assert_eq!((order.side, order.used, order.places), (64, 4, vec![1, 3]));
    }

    #[test]
    fn the_side_depends_on_the_beams_alone() {
        for beams in [355, 360, 365] {
            assert_eq!(BeamOrder::of_returns(&revolution(vec![Beam::NoReturn; beams])).side, 384);
        }
    }

    #[test]
    fn many_beams_and_clouds_are_placed_by_return() {
        let mut many = vec![Beam::NoReturn; 2000];
        many[1999] = Beam::Return(0);
        let order = BeamOrder::of_returns(&revolution(many));
        assert_eq!((order.side, order.used, order.places), (1024, 1024, vec![0]));
        let cloud = Revolution { points_m: vec![Point::origin(); 5], ..Revolution::default() };
        assert_eq!(BeamOrder::of_returns(&cloud).places, [0, 1, 2, 3, 4]);
    }
}

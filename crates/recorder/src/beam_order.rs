//! Where a return stands along the edges of the pictures: at its beam.
//!
//! A picture of n×n returns would change its size with every revolution, which the viewer takes for a broken video, and
//! its walls would jump about. By beam, walls stay in place and openings are seen as dark bands.

use crosscut_stage::{Beam, Revolution};

/// No picture has a longer side.
pub(crate) const LARGEST_SIDE: usize = 1024;

/// Sides are multiples of this, so that a beam more or less does not change them.
const SIDE_STEP: usize = 64;

/// The places of the returns of one revolution along the side of a square picture.
pub(crate) struct BeamOrder {
    /// Pixels a side; those from `used` on are dark.
    pub(crate) side: usize,
    /// Places that a return can have.
    pub(crate) used: usize,
    /// The place of each return, ascending.
    pub(crate) places: Vec<usize>,
}

impl BeamOrder {
    /// By beam, up to [`LARGEST_SIDE`] beams; beyond that, and without beams, by return.
    pub(crate) fn of(revolution: &Revolution) -> Self {
        let n = revolution.len();
        let used = match beams_of_returns(revolution) {
            Some((beams, places)) if beams <= LARGEST_SIDE => {
                return Self { side: beams.next_multiple_of(SIDE_STEP), used: beams, places };
            }
            Some(_) => LARGEST_SIDE, // how many return varies: the side holds any number
            None => n.min(LARGEST_SIDE),
        };
        Self { side: LARGEST_SIDE, used, places: (0..n).collect() }
    }
}

/// How many beams there are, and that of each return; `None` without beams.
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
    fn returns_stand_at_their_beams() {
        let order = BeamOrder::of(&revolution(vec![Beam::NoReturn, Beam::Return(0), Beam::Unknown, Beam::Return(1)]));
        assert_eq!((order.side, order.used, order.places), (64, 4, vec![1, 3]));
    }

    #[test]
    fn the_side_depends_on_the_beams_alone_and_not_on_the_returns() {
        for beams in [355, 360, 365] {
            assert_eq!(BeamOrder::of(&revolution(vec![Beam::NoReturn; beams])).side, 384);
        }
    }

    #[test]
    fn more_beams_than_pixels_and_clouds_stand_by_return() {
        let mut many = vec![Beam::NoReturn; 2000];
        many[1999] = Beam::Return(0);
        let order = BeamOrder::of(&revolution(many));
        assert_eq!((order.side, order.used, order.places), (1024, 1024, vec![0]));
        let cloud = Revolution { points_m: vec![Point::origin(); 5], ..Revolution::default() };
        assert_eq!(BeamOrder::of(&cloud).places, [0, 1, 2, 3, 4]);
    }
}

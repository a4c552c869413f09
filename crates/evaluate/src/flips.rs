//! A whole flight: counts that differ from those around them.

/// So many revolutions before and after are around a revolution.
pub const AROUND: usize = 5;

/// A revolution with another count than most around it have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flip {
    /// Its place in the flight.
    pub at: usize,
    /// Its count.
    pub junctions: usize,
    /// The count of more than half of those around it.
    pub around: usize,
}

/// The revolutions whose count differs from the one that more than half of the [`AROUND`] before and after have; fewer
/// at the ends of the flight. Where none has that many, nothing differs from it.
pub fn flips(junctions: &[usize]) -> Vec<Flip> {
    let flip = |at: usize| {
        let around = &junctions[at.saturating_sub(AROUND)..(at + AROUND + 1).min(junctions.len())];
        let others = around.len() - 1;
        let differs = |count: &&usize| **count != junctions[at];
        let is_majority = |count: &&usize| 2 * around.iter().filter(|other| other == count).count() > others;
        let &around = around.iter().filter(differs).find(is_majority)?;
        Some(Flip { at, junctions: junctions[at], around })
    };
    (0..junctions.len()).filter_map(flip).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_that_most_around_it_do_not_have_is_a_flip_and_a_lasting_change_is_none() {
        let flight = [2, 2, 2, 3, 2, 2, 2, 2, 4, 4, 4, 4, 4, 4];
        assert_eq!(flips(&flight), [Flip { at: 3, junctions: 3, around: 2 }]);
        assert_eq!(flips(&[1, 2, 2]), [Flip { at: 0, junctions: 1, around: 2 }], "at the start");
        assert!(flips(&[]).is_empty() && flips(&[7]).is_empty());
    }

    #[test]
    fn where_no_count_has_more_than_half_nothing_flips() {
        assert!(flips(&[1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3]).is_empty());
    }
}

//! Revolutions of a flight whose count differs from their neighbours.

/// A revolution has this many neighbours before it and after it.
pub const AROUND: usize = 5;

/// A revolution whose count differs from that of most of its neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flip {
    /// Its index in the flight.
    pub at: usize,
    /// Its count.
    pub junctions: usize,
    /// The count of more than half of its neighbours.
    pub around: usize,
}

/// Returns the revolutions whose count differs from the count of more than half of their neighbours: [`AROUND`] before
/// and after, fewer at the ends of the flight. Where no count has that majority, there is no flip.
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
    fn a_single_deviation_is_a_flip_and_a_lasting_change_is_none() {
        let flight = [2, 2, 2, 3, 2, 2, 2, 2, 4, 4, 4, 4, 4, 4];
        assert_eq!(flips(&flight), [Flip { at: 3, junctions: 3, around: 2 }]);
        assert_eq!(flips(&[1, 2, 2]), [Flip { at: 0, junctions: 1, around: 2 }], "at the start");
        assert!(flips(&[]).is_empty() && flips(&[7]).is_empty());
    }

    #[test]
    fn without_a_majority_there_is_no_flip() {
        assert!(flips(&[1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3]).is_empty());
    }
}

//! Clusters numbered by their first return.

/// The new number of each of `clusters` clusters: 0 for the one that appears first in `labels`, and so on; `None` for
/// one that does not appear.
pub(crate) fn by_first_return(labels: impl IntoIterator<Item = u32>, clusters: usize) -> Vec<Option<u32>> {
    let mut numbers = vec![None; clusters];
    let mut next = 0;
    for label in labels {
        let number = &mut numbers[label as usize];
        if number.is_none() {
            *number = Some(next);
            next += 1;
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_to_appear_is_number_0_and_the_absent_have_none() {
        assert_eq!(by_first_return([2, 2, 0, 3, 0], 4), [Some(1), None, Some(0), Some(2)]);
    }
}

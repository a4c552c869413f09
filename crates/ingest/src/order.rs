//! Numbers in order.

/// The middle one of these numbers.
pub(crate) fn usual(numbers: impl IntoIterator<Item = f64>) -> Option<f64> {
    at_share(numbers, 0.5)
}

/// The number that this share of all numbers lie below.
pub(crate) fn at_share(numbers: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let mut numbers: Vec<f64> = numbers.into_iter().collect();
    let at = (share * numbers.len() as f64) as usize;
    (at < numbers.len()).then(|| *numbers.select_nth_unstable_by(at, f64::total_cmp).1)
}

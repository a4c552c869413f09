//! U: its memory, and the signs of its columns.

use crosscut_stage::StageError;
use faer::Mat;

/// Numbers in a U, 268 MB of them: twice those of 4096 returns, the most of a message, of which each is a component of its own.
const MOST_NUMBERS: usize = 1 << 25;

/// Makes `u` a matrix of zeros in the memory that it has.
///
/// # Errors
/// If there are more than [`MOST_NUMBERS`].
pub(crate) fn make_zero(u: &mut Mat<f64>, nrows: usize, ncols: usize) -> Result<(), StageError> {
    if nrows.saturating_mul(ncols) > MOST_NUMBERS {
        return Err(StageError::TooLarge(format!(
            "U of {nrows} returns in {ncols} components has more than {MOST_NUMBERS} numbers; an affinity with more edges leaves \
             fewer components"
        )));
    }
    u.resize_with(nrows, ncols, |_, _| 0.0);
    u.fill(0.0);
    Ok(())
}

/// The sign of the entry of largest magnitude, the first of equals.
pub(crate) fn sign_of_largest(vector: &[f64]) -> f64 {
    let largest = vector.iter().fold(0.0f64, |largest, &x| if x.abs() > largest.abs() { x } else { largest });
    1.0f64.copysign(largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_entry_of_largest_magnitude_decides_the_sign() {
        assert_eq!(sign_of_largest(&[0.1, -0.7, 0.7]), -1.0);
        assert_eq!(sign_of_largest(&[0.1, 0.7, -0.7]), 1.0);
        assert_eq!(sign_of_largest(&[0.0, 0.0]), 1.0);
    }
}

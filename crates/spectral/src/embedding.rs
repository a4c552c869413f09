//! U: its memory, and the signs of its columns.

use faer::Mat;

/// Makes `u` a matrix of zeros in the memory that it has.
pub(crate) fn make_zero(u: &mut Mat<f64>, nrows: usize, ncols: usize) {
    u.resize_with(nrows, ncols, |_, _| 0.0);
    u.fill(0.0);
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

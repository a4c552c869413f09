//! Degrees that a Laplacian can be made of, and their sums.

use crosscut_stage::{Affinity, StageError};

/// # Errors
/// When there is not one degree for each return, or one of them is not finite or not above 0.
pub(crate) fn check_degrees(affinity: &Affinity) -> Result<(), StageError> {
    let n = affinity.weights.n();
    if affinity.degrees.len() != n {
        let degrees = affinity.degrees.len();
        return Err(StageError::Mismatch(format!("W is {n}x{n}, but there are {degrees} degrees")));
    }
    for (index, &degree) in affinity.degrees.iter().enumerate() {
        if !degree.is_finite() {
            return Err(StageError::NotFinite { what: "the degree", index });
        }
        if degree <= 0.0 {
            let message = format!(
                "the degree of return {index} is {degree}: W needs ones on its diagonal, and no negative weight"
            );
            return Err(StageError::Mismatch(message));
        }
    }
    Ok(())
}

/// Σ D_ii over each component, as [`DisjointSets::number_components`] numbers them.
///
/// [`DisjointSets::number_components`]: crosscut_stage::DisjointSets::number_components
pub(crate) fn sum_volumes(component_of_return: &[u32], degrees: &[f64], out: &mut Vec<f64>) {
    out.clear();
    for (&component, &degree) in component_of_return.iter().zip(degrees) {
        match out.get_mut(component as usize) {
            Some(volume) => *volume += degree,
            None => out.push(degree), // components appear in the order of their numbers
        }
    }
}

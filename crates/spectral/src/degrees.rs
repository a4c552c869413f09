//! Degrees that a Laplacian can be made of.

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

//! Points that an affinity can work on.

use crosscut_stage::{Point, StageError};

/// # Errors
/// The first point with a coordinate that is NaN or infinite.
pub(crate) fn check_finite(points_m: &[Point]) -> Result<(), StageError> {
    match points_m.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        Some(index) => Err(StageError::NotFinite { what: "the point", index }),
        None => Ok(()),
    }
}

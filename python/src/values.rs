//! Arguments that are checked as they are read: a wrong type is a `TypeError`, a wrong value a `ValueError`.

use nalgebra::{Isometry2, Vector2};
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;

/// A whole number from 0.
pub(crate) struct Whole(pub(crate) u64);

impl<'py> FromPyObject<'_, 'py> for Whole {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        held(object, "not from 0 to 2^64 - 1").map(Self)
    }
}

/// Any number.
pub(crate) struct Real(pub(crate) f64);

impl<'py> FromPyObject<'_, 'py> for Real {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        held(object, "larger than any number of 64 bits").map(Self)
    }
}

/// The value, if its type holds it; of a number that is `beyond` the type, a `ValueError` that says so.
fn held<'py, T>(object: Borrowed<'_, 'py, PyAny>, beyond: &str) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py, Error = PyErr>,
{
    object.extract().map_err(|error: PyErr| {
        let is_too_large = error.is_instance_of::<PyOverflowError>(object.py());
        if is_too_large { PyValueError::new_err(format!("{} is {beyond}", &*object)) } else { error }
    })
}

/// x and y in metres and yaw in radians, all finite.
pub(crate) struct Pose(pub(crate) Isometry2<f64>);

impl<'py> FromPyObject<'_, 'py> for Pose {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let numbers: PyResult<Vec<Real>> = object.try_iter()?.take(4).map(|number| number?.extract()).collect();
        let [Real(x_m), Real(y_m), Real(yaw_rad)] = numbers?[..] else {
            return Err(PyTypeError::new_err("a pose is three numbers: x and y in metres, yaw in radians"));
        };
        if ![x_m, y_m, yaw_rad].iter().all(|number| number.is_finite()) {
            return Err(PyValueError::new_err(format!("a pose is finite, not ({x_m}, {y_m}, {yaw_rad})")));
        }
        Ok(Self(Isometry2::new(Vector2::new(x_m, y_m), yaw_rad)))
    }
}

/// A pose as Python has it.
pub(crate) fn xy_yaw(pose: &Isometry2<f64>) -> (f64, f64, f64) {
    (pose.translation.x, pose.translation.y, pose.rotation.angle())
}

//! Eigenvalues and U by a callable: spectral(W) -> (eigenvalues, U).

use crosscut_stage::{Affinity, Kind, Notes, SpectralStage, Spectrum, StageError};
use faer::Mat;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::{CALLABLE, Callable, PYTHON};
use crate::arrays::{self, Matrix};

pub(crate) const KIND: Kind<dyn SpectralStage> =
    Kind::spectral(PYTHON, "λ and U by a callable of Python: spectral(W) -> (eigenvalues, U)", |params| {
        Box::new(PythonSpectral { callable: Callable::chosen(params) })
    })
    .params(&[CALLABLE.spec]);

/// No eigenvalue of a normalised Laplacian is larger.
const LARGEST: f64 = 2.0;
/// None is below 0 but for rounding, which in single precision reaches a few millionths.
const LEAST: f64 = -1e-4;

struct PythonSpectral {
    callable: Option<Callable>,
}

impl SpectralStage for PythonSpectral {
    fn spectrum(&mut self, affinity: &Affinity, out: &mut Spectrum, _: &mut Notes) -> Result<(), StageError> {
        let (callable, n) = (self.callable.as_ref(), affinity.weights.n());
        let (eigenvalues, u) = if n == 0 {
            (Vec::new(), Matrix::Dense { shape: [0, 0], flat: Vec::new() })
        } else {
            let w = &affinity.weights;
            Callable::call(callable, |py| PyTuple::new(py, [arrays::weights(py, w)?]), |returned| read(returned, n))?
        };
        check(&eigenvalues, &u, n).map_err(|what| Callable::refuse(callable, what))?;
        let [_, k] = u.shape();
        *out = Spectrum {
            tolerance: eigenvalues.get(k).copied().unwrap_or(LARGEST),
            eigenvalues,
            k,
            margin_decades: None,
            ..std::mem::take(out)
        };
        out.u = Mat::from_fn(n, k, |i, j| u.at(i, j));
        Ok(())
    }
}

/// Eigenvalues and U of n returns.
fn read(returned: &Bound<'_, PyAny>, n: usize) -> PyResult<(Vec<f64>, Matrix)> {
    let pair: PyResult<(Bound<'_, PyAny>, Bound<'_, PyAny>)> = returned.extract();
    let (eigenvalues, u) = pair
        .map_err(|_| PyTypeError::new_err(format!("{} is not a pair of eigenvalues and U", arrays::kind(returned))))?;
    Ok((arrays::vector(&eigenvalues, n)?, Matrix::of(&u, |[rows, k]| rows == n && k <= n)?))
}

/// What is wrong with the spectrum of n returns.
fn check(eigenvalues: &[f64], u: &Matrix, n: usize) -> Result<(), String> {
    let [rows, k] = u.shape();
    if rows != n || k > n {
        return Err(format!("a U of shape ({rows}, {k}) for {n} returns, not ({n}, k) with k <= {n}"));
    }
    if !(k..=n).contains(&eigenvalues.len()) {
        return Err(format!("{} eigenvalues for {n} returns and a U of {k} columns", eigenvalues.len()));
    }
    if let Some(at) = eigenvalues.iter().position(|value| !value.is_finite()) {
        return Err(format!("an eigenvalue that is not finite: eigenvalues[{at}] = {}", eigenvalues[at]));
    }
    if let Some(at) = eigenvalues.iter().position(|value| *value < LEAST) {
        return Err(format!(
            "an eigenvalue below 0, which no Laplacian of a W has: eigenvalues[{at}] = {}",
            eigenvalues[at]
        ));
    }
    if !eigenvalues.is_sorted() {
        return Err("eigenvalues that do not ascend".to_owned());
    }
    let mut wrong = None;
    u.for_each(|i, j, value| {
        if !value.is_finite() {
            wrong.get_or_insert(format!("a U that is not finite: U[{i}, {j}] = {value}"));
        }
    });
    wrong.map_or(Ok(()), Err)
}

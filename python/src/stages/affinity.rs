//! W by a callable: affinity(points) -> W.

use crosscut_stage::{Affinity, AffinityStage, Invariance, Kind, Notes, Revolution, StageError};
use pyo3::types::PyTuple;

use super::{CALLABLE, Callable, PYTHON};
use crate::arrays::{self, Matrix};

/// Its W may be sparse or have all entries: the memory is that of a sparse one with all.
pub(crate) const KIND: Kind<dyn AffinityStage> =
    Kind::affinity(PYTHON, "W by a callable of Python: affinity(points) -> W", |params| {
        Box::new(PythonAffinity { callable: Callable::chosen(params) })
    })
    .params(&[CALLABLE.spec])
    .blind_to(&[] as &[Invariance]);

struct PythonAffinity {
    callable: Option<Callable>,
}

impl AffinityStage for PythonAffinity {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        let (callable, n) = (self.callable.as_ref(), revolution.len());
        if n == 0 {
            out.weights.make_dense(0);
            return Ok(());
        }
        let points_m = &revolution.points_m;
        let w = Callable::call(
            callable,
            |py| PyTuple::new(py, [arrays::points(py, points_m)?]),
            |returned| Matrix::of(returned, |shape| shape == [n, n]),
        )?;
        check(&w, n).map_err(|what| Callable::refuse(callable, what))?;
        match &w {
            Matrix::Dense { .. } => {
                let dense = out.weights.make_dense(n);
                w.for_each(|i, j, value| dense[(i, j)] = value);
            }
            Matrix::Sparse { starts, columns, values, .. } => {
                let sparse = out.weights.make_sparse();
                for span in starts.windows(2) {
                    sparse.push_row(&columns[span[0]..span[1]], &values[span[0]..span[1]]);
                }
            }
        }
        Ok(())
    }
}

/// What is wrong with W of n returns.
fn check(w: &Matrix, n: usize) -> Result<(), String> {
    let [rows, columns] = w.shape();
    if [rows, columns] != [n, n] {
        return Err(format!("a W of shape ({rows}, {columns}) for {n} returns, not ({n}, {n})"));
    }
    let mut wrong = None;
    w.for_each(|i, j, value| {
        if wrong.is_some() {
            return;
        }
        if !value.is_finite() {
            wrong = Some(format!("a W that is not finite: W[{i}, {j}] = {value}"));
        } else if !(0.0..=1.0).contains(&value) {
            wrong = Some(format!("a W outside 0 to 1: W[{i}, {j}] = {value}"));
        } else if w.at(j, i).to_bits() != value.to_bits() {
            let other = w.at(j, i);
            wrong = Some(format!(
                "a W that is not symmetric: W[{i}, {j}] = {value} and W[{j}, {i}] = {other}; (W + W.T) / 2 is"
            ));
        }
    });
    wrong = wrong.or_else(|| {
        let odd = (0..n).find(|&i| w.at(i, i) != 1.0)?;
        Some(format!("a W whose diagonal is not 1: W[{odd}, {odd}] = {}", w.at(odd, odd)))
    });
    wrong.map_or(Ok(()), Err)
}

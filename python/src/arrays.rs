//! Matrices and points as arrays of numpy and scipy, and back.

use crosscut_stage::{Csr, Embedding, Point, Weights};
use numpy::{
    AllowTypeChange, IntoPyArray, PyArrayDescrMethods, PyArrayLike1, PyArrayLike2, PyArrayMethods, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Points as an (n, 3) array, metres.
pub(crate) fn points<'py>(py: Python<'py>, points_m: &[Point]) -> PyResult<Bound<'py, PyAny>> {
    let flat: Vec<f64> = points_m.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    Ok(flat.into_pyarray(py).reshape([points_m.len(), 3])?.into_any())
}

/// W as an (n, n) array, or as a `scipy.sparse.csr_array` if it is stored by its nonzero entries.
pub(crate) fn weights<'py>(py: Python<'py>, weights: &Weights) -> PyResult<Bound<'py, PyAny>> {
    match weights {
        Weights::Sparse(w) => csr(py, w, w.n()),
        w => dense(py, [w.n(), w.n()], |flat| w.for_each(|i, j, value| flat[i * w.n() + j] = value)),
    }
}

/// U as an (n, k) array, or as a `scipy.sparse.csr_array` if it has very many columns.
pub(crate) fn embedding<'py>(py: Python<'py>, u: &Embedding) -> PyResult<Bound<'py, PyAny>> {
    match u {
        Embedding::Sparse { columns, rows } => csr(py, rows, *columns),
        u => dense(py, [u.nrows(), u.ncols()], |flat| u.for_each(|i, j, value| flat[i * u.ncols() + j] = value)),
    }
}

fn dense(py: Python<'_>, shape: [usize; 2], fill: impl FnOnce(&mut [f64])) -> PyResult<Bound<'_, PyAny>> {
    let mut flat = vec![0.0; shape[0] * shape[1]];
    fill(&mut flat);
    Ok(flat.into_pyarray(py).reshape(shape)?.into_any())
}

fn csr<'py>(py: Python<'py>, rows: &Csr, ncols: usize) -> PyResult<Bound<'py, PyAny>> {
    let mut starts = vec![0i64];
    let (mut columns, mut values) = (Vec::new(), Vec::new());
    for i in 0..rows.n() {
        let (of_row, values_of_row) = rows.row(i);
        columns.extend(of_row.iter().map(|&j| i64::from(j)));
        values.extend_from_slice(values_of_row);
        starts.push(columns.len() as i64);
    }
    let parts = (values.into_pyarray(py), columns.into_pyarray(py), starts.into_pyarray(py));
    py.import("scipy.sparse")?.getattr("csr_array")?.call1((parts, (rows.n(), ncols)))
}

/// A matrix that Python gave, by its nonzero entries or with all of them, row by row.
pub(crate) enum Matrix {
    Dense { shape: [usize; 2], flat: Vec<f64> },
    Sparse { shape: [usize; 2], starts: Vec<i64>, columns: Vec<i64>, values: Vec<f64> },
}

impl Matrix {
    /// Reads an array, anything that numpy makes one of, or a sparse matrix of scipy.
    pub(crate) fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        if !object.hasattr("tocsr")? {
            refuse_complex(object)?;
            let array: PyArrayLike2<'_, f64, AllowTypeChange> = object.extract().map_err(|_| not_a_matrix(object))?;
            let array = array.as_array();
            return Ok(Self::Dense { shape: [array.nrows(), array.ncols()], flat: array.iter().copied().collect() });
        }
        let csr = object.call_method0("tocsr")?.call_method0("copy")?;
        csr.call_method0("sum_duplicates")?; // columns ascend after it
        Ok(Self::Sparse {
            shape: csr.getattr("shape")?.extract()?,
            starts: vector(&csr.getattr("indptr")?)?,
            columns: vector(&csr.getattr("indices")?)?,
            values: vector(&csr.getattr("data")?)?,
        })
    }

    pub(crate) fn shape(&self) -> [usize; 2] {
        match self {
            Self::Dense { shape, .. } | Self::Sparse { shape, .. } => *shape,
        }
    }

    /// Calls `entry(i, j, value)` for every stored entry, row by row, columns ascending.
    pub(crate) fn for_each(&self, mut entry: impl FnMut(usize, usize, f64)) {
        match self {
            Self::Dense { shape: [_, 0], .. } => {}
            Self::Dense { shape: [_, ncols], flat } => {
                let rows = flat.chunks_exact(*ncols).enumerate();
                rows.for_each(|(i, row)| row.iter().enumerate().for_each(|(j, &value)| entry(i, j, value)));
            }
            Self::Sparse { starts, columns, values, .. } => {
                for (i, span) in starts.windows(2).enumerate() {
                    for at in span[0] as usize..span[1] as usize {
                        entry(i, columns[at] as usize, values[at]);
                    }
                }
            }
        }
    }

    /// The entry of this row and column.
    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        match self {
            Self::Dense { shape, flat } => flat[i * shape[1] + j],
            Self::Sparse { starts, columns, values, .. } => {
                let span = starts[i] as usize..starts[i + 1] as usize;
                columns[span.clone()].binary_search(&(j as i64)).map_or(0.0, |at| values[span.start + at])
            }
        }
    }
}

/// The numbers of a one-dimensional array, or of anything that numpy makes one of.
pub(crate) fn vector<T>(object: &Bound<'_, PyAny>) -> PyResult<Vec<T>>
where
    T: numpy::Element + Copy,
    for<'a, 'py> PyArrayLike1<'py, T, AllowTypeChange>: FromPyObject<'a, 'py>,
{
    refuse_complex(object)?;
    let array: Result<PyArrayLike1<'_, T, AllowTypeChange>, _> = object.extract();
    let array =
        array.map_err(|_| PyTypeError::new_err(format!("{} is not an array of one dimension", kind(object))))?;
    Ok(array.as_array().iter().copied().collect())
}

/// The labels in a one-dimensional array, or in anything that numpy makes one of. A cast of numpy would round them.
pub(crate) fn labels(object: &Bound<'_, PyAny>) -> PyResult<Vec<i64>> {
    if matches!(entries(object), Some(b'i' | b'u' | b'b')) {
        return vector(object);
    }
    let values: Vec<f64> = vector(object)?;
    let whole = |(at, value): (usize, f64)| {
        let label = value as i64;
        let is_whole = label as f64 == value;
        is_whole
            .then_some(label)
            .ok_or_else(|| PyValueError::new_err(format!("labels[{at}] = {value} is no whole number")))
    };
    values.into_iter().enumerate().map(whole).collect()
}

/// A cast of numpy would drop imaginary parts.
fn refuse_complex(object: &Bound<'_, PyAny>) -> PyResult<()> {
    match entries(object) {
        Some(b'c') => Err(PyTypeError::new_err(format!("{} has complex numbers, not real ones", kind(object)))),
        _ => Ok(()),
    }
}

/// What numpy makes the entries of an array: `f` floating point, `c` complex and so on; `None` for what is no array.
fn entries(object: &Bound<'_, PyAny>) -> Option<u8> {
    let made = || numpy::get_array_module(object.py())?.call_method1("asarray", (object,));
    let array = if object.is_instance_of::<PyUntypedArray>() { object.clone() } else { made().ok()? };
    Some(array.cast::<PyUntypedArray>().ok()?.dtype().kind())
}

fn not_a_matrix(object: &Bound<'_, PyAny>) -> PyErr {
    PyTypeError::new_err(format!("{} is not an array of two dimensions", kind(object)))
}

/// Type and, of an array, shape, for messages.
pub(crate) fn kind(object: &Bound<'_, PyAny>) -> String {
    let shape = object.getattr("shape").map(|shape| format!(" of shape {shape}")).unwrap_or_default();
    let name = object.get_type().name().map(|name| name.to_string()).unwrap_or_default();
    format!("{name}{shape}")
}

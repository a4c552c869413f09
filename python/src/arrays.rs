//! Matrices and points as arrays of numpy and scipy, and back.

use crosscut_stage::{Csr, Point, Weights};
use faer::Mat;
use numpy::{
    AllowTypeChange, IntoPyArray, PyArrayDescrMethods, PyArrayLike1, PyArrayLike2, PyArrayMethods, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::sparse;

/// Points as an (n, 3) array, metres.
pub(crate) fn points<'py>(py: Python<'py>, points_m: &[Point]) -> PyResult<Bound<'py, PyAny>> {
    let flat: Vec<f64> = points_m.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    Ok(flat.into_pyarray(py).reshape([points_m.len(), 3])?.into_any())
}

/// W as an (n, n) array, or as a `scipy.sparse.csr_array` if it is stored by its nonzero entries.
pub(crate) fn weights<'py>(py: Python<'py>, weights: &Weights) -> PyResult<Bound<'py, PyAny>> {
    match weights {
        Weights::Sparse(w) => csr(py, w),
        w => dense(py, [w.n(), w.n()], |flat| w.for_each(|i, j, value| flat[i * w.n() + j] = value)),
    }
}

/// U as an (n, k) array.
pub(crate) fn embedding<'py>(py: Python<'py>, u: &Mat<f64>) -> PyResult<Bound<'py, PyAny>> {
    let [n, k] = [u.nrows(), u.ncols()];
    dense(py, [n, k], |flat| (0..n * k).for_each(|at| flat[at] = u[(at / k, at % k)]))
}

fn dense(py: Python<'_>, shape: [usize; 2], fill: impl FnOnce(&mut [f64])) -> PyResult<Bound<'_, PyAny>> {
    let mut flat = vec![0.0; shape[0] * shape[1]];
    fill(&mut flat);
    Ok(flat.into_pyarray(py).reshape(shape)?.into_any())
}

fn csr<'py>(py: Python<'py>, rows: &Csr) -> PyResult<Bound<'py, PyAny>> {
    let mut starts = vec![0i64];
    let (mut columns, mut values) = (Vec::new(), Vec::new());
    for i in 0..rows.n() {
        let (of_row, values_of_row) = rows.row(i);
        columns.extend(of_row.iter().map(|&j| i64::from(j)));
        values.extend_from_slice(values_of_row);
        starts.push(columns.len() as i64);
    }
    let parts = (values.into_pyarray(py), columns.into_pyarray(py), starts.into_pyarray(py));
    py.import("crosscut._extras")?
        .call_method0("scipy_sparse")?
        .getattr("csr_array")?
        .call1((parts, (rows.n(), rows.n())))
}

/// A matrix that Python gave, by its nonzero entries or with all of them, row by row.
pub(crate) enum Matrix {
    Dense { shape: [usize; 2], flat: Vec<f64> },
    Sparse { shape: [usize; 2], starts: Vec<usize>, columns: Vec<u32>, values: Vec<f64> },
}

impl Matrix {
    /// Reads an array, anything that numpy makes one of, or a sparse matrix of scipy. Of one whose shape does not fit, the shape
    /// alone is read: what Python gives may be of any size.
    pub(crate) fn of(object: &Bound<'_, PyAny>, fits: impl Fn([usize; 2]) -> bool) -> PyResult<Self> {
        if object.hasattr("tocsr")? {
            return sparse::read(object, fits);
        }
        let array = array(object).map_err(|_| not_a_matrix(object))?;
        let &[nrows, ncols] = array.shape() else { return Err(not_a_matrix(object)) };
        let shape = [nrows, ncols];
        if !fits(shape) {
            return Ok(Self::without_entries(shape));
        }
        refuse_complex(object, &array)?;
        let array = without_mask(array)?;
        let array: PyArrayLike2<'_, f64, AllowTypeChange> = array.extract().map_err(|_| not_a_matrix(object))?;
        Ok(Self::Dense { shape, flat: array.as_array().iter().copied().collect() })
    }

    pub(crate) fn without_entries(shape: [usize; 2]) -> Self {
        Self::Dense { shape, flat: Vec::new() }
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
                    (span[0]..span[1]).for_each(|at| entry(i, columns[at] as usize, values[at]));
                }
            }
        }
    }

    /// The entry of this row and column.
    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        match self {
            Self::Dense { shape, flat } => flat[i * shape[1] + j],
            Self::Sparse { starts, columns, values, .. } => {
                let span = starts[i]..starts[i + 1];
                columns[span.clone()].binary_search(&(j as u32)).map_or(0.0, |at| values[span.start + at])
            }
        }
    }
}

/// The numbers of a one-dimensional array, or of anything that numpy makes one of: at most this many.
pub(crate) fn vector<T>(object: &Bound<'_, PyAny>, most: usize) -> PyResult<Vec<T>>
where
    T: numpy::Element + Copy,
    for<'a, 'py> PyArrayLike1<'py, T, AllowTypeChange>: FromPyObject<'a, 'py>,
{
    let not_a_vector = || PyTypeError::new_err(format!("{} is not an array of one dimension", kind(object)));
    let array = array(object).map_err(|_| not_a_vector())?;
    let &[length] = array.shape() else { return Err(not_a_vector()) };
    if length > most {
        return Err(PyValueError::new_err(format!("{} has more than {most} entries", kind(object))));
    }
    refuse_complex(object, &array)?;
    let array = without_mask(array)?;
    let array: Result<PyArrayLike1<'_, T, AllowTypeChange>, _> = array.extract();
    Ok(array.map_err(|_| not_a_vector())?.as_array().iter().copied().collect())
}

/// The labels in a one-dimensional array, or in anything that numpy makes one of. A cast of numpy would round them.
pub(crate) fn labels(object: &Bound<'_, PyAny>, most: usize) -> PyResult<Vec<i64>> {
    let kind = array(object).ok().filter(|array| !is_masked(array)).map(|array| array.dtype().kind());
    if matches!(kind, Some(b'i' | b'b')) {
        return vector(object, most);
    }
    if kind == Some(b'u') {
        let label = |(at, value): (usize, u64)| {
            let too_large = |_| PyValueError::new_err(format!("labels[{at}] = {value} is larger than a label can be"));
            i64::try_from(value).map_err(too_large)
        };
        return vector(object, most)?.into_iter().enumerate().map(label).collect();
    }
    let values: Vec<f64> = vector(object, most)?;
    let whole = |(at, value): (usize, f64)| {
        let label = value as i64;
        let is_whole = label as f64 == value;
        is_whole
            .then_some(label)
            .ok_or_else(|| PyValueError::new_err(format!("labels[{at}] = {value} is no whole number")))
    };
    values.into_iter().enumerate().map(whole).collect()
}

/// The array, or the one that numpy makes of an object; no array is copied.
pub(crate) fn array<'py>(object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    if let Ok(array) = object.cast::<PyUntypedArray>() {
        return Ok(array.clone());
    }
    let made = numpy::get_array_module(object.py())?.call_method1("asarray", (object,))?;
    Ok(made.cast_into::<PyUntypedArray>()?)
}

/// Whether it is an array of `numpy.ma`.
fn is_masked(array: &Bound<'_, PyUntypedArray>) -> bool {
    array.hasattr("filled").unwrap_or(false)
}

/// NaN for what is masked: its array has any number there. Other arrays stay as they are.
fn without_mask<'py>(array: Bound<'py, PyUntypedArray>) -> PyResult<Bound<'py, PyUntypedArray>> {
    if !is_masked(&array) {
        return Ok(array);
    }
    let filled = array.call_method1("astype", ("float64",))?.call_method1("filled", (f64::NAN,))?;
    Ok(filled.cast_into::<PyUntypedArray>()?)
}

/// A cast of numpy would drop imaginary parts.
fn refuse_complex(object: &Bound<'_, PyAny>, array: &Bound<'_, PyUntypedArray>) -> PyResult<()> {
    if array.dtype().kind() == b'c' {
        return Err(PyTypeError::new_err(format!("{} has complex numbers, not real ones", kind(object))));
    }
    Ok(())
}

pub(crate) fn not_a_matrix(object: &Bound<'_, PyAny>) -> PyErr {
    PyTypeError::new_err(format!("{} is not an array of two dimensions", kind(object)))
}

/// Type and, of an array, shape, for messages.
pub(crate) fn kind(object: &Bound<'_, PyAny>) -> String {
    let shape = object.getattr("shape").map(|shape| format!(" of shape {shape}")).unwrap_or_default();
    let name = object.get_type().name().map(|name| name.to_string()).unwrap_or_default();
    format!("{name}{shape}")
}

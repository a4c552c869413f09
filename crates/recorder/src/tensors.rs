//! Values as tensors with named dimensions.

use faer::Mat;
use rerun::external::arrow::datatypes::{ArrowPrimitiveType, Float16Type};
use rerun::{TensorBuffer, TensorData};

/// Half precision: 11 bits, three digits.
type F16 = <Float16Type as ArrowPrimitiveType>::Native;

/// Names of the dimensions, as in the schema.
type Dims<'a> = &'a [&'a str];

pub(crate) fn f32_vector(values: Vec<f32>, dims: Dims) -> TensorData {
    tensor(&[values.len()], TensorBuffer::F32(values.into()), dims)
}

pub(crate) fn f64_vector(values: Vec<f64>, dims: Dims) -> TensorData {
    tensor(&[values.len()], TensorBuffer::F64(values.into()), dims)
}

pub(crate) fn i32_vector(values: impl Iterator<Item = i32>, dims: Dims) -> TensorData {
    let values: Vec<i32> = values.collect();
    tensor(&[values.len()], TensorBuffer::I32(values.into()), dims)
}

pub(crate) fn u8_vector(values: impl Iterator<Item = u8>, dims: Dims) -> TensorData {
    let values: Vec<u8> = values.collect();
    tensor(&[values.len()], TensorBuffer::U8(values.into()), dims)
}

/// `values` row by row, rounded to half precision.
pub(crate) fn f16_matrix(values: impl Iterator<Item = f64>, shape: [usize; 2], dims: Dims) -> TensorData {
    let values: Vec<F16> = values.map(F16::from_f64).collect();
    tensor(&shape, TensorBuffer::F16(values.into()), dims)
}

/// `values` row by row.
pub(crate) fn f64_matrix(values: Vec<f64>, shape: [usize; 2], dims: Dims) -> TensorData {
    tensor(&shape, TensorBuffer::F64(values.into()), dims)
}

/// `values` row by row, as f32.
pub(crate) fn f32_matrix(values: Vec<f32>, shape: [usize; 2], dims: Dims) -> TensorData {
    tensor(&shape, TensorBuffer::F32(values.into()), dims)
}

/// The values of `m`, row by row.
pub(crate) fn rows_of(m: &Mat<f64>) -> impl Iterator<Item = f64> {
    (0..m.nrows()).flat_map(move |i| (0..m.ncols()).map(move |j| m[(i, j)]))
}

/// All values of `m`.
pub(crate) fn f64_rows(m: &Mat<f64>, dims: Dims) -> TensorData {
    f64_matrix(rows_of(m).collect(), [m.nrows(), m.ncols()], dims)
}

fn tensor(shape: &[usize], buffer: TensorBuffer, dims: Dims) -> TensorData {
    let shape: Vec<u64> = shape.iter().map(|&size| size as u64).collect();
    TensorData::new(shape, buffer).with_dim_names(dims.iter().copied())
}

//! Values to read back, as tensors with named dimensions.

use crosscut_stage::Embedding;
use rerun::external::arrow::datatypes::{ArrowPrimitiveType, Float16Type};
use rerun::{Tensor, TensorBuffer, TensorData};

/// Half precision: 11 bits, so three digits.
type F16 = <Float16Type as ArrowPrimitiveType>::Native;

pub(crate) fn f32_vector(values: Vec<f32>, dim: &str) -> Tensor {
    tensor(&[values.len()], TensorBuffer::F32(values.into()), &[dim])
}

pub(crate) fn f64_vector(values: Vec<f64>, dim: &str) -> Tensor {
    tensor(&[values.len()], TensorBuffer::F64(values.into()), &[dim])
}

pub(crate) fn i32_vector(values: impl Iterator<Item = i32>, dim: &str) -> Tensor {
    let values: Vec<i32> = values.collect();
    tensor(&[values.len()], TensorBuffer::I32(values.into()), &[dim])
}

pub(crate) fn u8_vector(values: impl Iterator<Item = u8>, dim: &str) -> Tensor {
    let values: Vec<u8> = values.collect();
    tensor(&[values.len()], TensorBuffer::U8(values.into()), &[dim])
}

/// `values` row by row, rounded to half precision.
pub(crate) fn f16_matrix(values: impl Iterator<Item = f64>, shape: [usize; 2], dims: [&str; 2]) -> Tensor {
    let values: Vec<F16> = values.map(F16::from_f64).collect();
    tensor(&shape, TensorBuffer::F16(values.into()), &dims)
}

/// `values` row by row.
pub(crate) fn f64_matrix(values: Vec<f64>, shape: [usize; 2], dims: [&str; 2]) -> Tensor {
    tensor(&shape, TensorBuffer::F64(values.into()), &dims)
}

/// The values of `m`, row by row.
pub(crate) fn rows_of(m: &Embedding) -> impl Iterator<Item = f64> {
    (0..m.nrows()).flat_map(move |i| (0..m.ncols()).map(move |j| m[(i, j)]))
}

/// The entries of `m` that are stored: row, column and value of each.
pub(crate) fn entries(m: &Embedding, what: &str) -> Tensor {
    let row = |i: usize| m.row(i).flat_map(move |(j, value)| [i as f64, j as f64, value]);
    let values: Vec<f64> = (0..m.nrows()).flat_map(row).collect();
    tensor(&[values.len() / 3, 3], TensorBuffer::F64(values.into()), &["entry", what])
}

/// A matrix of points by its entries: all of them, or those that are stored.
pub(crate) fn f64_rows(m: &Embedding, row: &str) -> Tensor {
    match m {
        Embedding::Sparse { .. } => entries(m, &format!("{row}, eigenvector, value")),
        dense => f64_matrix(rows_of(dense).collect(), [m.nrows(), m.ncols()], [row, "eigenvector"]),
    }
}

fn tensor(shape: &[usize], buffer: TensorBuffer, dims: &[&str]) -> Tensor {
    let shape: Vec<u64> = shape.iter().map(|&size| size as u64).collect();
    Tensor::new(TensorData::new(shape, buffer).with_dim_names(dims.iter().copied()))
}

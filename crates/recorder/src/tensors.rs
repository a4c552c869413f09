//! Values to read back, as tensors with named dimensions.

use faer::Mat;
use rerun::{Tensor, TensorBuffer, TensorData};

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

/// `values` row by row.
pub(crate) fn f32_matrix(values: Vec<f32>, shape: [usize; 2], dims: [&str; 2]) -> Tensor {
    tensor(&shape, TensorBuffer::F32(values.into()), &dims)
}

/// `values` row by row.
pub(crate) fn f64_matrix(values: Vec<f64>, shape: [usize; 2], dims: [&str; 2]) -> Tensor {
    tensor(&shape, TensorBuffer::F64(values.into()), &dims)
}

/// The values of `m`, row by row.
pub(crate) fn rows_of(m: &Mat<f64>) -> impl Iterator<Item = f64> {
    (0..m.nrows()).flat_map(move |i| (0..m.ncols()).map(move |j| m[(i, j)]))
}

fn tensor(shape: &[usize], buffer: TensorBuffer, dims: &[&str]) -> Tensor {
    let shape: Vec<u64> = shape.iter().map(|&size| size as u64).collect();
    Tensor::new(TensorData::new(shape, buffer).with_dim_names(dims.iter().copied()))
}

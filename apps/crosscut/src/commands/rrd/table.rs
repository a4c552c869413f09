//! A value as rows of a table: where each of its numbers or texts stands, and what stands there.

use anyhow::bail;
use crosscut_recorder::{Array, Numbers, Value};

/// One number or text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Item<'a> {
    F64(f64),
    F32(f32),
    I64(i64),
    Text(&'a str),
}

/// What the indices of a value count.
pub(super) fn dims(value: &Value) -> Vec<&str> {
    match value {
        Value::Numbers(array) => array.dims.iter().map(String::as_str).collect(),
        Value::Lists(_) => vec!["list", "item", "axis"],
        _ => vec!["item"],
    }
}

/// Hands over every number or text with its indices, one a dimension, the last running fastest.
pub(super) fn for_each(
    value: &Value,
    mut take: impl FnMut(&[usize], Item) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    match value {
        Value::Numbers(array) => {
            (0..array.numbers.len()).try_for_each(|at| take(&indices(&array.shape, at), item(array, at)))
        }
        Value::Lists(lists) => lists.iter().enumerate().try_for_each(|(list, array)| {
            (0..array.numbers.len()).try_for_each(|at| {
                let indices: Vec<usize> = [list].into_iter().chain(indices(&array.shape, at)).collect();
                take(&indices, item(array, at))
            })
        }),
        Value::Texts(texts) => texts.iter().enumerate().try_for_each(|(at, text)| take(&[at], Item::Text(text))),
        other => bail!("{other} cannot be written as a table"),
    }
}

fn item(array: &Array, at: usize) -> Item<'static> {
    match &array.numbers {
        Numbers::F64(values) => Item::F64(values[at]),
        Numbers::F32(values) => Item::F32(values[at]),
        Numbers::I64(values) => Item::I64(values[at]),
    }
}

/// Where number `at` of an array stands.
fn indices(shape: &[usize], mut at: usize) -> Vec<usize> {
    let mut indices: Vec<usize> = shape.iter().rev().map(|&size| (at % size, at /= size).0).collect();
    indices.reverse();
    indices
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_run_fastest_along_the_last_dimension() {
        let all: Vec<Vec<usize>> = (0..6).map(|at| indices(&[2, 3], at)).collect();
        assert_eq!(all, [[0, 0], [0, 1], [0, 2], [1, 0], [1, 1], [1, 2]]);
        assert_eq!(indices(&[], 0), [0; 0]);
    }
}

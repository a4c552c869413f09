//! What a component holds, as numbers and words.

use std::fmt;

use rerun::external::arrow::array::{Array as _, ArrayRef, AsArray as _};
use rerun::external::arrow::datatypes::{
    ArrowPrimitiveType, DataType, Float16Type, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type,
    UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use rerun::{Component as _, Loggable as _, TensorBuffer, components};

use super::messages::caught;
use super::picture;
use super::rows::Cell;

/// What a component holds at one revolution.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Value {
    /// Numbers in one array.
    Numbers(Array),
    /// Several arrays of different lengths, such as lines of points.
    Lists(Vec<Array>),
    /// Words.
    Texts(Vec<String>),
}

/// Numbers with a shape, row by row (the last index runs fastest).
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// How many there are along each dimension; none for a single number.
    pub shape: Vec<usize>,
    /// What each dimension counts.
    pub dims: Vec<String>,
    /// All numbers.
    pub numbers: Numbers,
}

/// Numbers of one type.
#[derive(Clone, Debug, PartialEq)]
pub enum Numbers {
    /// As stored, or pictures by their scale.
    F64(Vec<f64>),
    /// As stored, or f16 as stored.
    F32(Vec<f32>),
    /// Whole numbers of any size.
    I64(Vec<i64>),
}

impl Numbers {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::F64(values) => values.len(),
            Self::F32(values) => values.len(),
            Self::I64(values) => values.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn type_name(&self) -> &'static str {
        match self {
            Self::F64(_) => "f64",
            Self::F32(_) => "f32",
            Self::I64(_) => "i64",
        }
    }
}

impl Array {
    /// The numbers as f64; whole numbers beyond 2^53 are rounded.
    pub fn to_f64(&self) -> Vec<f64> {
        match &self.numbers {
            Numbers::F64(values) => values.clone(),
            Numbers::F32(values) => values.iter().map(|&x| f64::from(x)).collect(),
            Numbers::I64(values) => values.iter().map(|&i| i as f64).collect(),
        }
    }

    /// An error if there are not as many numbers as the shape says, which no reader of the array would expect.
    fn new(shape: Vec<usize>, dims: Vec<String>, numbers: Numbers) -> Result<Self, String> {
        let count = shape.iter().try_fold(1, |count: usize, &size| count.checked_mul(size));
        if count != Some(numbers.len()) {
            return Err(format!("its shape {shape:?} does not fit its {} numbers", numbers.len()));
        }
        Ok(Self { shape, dims, numbers })
    }
}

/// Type and shape, in a few words.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Numbers(array) => write!(f, "{} {:?}", array.numbers.type_name(), array.shape),
            Self::Lists(lists) => {
                let name = lists.first().map_or("no", |list| list.numbers.type_name());
                write!(f, "{} lists of {name}", lists.len())
            }
            Self::Texts(texts) if texts.len() == 1 => f.write_str("text"),
            Self::Texts(texts) => write!(f, "{} texts", texts.len()),
        }
    }
}

impl Value {
    /// The value of a cell; `beside` are all cells of its row, for the scale of a picture. Otherwise, what it is.
    pub(super) fn of(cell: &Cell, beside: &[Cell]) -> Result<Self, String> {
        caught(|| Self::decoded(cell, beside))
    }

    fn decoded(cell: &Cell, beside: &[Cell]) -> Result<Self, String> {
        if cell.type_name == components::TensorData::name().as_str() {
            return tensor(&cell.values).map(Self::Numbers);
        }
        if cell.type_name == components::Blob::name().as_str() {
            return picture::numbers(cell, beside).map(Self::Numbers);
        }
        let number = cell.type_name == components::Scalar::name().as_str() && cell.values.len() == 1;
        match cell.values.data_type() {
            DataType::Utf8 => {
                let texts = cell.values.as_string::<i32>().iter().flatten();
                Ok(Self::Texts(texts.map(str::to_owned).collect()))
            }
            DataType::List(_) => lists(&cell.values).map(Self::Lists),
            _ if number => Array::new(vec![], vec![], flat(&cell.values)?).map(Self::Numbers),
            _ => array(&cell.values).map(Self::Numbers),
        }
    }
}

/// One number an item, or equally many.
fn array(values: &ArrayRef) -> Result<Array, String> {
    match values.data_type() {
        DataType::FixedSizeList(_, size) => {
            let shape = vec![values.len(), usize::try_from(*size).map_err(|e| e.to_string())?];
            Array::new(shape, names(&["item", "axis"]), flat(values.as_fixed_size_list().values())?)
        }
        _ => Array::new(vec![values.len()], names(&["item"]), flat(values)?),
    }
}

fn names(dims: &[&str]) -> Vec<String> {
    dims.iter().map(|&dim| dim.to_owned()).collect()
}

fn lists(values: &ArrayRef) -> Result<Vec<Array>, String> {
    let list = values.as_list::<i32>();
    (0..list.len()).map(|item| array(&list.value(item))).collect()
}

fn flat(values: &ArrayRef) -> Result<Numbers, String> {
    fn all<T: ArrowPrimitiveType, N>(values: &ArrayRef, number: impl Fn(T::Native) -> N) -> Vec<N> {
        values.as_primitive::<T>().values().iter().map(|&value| number(value)).collect()
    }
    Ok(match values.data_type() {
        DataType::Float64 => Numbers::F64(all::<Float64Type, _>(values, |x| x)),
        DataType::Float32 => Numbers::F32(all::<Float32Type, _>(values, |x| x)),
        DataType::Float16 => Numbers::F32(all::<Float16Type, _>(values, f32::from)),
        DataType::Int64 => Numbers::I64(all::<Int64Type, _>(values, |i| i)),
        DataType::Int32 => Numbers::I64(all::<Int32Type, _>(values, i64::from)),
        DataType::Int16 => Numbers::I64(all::<Int16Type, _>(values, i64::from)),
        DataType::Int8 => Numbers::I64(all::<Int8Type, _>(values, i64::from)),
        DataType::UInt64 => Numbers::I64(all::<UInt64Type, _>(values, u64::cast_signed)),
        DataType::UInt32 => Numbers::I64(all::<UInt32Type, _>(values, i64::from)),
        DataType::UInt16 => Numbers::I64(all::<UInt16Type, _>(values, i64::from)),
        DataType::UInt8 => Numbers::I64(all::<UInt8Type, _>(values, i64::from)),
        DataType::Boolean => Numbers::I64(values.as_boolean().values().iter().map(i64::from).collect()),
        _ => return Err("neither numbers nor words".to_owned()),
    })
}

fn tensor(values: &ArrayRef) -> Result<Array, String> {
    let tensors = components::TensorData::from_arrow(values).map_err(|e| e.to_string())?;
    let tensor = tensors.into_iter().next().ok_or("no tensor")?.0;
    let shape: Vec<usize> = tensor.shape.iter().map(|&size| size as usize).collect();
    let names = tensor.names.as_deref().unwrap_or_default();
    let unnamed = |i: usize| if shape.len() == 1 { "item".to_owned() } else { format!("dim_{i}") };
    let dim = |i: usize| names.get(i).map_or_else(|| unnamed(i), ToString::to_string);
    let dims = (0..shape.len()).map(dim).collect();
    let numbers = match tensor.buffer {
        TensorBuffer::F64(x) => Numbers::F64(x.to_vec()),
        TensorBuffer::F32(x) => Numbers::F32(x.to_vec()),
        TensorBuffer::F16(x) => Numbers::F32(x.iter().map(|&x| f32::from(x)).collect()),
        TensorBuffer::I64(i) => Numbers::I64(i.to_vec()),
        TensorBuffer::I32(i) => Numbers::I64(i.iter().map(|&i| i64::from(i)).collect()),
        TensorBuffer::I16(i) => Numbers::I64(i.iter().map(|&i| i64::from(i)).collect()),
        TensorBuffer::I8(i) => Numbers::I64(i.iter().map(|&i| i64::from(i)).collect()),
        TensorBuffer::U64(i) => Numbers::I64(i.iter().map(|&i| i.cast_signed()).collect()),
        TensorBuffer::U32(i) => Numbers::I64(i.iter().map(|&i| i64::from(i)).collect()),
        TensorBuffer::U16(i) => Numbers::I64(i.iter().map(|&i| i64::from(i)).collect()),
        TensorBuffer::U8(i) => Numbers::I64(i.iter().map(|&i| i64::from(i)).collect()),
    };
    Array::new(shape, dims, numbers)
}

//! The values of components, as numbers and words.

use std::fmt;

use rerun::external::arrow::array::{Array as _, ArrayRef, AsArray};
use rerun::external::arrow::compute::{CastOptions, cast_with_options};
use rerun::external::arrow::datatypes::{DataType, Float32Type, Float64Type, Int64Type};
use rerun::external::image;
use rerun::{Component as _, EncodedDepthImage, Loggable as _, components};

use crate::cell::Cell;
use crate::messages::caught;

/// The value of a component at one revolution.
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
    /// Length of each dimension; no dimension for a single number.
    pub shape: Vec<usize>,
    /// Name of each dimension.
    pub dims: Vec<String>,
    /// All numbers.
    pub numbers: Numbers,
}

/// Numbers of one type.
#[derive(Clone, Debug, PartialEq)]
pub enum Numbers {
    /// Stored as f64, or read from a picture by its scale.
    F64(Vec<f64>),
    /// Stored as f32 or f16.
    F32(Vec<f32>),
    /// Stored as whole numbers of any size.
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

impl Value {
    /// Its numbers as f64; none of words, or of several arrays.
    pub fn to_f64(&self) -> Vec<f64> {
        if let Self::Numbers(array) = self { array.to_f64() } else { Vec::new() }
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

    /// An error if the shape does not fit the count of numbers.
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
    /// The value of a cell; `beside` are all cells of its row, among them the scale of a picture. The error says why
    /// there is no value.
    pub(crate) fn of(cell: &Cell, beside: &[Cell]) -> Result<Self, String> {
        caught(|| Self::decoded(cell, beside))
    }

    fn decoded(cell: &Cell, beside: &[Cell]) -> Result<Self, String> {
        if cell.type_name == components::TensorData::name().as_str() {
            return tensor(&cell.values).map(Self::Numbers);
        }
        if cell.type_name == components::Blob::name().as_str() {
            return matrix(cell, beside).map(Self::Numbers);
        }
        let number = cell.type_name == components::Scalar::name().as_str() && cell.values.len() == 1;
        match cell.values.data_type() {
            DataType::Utf8 => {
                let texts = cell.values.as_string::<i32>().iter().flatten();
                Ok(Self::Texts(texts.map(str::to_owned).collect()))
            }
            DataType::Struct(_) => joined(&cell.values).map(Self::Texts),
            DataType::List(_) => lists(&cell.values).map(Self::Lists),
            _ if number => Array::new(vec![], vec![], flat(&cell.values)?).map(Self::Numbers),
            _ => array(&cell.values).map(Self::Numbers),
        }
    }
}

/// Items of several texts, such as the two ends of an edge, with a space between them.
fn joined(values: &ArrayRef) -> Result<Vec<String>, String> {
    let fields = values.as_struct().columns().iter();
    let fields: Option<Vec<_>> = fields.map(|field| field.as_string_opt::<i32>()).collect();
    let fields = fields.ok_or("neither numbers nor words")?;
    let item = |at: usize| fields.iter().map(|field| field.value(at)).collect::<Vec<_>>().join(" ");
    Ok((0..values.len()).map(item).collect())
}

/// Items of one number, or of equally many.
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

/// The numbers of an array, f16 as f32 and whole numbers as i64.
fn flat(values: &ArrayRef) -> Result<Numbers, String> {
    let options = CastOptions { safe: false, ..CastOptions::default() }; // an overflow is an error
    let cast = |to| cast_with_options(values, &to, &options).map_err(|e| e.to_string());
    Ok(match values.data_type() {
        DataType::Float64 => Numbers::F64(values.as_primitive::<Float64Type>().values().to_vec()),
        DataType::Float32 | DataType::Float16 => {
            Numbers::F32(cast(DataType::Float32)?.as_primitive::<Float32Type>().values().to_vec())
        }
        whole if whole.is_integer() || *whole == DataType::Boolean => {
            Numbers::I64(cast(DataType::Int64)?.as_primitive::<Int64Type>().values().to_vec())
        }
        _ => return Err("neither numbers nor words".to_owned()),
    })
}

/// Rerun's tensor: a shape, the names of the dimensions if there are any, and one list of numbers of some type.
fn tensor(values: &ArrayRef) -> Result<Array, String> {
    let tensor = values.as_struct_opt().filter(|tensor| !tensor.is_empty()).ok_or("no tensor")?;
    let field = |name: &str| tensor.column_by_name(name).ok_or_else(|| format!("a tensor without its {name}"));
    let first_list = |lists: &ArrayRef| lists.as_list_opt::<i32>().map(|lists| lists.value(0)).ok_or("not a list");
    let buffer = field("buffer")?.as_union_opt().ok_or("a tensor of an unknown type")?.value(0);
    let Numbers::I64(sizes) = flat(&first_list(field("shape")?)?)? else {
        return Err("a shape of fractions".to_owned());
    };
    let shape: Vec<usize> =
        sizes.iter().map(|&size| usize::try_from(size)).collect::<Result<_, _>>().map_err(|e| e.to_string())?;
    let names = field("names")?;
    let names = if names.is_null(0) { None } else { Some(first_list(names)?) };
    let names: Vec<&str> = names.iter().flat_map(AsArray::as_string::<i32>).map(Option::unwrap_or_default).collect();
    let unnamed = |i: usize| if shape.len() == 1 { "item".to_owned() } else { format!("dim_{i}") };
    let dims = (0..shape.len()).map(|i| names.get(i).map_or_else(|| unnamed(i), |&name| name.to_owned())).collect();
    Array::new(shape, dims, flat(&first_list(&buffer)?)?)
}

/// The decades that the levels of a picture span, ending at 1.
const DECADES: f64 = 16.0;

/// The numbers that a PNG picture of W or L stands for, by the range of levels that is stored beside it. Both matrices
/// are symmetric; a picture may hold the upper triangle alone.
fn matrix(picture: &Cell, beside: &[Cell]) -> Result<Array, String> {
    let blobs = components::Blob::from_arrow(&picture.values).map_err(|e| e.to_string())?;
    let blob = blobs.first().ok_or("no picture")?;
    let picture = image::load_from_memory(&blob.0.0).map_err(|e| e.to_string())?.to_luma8();
    let brightest = brightest_level(beside).ok_or("a picture without a range of levels")?;
    let value = |level: u8| 10f64.powf(DECADES * (f64::from(level) / brightest - 1.0));
    let values: Vec<f64> = (0..=u8::MAX).map(|level| if level == 0 { 0.0 } else { value(level) }).collect();
    let mirrored = |x: u32, y: u32| picture.get_pixel_checked(y, x).map_or(0, |level| level.0[0]);
    let level = |(x, y, level): (u32, u32, &image::Luma<u8>)| level.0[0].max(mirrored(x, y));
    let numbers = picture.enumerate_pixels().map(|pixel| values[usize::from(level(pixel))]).collect();
    let shape = [picture.height(), picture.width()].map(|size| size as usize);
    Array::new(shape.to_vec(), names(&["row", "column"]), Numbers::F64(numbers))
}

/// The level that stands for 1. The range of a grey PNG is stored as a share of 255.
fn brightest_level(beside: &[Cell]) -> Option<f64> {
    let name = EncodedDepthImage::descriptor_depth_range().component;
    let range = beside.iter().find(|cell| cell.component == name.as_str())?;
    let ranges = components::ValueRange::from_arrow(&range.values).ok()?;
    Some(ranges.first()?.0.0[1] * 255.0)
}

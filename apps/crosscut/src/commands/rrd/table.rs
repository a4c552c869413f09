//! A value as rows of a table: one row for each of its numbers or texts, with its indices.

use std::io::{self, Write};
use std::iter::repeat_n;
use std::sync::Arc;

use anyhow::bail;
use crosscut_rrd::arrow::array::{
    Array as _, ArrayRef, AsArray as _, Float32Array, Float64Array, Int64Array, RecordBatch, StringArray,
};
use crosscut_rrd::arrow::compute::concat;
use crosscut_rrd::arrow::datatypes::{DataType, Field, Float32Type, Float64Type, Int64Type, Schema};
use crosscut_rrd::{Array, Numbers, Value};

use crate::output::typeset::csv_field;

/// The columns `revolution`, `stamp_ns`, one for each index, and `value`. That of revolutions or stamps is empty for a
/// value without one.
pub(super) fn rows(revolution: Option<i64>, stamp_ns: Option<i64>, value: &Value) -> anyhow::Result<RecordBatch> {
    let (dims, parts): (Vec<&str>, Vec<(Vec<usize>, ArrayRef)>) = match value {
        Value::Numbers(array) => (array.dims.iter().map(String::as_str).collect(), vec![shape_and_numbers(array)]),
        Value::Lists(lists) => (vec!["list", "item", "axis"], lists.iter().map(shape_and_numbers).collect()),
        Value::Texts(texts) => {
            (vec!["item"], vec![(vec![texts.len()], Arc::new(StringArray::from_iter_values(texts)) as ArrayRef)])
        }
        other => bail!("{other} cannot be written as a table"),
    };
    let mut indices = vec![Vec::new(); dims.len()];
    for (list, (shape, values)) in parts.iter().enumerate() {
        let (of_list, of_dims) = indices.split_at_mut(usize::from(matches!(value, Value::Lists(_))));
        of_list.iter_mut().for_each(|column| column.extend(repeat_n(list as i64, values.len())));
        for (dim, (column, &size)) in of_dims.iter_mut().zip(shape).enumerate() {
            let inner: usize = shape[dim + 1..].iter().product();
            column.extend((0..values.len()).map(|at| (at / inner % size) as i64));
        }
    }
    let values = match parts.as_slice() {
        [] => Arc::new(Float32Array::from(Vec::<f32>::new())),
        parts => concat(&parts.iter().map(|(_, values)| values.as_ref()).collect::<Vec<_>>())?,
    };
    let same = |of_all: Option<i64>| Arc::new(Int64Array::from(vec![of_all; values.len()])) as ArrayRef;
    let mut columns = vec![same(revolution), same(stamp_ns)];
    columns.extend(indices.into_iter().map(|column| Arc::new(Int64Array::from(column)) as ArrayRef));
    columns.push(values);
    let names = ["revolution", "stamp_ns"].into_iter().chain(dims).chain(["value"]);
    let is_empty = [revolution.is_none(), stamp_ns.is_none()].into_iter().chain(std::iter::repeat(false));
    let fields = names
        .zip(&columns)
        .zip(is_empty)
        .map(|((name, column), is_empty)| Field::new(name, column.data_type().clone(), is_empty));
    Ok(RecordBatch::try_new(Arc::new(Schema::new(fields.collect::<Vec<_>>())), columns)?)
}

fn shape_and_numbers(array: &Array) -> (Vec<usize>, ArrayRef) {
    let numbers: ArrayRef = match &array.numbers {
        Numbers::F64(values) => Arc::new(Float64Array::from(values.clone())),
        Numbers::F32(values) => Arc::new(Float32Array::from(values.clone())),
        Numbers::I64(values) => Arc::new(Int64Array::from(values.clone())),
    };
    (array.shape.clone(), numbers)
}

/// The first line of a CSV file: the names of the columns.
pub(super) fn write_csv_header(out: &mut impl Write, rows: &RecordBatch) -> io::Result<()> {
    let names: Vec<_> = rows.schema_ref().fields().iter().map(|field| csv_field(field.name())).collect();
    writeln!(out, "{}", names.join(","))
}

/// The rows as lines of CSV. A number is the shortest text that reads back as the same number.
pub(super) fn write_csv(out: &mut impl Write, rows: &RecordBatch) -> io::Result<()> {
    let Some((values, indices)) = rows.columns().split_last() else { return Ok(()) };
    for row in 0..rows.num_rows() {
        for column in indices {
            if column.is_valid(row) {
                write!(out, "{}", column.as_primitive::<Int64Type>().value(row))?;
            }
            out.write_all(b",")?;
        }
        match values.data_type() {
            DataType::Float64 => writeln!(out, "{:?}", values.as_primitive::<Float64Type>().value(row)),
            DataType::Float32 => writeln!(out, "{:?}", values.as_primitive::<Float32Type>().value(row)),
            DataType::Int64 => writeln!(out, "{}", values.as_primitive::<Int64Type>().value(row)),
            _ => writeln!(out, "{}", csv_field(values.as_string::<i32>().value(row))),
        }?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn csv(revolution: Option<i64>, stamp_ns: Option<i64>, value: &Value) -> String {
        let (mut csv, rows) = (Vec::new(), rows(revolution, stamp_ns, value).unwrap());
        write_csv_header(&mut csv, &rows).unwrap();
        write_csv(&mut csv, &rows).unwrap();
        String::from_utf8(csv).unwrap()
    }

    fn array(numbers: Numbers, shape: &[usize]) -> Array {
        let dims = ["return i", "return j, upper triangle"];
        Array { shape: shape.to_vec(), dims: dims[..shape.len()].iter().map(|&dim| dim.to_owned()).collect(), numbers }
    }

    #[test]
    fn indices_run_fastest_along_the_last_dimension() {
        let matrix = array(Numbers::F64(vec![0.1, f64::INFINITY, -0.0, 1e-16, 1e300, 5.0]), &[2, 3]);
        let expected = "revolution,stamp_ns,return i,\"return j, upper triangle\",value\n\
            7,70,0,0,0.1\n7,70,0,1,inf\n7,70,0,2,-0.0\n7,70,1,0,1e-16\n7,70,1,1,1e300\n7,70,1,2,5.0\n";
        assert_eq!(csv(Some(7), Some(70), &Value::Numbers(matrix)), expected);
        let number = Value::Numbers(array(Numbers::I64(vec![3]), &[]));
        assert_eq!(csv(Some(7), Some(70), &number), "revolution,stamp_ns,value\n7,70,3\n");
    }

    #[test]
    fn lists_of_different_lengths_have_an_index_of_the_list() {
        let strip = |numbers: &[f32], shape: &[usize]| array(Numbers::F32(numbers.to_vec()), shape);
        let strips = Value::Lists(vec![strip(&[0.1, 1.0], &[1, 2]), strip(&[2.0, 3.0, 4.0, 5.0], &[2, 2])]);
        let expected = "revolution,stamp_ns,list,item,axis,value\n\
            7,,0,0,0,0.1\n7,,0,0,1,1.0\n7,,1,0,0,2.0\n7,,1,0,1,3.0\n7,,1,1,0,4.0\n7,,1,1,1,5.0\n";
        assert_eq!(csv(Some(7), None, &strips), expected);
        assert_eq!(csv(Some(7), None, &Value::Lists(vec![])), "revolution,stamp_ns,list,item,axis,value\n");
    }

    #[test]
    fn texts_with_commas_quotes_and_line_ends_stay_one_field() {
        let texts = Value::Texts(["tee", "a, b", "\"c\"", "d\ne"].map(str::to_owned).to_vec());
        let expected = "revolution,stamp_ns,item,value\n,,0,tee\n,,1,\"a, b\"\n,,2,\"\"\"c\"\"\"\n,,3,\"d\ne\"\n";
        assert_eq!(csv(None, None, &texts), expected);
    }
}

//! A value as rows of a table: one row for each of its numbers or texts, with its indices.

use std::io::{self, Write};

use anyhow::bail;
use crosscut_rrd::{Array, Numbers, Value};

use crate::output::typeset::csv_field;

/// The names of the columns: `revolution`, `stamp_ns`, one for each index, and `value`.
pub(super) fn columns(value: &Value) -> anyhow::Result<Vec<&str>> {
    let dims: Vec<&str> = match value {
        Value::Numbers(array) => array.dims.iter().map(String::as_str).collect(),
        Value::Lists(_) => vec!["list", "item", "axis"],
        Value::Texts(_) => vec!["item"],
        other => bail!("{other} cannot be written as a table"),
    };
    Ok(["revolution", "stamp_ns"].into_iter().chain(dims).chain(["value"]).collect())
}

/// The first line of a CSV file: the names of the columns.
pub(super) fn write_csv_header(out: &mut impl Write, columns: &[&str]) -> io::Result<()> {
    writeln!(out, "{}", columns.iter().map(|name| csv_field(name)).collect::<Vec<_>>().join(","))
}

/// The rows as lines of CSV; revolution and stamp are empty for a value without one.
pub(super) fn write_csv(out: &mut impl Write, of: [Option<i64>; 2], value: &Value) -> io::Result<()> {
    let of = of.map(|number| number.map_or_else(String::new, |number| number.to_string())).join(",");
    match value {
        Value::Numbers(array) => write_numbers(out, &of, array),
        Value::Lists(lists) => {
            lists.iter().enumerate().try_for_each(|(at, list)| write_numbers(out, &format!("{of},{at}"), list))
        }
        Value::Texts(texts) => {
            texts.iter().enumerate().try_for_each(|(at, text)| writeln!(out, "{of},{at},{}", csv_field(text)))
        }
        _ => Ok(()), // which has no columns
    }
}

/// A number is the shortest text that reads back as the same number.
fn write_numbers(out: &mut impl Write, of: &str, array: &Array) -> io::Result<()> {
    for at in 0..array.numbers.len() {
        out.write_all(of.as_bytes())?;
        let mut inner: usize = array.shape.iter().product();
        for size in &array.shape {
            inner /= size;
            write!(out, ",{}", at / inner % size)?;
        }
        match &array.numbers {
            Numbers::F64(values) => writeln!(out, ",{:?}", values[at]),
            Numbers::F32(values) => writeln!(out, ",{:?}", values[at]),
            Numbers::I64(values) => writeln!(out, ",{}", values[at]),
        }?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn csv(revolution: Option<i64>, stamp_ns: Option<i64>, value: &Value) -> String {
        let mut csv = Vec::new();
        write_csv_header(&mut csv, &columns(value).unwrap()).unwrap();
        write_csv(&mut csv, [revolution, stamp_ns], value).unwrap();
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

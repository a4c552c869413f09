//! NumPy's file format, version 1.0: a header that is a Python literal, then the numbers.
//!
//! Own code, because the crates for it bring a parser of Python literals and a compiled assembly file for one line of
//! text. The cross-checks read these files with NumPy.

use std::io::{self, Read};

/// Length of the header, padded with spaces: room for any shape, which may be known last.
pub const HEADER_BYTES: usize = 192;

/// The longest header that is read.
const LONGEST_HEADER: usize = 1 << 16;

/// Numbers in rows, with their shape.
#[derive(Clone, Debug, PartialEq)]
pub struct NpyArray {
    /// Sizes, the slowest first; empty for a single number.
    pub shape: Vec<usize>,
    /// The numbers, the last index fastest.
    pub values: Vec<f64>,
}

/// The header of numbers of the type `descr` (`<f8`), of this shape, the last index fastest.
pub fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let sizes: String = shape.iter().map(|size| format!("{size}, ")).collect();
    let literal = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({sizes}), }}");
    let room = HEADER_BYTES - 10;
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend((room as u16).to_le_bytes());
    header.extend(format!("{literal:<width$}\n", width = room - 1).into_bytes());
    header
}

impl NpyArray {
    /// A file of numbers of type `<f8`.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut file = header("<f8", &self.shape);
        file.extend(self.values.iter().flat_map(|x| x.to_le_bytes()));
        file
    }

    /// Reads an array of at most `most` whole or floating-point numbers in any byte order, by rows or by columns.
    ///
    /// # Errors
    /// When it is not such a file, cut off, or larger.
    pub fn read(from: &mut impl Read, most: usize) -> Result<Self, String> {
        let cut_off = |error: io::Error| format!("the file is cut off: {error}");
        let mut magic = [0; 8];
        from.read_exact(&mut magic).map_err(cut_off)?;
        if &magic[..6] != b"\x93NUMPY" {
            return Err("not a file of numpy.save".to_owned());
        }
        let mut length = [0; 4];
        from.read_exact(&mut length[..if magic[6] == 1 { 2 } else { 4 }]).map_err(cut_off)?;
        let length = u32::from_le_bytes(length) as usize;
        if length > LONGEST_HEADER {
            return Err(format!("a header of {length} bytes"));
        }
        let mut header = vec![0; length];
        from.read_exact(&mut header).map_err(cut_off)?;
        let header = String::from_utf8_lossy(&header).into_owned();
        let unknown = || format!("a header that is not understood: {}", header.trim());
        let descr = between(&header, "'descr':", ",").map(|text| text.trim_matches(['\'', ' '])).ok_or_else(unknown)?;
        let by_columns = between(&header, "'fortran_order':", ",").ok_or_else(unknown)?.trim() == "True";
        let sizes = between(&header, "'shape':", ")").ok_or_else(unknown)?.trim().trim_start_matches('(');
        let sizes = sizes.split(',').map(str::trim).filter(|size| !size.is_empty());
        let shape: Vec<usize> = sizes.map(|size| size.parse().map_err(|_| unknown())).collect::<Result<_, _>>()?;

        let (decode, bytes) = decoder(descr).ok_or_else(|| format!("numbers of type {descr}; save float64"))?;
        let count = shape.iter().try_fold(1_usize, |all, &size| all.checked_mul(size));
        let count = count.filter(|&count| count <= most);
        let count = count.ok_or_else(|| format!("its shape {shape:?} has more than the {most} numbers that fit"))?;
        let mut data = Vec::new();
        from.take((count * bytes) as u64 + 1).read_to_end(&mut data).map_err(cut_off)?;
        if data.len() != count * bytes {
            let kind = if data.len() < count * bytes { "fewer" } else { "more" };
            return Err(format!("it holds {kind} numbers than its shape {shape:?} says"));
        }
        let values: Vec<f64> = data.chunks_exact(bytes).map(decode).collect();
        Ok(Self { values: if by_columns { by_rows(&shape, &values)? } else { values }, shape })
    }
}

fn between<'a>(text: &'a str, start: &str, end: &str) -> Option<&'a str> {
    let (_, after) = text.split_once(start)?;
    after.split_once(end).map(|(found, _)| found)
}

/// Reads one number from its bytes.
type Decode = fn(&[u8]) -> f64;

/// How a type of NumPy is decoded, and how many bytes a number has.
fn decoder(descr: &str) -> Option<(Decode, usize)> {
    fn whole<const N: usize>(bytes: &[u8]) -> [u8; N] {
        bytes.try_into().expect("as many bytes as the type has")
    }
    Some(match descr {
        "<f8" => (|bytes| f64::from_le_bytes(whole(bytes)), 8),
        ">f8" => (|bytes| f64::from_be_bytes(whole(bytes)), 8),
        "<f4" => (|bytes| f64::from(f32::from_le_bytes(whole(bytes))), 4),
        "<i8" => (|bytes| i64::from_le_bytes(whole(bytes)) as f64, 8),
        "<i4" => (|bytes| f64::from(i32::from_le_bytes(whole(bytes))), 4),
        "<u4" => (|bytes| f64::from(u32::from_le_bytes(whole(bytes))), 4),
        "|u1" | "|b1" => (|bytes| f64::from(bytes[0]), 1),
        _ => return None,
    })
}

/// The numbers of a matrix that was stored by columns, by rows.
fn by_rows(shape: &[usize], values: &[f64]) -> Result<Vec<f64>, String> {
    match *shape {
        [] | [_] => Ok(values.to_vec()),
        [rows, columns] => Ok((0..rows * columns).map(|at| values[at / columns + rows * (at % columns)]).collect()),
        _ => Err("more than two dimensions by columns; save numpy.ascontiguousarray(...)".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(descr: &str, by_columns: bool, shape: &str, data: &[u8]) -> Vec<u8> {
        let order = if by_columns { "True" } else { "False" };
        let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
        let mut file = b"\x93NUMPY\x01\x00".to_vec();
        file.extend((header.len() as u16).to_le_bytes());
        file.extend(header.bytes().chain(data.iter().copied()));
        file
    }

    #[test]
    fn what_is_written_reads_back() {
        for shape in [vec![], vec![3], vec![2, 3], vec![0, 4]] {
            let count = shape.iter().product();
            let array = NpyArray { values: (0..count).map(|i| i as f64 / 3.0).collect(), shape };
            assert_eq!(NpyArray::read(&mut &array.to_bytes()[..], 6), Ok(array));
        }
    }

    #[test]
    fn columns_and_other_types_are_read_as_rows_of_numbers() {
        let bytes: Vec<u8> = [1_i32, 2, 3, 4, 5, 6].iter().flat_map(|i| i.to_le_bytes()).collect();
        let read = |file: Vec<u8>| NpyArray::read(&mut &file[..], 6).map(|array| array.values);
        assert_eq!(read(file("<i4", true, "(2, 3)", &bytes)), Ok(vec![1.0, 3.0, 5.0, 2.0, 4.0, 6.0]));
        assert_eq!(read(file("<i4", false, "(6,)", &bytes)), Ok(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    }

    #[test]
    fn what_is_no_such_file_is_refused_in_words() {
        let refused = |file: &[u8]| NpyArray::read(&mut &*file, 4).expect_err("refused");
        assert!(refused(b"PK\x03\x04aaaaaaa").contains("numpy.save"));
        assert!(refused(&file("<f8", false, "(2, 2)", &[0; 24])).contains("fewer"));
        assert!(refused(&file("<f8", false, "(2,)", &[0; 24])).contains("more"));
        assert!(refused(&file("<c16", false, "(1,)", &[0; 16])).contains("<c16"));
        assert!(refused(&file("<f8", false, "(99999999999999999999,)", &[])).contains("not understood"));
        assert!(refused(&file("<f8", false, "(5,)", &[0; 40])).contains("more than the 4 numbers"));
        assert!(refused(&file("<f8", false, "(4294967296, 4294967296)", &[])).contains("more than"));
    }

    #[test]
    fn the_header_has_its_stated_length_and_ends_in_a_newline() {
        for shape in [&[][..], &[7], &[3, 312, 4], &[usize::MAX; 4]] {
            let header = header("<f8", shape);
            assert_eq!(header.len(), HEADER_BYTES);
            assert_eq!(usize::from(u16::from_le_bytes([header[8], header[9]])), HEADER_BYTES - 10);
            assert_eq!(header.last(), Some(&b'\n'));
        }
        let text = String::from_utf8_lossy(&header("<i8", &[7])).into_owned();
        assert!(text.contains("{'descr': '<i8', 'fortran_order': False, 'shape': (7, ), }"), "{text}");
    }
}

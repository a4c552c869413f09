//! NumPy's file format, version 1.0: a header that is a Python literal, then the numbers.
//!
//! Own code, because the crates for it bring a parser of Python literals and a compiled assembly file for one line of
//! text. The cross-checks read these files with NumPy.

use std::io::{Seek, Write};

use anyhow::bail;
use crosscut_outfile::Whole;
use crosscut_rrd::{Array, Numbers};

use crate::exit::UsageError;

/// Length of the header, padded with spaces: room for any shape, which is known last.
const HEADER_BYTES: usize = 192;

/// An array that grows along its first dimension, the revolutions.
pub(super) struct NpyFile {
    file: Whole,
    one: bool,
    count: usize,
    /// Type and shape of every revolution, set by the first one.
    each: Option<(&'static str, Vec<usize>)>,
}

impl NpyFile {
    /// An empty file. The array of `one` revolution has no dimension for revolutions.
    pub(super) fn new(mut file: Whole, one: bool) -> anyhow::Result<Self> {
        file.write_all(&[0; HEADER_BYTES])?;
        Ok(Self { file, one, count: 0, each: None })
    }

    /// The numbers of one more revolution.
    pub(super) fn add(&mut self, array: &Array) -> anyhow::Result<()> {
        let each = (descr(&array.numbers), array.shape.clone());
        let first = self.each.get_or_insert_with(|| each.clone());
        if *first != each || (self.one && self.count > 0) {
            let text = "its array differs in shape from the one before: take one with --revolution, or .csv";
            bail!(UsageError(format!("{text} ({:?} and {:?})", first.1, each.1)));
        }
        self.count += 1;
        match &array.numbers {
            Numbers::F64(values) => values.iter().try_for_each(|x| self.file.write_all(&x.to_le_bytes())),
            Numbers::F32(values) => values.iter().try_for_each(|x| self.file.write_all(&x.to_le_bytes())),
            Numbers::I64(values) => values.iter().try_for_each(|i| self.file.write_all(&i.to_le_bytes())),
        }?;
        Ok(())
    }

    /// Writes the header, now that the shape is known, and gives the file its name.
    pub(super) fn finish(mut self) -> anyhow::Result<()> {
        let (descr, each) = self.each.unwrap_or(("<f8", Vec::new()));
        let shape: Vec<usize> = if self.one { each } else { [self.count].into_iter().chain(each).collect() };
        self.file.rewind()?;
        self.file.write_all(&header(descr, &shape))?;
        Ok(self.file.finish()?)
    }
}

/// NumPy's name of the type.
fn descr(numbers: &Numbers) -> &'static str {
    match numbers {
        Numbers::F64(_) => "<f8",
        Numbers::F32(_) => "<f4",
        Numbers::I64(_) => "<i8",
    }
}

fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let sizes: String = shape.iter().map(|size| format!("{size}, ")).collect();
    let literal = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({sizes}), }}");
    let room = HEADER_BYTES - 10;
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend((room as u16).to_le_bytes());
    header.extend(format!("{literal:<width$}\n", width = room - 1).into_bytes());
    header
}

#[cfg(test)]
mod tests {
    use super::*;

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

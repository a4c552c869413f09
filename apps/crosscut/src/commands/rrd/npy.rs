//! An array of NumPy that grows while a recording is read.

use std::io::{Seek, Write};

use anyhow::bail;
use crosscut_debugger::npy::{HEADER_BYTES, header};
use crosscut_outfile::Whole;
use crosscut_rrd::{Array, Numbers};

use crate::exit::UsageError;

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
            let text = "its array differs in shape from the one before: take one with --at, or .csv";
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

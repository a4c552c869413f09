//! A file that is of use only when it is complete.

use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use crate::Keep;
use crate::part::Part;

/// A file that has its name once it is finished. Dropped before that, it is removed.
pub struct Whole {
    out: BufWriter<Unbuffered>,
}

struct Unbuffered(Part);

impl Whole {
    /// Begins the file, and holds it: a second program is refused.
    ///
    /// # Errors
    /// When it cannot be written, or another program writes to it.
    pub fn create(path: &Path, keep: Keep) -> io::Result<Self> {
        Ok(Self { out: BufWriter::new(Unbuffered(Part::create(path, keep)?)) })
    }

    /// Where the bytes are until the file is finished; `None` for a pipe or a device. Who ends the program at once, without
    /// dropping this value, removes it.
    pub fn part(&self) -> Option<&Path> {
        self.out.get_ref().0.path()
    }

    /// Gives the file its name; what had it before is gone then.
    ///
    /// # Errors
    /// When it cannot be written; what was there is then still there.
    pub fn finish(mut self) -> io::Result<()> {
        self.out.flush()?;
        self.out.get_mut().0.take_name()
    }
}

impl Write for Whole {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

impl Seek for Whole {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.out.seek(to)
    }
}

impl Write for Unbuffered {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.file().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Unbuffered {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.file().seek(to)
    }
}

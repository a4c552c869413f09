//! A file that is closed while nobody reads it: a flight may have more parts than a process may have files open.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::PathBuf;
use std::sync::Arc;

use tempfile::TempPath;

use crate::stopping;

/// Open from the first read after a rest on.
pub(super) struct RestingFile {
    path: PathBuf,
    file: Option<File>,
    /// Where reading goes on after a rest.
    at_byte: u64,
    /// Removes the file, if it is a temporary one, when nobody reads it any more.
    _temporary: Option<Arc<TempPath>>,
}

impl RestingFile {
    pub(super) fn new(path: PathBuf, file: File) -> Self {
        Self { path, file: Some(file), at_byte: 0, _temporary: None }
    }

    /// A file that goes away with the last value that names it.
    pub(super) fn temporary(path: Arc<TempPath>) -> Self {
        Self { path: path.to_path_buf(), file: None, at_byte: 0, _temporary: Some(path) }
    }

    /// Size of the file.
    pub(super) fn length(&self) -> io::Result<u64> {
        self.file.as_ref().map_or_else(|| self.path.metadata(), File::metadata).map(|metadata| metadata.len())
    }

    /// Closes it until it is read again.
    pub(super) fn rest(&mut self) -> io::Result<()> {
        if let Some(file) = &mut self.file {
            self.at_byte = file.stream_position()?;
            self.file = None;
        }
        Ok(())
    }

    fn awake(&mut self) -> io::Result<&mut File> {
        if self.file.is_none() {
            let mut file = File::open(&self.path)?;
            file.seek(SeekFrom::Start(self.at_byte))?;
            self.file = Some(file);
        }
        Ok(self.file.as_mut().expect("opened above"))
    }
}

impl Read for RestingFile {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        stopping::check()?;
        self.awake()?.read(buffer)
    }
}

impl Seek for RestingFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match (&self.file, to) {
            (None, SeekFrom::Start(at_byte)) => self.at_byte = at_byte,
            (None, SeekFrom::Current(0)) => {}
            _ => return self.awake()?.seek(to),
        }
        Ok(self.at_byte)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reading_goes_on_after_a_rest_where_it_was_or_was_sent_to() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("ten.bin");
        std::fs::write(&path, (0..10).collect::<Vec<u8>>()).expect("writable");
        let mut file = RestingFile::new(path.clone(), File::open(&path).expect("there"));
        let next = |file: &mut RestingFile| {
            let mut byte = [0];
            file.read_exact(&mut byte).map(|()| byte[0])
        };
        assert_eq!(next(&mut file).expect("a byte"), 0);
        file.rest().expect("at rest");
        assert_eq!((file.stream_position().expect("known"), next(&mut file).expect("a byte")), (1, 1));
        file.rest().expect("at rest");
        assert_eq!(file.seek(SeekFrom::Start(7)).expect("sought"), 7);
        assert_eq!(next(&mut file).expect("a byte"), 7);
        file.rest().expect("at rest");
        assert_eq!(file.seek(SeekFrom::End(-1)).expect("sought"), 9);
        file.rest().expect("at rest");
        std::fs::remove_file(path).expect("there");
        assert!(next(&mut file).is_err(), "gone while it rested");
    }
}

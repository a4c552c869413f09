//! Files that are read on while they are written, one after the other.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::thread::Builder;

use super::feed::{Feeding, FileFeed};
use crate::container::{self, FollowedMcap};
use crate::{CsvGeometry, Following, IngestError, Loss, LossKind, metadata, recordings_in};

/// Waits for the first of the files in `inputs`, and reads them into `feed` on a thread of its own.
///
/// # Errors
/// When the first file cannot be read or is no MCAP, or waiting is over before it is there.
pub(super) fn read(inputs: &[PathBuf], feed: FileFeed, following: &Following) -> Result<(), IngestError> {
    let mut files = Files { inputs: inputs.to_vec(), done: BTreeSet::new(), following: following.clone() };
    let first = match files.next() {
        Some(path) => path,
        None => return Err(recordings_in(inputs).err().unwrap_or(IngestError::NoInput)),
    };
    let first = open(&first, following)?;
    let reading = Builder::new().name("follow".to_owned()).spawn(move || {
        let mut file = Some(first);
        while let Some(mut open_file) = file.take() {
            if !feed_all(&mut open_file, &feed) {
                return;
            }
            file = files.next_open(&feed);
        }
    });
    reading.map(drop).map_err(|source| IngestError::cannot_open(&inputs[0], source))
}

/// The files of a flight, of which more may appear.
struct Files {
    inputs: Vec<PathBuf>,
    done: BTreeSet<PathBuf>,
    following: Following,
}

impl Files {
    /// The next file, once it is there; `None` if there will be no more.
    fn next(&mut self) -> Option<PathBuf> {
        loop {
            // In this order: a file that appears in between is found the next time.
            let is_closed = self.inputs.iter().all(|input| !input.is_dir() || metadata::is_there(input));
            let mut is_missing = false;
            for input in &self.inputs {
                let files =
                    if input.is_dir() { recordings_in(std::slice::from_ref(input)) } else { Ok(vec![input.clone()]) };
                is_missing |= files.is_err();
                let next = files.unwrap_or_default().into_iter().find(|file| !self.done.contains(file));
                if let Some(next) = next {
                    self.done.insert(next.clone());
                    return Some(next);
                }
            }
            if (is_closed && !is_missing) || !self.following.wait() {
                return None;
            }
        }
    }

    /// The next file that can be read; others are lost.
    fn next_open(&mut self, feed: &FileFeed) -> Option<FollowedMcap> {
        loop {
            let path = self.next()?;
            match open(&path, &self.following) {
                Ok(file) => return Some(file),
                Err(error) => {
                    let loss = Loss { file: path, kind: LossKind::File { cause: error.to_string() } };
                    feed.lose(loss).ok()?;
                }
            }
        }
    }
}

/// Opens an MCAP, once its first bytes are there.
fn open(path: &Path, following: &Following) -> Result<FollowedMcap, IngestError> {
    let failed = |source| IngestError::cannot_open(path, source);
    loop {
        if !std::fs::metadata(path).map_err(failed)?.is_file() {
            return Err(IngestError::NotAFile { path: path.to_owned() });
        }
        let (file, mut start) = (File::open(path).map_err(failed)?, Vec::new());
        (&file).take(::mcap::MAGIC.len() as u64).read_to_end(&mut start).map_err(failed)?;
        if start == ::mcap::MAGIC {
            return container::follow_mcap(path, file, following).map_err(failed);
        }
        let error = match container::open(path, &CsvGeometry::default()) {
            Ok(_) => IngestError::CannotFollow { path: path.to_owned() },
            Err(error) => error,
        };
        if !error.may_be_too_early() || !following.wait() {
            return Err(error);
        }
    }
}

/// Feeds all messages of a file; `false` if nobody wants more.
fn feed_all(file: &mut FollowedMcap, feed: &FileFeed) -> bool {
    let mut feeding = Feeding::new(feed);
    loop {
        let read = file.step(&mut feeding);
        let is_lost = read.loss.map_or(Ok(()), |loss| feed.lose(loss));
        if is_lost.is_err() || !feeding.is_wanted {
            return false;
        }
        if read.has_ended {
            return true;
        }
    }
}

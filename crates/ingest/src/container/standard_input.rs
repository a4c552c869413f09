//! Standard input, which may send nothing for long.

use std::io::{self, Read};
use std::thread::Builder;
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, bounded};

use crate::stopping;

const PART_BYTES: usize = 64 * 1024;
/// This many parts wait to be taken.
const MOST_WAITING: usize = 4;
/// How long a reader waits before it looks whether reading has to stop.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Reads standard input on a thread of its own, so that reading stops when it has to ([`crate::stop_reading`]), whether anything
/// comes or not.
pub(crate) struct StandardInput {
    parts: Receiver<io::Result<Vec<u8>>>,
    part: io::Cursor<Vec<u8>>,
}

impl StandardInput {
    /// Begins to read.
    ///
    /// # Errors
    /// When the thread cannot be started.
    pub(crate) fn open() -> io::Result<Self> {
        let (sender, parts) = bounded(MOST_WAITING);
        let read = move || {
            loop {
                let mut part = vec![0; PART_BYTES];
                let read = match io::stdin().read(&mut part) {
                    Ok(0) => return,
                    Ok(count) => {
                        part.truncate(count);
                        Ok(part)
                    }
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                    Err(error) => Err(error),
                };
                let has_ended = read.is_err();
                if sender.send(read).is_err() || has_ended {
                    return;
                }
            }
        };
        // Nobody waits for this thread: it may be reading a pipe into which nothing comes any more.
        Builder::new().name("stdin".to_owned()).spawn(read)?;
        Ok(Self { parts, part: io::Cursor::default() })
    }
}

impl Read for StandardInput {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.part.position() == self.part.get_ref().len() as u64 {
            match self.parts.recv_timeout(LOOK_EVERY) {
                Ok(part) => self.part = io::Cursor::new(part?),
                Err(RecvTimeoutError::Timeout) => stopping::check()?,
                Err(RecvTimeoutError::Disconnected) => return Ok(0),
            }
        }
        self.part.read(buffer)
    }
}

//! Standard input, read as it comes.

use std::io::{self, BufReader};
use std::path::Path;
use std::thread::Builder;

use super::feed::{Feeding, FileFeed};
use crate::container::{PipedMcap, Plain, StandardInput, keep_standard_input};

/// Reads standard input into `feed` on a thread of its own, if it is an MCAP; otherwise keeps it, to be read as a whole, and gives
/// `false`.
pub(super) fn read(feed: FileFeed) -> io::Result<bool> {
    let input = Plain::of(StandardInput::open()?)?;
    if input.start != mcap::MAGIC {
        keep_standard_input(input)?;
        return Ok(false);
    }
    let mut piped = PipedMcap::new(BufReader::new(input.rest), Path::new("-"));
    let read = move || {
        let mut feeding = Feeding::new(&feed);
        loop {
            let read = piped.step(&mut feeding);
            let is_lost = read.loss.map_or(Ok(()), |loss| feed.lose(loss));
            if read.has_ended || is_lost.is_err() || !feeding.is_wanted {
                return;
            }
        }
    };
    // Nobody waits for this thread: it may be reading a pipe into which nothing comes any more.
    Builder::new().name("stdin".to_owned()).spawn(read).map(|_| true)
}

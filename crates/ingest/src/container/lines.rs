//! Text files with a message, or several, in a line.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io::{self, BufRead, BufReader, Read as _, Seek as _};
use std::mem;
use std::path::Path;

use super::resting_file::RestingFile;
use super::{ChannelId, Container, Contents, Message, Topic};
use crate::{Loss, LossKind, limits};

/// What lines mean.
pub(super) trait LineFormat: Send {
    /// Name of the format.
    const NAME: &'static str;
    /// Whether the last word of a line matters, so that a file may have been cut off in it unnoticed.
    const LAST_WORD_COUNTS: bool;

    /// Looks at a line before any is read, so that what holds for the whole file is known.
    fn survey(&mut self, line: &Line);

    /// What each channel carries that the survey found.
    fn channels(&self) -> BTreeMap<ChannelId, Topic>;

    /// What there is to say of the file beside its topics.
    fn properties(&self) -> Vec<(&'static str, String)> {
        Vec::new()
    }

    /// Hands the messages of a line to `out`. Lines come in their order; behind the last one comes an empty one.
    ///
    /// # Errors
    /// When the line should have a message of this channel, and cannot be read: why.
    fn read(&mut self, line: &Line, out: &mut VecDeque<Message>) -> Result<(), (ChannelId, String)>;
}

/// One line.
pub(super) struct Line {
    /// Counted from 1.
    pub(super) number: u64,
    /// Without its end.
    pub(super) text: String,
    /// Whether its end is there. Otherwise the file may have been cut off in its last word.
    pub(super) is_ended: bool,
}

impl Line {
    /// The number of the empty line behind the last one.
    pub(super) const END: u64 = u64::MAX;
}

/// Reads a text file as a [`Container`].
pub(super) struct Lines<F> {
    format: F,
    input: BufReader<RestingFile>,
    number: u64,
    contents: Contents,
    is_by_log_time: bool,
    selected: BTreeSet<ChannelId>,
    queue: VecDeque<Message>,
    /// When the last message was recorded.
    last_ns: u64,
    losses: Vec<Loss>,
}

impl<F: LineFormat> Lines<F> {
    /// Looks through `file`; `path` names it in losses.
    pub(super) fn open(path: &Path, file: RestingFile, mut format: F) -> io::Result<Self> {
        let bytes = file.length()?;
        let mut input = BufReader::new(file);
        let mut number = 0;
        while let Some(line) = line_or_end(&mut input, &mut number)? {
            format.survey(&line);
        }
        let channels = format.channels();
        let properties = format.properties();
        let contents =
            Contents { path: path.to_owned(), bytes, format: F::NAME, properties, channels, ..Contents::default() };
        let (queue, losses) = (VecDeque::new(), Vec::new());
        let selected = contents.channels.keys().copied().collect();
        let mut lines =
            Self { format, input, number, contents, is_by_log_time: true, selected, queue, last_ns: 0, losses };
        lines.count()?;
        Ok(lines)
    }

    /// Counts the messages, and the lines that cannot be read.
    fn count(&mut self) -> io::Result<()> {
        self.input.rewind()?;
        self.number = 0;
        let (mut counts, mut damaged, mut last_ns, mut unreadable) = (BTreeMap::new(), BTreeMap::new(), 0, None);
        while let Some(line) = line_or_end(&mut self.input, &mut self.number)? {
            if let Err((channel, cause)) = self.format.read(&line, &mut self.queue) {
                unreadable.get_or_insert((line.number, 0, cause)).1 += 1;
                *damaged.entry(channel).or_default() += u64::from(line.is_ended);
            }
            if F::LAST_WORD_COUNTS && !line.is_ended && !self.queue.is_empty() {
                let kind = LossKind::LastLine { line: line.number };
                self.contents.losses.push(Loss { file: self.contents.path.clone(), kind });
            }
            for Message { channel, log_time_ns, .. } in self.queue.drain(..) {
                *counts.entry(channel).or_default() += 1;
                self.is_by_log_time &= log_time_ns >= mem::replace(&mut last_ns, log_time_ns);
                self.contents.log_times_ns.add(log_time_ns);
            }
        }
        // A channel without any line that can be read has no messages.
        for (channel, count) in &mut counts {
            *count += damaged.get(channel).copied().unwrap_or(0);
        }
        self.contents.counts = Some(counts);
        if let Some((first, count, cause)) = unreadable {
            let kind = LossKind::Lines { first, count, cause };
            self.contents.losses.push(Loss { file: self.contents.path.clone(), kind });
        }
        self.rest()
    }

    fn rest(&mut self) -> io::Result<()> {
        (self.number, self.last_ns) = (0, 0);
        self.input.rewind()?;
        self.input.get_mut().rest()
    }

    fn lose_rest(&mut self, error: io::Error) {
        let kind = LossKind::Rest { at_byte: 0, damage: error.into() };
        self.losses.push(Loss { file: self.contents.path.clone(), kind });
    }
}

impl<F: LineFormat> Container for Lines<F> {
    fn contents(&self) -> &Contents {
        &self.contents
    }

    fn contents_mut(&mut self) -> &mut Contents {
        &mut self.contents
    }

    fn select(&mut self, channels: &BTreeSet<ChannelId>) {
        self.selected.clone_from(channels);
        self.queue.clear();
        self.rest().unwrap_or_else(|error| self.lose_rest(error));
    }

    fn next(&mut self) -> Option<Message> {
        while self.queue.is_empty() {
            let line = match line_or_end(&mut self.input, &mut self.number) {
                Ok(Some(line)) => line,
                Ok(None) => return None,
                Err(error) => {
                    self.lose_rest(error);
                    return None;
                }
            };
            let Self { format, queue, selected, .. } = self;
            // Lines that cannot be read were found when the file was looked through. Each that was written to its end is a
            // message of its channel all the same, as old as the one before it.
            if let Err((channel, cause)) = format.read(&line, queue)
                && line.is_ended
            {
                let damage = Some(format!("line {}: {cause}", line.number));
                queue.push_back(Message { channel, log_time_ns: self.last_ns, data: Vec::new(), damage });
            }
            self.last_ns = queue.back().map_or(self.last_ns, |message| message.log_time_ns);
            queue.retain(|message| selected.contains(&message.channel));
        }
        self.queue.pop_front()
    }

    fn is_by_log_time(&self) -> bool {
        self.is_by_log_time
    }

    fn take_losses(&mut self) -> Vec<Loss> {
        mem::take(&mut self.losses)
    }
}

/// The next line, or the empty one behind the last.
fn line_or_end(input: &mut impl BufRead, number: &mut u64) -> io::Result<Option<Line>> {
    let has_ended = *number == Line::END;
    let line = if has_ended { None } else { next_line(input, number)? };
    if line.is_none() && !has_ended {
        *number = Line::END;
        return Ok(Some(Line { number: Line::END, text: String::new(), is_ended: true }));
    }
    Ok(line)
}

/// The next line, without a mark of the byte order; one that is too long is cut off.
pub(super) fn next_line(input: &mut impl BufRead, number: &mut u64) -> io::Result<Option<Line>> {
    let mut bytes = Vec::new();
    if input.take(limits::LINE_BYTES).read_until(b'\n', &mut bytes)? == 0 {
        return Ok(None);
    }
    *number += 1;
    let is_ended = bytes.ends_with(b"\n");
    let text = String::from_utf8_lossy(&bytes).trim_start_matches('\u{feff}').trim_end_matches(['\r', '\n']).to_owned();
    Ok(Some(Line { number: *number, text, is_ended }))
}

//! The messages of one topic in one file, counted.

use std::collections::BTreeSet;
use std::io::Read as _;
use std::mem;

use crosscut_messages::CDR_ENCODING;

use super::{ChannelId, Container, Message};
use crate::{Loss, LossKind, limits};

/// The first bytes of what is compressed with zstd.
const ZSTD_SIGN: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// Reads the messages of one topic, in the order of its [`Container`].
pub(crate) struct TopicReader {
    /// Messages go back to it, and it knows whether a stream goes on; [`TopicReader::next`] gives them.
    pub(crate) container: Box<dyn Container>,
    channels: BTreeSet<ChannelId>,
    /// Messages that were handed out, or are known to be lost.
    passed: u64,
    /// Messages that are known to be lost, since the last call of [`TopicReader::take_skipped`].
    skipped: u64,
    /// Something was lost, and it is not known how many messages with it.
    lost_uncounted: bool,
    losses: Vec<Loss>,
}

impl TopicReader {
    pub(crate) fn new(mut container: Box<dyn Container>, channels: BTreeSet<ChannelId>) -> Self {
        container.select(&channels);
        let mut losses = container.contents().losses.clone();
        losses.extend(container.take_losses());
        Self { container, channels, passed: 0, skipped: 0, lost_uncounted: false, losses }
    }

    /// The next message; give it back to its container.
    pub(crate) fn next(&mut self) -> Option<Message> {
        let mut message = self.container.next();
        if let Some(message) = &mut message {
            self.decompress(message);
        }
        let skipped = self.container.take_skipped();
        self.skipped += skipped;
        self.passed += skipped;
        for loss in self.container.take_losses() {
            self.lost_uncounted |= matches!(loss.kind, LossKind::Part { scans: None, .. } | LossKind::Rest { .. });
            self.losses.push(loss);
        }
        match message {
            Some(_) => self.passed += 1,
            None => self.check_count(),
        }
        message
    }

    /// Decompresses a message of a recorder that compresses each one (`ros2 bag record --compression-mode message`). No
    /// message in CDR begins like that. A damaged one stays compressed, and cannot be decoded.
    fn decompress(&self, message: &mut Message) {
        let encoding = self.container.contents().channels.get(&message.channel).map(|topic| topic.encoding.as_str());
        if encoding != Some(CDR_ENCODING) || !message.data.starts_with(&ZSTD_SIGN) {
            return;
        }
        let mut plain = Vec::new();
        let decoder = zstd::stream::read::Decoder::with_buffer(&message.data[..]);
        let read = decoder.and_then(|decoder| decoder.take(limits::MESSAGE_BYTES).read_to_end(&mut plain));
        if read.is_ok() {
            message.data = plain;
        }
    }

    /// Reports messages that the file counts and that were not there, if nothing that is known explains it.
    fn check_count(&mut self) {
        let count = self.left();
        if count > 0 && self.container.is_by_log_time() && !self.lost_uncounted {
            self.passed += count;
            let contents = self.container.contents();
            let topic = self.channels.iter().find_map(|id| contents.channels.get(id)).map(|topic| topic.name.clone());
            let kind = LossKind::Missing { topic: topic.unwrap_or_default(), count };
            self.losses.push(Loss { file: contents.path.clone(), kind });
        }
    }

    /// How many messages are still to come, as the file counts them.
    pub(crate) fn left(&self) -> u64 {
        self.container.contents().count(&self.channels).unwrap_or(0).saturating_sub(self.passed)
    }

    /// How many messages were lost since the last call, as far as that is known.
    pub(crate) fn take_skipped(&mut self) -> u64 {
        mem::take(&mut self.skipped)
    }

    /// What was lost since the last call.
    pub(crate) fn take_losses(&mut self) -> Vec<Loss> {
        mem::take(&mut self.losses)
    }
}

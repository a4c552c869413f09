//! A reader of a stream: a container whose messages come as they come.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use super::feed::now_ns;
use super::queues::{LEARNING, LIVE_WAIT_NS, Queue, Stream, lock};
use crate::Loss;
use crate::container::Wait;
use crate::container::{ChannelId, Container, Contents, Message};

/// One reader; all of a stream share it.
pub(super) struct Streamed {
    stream: Arc<Mutex<Stream>>,
    /// The number of its queue.
    queue: usize,
    contents: Contents,
    wait: Wait,
    is_waiting: bool,
}

impl Streamed {
    pub(super) fn boxed(stream: &Arc<Mutex<Stream>>) -> Box<dyn Container> {
        let mut locked = lock(stream);
        locked.queues.push(Queue::default());
        let (queue, contents) = (locked.queues.len() - 1, locked.contents());
        Box::new(Self { stream: Arc::clone(stream), queue, contents, wait: Wait::default(), is_waiting: false })
    }
}

impl Container for Streamed {
    fn contents(&self) -> &Contents {
        &self.contents
    }

    fn contents_mut(&mut self) -> &mut Contents {
        &mut self.contents
    }

    fn select(&mut self, channels: &BTreeSet<ChannelId>) {
        let mut stream = lock(&self.stream);
        let before = stream.history.iter().flatten().filter(|message| channels.contains(&message.channel));
        let messages = before.cloned().collect();
        stream.queues[self.queue] = Queue { channels: channels.clone(), messages };
    }

    fn again(&self) -> Option<Box<dyn Container>> {
        Some(Self::boxed(&self.stream))
    }

    fn wait(&mut self, wait: Wait) {
        self.wait = wait;
    }

    fn is_waiting(&self) -> bool {
        self.is_waiting
    }

    fn failure(&self) -> Option<String> {
        lock(&self.stream).failure.clone()
    }

    fn next(&mut self) -> Option<Message> {
        let mut stream = lock(&self.stream);
        loop {
            self.is_waiting = false;
            if let Some(message) = stream.queues[self.queue].messages.pop_front() {
                stream.bytes = stream.bytes.saturating_sub(message.data.len() as u64);
                return Some(message);
            }
            if stream.has_ended {
                return None;
            }
            self.is_waiting = true;
            let until = match self.wait {
                Wait::Always => None,
                Wait::Learning => stream.first_scan_at.map(|at| at + LEARNING),
                Wait::Recorded(recorded_ns) if stream.is_live => {
                    let left_ns = recorded_ns.saturating_add(LIVE_WAIT_NS).saturating_sub(now_ns());
                    Some(Instant::now() + Duration::from_nanos(left_ns.min(LIVE_WAIT_NS)))
                }
                Wait::Recorded(recorded_ns) if stream.is_past(recorded_ns) => return None,
                Wait::Recorded(_) => None,
                Wait::Never => Some(Instant::now()),
            };
            let is_over = until.is_some_and(|until| until <= Instant::now());
            if is_over && stream.arrivals.is_empty() {
                return None;
            }
            stream.receive(until);
        }
    }

    fn is_by_log_time(&self) -> bool {
        false
    }

    fn take_losses(&mut self) -> Vec<Loss> {
        // The first reader is that of the scans.
        if self.queue == 0 { lock(&self.stream).all_losses() } else { Vec::new() }
    }
}

//! The queue of messages to viewers, so that no viewer holds up the flight.
//!
//! Rerun's sinks block for good when a viewer stops reading. Here a thread hands the messages over. When more than
//! 64 MiB wait, the flight waits once, for 2 s. After that, messages that find no room are left out and counted, until
//! the viewer reads again. The file is not concerned.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rerun::external::re_byte_size::SizeBytes as _;
use rerun::log::LogMsg;
use rerun::sink::{GrpcSink, GrpcSinkConnectionState, LogSink, SinkFlushError};

use crate::RecorderError;
use crate::serving::Server;

/// How many bytes may wait, and how long the flight waits for a viewer.
#[derive(Clone, Copy)]
struct QueueLimits {
    /// Bytes of messages that may wait.
    queue_bytes: u64,
    /// How long the flight waits for a slow viewer.
    patience: Duration,
    /// How long the end of the flight waits for a viewer that reads nothing, or is still starting.
    last_patience: Duration,
}

const LIMITS: QueueLimits =
    QueueLimits { queue_bytes: 64 << 20, patience: Duration::from_secs(2), last_patience: Duration::from_secs(15) };

/// While there are no messages, the viewer is looked at as often.
const WATCH_EVERY: Duration = Duration::from_millis(100);

/// Where messages are sent during the flight.
pub(crate) enum Outlet {
    /// To one viewer.
    Viewer(GrpcSink),
    /// To any number of viewers that come and go.
    Server(Server),
}

impl Outlet {
    fn sink(&self) -> &dyn LogSink {
        match self {
            Self::Viewer(sink) => sink,
            Self::Server(server) => &server.sink,
        }
    }

    fn connection(&self) -> Connection {
        match self {
            Self::Server(_) => Connection::Open,
            Self::Viewer(sink) => match sink.status() {
                GrpcSinkConnectionState::Connecting { .. } => Connection::Awaited,
                GrpcSinkConnectionState::Connected => Connection::Open,
                GrpcSinkConnectionState::Disconnected(_) => Connection::Closed,
            },
        }
    }
}

#[derive(Clone, Copy, Default, PartialEq, Eq)]
enum Connection {
    #[default]
    Awaited,
    Open,
    Closed,
}

/// The recorder's end of the queue; the outlet is closed when it is dropped.
pub(crate) struct Live {
    queue: LiveSink,
    /// The outlet is a server, which stays open after the flight.
    serves: bool,
}

/// Rerun's end of the queue.
#[derive(Clone)]
pub(crate) struct LiveSink(Arc<Shared>);

struct Shared {
    limits: QueueLimits,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// Each message with its size when it was added: the size that Rerun reports may change.
    waiting: VecDeque<(u64, LogMsg)>,
    waiting_bytes: u64,
    /// A message is being handed over.
    busy: bool,
    /// Messages handed over so far.
    taken: u64,
    /// The flight has waited in vain. It does not wait again until there is room.
    stalled: bool,
    left_out: u64,
    connection: Connection,
    closed: bool,
    ended: bool,
}

impl Live {
    /// Starts to hand over to `outlet`.
    ///
    /// # Errors
    /// When the thread cannot be started.
    pub(crate) fn start(outlet: Outlet) -> Result<Self, RecorderError> {
        Self::within(LIMITS, outlet)
    }

    fn within(limits: QueueLimits, outlet: Outlet) -> Result<Self, RecorderError> {
        let queue = LiveSink(Arc::new(Shared { limits, state: Mutex::default(), changed: Condvar::new() }));
        let serves = matches!(outlet, Outlet::Server(_));
        let theirs = Arc::clone(&queue.0);
        std::thread::Builder::new()
            .name("viewers".to_owned())
            .spawn(move || {
                theirs.hand_over(&outlet);
                drop(outlet); // closes the connection
                theirs.change(|state| state.ended = true);
            })
            .map_err(|e| RecorderError::Viewer(e.to_string()))?;
        Ok(Self { queue, serves })
    }

    /// The sink that Rerun sends to.
    pub(crate) fn sink(&self) -> LiveSink {
        self.queue.clone()
    }

    /// Whether the viewer is open, or may still answer.
    pub(crate) fn is_open(&self) -> bool {
        self.queue.0.lock().connection != Connection::Closed
    }

    /// Waits until the viewers have read what they will get. A server stays open.
    ///
    /// # Errors
    /// When the viewer was closed, never answered, or missed messages.
    pub(crate) fn end(&self) -> Result<(), RecorderError> {
        let shared = &self.queue.0;
        shared.wait_for_progress(State::is_idle);
        shared.change(State::leave_out_the_rest);
        if !self.serves {
            shared.change(|state| state.closed = true);
            shared.wait_for_progress(|state| state.ended);
        }
        let state = shared.lock();
        match (state.connection, state.left_out) {
            (Connection::Closed, _) => {
                Err(RecorderError::Viewer("it was closed before the flight was over".to_owned()))
            }
            (Connection::Awaited, 1..) => Err(RecorderError::Viewer("it does not answer".to_owned())),
            (_, 0) => Ok(()),
            (_, count) => Err(RecorderError::ViewerTooSlow(count)),
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.queue.0.change(|state| state.closed = true);
    }
}

impl LogSink for LiveSink {
    fn send(&self, message: LogMsg) {
        let (shared, bytes) = (&self.0, message.total_size_bytes());
        let has_room = |state: &State| {
            // A message larger than the whole queue passes when it is alone.
            state.waiting.is_empty() || state.waiting_bytes + bytes <= shared.limits.queue_bytes
        };
        let start = Instant::now();
        let mut state = shared.lock();
        while !has_room(&state) && !state.stalled && start.elapsed() < shared.limits.patience {
            state = shared.wait(state, shared.limits.patience.saturating_sub(start.elapsed()));
        }
        state.stalled = !has_room(&state);
        if state.stalled || state.connection == Connection::Closed {
            state.left_out += 1;
            return;
        }
        state.waiting_bytes += bytes;
        state.waiting.push_back((bytes, message));
        shared.changed.notify_all();
    }

    /// Never waits: whether viewers follow is asked once, at the end.
    fn flush_blocking(&self, _timeout: Duration) -> Result<(), SinkFlushError> {
        Ok(())
    }
}

impl State {
    fn is_idle(&self) -> bool {
        self.waiting.is_empty() && !self.busy
    }

    fn leave_out_the_rest(&mut self) {
        self.left_out += self.waiting.len() as u64 + u64::from(self.busy);
        self.waiting.clear();
        self.waiting_bytes = 0;
    }
}

impl Shared {
    /// The work of the thread: hands over one message after the other until the queue is closed.
    fn hand_over(&self, outlet: &Outlet) {
        while let Some(message) = self.next(outlet) {
            outlet.sink().send(message);
            while self.is_caught_up() && outlet.sink().flush_blocking(self.limits.last_patience).is_err() {
                if outlet.connection() != Connection::Awaited {
                    break;
                }
            }
            self.change(|state| {
                state.busy = false;
                state.taken += 1;
                state.connection = outlet.connection();
                if state.connection == Connection::Closed {
                    state.leave_out_the_rest();
                }
            });
        }
    }

    /// Whether nothing waits and the queue is open.
    fn is_caught_up(&self) -> bool {
        let state = self.lock();
        state.waiting.is_empty() && !state.closed
    }

    /// The next message; `None` once the queue is closed. Meanwhile it is noticed if the viewer is closed.
    fn next(&self, outlet: &Outlet) -> Option<LogMsg> {
        let mut state = self.lock();
        loop {
            if let Some((bytes, message)) = state.waiting.pop_front() {
                state.waiting_bytes -= bytes;
                state.busy = true;
                self.changed.notify_all();
                return Some(message);
            }
            if state.closed {
                return None;
            }
            state = self.wait(state, WATCH_EVERY);
            state.connection = outlet.connection();
        }
    }

    /// Blocks until `done(&state)`, or until no message has been taken for `last_patience`.
    fn wait_for_progress(&self, done: impl Fn(&State) -> bool) {
        let mut state = self.lock();
        let (mut taken, mut since) = (state.taken, Instant::now());
        while !done(&state) && since.elapsed() < self.limits.last_patience {
            state = self.wait(state, Duration::from_millis(100));
            if state.taken != taken {
                (taken, since) = (state.taken, Instant::now());
            }
        }
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.lock());
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, state: MutexGuard<'a, State>, timeout: Duration) -> MutexGuard<'a, State> {
        self.changed.wait_timeout(state, timeout).unwrap_or_else(PoisonError::into_inner).0
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;
    use std::net::TcpListener;

    use rerun::external::re_uri::ProxyUri;
    use rerun::{RecordingStream, RecordingStreamBuilder, Tensor, TensorBuffer, TensorData};

    use super::*;

    const HASTY: QueueLimits = QueueLimits {
        queue_bytes: 1 << 20,
        patience: Duration::from_millis(50),
        last_patience: Duration::from_millis(500),
    };

    /// A stream to the viewer at this listener.
    fn connected(listener: &TcpListener) -> (Live, RecordingStream) {
        let address = listener.local_addr().unwrap();
        let uri: ProxyUri = format!("rerun+http://{address}/proxy").parse().unwrap();
        let live = Live::within(HASTY, Outlet::Viewer(GrpcSink::new(uri))).unwrap();
        let rec =
            RecordingStreamBuilder::new("test").set_sinks(vec![Box::new(live.sink()) as Box<dyn LogSink>]).unwrap();
        (live, rec)
    }

    /// Logs `count` messages of a megabyte each.
    fn log_megabytes(rec: &RecordingStream, count: i64) {
        for i in 0..count {
            rec.set_time_sequence("i", i);
            let noise: Vec<u8> =
                (0..1_u64 << 20).map(|j| (j.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as u8).collect();
            rec.log("x", &Tensor::new(TensorData::new(vec![1 << 20], TensorBuffer::U8(noise.into())))).unwrap();
            rec.flush_blocking().unwrap();
        }
    }

    #[test]
    fn messages_that_a_deaf_viewer_misses_are_counted() {
        let deaf = TcpListener::bind("127.0.0.1:0").unwrap();
        let (live, rec) = connected(&deaf);
        log_megabytes(&rec, 20);
        let left_out = match live.end() {
            Err(RecorderError::ViewerTooSlow(count)) => count,
            other => panic!("{other:?}"),
        };
        assert!((10..=20).contains(&left_out), "{left_out} left out");
    }

    #[test]
    fn a_viewer_that_is_closed_ends_as_an_error() {
        let short = TcpListener::bind("127.0.0.1:0").unwrap();
        let (live, rec) = connected(&short);
        log_megabytes(&rec, 1);
        // Some of the message must have come: a connection that closes earlier is opened again, and nobody reads it.
        short.accept().unwrap().0.read_exact(&mut [0; 4096]).unwrap();
        drop(short);
        let start = Instant::now();
        while live.queue.0.lock().connection != Connection::Closed && start.elapsed() < Duration::from_secs(30) {
            log_megabytes(&rec, 1);
        }
        assert!(matches!(live.end(), Err(RecorderError::Viewer(text)) if text.contains("closed")));
    }

    #[test]
    fn a_viewer_that_never_answers_ends_as_an_error() {
        // A port that is free now may be another test's a moment later; nothing listens at port 1.
        let uri: ProxyUri = "rerun+http://127.0.0.1:1/proxy".parse().unwrap();
        let live = Live::within(HASTY, Outlet::Viewer(GrpcSink::new(uri))).unwrap();
        let rec =
            RecordingStreamBuilder::new("test").set_sinks(vec![Box::new(live.sink()) as Box<dyn LogSink>]).unwrap();
        log_megabytes(&rec, 5);
        assert!(matches!(live.end(), Err(RecorderError::Viewer(text)) if text.contains("does not answer")));
    }
}

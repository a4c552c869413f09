//! A disk that is slower than a live flight: what is left out, and how much.
//!
//! A recorded flight waits for the disk. A live one goes on, so what the disk has not taken yet waits in memory: beyond
//! [`THIN_BYTES`] the matrices of a revolution are left out, beyond [`MOST_BYTES`] the revolution altogether, until the
//! disk has caught up. Both are counted, and said in the recording and at the end.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crosscut_stage::Frame;
use rerun::log::LogMsg;
use rerun::sink::{LogSink, SinkFlushError};

use crate::scope::Share;

/// What waits is flushed at the latest when it has grown by so much, so that it is known how far the disk got.
const FLUSH_BYTES: u64 = 4 << 20;
/// No more matrices while this much waits.
const THIN_BYTES: u64 = 16 << 20;
/// Nothing more while this much waits. Rerun itself takes 50 MB before its calls block.
const MOST_BYTES: u64 = 40 << 20;

/// What there is room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Room {
    /// The whole revolution.
    All,
    /// The revolution without its matrices.
    NoMatrices,
    /// None of it.
    Nothing,
}

/// Revolutions that the disk had no time for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Lost {
    /// Recorded without matrices.
    pub(crate) thinned: u64,
    /// Not recorded.
    pub(crate) left_out: u64,
}

/// What waits for the disk during a live flight, by estimate.
#[derive(Debug, Default)]
pub(crate) struct Backlog {
    flushed: Flushed,
    /// Bytes of each flush that is not done, the oldest first.
    flushes: VecDeque<u64>,
    asked: u64,
    unflushed: u64,
    lost: Lost,
    /// The same since the disk had last caught up.
    lost_in_row: Lost,
}

/// A sink that takes nothing and counts flushes: the last of several, it counts those that the others have done.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flushed(Arc<AtomicU64>);

impl LogSink for Flushed {
    fn send(&self, _: LogMsg) {}

    fn flush_blocking(&self, _: Duration) -> Result<(), SinkFlushError> {
        self.0.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }
}

impl Backlog {
    /// To stand behind the file among Rerun's sinks.
    pub(crate) fn sink(&self) -> Flushed {
        self.flushed.clone()
    }

    /// What there is room for of this revolution's share; and what is to be said of it: where losses begin, and where
    /// they have ended.
    pub(crate) fn room_for(&mut self, frame: &Frame, share: Share) -> (Room, Option<String>) {
        self.forget_what_is_done();
        let (light, all) = estimated_bytes(frame, share);
        let waiting = self.flushes.iter().sum::<u64>() + self.unflushed;
        // One that is larger than what may wait passes when it is alone.
        let room = match waiting {
            0 => Room::All,
            _ if waiting + all <= THIN_BYTES => Room::All,
            _ if waiting + light > MOST_BYTES => Room::Nothing,
            _ if share.matrices || share.exact => Room::NoMatrices,
            _ => Room::All,
        };
        self.unflushed += match room {
            Room::All => all,
            Room::NoMatrices => light,
            Room::Nothing => 0,
        };
        (room, self.count(room))
    }

    fn forget_what_is_done(&mut self) {
        let flushes_done = self.flushed.0.load(Ordering::Relaxed);
        while self.asked - (self.flushes.len() as u64) < flushes_done && self.flushes.pop_front().is_some() {}
    }

    /// Whether the disk has taken all that it was asked to.
    pub(crate) fn is_clear(&self) -> bool {
        self.flushed.0.load(Ordering::Relaxed) >= self.asked
    }

    fn count(&mut self, room: Room) -> Option<String> {
        let before = self.lost_in_row;
        for lost in [&mut self.lost, &mut self.lost_in_row] {
            lost.thinned += u64::from(room == Room::NoMatrices);
            lost.left_out += u64::from(room == Room::Nothing);
        }
        if room == Room::All {
            self.lost_in_row = Lost::default();
        }
        match (before == Lost::default(), room == Room::All) {
            (true, false) => Some("the disk is slower than the flight: no matrices until it has caught up".to_owned()),
            (false, true) => Some(format!(
                "the disk has caught up: {} revolutions without matrices, {} not recorded",
                before.thinned, before.left_out
            )),
            _ => None,
        }
    }

    /// Whether so much was recorded since the last flush that another is due.
    pub(crate) fn wants_flush(&self) -> bool {
        self.unflushed >= FLUSH_BYTES
    }

    /// A flush of everything recorded so far was asked for.
    pub(crate) fn flush_asked(&mut self) {
        self.asked += 1;
        self.flushes.push_back(std::mem::take(&mut self.unflushed));
    }

    /// What was lost over the whole flight, if anything was.
    pub(crate) fn lost(&self) -> Option<Lost> {
        (self.lost != Lost::default()).then_some(self.lost)
    }
}

/// Bytes in memory of a revolution without its matrices, and of all its share. Points, ranges, labels and drawings come
/// to about 100 bytes a return; pictures and links to half a byte for each of n²; U and its drawing to 8 a number;
/// exact W to f64.
fn estimated_bytes(frame: &Frame, share: Share) -> (u64, u64) {
    let (n, k) = (frame.revolution.len() as u64, frame.spectrum.u.ncols() as u64);
    let light = (16 << 10) + 100 * n;
    let matrices = if share.matrices { n * n / 2 + 8 * n * k.min(64) } else { 0 };
    let exact = if share.exact { frame.affinity.weights.memory_bytes() } else { 0 };
    (light, light + matrices + exact)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::Point;

    const ALL: Share = Share { matrices: true, exact: true, exact_refused: false, new_part: false };

    /// 0.1 MB without matrices, 9 MB with them.
    fn frame() -> Frame {
        let mut frame = Frame::default();
        frame.revolution.points_m = vec![Point::origin(); 1000];
        frame.affinity.weights.make_dense(1000);
        frame
    }

    /// Rooms for `count` revolutions; a flush is asked for whenever it is due, and none is done.
    fn rooms(backlog: &mut Backlog, count: usize) -> Vec<Room> {
        let frame = frame();
        let room = |_| {
            let (room, _) = backlog.room_for(&frame, ALL);
            if backlog.wants_flush() {
                backlog.flush_asked();
            }
            room
        };
        (0..count).map(room).collect()
    }

    #[test]
    fn a_disk_that_takes_nothing_costs_first_the_matrices_and_then_the_revolutions_and_all_are_counted() {
        let mut backlog = Backlog::default();
        let rooms = rooms(&mut backlog, 2000);
        let count = |room| rooms.iter().filter(|&&r| r == room).count() as u64;
        assert_eq!(rooms[0], Room::All);
        assert!(rooms.is_sorted_by_key(|&room| room as u8), "never better while nothing is taken");
        assert!(count(Room::NoMatrices) > 100 && count(Room::Nothing) > 1000);
        let lost = Lost { thinned: count(Room::NoMatrices), left_out: count(Room::Nothing) };
        assert_eq!(backlog.lost(), Some(lost));
    }

    #[test]
    fn a_disk_that_keeps_up_costs_nothing() {
        let (mut backlog, frame) = (Backlog::default(), frame());
        for _ in 0..500 {
            assert_eq!(backlog.room_for(&frame, ALL), (Room::All, None));
            backlog.flush_asked();
            backlog.sink().flush_blocking(Duration::MAX).unwrap();
        }
        assert_eq!(backlog.lost(), None);
    }

    #[test]
    fn losses_are_said_where_they_begin_and_counted_where_the_disk_has_caught_up() {
        let (mut backlog, frame) = (Backlog::default(), frame());
        let said: Vec<Option<String>> = (0..5).map(|_| backlog.room_for(&frame, ALL).1).collect();
        assert_eq!(said.iter().flatten().count(), 1, "{said:?}");
        backlog.flush_asked();
        backlog.sink().flush_blocking(Duration::MAX).unwrap();
        let (room, said) = backlog.room_for(&frame, ALL);
        assert_eq!(room, Room::All);
        assert!(said.is_some_and(|said| said.contains("4 revolutions without matrices, 0 not recorded")));
        assert_eq!(backlog.room_for(&Frame::default(), ALL).1, None);
    }

    #[test]
    fn a_revolution_larger_than_what_may_wait_is_recorded_when_nothing_waits() {
        let mut large = frame();
        large.affinity.weights.make_dense(3000);
        let mut backlog = Backlog::default();
        assert_eq!(backlog.room_for(&large, ALL).0, Room::All);
        assert_eq!(backlog.room_for(&large, ALL).0, Room::Nothing);
    }
}

//! A disk that is slower than a live flight: what is left out, and how much.
//!
//! A recorded flight waits for the disk. A live one does not, so rows that are not written yet wait in memory. Beyond
//! [`THIN_BYTES`] the matrices of a revolution are left out, beyond [`MOST_BYTES`] the whole revolution, until the disk
//! has caught up. Both are counted, and reported in the recording and at the end.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crosscut_stage::Frame;
use rerun::log::LogMsg;
use rerun::sink::{LogSink, SinkFlushError};

use crate::scope::Share;

/// A flush is due after this many bytes at the latest: only flushes show how far the disk got.
const FLUSH_BYTES: u64 = 4 << 20;
/// While more than this waits, matrices are left out.
const THIN_BYTES: u64 = 16 << 20;
/// While more than this waits, revolutions are left out. Rerun's own calls block at 50 MB.
const MOST_BYTES: u64 = 40 << 20;

/// How much of a revolution there is room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Room {
    /// The whole revolution.
    All,
    /// The revolution without its matrices.
    NoMatrices,
    /// None of it.
    Nothing,
}

/// Numbers of revolutions that the disk was too slow for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Lost {
    /// Recorded without matrices.
    pub(crate) thinned: u64,
    /// Not recorded.
    pub(crate) left_out: u64,
}

/// Estimate of the bytes that wait for the disk during a live flight.
#[derive(Debug, Default)]
pub(crate) struct Backlog {
    flushed: Flushed,
    /// Bytes of each flush that is not done, the oldest first.
    flushes: VecDeque<u64>,
    /// Number of flushes so far, done or not.
    asked: u64,
    /// Bytes since the last flush was asked for.
    unflushed: u64,
    lost: Lost,
    /// Losses since the disk had last caught up.
    lost_in_row: Lost,
}

/// A sink that takes nothing and counts flushes. As the last of several sinks it counts those that the others have done.
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
    /// The sink that counts flushes. It has to come after the file among Rerun's sinks.
    pub(crate) fn sink(&self) -> Flushed {
        self.flushed.clone()
    }

    /// How much of this revolution's share there is room for, and a message where losses begin or have ended.
    pub(crate) fn room_for(&mut self, frame: &Frame, share: Share) -> (Room, Option<String>) {
        self.forget_what_is_done();
        let (light, all) = estimated_bytes(frame, share);
        let waiting = self.flushes.iter().sum::<u64>() + self.unflushed;
        // A revolution that is larger than the limits is recorded when nothing else waits.
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

    /// Whether all flushes are done.
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

    /// Whether another flush is due.
    pub(crate) fn wants_flush(&self) -> bool {
        self.unflushed >= FLUSH_BYTES
    }

    /// Notes that a flush of all rows so far was asked for.
    pub(crate) fn flush_asked(&mut self) {
        self.asked += 1;
        self.flushes.push_back(std::mem::take(&mut self.unflushed));
    }

    /// Losses over the whole flight; `None` if there were none.
    pub(crate) fn lost(&self) -> Option<Lost> {
        (self.lost != Lost::default()).then_some(self.lost)
    }
}

/// Estimated bytes in memory of a revolution without its matrices, and with its whole share. Points, ranges, labels and
/// drawings take about 100 bytes a return, centroids 8 bytes a number; pictures and edges half a byte for each of n²; U and its
/// drawing 8 bytes a number; the exact W up to 12 bytes an entry, the exact U 8 bytes a number.
fn estimated_bytes(frame: &Frame, share: Share) -> (u64, u64) {
    let (n, k) = (frame.revolution.len() as u64, frame.spectrum.u.ncols() as u64);
    let cloud = 14 * frame.revolution.cloud_m.len() as u64;
    let light = (16 << 10) + 100 * n + cloud + 8 * frame.partition.centroids.nrows() as u64 * k;
    let matrices = if share.matrices { n * n / 2 + 8 * n * k } else { 0 };
    let exact = if share.exact { 12 * frame.affinity.weights.stored() as u64 + 8 * n * k } else { 0 };
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

    /// The room for each of `count` revolutions, while no flush is ever done.
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
    fn a_stopped_disk_costs_matrices_then_revolutions_and_both_are_counted() {
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
    fn losses_are_reported_where_they_begin_and_where_they_end() {
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
    fn a_revolution_beyond_the_limits_is_recorded_when_nothing_waits() {
        let mut large = frame();
        large.affinity.weights.make_dense(3000);
        let mut backlog = Backlog::default();
        assert_eq!(backlog.room_for(&large, ALL).0, Room::All);
        assert_eq!(backlog.room_for(&large, ALL).0, Room::Nothing);
    }
}

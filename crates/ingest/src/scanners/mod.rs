//! Several scanners of one vehicle as one revolution.
//!
//! The scans of the first topic lead. Each is joined with that scan of every other topic whose stamp is nearest, in the
//! nearest frame in which all scanners lie by the transforms of the recording.

mod around;
mod frames;
mod mount;
mod same_frame;

use crosscut_stage::NoteCode::{N050, N051, N052, N053, N054, N055, N056};
use crosscut_stage::{Notes, Revolution, Source, counted};

use self::around::Around;
use self::frames::Frames;
pub(crate) use self::mount::Mount;
use self::same_frame::Agreement;
use crate::Loss;
use crate::container::{Container, Wait};

/// Scans of two scanners whose stamps are further apart than this are of different revolutions.
const FARTHEST_NS: u64 = 100_000_000;

/// The scan of another scanner that belongs to one of the first is recorded at most this long after it.
const AHEAD_NS: u64 = 1_000_000_000;

/// The scans of one topic, as another scanner is read.
pub(crate) trait Scans: Source {
    fn topic(&self) -> &str;
    fn losses(&self) -> &[Loss];
    /// From now on, revolutions of a stream are waited for up to this time of recording.
    fn wait(&mut self, wait: Wait);
    /// Whether there was no revolution in time, rather than no more.
    fn is_waiting(&self) -> bool;
}

/// The scanners beside the first one.
pub(crate) struct Scanners<S> {
    others: Vec<Scanner<S>>,
    frames: Frames,
    around: Around,
    joined: Revolution,
}

/// One scanner, and its scans around the time of the last revolution.
struct Scanner<S> {
    scans: S,
    before: Option<Revolution>,
    after: Option<Revolution>,
    /// A place for the next one.
    spare: Option<Revolution>,
    has_ended: bool,
    /// With the first scanner, where both state one frame.
    agreement: Agreement,
}

impl<S: Scans> Scanners<S> {
    /// Of the scans of the other topics; the transforms are in the files of `containers`.
    pub(crate) fn new(others: Vec<S>, containers: Vec<Box<dyn Container>>, is_stream: bool) -> Self {
        let scanner = |scans| Scanner {
            scans,
            before: None,
            after: None,
            spare: None,
            has_ended: false,
            agreement: Agreement::default(),
        };
        let (others, frames) = (others.into_iter().map(scanner).collect(), Frames::read(containers, is_stream));
        Self { others, frames, around: Around::default(), joined: Revolution::default() }
    }

    /// What was lost of the other topics.
    pub(crate) fn losses(&self) -> impl Iterator<Item = &Loss> {
        self.others.iter().flat_map(|scanner| scanner.scans.losses())
    }

    /// Joins the other scanners to `first`, a scan of the first one that was recorded at `recorded_ns`. Notes say what was joined,
    /// and what cannot be.
    pub(crate) fn join(&mut self, first: &mut Revolution, recorded_ns: u64, notes: &mut Notes) {
        let stamp_ns = first.stamp_ns;
        let Self { others, frames, around, joined } = self;
        for scanner in &mut *others {
            scanner.scans.wait(Wait::Recorded(recorded_ns.saturating_add(AHEAD_NS)));
            scanner.read_to(stamp_ns);
            if let Some(seen) = scanner.nearest(stamp_ns).filter(|seen| seen.frame_id == first.frame_id).cloned() {
                scanner.agreement.compare(first, &seen);
            }
        }
        frames.read_on();
        let mut near = Vec::new();
        for scanner in others.iter() {
            let topic = scanner.scans.topic();
            match scanner.nearest(stamp_ns) {
                None => notes.add(N050, format!("{topic} is not joined: it has no scan within 0.1 s")),
                Some(seen) if frames.common(&[&first.frame_id, &seen.frame_id]).is_none() => notes.add(N051, format!(
                    "{topic} is not joined: no transforms lead from `{}` to `{}`",
                    seen.frame_id, first.frame_id
                )),
                Some(seen) if scanner.agreement.is_refuted() && seen.frame_id == first.frame_id => notes.add(N056, format!(
                    "{topic} is not joined: both scanners state the frame `{}`, and in it they see different things; one of \
                     them needs a frame of its own",
                    first.frame_id
                )),
                Some(seen) => near.push((topic, seen)),
            }
        }
        let seen = || std::iter::once(&*first).chain(near.iter().map(|(_, seen)| *seen));
        let names: Vec<&str> = seen().map(|seen| seen.frame_id.as_str()).collect();
        let Some(frame) = frames.common(&names).filter(|_| !near.is_empty()) else { return };
        let Some(pose) = frames.pose(&first.frame_id, &frame, stamp_ns) else {
            notes
                .add(N052, format!("no scanner is joined: the pose of `{}` is not known at this time", first.frame_id));
            return;
        };
        let mut placed = vec![(pose, &*first)];
        for (topic, seen) in near {
            match frames.pose(&seen.frame_id, &frame, seen.stamp_ns) {
                Some(pose) => {
                    placed.push((pose, seen));
                    notes.add(N053, format!("joined with {topic} in frame `{frame}`"));
                }
                None => notes.add(N054, format!("{topic} is not joined: its pose is not known at this time")),
            }
        }
        let filled = around.look(&placed, joined);
        if filled > 0 {
            let beams = counted(filled as u64, "beam");
            notes.add(N055, format!("{beams} between those of the scanners: as far as the farther neighbour sees"));
        }
        std::mem::swap(&mut first.points_m, &mut joined.points_m);
        std::mem::swap(&mut first.sweep, &mut joined.sweep);
        first.entries.clear();
        first.frame_id = frame;
    }
}

impl<S: Scans> Scanner<S> {
    /// Reads on until a scan is later than `stamp_ns`.
    fn read_to(&mut self, stamp_ns: u64) {
        while !self.has_ended && self.after.as_ref().is_none_or(|after| after.stamp_ns <= stamp_ns) {
            let mut next = self.spare.take().unwrap_or_default();
            // A topic that cannot be read on has ended; its losses say why.
            let is_read = matches!(self.scans.next(&mut next, &mut Notes::default()), Ok(true));
            if !is_read && self.scans.is_waiting() {
                self.spare = Some(next);
                return;
            }
            self.has_ended = !is_read;
            self.spare = std::mem::replace(&mut self.before, self.after.take());
            self.after = Some(next).filter(|_| is_read);
        }
    }

    fn nearest(&self, stamp_ns: u64) -> Option<&Revolution> {
        let apart_ns = |seen: &&Revolution| seen.stamp_ns.abs_diff(stamp_ns);
        let seen = self.before.iter().chain(&self.after);
        seen.min_by_key(apart_ns).filter(|seen| apart_ns(seen) <= FARTHEST_NS)
    }
}

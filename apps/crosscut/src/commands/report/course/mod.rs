//! A flight over time: count, margin and confidence, and the revolutions whose count differs from their neighbours.

mod picture;
mod reason;

use crosscut_evaluate::{AROUND, Flip, flips};
use crosscut_stage::Frame;

use reason::WallArc;

/// The values that are kept of every revolution of a flight.
#[derive(Default)]
pub(super) struct Course {
    moments: Vec<Moment>,
}

/// The values of one revolution.
struct Moment {
    seq: u64,
    stamp_ns: u64,
    junctions: usize,
    margin: Option<f64>,
    confidence: Option<f64>,
    walls: Vec<WallArc>,
    limited_view: bool,
}

impl Course {
    /// Adds the next revolution of the flight.
    pub(super) fn take(&mut self, frame: &Frame) {
        self.moments.push(Moment {
            seq: frame.revolution.seq,
            stamp_ns: frame.revolution.stamp_ns,
            junctions: frame.junction.junctions,
            margin: frame.spectrum.margin_decades,
            confidence: frame.junction.confidence,
            walls: reason::arcs(&frame.junction),
            limited_view: frame.revolution.beams().is_some_and(|sweep| !sweep.view().full_turn),
        });
    }

    /// "Recorded on 2026-11-28 at 17:24 UTC. "; empty where stamps do not count from 1970.
    pub(super) fn began(&self) -> String {
        const YEAR_2000_S: i64 = 946_684_800;
        let first = self
            .moments
            .first()
            .and_then(|first| jiff::Timestamp::from_second((first.stamp_ns / 1_000_000_000) as i64).ok());
        let first = first.filter(|first| first.as_second() >= YEAR_2000_S);
        first.map_or_else(String::new, |first| first.strftime("Recorded on %Y-%m-%d at %H:%M UTC. ").to_string())
    }

    /// From the first revolution to the last, s.
    pub(super) fn duration_s(&self) -> f64 {
        let stamps = self.moments.first().zip(self.moments.last());
        stamps.map_or(0.0, |(first, last)| (last.stamp_ns as f64 - first.stamp_ns as f64) / 1e9)
    }

    /// The picture, and how many revolutions have another count than most of their neighbours.
    pub(super) fn picture(&self) -> (String, usize) {
        let flips = self.flips();
        (picture::svg(self, &flips), flips.len())
    }

    fn flips(&self) -> Vec<Flip> {
        flips(&self.moments.iter().map(|moment| moment.junctions).collect::<Vec<_>>())
    }

    /// How the walls of a flip differ from those of the nearest revolution with the count around it.
    fn reason(&self, flip: &Flip) -> String {
        let near = (1..=AROUND).flat_map(|apart| [flip.at.checked_sub(apart), Some(flip.at + apart)]);
        let moments = near.flatten().filter_map(|at| self.moments.get(at));
        let typical = moments.into_iter().find(|moment| moment.junctions == flip.around);
        let own = &self.moments[flip.at];
        typical.map_or_else(String::new, |other| reason::of_flip(&own.walls, &other.walls, own.limited_view))
    }
}

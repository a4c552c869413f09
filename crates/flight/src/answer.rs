//! What the flight so far adds to the answer for one revolution.

use crosscut_stage::{Frame, PoseDoubt, counted, degrees_words};
use nalgebra::Isometry2;
use serde::{Deserialize, Serialize};

/// What the flight so far adds to the answer for one revolution. [`Flight`](crate::Flight) leaves it in the frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlightAnswer {
    /// Where the revolution was taken, metres and radians in the frame of the flight's first pose; `None` where that is not
    /// known.
    pub pose: Option<Isometry2<f64>>,
    /// How far it may be off.
    pub doubt: Option<PoseDoubt>,
    /// The place that the vehicle is in; `None` for a cloud, where no wall is in view, and for a limited view that has not
    /// seen enough around it.
    pub here: Option<Here>,
    /// The answer over the last revolutions.
    pub steady: Option<Steady>,
}

static NONE: FlightAnswer = FlightAnswer { pose: None, doubt: None, here: None, steady: None };

impl FlightAnswer {
    /// That of a frame; an empty one if no flight saw the frame.
    pub fn of(frame: &Frame) -> &Self {
        frame.extra.get().unwrap_or(&NONE)
    }

    /// The place by the steady answer.
    pub fn steady_here(&self) -> Option<&Here> {
        self.steady.as_ref()?.here.as_ref()
    }

    /// Leaves it in a frame.
    pub fn put(self, frame: &mut Frame) {
        frame.extra.set(self);
    }
}

/// The kind of place that the vehicle is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum HereKind {
    /// Three or more ways.
    Junction,
    /// Two ways.
    Passage,
    /// One way.
    DeadEnd,
    /// No way, or much wider than its one or two ways.
    Chamber,
}

impl HereKind {
    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Junction => "junction",
            Self::Passage => "passage",
            Self::DeadEnd => "dead_end",
            Self::Chamber => "chamber",
        }
    }
}

/// The place that the vehicle is in.
#[derive(Clone, Debug, PartialEq)]
pub struct Here {
    /// Its kind, by the number of its ways.
    pub kind: HereKind,
    /// What was looked at: everything within this distance of the sensor, metres.
    pub look_m: f64,
    /// Where the place continues, by bearing ascending.
    pub ways: Vec<Way>,
    /// A look of 0.9 local widths sees as many ways: the vehicle is in the middle of the place, or the place is wider than the
    /// look. Never in a limited view.
    pub is_middle: bool,
    /// The confidence of the revolution, less where a shorter or a longer look sees another place. 0 to 1.
    pub confidence: f64,
}

impl Here {
    /// What a map takes the place to be: a chamber with one way is a dead end; passages, also those through chambers, are
    /// no node.
    pub fn node(&self) -> Option<HereKind> {
        match (self.kind, self.ways.len()) {
            (HereKind::Junction, _) => Some(HereKind::Junction),
            (HereKind::DeadEnd, _) | (HereKind::Chamber, 1) => Some(HereKind::DeadEnd),
            (HereKind::Passage | HereKind::Chamber, _) => None,
        }
    }
}

/// Where a place continues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// Direction of the middle of its mouth.
    pub bearing_rad: f64,
    /// Width of its mouth, metres.
    pub width_m: f64,
    /// Index of the opening that it leads to; `None` if no opening lies behind the mouth: the passage is seen to end.
    pub opening: Option<usize>,
}

/// The answer over the last revolutions.
#[derive(Clone, Debug, PartialEq)]
pub struct Steady {
    /// The number of walls, as [`Junction::junctions`](crosscut_stage::Junction::junctions), with what earlier revolutions saw beyond gaps.
    pub junctions: usize,
    /// The place; its ways lead to the openings below.
    pub here: Option<Here>,
    /// The openings, by bearing ascending.
    pub openings: Vec<SteadyOpening>,
    /// Bearings of the openings of the scan that what was seen before closes.
    pub closed_rad: Vec<f64>,
}

impl Steady {
    /// By what it stands, at this stamp: "3 walls. Openings: at +12°, seen through now; at +95°, seen through 3.9 s ago; at -80°, judged,
    /// p = 0.30. Closed, as seen before: at -20°."
    pub fn words(&self, now_ns: u64) -> String {
        let openings: Vec<String> = self.openings.iter().map(|opening| opening.words(now_ns)).collect();
        let listed = if openings.is_empty() { "none".to_owned() } else { openings.join("; ") };
        let closed: Vec<String> = self.closed_rad.iter().map(|bearing_rad| degrees_words(*bearing_rad)).collect();
        let closed = if closed.is_empty() {
            String::new()
        } else {
            format!(" Closed, as seen before: at {}.", closed.join(", "))
        };
        format!("{}. Openings: {listed}.{closed}", counted(self.junctions as u64, "wall"))
    }
}

impl SteadyOpening {
    fn words(&self, now_ns: u64) -> String {
        let ago_s = self.seen_ns.map(|seen_ns| now_ns.saturating_sub(seen_ns) as f64 * 1e-9);
        let known = match (ago_s, self.p) {
            (Some(ago_s), _) if ago_s < 0.05 => "seen through now".to_owned(),
            (Some(ago_s), _) => format!("seen through {ago_s:.1} s ago"),
            (None, Some(p)) => format!("judged, p = {p:.2}"),
            (None, None) => "judged".to_owned(),
        };
        format!("at {}, {known}", degrees_words(self.bearing_rad))
    }
}

/// An opening that is followed from revolution to revolution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SteadyOpening {
    /// Its number in the flight.
    pub track: u64,
    /// Direction towards the branch.
    pub bearing_rad: f64,
    /// Clear width across the branch, metres.
    pub width_m: f64,
    /// The odds that a vehicle can pass, as a probability, of the revolution that saw it last; `None` where too little was seen, and
    /// where that revolution sees a wall go on and an earlier one saw through.
    pub p: Option<f64>,
    /// The stamp of the last revolution that saw through; `None` where neither this one nor what was seen around tells: a hidden wall may
    /// close it.
    pub seen_ns: Option<u64>,
}

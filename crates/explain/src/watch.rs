//! The revolutions of a flight to look at first.

use std::fmt;

use crosscut_stage::{Frame, Place, counted};

/// A margin below this is low.
const LOW_DECADES: f64 = 0.5;
/// A low margin is reported again only after the margin was above this.
const RECOVERED_DECADES: f64 = 1.0;

/// The reason to look at a revolution.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// Count or place differ from those of the previous revolution.
    Changed {
        /// Junctions before and now.
        junctions: [usize; 2],
        /// Place before and now.
        place: [Place; 2],
    },
    /// A small change of τ would give another k.
    LowMargin {
        /// The margin, in decades.
        decades: f64,
        /// The k that was reported.
        k: usize,
    },
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Changed { junctions: [before, now], place: [from, to] } => {
                if before == now {
                    write!(f, "still {}", counted(*now as u64, "wall"))?;
                } else {
                    write!(f, "{before} → {}", counted(*now as u64, "wall"))?;
                }
                if from == to { write!(f, " ({to})") } else { write!(f, " ({from} → {to})") }
            }
            Self::LowMargin { decades, k } => write!(f, "low margin: k = {k} holds by {decades:.2} decades"),
        }
    }
}

/// Compares each revolution with the previous one.
#[derive(Debug, Default)]
pub struct Watch {
    before: Option<(usize, Place)>,
    low: bool,
}

impl Watch {
    /// The reasons to look at the next revolution of the flight.
    pub fn events(&mut self, frame: &Frame) -> Vec<Event> {
        let mut events = Vec::new();
        let (junctions, place) = (frame.junction.junctions, frame.junction.place);
        if let Some(before) = self.before.replace((junctions, place))
            && before != (junctions, place)
        {
            events.push(Event::Changed { junctions: [before.0, junctions], place: [before.1, place] });
        }
        if let Some(decades) = frame.spectrum.margin_decades {
            if decades < LOW_DECADES && !self.low {
                self.low = true;
                events.push(Event::LowMargin { decades, k: frame.spectrum.k });
            } else if decades > RECOVERED_DECADES {
                self.low = false;
            }
        }
        events
    }
}

//! The revolutions of a flight to look at first.

use std::fmt;

use crosscut_stage::{Frame, Place, Unsure, counted};

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
    /// The count is wrong from here on.
    Wrong {
        /// The reported number of walls.
        counted: usize,
        /// The true number.
        truth: usize,
    },
    /// The confidence is low.
    Unsure {
        /// The confidence, 0 to 1.
        confidence: f64,
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
                let [from, to] = [from, to].map(Place::words);
                if from == to { write!(f, " ({to})") } else { write!(f, " ({from} → {to})") }
            }
            Self::Wrong { counted, truth } => write!(f, "wrong: {counted} counted, {truth} in truth"),
            Self::Unsure { confidence } => write!(f, "unsure: confidence {:.0} %", 100.0 * confidence),
            Self::LowMargin { decades, k } => write!(f, "low margin: k = {k} holds by {decades:.2} decades"),
        }
    }
}

/// What is doubtful of an answer, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Doubt {
    /// The count is wrong by the truth, and the answer unsure.
    WrongAndUnsure,
    /// The count is wrong by the truth.
    Wrong,
    /// The confidence was low, and has not recovered since.
    Unsure,
    /// Neither.
    None,
}

impl Doubt {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::WrongAndUnsure, Self::Wrong, Self::Unsure, Self::None];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::WrongAndUnsure => "wrong, unsure",
            Self::Wrong => "wrong",
            Self::Unsure => "unsure",
            Self::None => "none",
        }
    }
}

/// Compares each revolution with the previous one.
#[derive(Debug, Default)]
pub struct Watch {
    before: Option<(usize, Place)>,
    low: bool,
    unsure: Unsure,
    wrong: Option<[usize; 2]>,
}

impl Watch {
    /// The reasons to look at the next revolution of the flight, of which `truth` is the true number of walls, if it is known.
    pub fn events(&mut self, frame: &Frame, truth: Option<usize>) -> Vec<Event> {
        let mut events = Vec::new();
        let (junctions, place) = (frame.junction.junctions, frame.junction.place);
        let wrong = truth.filter(|truth| *truth != junctions).map(|truth| [junctions, truth]);
        if wrong != self.wrong {
            events.extend(wrong.map(|[counted, truth]| Event::Wrong { counted, truth }));
            self.wrong = wrong;
        }
        if let Some(before) = self.before.replace((junctions, place))
            && before != (junctions, place)
        {
            events.push(Event::Changed { junctions: [before.0, junctions], place: [before.1, place] });
        }
        let was_unsure = self.unsure.is_unsure();
        if self.unsure.after(frame.junction.confidence) && !was_unsure {
            events.extend(frame.junction.confidence.map(|confidence| Event::Unsure { confidence }));
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

    /// What is doubtful of the last revolution that was watched.
    pub fn doubt(&self) -> Doubt {
        match (self.wrong, self.unsure.is_unsure()) {
            (Some(_), true) => Doubt::WrongAndUnsure,
            (Some(_), false) => Doubt::Wrong,
            (None, true) => Doubt::Unsure,
            (None, false) => Doubt::None,
        }
    }
}

//! What is reported: walls, openings, and the name of the place.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{Evidence, Known, KnownGaps, Point, Way};

/// Answers of at least this confidence are called sure.
pub const SURE: f64 = 0.9;

/// The answer for one revolution.
#[derive(Clone, Debug, Default)]
pub struct Junction {
    /// The paper's count: the number of walls, islands left out. A plain tunnel has 2, a dead end 1.
    pub junctions: usize,
    /// The walls, numbered by their smallest beam index.
    pub walls: Vec<Wall>,
    /// The openings, by bearing ascending.
    pub openings: Vec<Opening>,
    /// The ways on in three dimensions, by bearing ascending; `None` of affinities whose rows are returns.
    pub ways: Option<Vec<Way>>,
    /// How its gaps are known: the openings, and the gaps at which the affinity decided that a wall goes on.
    pub gaps: KnownGaps,
    /// Wall of each return, n entries; `None` for a return of no wall.
    pub wall_of_return: Vec<Option<u32>>,
    /// What kind of place this is.
    pub place: Place,
    /// Estimated probability that the answer is right, 0 to 1; `None` where nothing was calibrated for the affinity.
    pub confidence: Option<f64>,
}

impl Junction {
    /// From end to end of a wall, metres: from its return that is farthest from its first one to that farthest from
    /// there. `points_m` are the returns of the revolution. `None` for a wall without a return.
    pub fn ends_m(&self, wall: u32, points_m: &[Point]) -> Option<[Point; 2]> {
        let returns_m = || {
            let of_wall = |(_, id): &(&Point, &Option<u32>)| **id == Some(wall);
            points_m.iter().zip(&self.wall_of_return).filter(of_wall).map(|(point_m, _)| *point_m)
        };
        let farthest_m = |from_m: Point| returns_m().max_by(|a, b| (a - from_m).norm().total_cmp(&(b - from_m).norm()));
        let start_m = farthest_m(returns_m().next()?)?;
        Some([start_m, farthest_m(start_m)?])
    }
}

/// The returns between two consecutive openings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Its number.
    pub id: u32,
    /// Number of its returns.
    pub returns: usize,
    /// Anticlockwise from the first to the last return (from > to crosses ±π).
    pub bearing_rad: [f64; 2],
    /// A pillar: counted in k, not in `junctions`.
    pub island: bool,
}

/// A gap through which the vehicle can leave the place.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Direction towards the branch.
    pub bearing_rad: f64,
    /// Clear width across the branch, metres.
    pub width_m: f64,
    /// The walls on its clockwise and anticlockwise side; the same twice at a dead end, and where the end of the view
    /// cuts it.
    pub walls: [u32; 2],
    /// The returns of these walls beside it, as indices of [`Revolution::points_m`](crate::Revolution::points_m),
    /// clockwise end first; `None` at the end of a limited view that cuts it.
    pub returns: [Option<u32>; 2],
    /// Of a doorway through which a wall is seen: the gaps on both sides of that wall, each by its returns as above. Empty
    /// of an opening that is one gap.
    pub gaps: Vec<[u32; 2]>,
    /// Why it is believed.
    pub evidence: Evidence,
    /// How it is known: seen through, or judged.
    pub known: Known,
    /// The two ends of the edge of the visible free space that it is made of, metres, clockwise end first.
    pub edge_m: [Point; 2],
    /// The odds that a vehicle can pass, as a probability; `None` where too little is seen to say.
    pub p: Option<f64>,
}

impl Opening {
    /// The end of a limited view cuts it: only its one wall is in view, and bearing and width are those of the part in
    /// view.
    pub fn is_cut_by_view(&self) -> bool {
        self.returns.contains(&None)
    }

    /// Whether a gap between two returns, anticlockwise, is this opening or part of it: a stray return inside an opening
    /// splits its edge. The first part begins where the opening begins, the last ends where it ends.
    pub fn shares_end_with(&self, [from, to]: [u32; 2]) -> bool {
        let is_of_gap = |gap: &[u32; 2]| gap[0] == from || gap[1] == to;
        self.returns[0] == Some(from) || self.returns[1] == Some(to) || self.gaps.iter().any(is_of_gap)
    }

    /// How far the nearer end of its edge is from the sensor, metres. What is far is a glimpse, and decided by few
    /// returns.
    pub fn range_m(&self) -> f64 {
        let [from_m, to_m] = self.edge_m.map(|end_m| end_m.coords.norm());
        from_m.min(to_m)
    }
}

/// What kind of place the sensor is in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Place {
    /// No opening.
    Closed,
    /// One opening.
    DeadEnd,
    /// Two openings, opposite each other.
    Corridor,
    /// Two openings, at an angle.
    Bend,
    /// Three openings.
    Tee,
    /// Four openings.
    Cross,
    /// This many openings, five or more.
    Junction(usize),
    /// The sensor does not see all around, or sees no wall, so the place cannot be named.
    #[default]
    PartialView,
}

impl Place {
    /// What people call it: "dead end", "crossing", "5-way junction". Results have [`Display`](fmt::Display).
    pub fn words(&self) -> String {
        match self {
            Self::Tee => junction_of(3),
            Self::Cross => junction_of(4),
            Self::Junction(ways) => junction_of(*ways),
            other => other.to_string().replace('_', " "),
        }
    }
}

/// What people call a junction of this many ways: "tee", "crossing", "5-way junction".
pub fn junction_of(ways: usize) -> String {
    match ways {
        3 => "tee".to_owned(),
        4 => "crossing".to_owned(),
        _ => format!("{ways}-way junction"),
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Closed => f.write_str("closed"),
            Self::DeadEnd => f.write_str("dead_end"),
            Self::Corridor => f.write_str("corridor"),
            Self::Bend => f.write_str("bend"),
            Self::Tee => f.write_str("tee"),
            Self::Cross => f.write_str("cross"),
            Self::Junction(ways) => write!(f, "junction_{ways}"),
            Self::PartialView => f.write_str("partial_view"),
        }
    }
}

//! The map of a flight: junctions and dead ends, and the passages between them.

mod anchored;
mod candidate;
mod derived;
mod drawing;
mod legs;
mod log;
mod mapper;
mod no_place;
mod outline;
mod passed;
mod recognise;
mod reconsider;
mod stay;
mod stretch;
mod travelled;
mod visit;

use std::collections::BTreeSet;

use crosscut_stage::{DisjointSets, counted, junction_of};
use nalgebra::Point2;
use serde::Serialize;

use crate::HereKind;

pub use anchored::Anchored;
pub use drawing::MapDrawing;
pub use mapper::{Located, Mapper};
pub use no_place::NoPlace;
pub use outline::Fit;
pub(crate) use outline::Walls;

/// Junctions and dead ends of a flight, and the passages that were flown between them. Positions and bearings are in the
/// frame of the flight's first pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Map {
    /// Junctions and dead ends, by number.
    pub nodes: Vec<Node>,
    /// Passages, by number.
    pub passages: Vec<Passage>,
    /// Visits that were taken to be to a node seen before, in order.
    pub merges: Vec<Decided>,
    /// Visits that look like a node seen before and were not taken to be to it, in order.
    pub refusals: Vec<Decided>,
    /// The stamp at which each stretch of the flight begins: how one lies to the one before was not seen.
    pub stretches_from_ns: Vec<u64>,
}

/// A junction or a dead end.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// [`HereKind::Junction`] or [`HereKind::DeadEnd`].
    pub kind: HereKind,
    /// Where it is, metres.
    pub position_m: Point2<f64>,
    /// Its ways in cyclic order, anticlockwise.
    pub ways: Vec<NodeWay>,
    /// First and last stamp of each visit.
    pub visits: Vec<[u64; 2]>,
}

/// A way of a node.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NodeWay {
    /// Its direction.
    pub bearing_rad: f64,
    /// Width of its mouth, metres.
    pub width_m: f64,
    /// The vehicle came or left by it.
    pub taken: bool,
    /// Number of the passage that the way leads to, if that passage was flown from end to end.
    #[serde(rename = "edge")]
    pub passage: Option<usize>,
}

/// A passage between two nodes that was flown from end to end.
#[derive(Clone, Debug, PartialEq)]
pub struct Passage {
    /// The node where it was entered first.
    pub from: usize,
    /// The node where it was left first.
    pub to: usize,
    /// Length of the way flown between the two positions, metres.
    pub length_m: f64,
    /// Standard deviation of where it leads as seen from its beginning, metres; `None` if nothing shows its length.
    pub length_sd_m: Option<f64>,
    /// Mean width of its mouths, as seen on the way, metres.
    pub width_m: f64,
    /// Stamps at its first flight: when the one node was left, and the other one reached.
    pub stretch_ns: [u64; 2],
    /// Places along its first flight, a few metres apart.
    pub via_m: Vec<Point2<f64>>,
}

/// A decision whether a visit was to a node seen before.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Decided {
    /// The likeliest node. The visit is one to this node if the decision stands among [`Map::merges`], and was to a new node if
    /// it stands among [`Map::refusals`].
    pub node: usize,
    /// Stamp at the end of the visit.
    pub at_ns: u64,
    /// Share of the walls seen that lie on those of the node, 0 to 1.
    pub score: f64,
    /// Share of the walls seen that lie on those of the second likeliest place, if there is any.
    pub runner_up: Option<f64>,
    /// Why, in words.
    pub why: String,
}

/// How many loops passages between these pairs of nodes close: passages less nodes, plus parts that are not connected.
pub fn loops_in(passages: impl IntoIterator<Item = [usize; 2]>) -> usize {
    let passages: Vec<[usize; 2]> = passages.into_iter().collect();
    let mut sets = DisjointSets::default();
    sets.reset(passages.iter().flatten().max().map_or(0, |last| last + 1));
    let mut closes = |[from, to]: &[usize; 2]| {
        let is_closed = sets.root(*from) == sets.root(*to);
        sets.join(*from, *to);
        is_closed
    };
    passages.iter().filter(|ends| closes(ends)).count()
}

impl Map {
    /// A passage from node to node: where it begins, the places along it, where it ends.
    pub fn course_m<'a>(&'a self, passage: &'a Passage) -> impl Iterator<Item = &'a Point2<f64>> {
        let [from, to] = [passage.from, passage.to].map(|node| &self.nodes[node].position_m);
        std::iter::once(from).chain(&passage.via_m).chain([to])
    }

    /// The node that was visited first.
    pub fn first_visited(&self) -> Option<usize> {
        (0..self.nodes.len()).min_by_key(|&node| self.nodes[node].visits.first().map(|visit| visit[0]))
    }

    /// How many ways of junctions were not taken.
    pub fn ways_not_taken(&self) -> usize {
        let junctions = self.nodes.iter().filter(|node| node.kind == HereKind::Junction);
        junctions.flat_map(|node| &node.ways).filter(|way| !way.taken).count()
    }

    /// The stretch in which a node was visited first.
    pub fn stretch_of(&self, node: &Node) -> usize {
        let first_ns = node.visits.first().map_or(0, |visit| visit[0]);
        self.stretches_from_ns.partition_point(|from_ns| *from_ns <= first_ns).saturating_sub(1)
    }

    /// "in 2 stretches (the pose was lost at 15.5 s): places of different stretches may be one", if there are such.
    fn lost(&self) -> Option<String> {
        let Self { nodes, stretches_from_ns: from_ns, .. } = self;
        let stretches = nodes.iter().map(|node| self.stretch_of(node)).collect::<BTreeSet<_>>().len();
        let since_s = |ns: &u64| format!("{:.1} s", ns.saturating_sub(from_ns[0]) as f64 * 1e-9);
        let at: Vec<String> = from_ns.iter().skip(1).take(3).map(since_s).collect();
        let more = if from_ns.len() > 4 { "..." } else { "" };
        (stretches > 1).then(|| {
            let at = at.join(", ");
            format!(
                "in {stretches} stretches (the pose was lost at {at}{more}): places of different stretches may be one"
            )
        })
    }

    /// How many loops the passages close.
    pub fn loops(&self) -> usize {
        loops_in(self.passages.iter().map(|passage| [passage.from, passage.to]))
    }

    /// The map in a line: `11 junctions: 7 tees, 3 crossings, 1 5-way junction; 4 dead ends; 2 loops; 3 ways not taken`.
    pub fn summary(&self) -> String {
        let with = |ways: usize| {
            let is_with = |node: &&Node| node.kind == HereKind::Junction && node.ways.len() == ways;
            self.nodes.iter().filter(is_with).count() as u64
        };
        let most = self.nodes.iter().map(|node| node.ways.len()).max().unwrap_or(0);
        let of_ways = (3..=most).filter(|&ways| with(ways) > 0).map(|ways| match ways {
            3 => counted(with(3), "tee"),
            4 => counted(with(4), "crossing"),
            _ => counted(with(ways), &junction_of(ways)),
        });
        let of_ways = of_ways.collect::<Vec<_>>().join(", ");
        let is_junction = |node: &&Node| node.kind == HereKind::Junction;
        let junctions = self.nodes.iter().filter(is_junction).count();
        let junctions_of = counted(junctions as u64, "junction");
        let junctions_of = if junctions > 0 { format!("{junctions_of}: {of_ways}") } else { junctions_of };
        let ends = counted((self.nodes.len() - junctions) as u64, "dead end");
        let loops = counted(self.loops() as u64, "loop");
        let not_taken = counted(self.ways_not_taken() as u64, "way");
        let lost = self.lost().map_or_else(String::new, |lost| format!("; {lost}"));
        format!("{junctions_of}; {ends}; {loops}; {not_taken} not taken{lost}")
    }
}

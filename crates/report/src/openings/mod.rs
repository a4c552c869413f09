//! Openings: edges between two returns of walls that the vehicle can pass.
//!
//! Going around the sensor anticlockwise, every two returns p, q of walls that follow each other bound an edge of the
//! visible free space. Which edges are openings depends on the affinity.
//!
//! **The affinity decided at gaps**, and walls end where it found an opening ([`OpeningRule::BetweenWalls`]): the
//! openings are its verdicts. Where an island stands in an opening, the verdicts on both sides of it are one opening.
//! Without verdicts, every edge between two different walls is one. A way into a room behind a doorway is no wider than
//! the doorway ([`Doorway`](crosscut_scan::Doorway)). Where the wall behind it is seen, with a gap on each side, both
//! gaps are one opening, the doorway: whichever way the vehicle takes inside, it goes in through the door.
//!
//! **The free space decides** for walls of any other origin ([`OpeningRule::FreeSpace`]), and for one wall all around
//! without a verdict. An edge is an opening when
//!
//! 1. ‖p - q‖ is at least the vehicle's width,
//! 2. it is not merely a sparse stretch of one wall, whose returns at grazing incidence are metres apart but all on one
//!    line: either the two belong to different walls and beams between them came back with nothing
//!    ([`Evidence::NoReturn`]), or neither wall continues along its own line across
//!    the edge: the nearer end clears the line of the farther wall by the vehicle's width, and the farther end leaves
//!    the line of the nearer wall by half of it. An edge that is seen over half a turn or more, most of it with nothing
//!    in it, is none such a stretch: the line of a wall would pass on the other side of the sensor;
//! 3. a strip of the vehicle's width that leaves the edge outward meets no return for [`DEPTH_M`](crosscut_stage::DEPTH_M).
//!
//! Edges that lead into the same branch (a stray return deep inside it splits its edge in two) are one opening.
//!
//! By either rule, no opening is narrower than the vehicle, and some beam in it is known: a masked sector is no opening,
//! nor is what lies outside the view ([`Sweep::view`](crosscut_stage::Sweep::view)).
//!
//! A limited view may end in the middle of an opening. Where beams came back with nothing all the way from the last
//! return of a wall to the end of the view (single other beams apart), and leave room for the vehicle beside that
//! return, there is an opening of which a part is seen ([`Opening::is_cut_by_view`]).
//!
//! Bearing and width are those of the branch behind the edge, [`LOOKOUT_M`] from the sensor or where its centreline is
//! last seen, if that is nearer. Walls are lines from return to return. With N the wall whose end is nearer to the
//! sensor, F the other, d_F(x) the distance of x from F, and n (f) the place where N (F), followed from its end, comes
//! within 8 m:
//! ```text
//! width = min(d_F(n), d_N(f))
//! bearing of x, the first on the beam through n from n to the circle of 8 m, then on the circle towards F,
//!         with d_F(x) = width / 2
//! ```
//! The beam through n is where sight into the branch ends if N turns a corner there: there the centreline is last seen.
//!
//! Behind an edge more than 8 m away, walls may lead around a chamber instead of along a branch. Where n and f lie on
//! the other side of the sensor, or farther from each other than [`WIDENS`] times the width of the edge, the ends of
//! the edge take their place. If the line across the branch does not lie ahead, the edge replaces it. If x does not lie
//! ahead, the bearing is that of the middle of the edge. Bearing and width of a branch that the end of the view cuts
//! are those of the part in view.

mod edge;
mod free_space;

use crosscut_scan::Position;
use crosscut_stage::{Beam, Evidence, Known, Opening, Point, Revolution, Verdict};

pub(crate) use self::edge::{FreeEdge, WallEnd};
use crate::wall_ring::WallRing;

/// An opening's bearing and width are taken at most this far from the sensor.
pub const LOOKOUT_M: f64 = 8.0;

/// Walls this many times farther from each other than at the edge are no longer those of the branch.
pub const WIDENS: f64 = 2.5;

/// Which edges are openings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OpeningRule {
    /// The edges through which the vehicle fits into free space.
    #[default]
    FreeSpace,
    /// The edges where the affinity decided that a wall ends; without its verdicts, the edges between two walls.
    BetweenWalls,
}

/// Writes the openings between the walls of `outline`, which is filled from `revolution`, by bearing ascending.
/// `verdicts` come from the affinity, if it gives any.
pub fn find(
    rule: OpeningRule,
    revolution: &Revolution,
    verdicts: &[Verdict],
    outline: &WallRing,
    vehicle_width_m: f64,
    out: &mut Vec<Opening>,
) {
    let is_one_wall = outline.walls().windows(2).all(|pair| pair[0] == pair[1]);
    out.clear();
    match rule {
        OpeningRule::BetweenWalls if !verdicts.is_empty() => {
            out.extend(between_walls(decided(verdicts, outline), vehicle_width_m));
        }
        OpeningRule::BetweenWalls if !is_one_wall => {
            let edges =
                FreeEdge::all(outline, vehicle_width_m).filter(|edge| edge.is_between_walls() && edge.is_known());
            out.extend(between_walls(edges, vehicle_width_m));
        }
        _ => out.extend(free_space::search(revolution, outline, vehicle_width_m)),
    }
    if !outline.ring.full_turn {
        out.extend(cut_by_view(outline, vehicle_width_m));
    }
    out.retain(|opening| opening.width_m >= vehicle_width_m);
    out.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
}

/// The edges where the affinity found an opening. Where an island, or another piece of no wall, is on the far side, the
/// edge reaches to the end of the next such gap.
fn decided<'a>(verdicts: &[Verdict], outline: &'a WallRing) -> impl Iterator<Item = FreeEdge<'a>> {
    let openings = || verdicts.iter().filter(|verdict| verdict.is_opening).map(|verdict| verdict.returns);
    let starts = openings().filter_map(|[from, to]| Some((outline.place_of(from)?, to)));
    let edges = starts.filter_map(move |(from, mut to)| {
        for _ in verdicts {
            if let Some(place) = outline.place_of(to) {
                return Some([from, place]);
            }
            [_, to] = openings().min_by_key(|next| outline.order_from(to, next[0]))?;
        }
        None
    });
    let wraps = |[from, to]: [usize; 2]| to <= from;
    let edges: Vec<_> = edges.filter(|pair| outline.ring.full_turn || !wraps(*pair)).collect();
    let parts = edges.into_iter().flat_map(|pair| parts(outline, pair));
    parts.map(|pair| FreeEdge::between(outline, pair)).filter(FreeEdge::is_known)
}

/// The parts of an edge between which other walls stand: what the affinity took for an island may count as a wall.
fn parts(outline: &WallRing, [from, to]: [usize; 2]) -> Vec<[usize; 2]> {
    let (n, beside) = (outline.len(), [from, to].map(|at| outline.wall(at)));
    let (mut parts, mut start) = (Vec::new(), from);
    for at in (1..(to + n - from) % n).map(|step| (from + step) % n) {
        // Returns of the walls beside the edge are stray ones.
        if beside.contains(&outline.wall(at)) {
            continue;
        }
        if outline.wall(at) != outline.wall(start) {
            parts.push([start, at]);
        }
        start = at;
    }
    parts.push([start, to]);
    parts
}

/// The edges of an opening, of which there are several where a wall is seen through a doorway; none if the view cuts it.
pub(crate) fn edges_of<'a>(opening: &Opening, outline: &'a WallRing) -> Vec<FreeEdge<'a>> {
    let whole = match opening.returns {
        [Some(from), Some(to)] if opening.gaps.is_empty() => Some([from, to]),
        _ => None,
    };
    let gaps = whole.iter().chain(&opening.gaps);
    gaps.filter_map(|&gap| outline.places_of(gap)).map(|pair| FreeEdge::between(outline, pair)).collect()
}

/// The openings at edges where a wall ends. Those that begin at the two sides of a doorway are one.
fn between_walls<'a>(edges: impl Iterator<Item = FreeEdge<'a>>, vehicle_width_m: f64) -> Vec<Opening> {
    let mut edges: Vec<_> = edges.collect();
    edges.sort_by_key(|edge| edge.clockwise.at);
    let count = edges.len();
    let last_behind_doorway = |first: usize| {
        let others = if edges[first].outline.ring.full_turn { count } else { count - first };
        (1..others).rev().find(|more| edges[first].is_doorway_to(&edges[(first + more) % count], vehicle_width_m))
    };
    let doorways: Vec<_> = (0..count).filter_map(|first| Some((first, last_behind_doorway(first)?))).collect();
    let doorways_before =
        |at: usize| doorways.iter().filter(move |(first, more)| (at + count - first) % count <= *more).count();
    let alone = (0..count).filter(|&at| doorways_before(at) == 0).map(|at| into_branch(&edges[at], vehicle_width_m));
    // Another doorway may be seen through a doorway.
    let outermost = doorways.iter().filter(|(first, _)| doorways_before(*first) == 1);
    let through_doorways = outermost.map(|&(first, more)| {
        let inside: Vec<_> = (first..=first + more).map(|at| &edges[at % count]).collect();
        let (opening, _) = inside[0].up_to(inside[more]).opening();
        Opening { gaps: inside.iter().map(|edge| edge.returns()).collect(), ..opening }
    });
    alone.chain(through_doorways).collect()
}

/// The opening at one edge. A way into a room is no wider than its door.
fn into_branch(edge: &FreeEdge<'_>, vehicle_width_m: f64) -> Opening {
    let (mut opening, _) = edge.opening();
    if let Some(doorway_m) = edge.doorway_m(vehicle_width_m) {
        opening.width_m = opening.width_m.min(doorway_m);
    }
    opening
}

/// Whether the view goes all the way round, and something is known between any two walls.
pub(crate) fn sees_all(outline: &WallRing) -> bool {
    let knows_all = || FreeEdge::all(outline, f64::INFINITY).all(|edge| edge.is_known());
    outline.ring.full_turn && (!outline.ring.beams.contains(&Beam::Unknown) || knows_all())
}

/// Openings that an end of a limited view cuts.
fn cut_by_view(outline: &WallRing, vehicle_width_m: f64) -> impl Iterator<Item = Opening> {
    let ends = outline.len().checked_sub(1).map(|last| {
        let [before, after] = [(0, false), (last, true)];
        [before, after].map(|(at, is_clockwise)| WallEnd { at, is_clockwise })
    });
    ends.into_iter().flatten().filter_map(move |end| cut_beside(end, outline, vehicle_width_m))
}

/// The opening between the end of a wall and the end of the view.
fn cut_beside(wall: WallEnd, outline: &WallRing, vehicle_width_m: f64) -> Option<Opening> {
    if outline.room_to_end_m(wall.at, wall.is_clockwise) < vehicle_width_m {
        return None;
    }
    let end = outline.ring.returns[wall.at];
    let beams = if wall.is_clockwise { outline.ring.beams.len() - 1 - end.beam } else { end.beam };
    let turn_rad = beams as f64 * outline.ring.step_rad;
    let towards_end = if wall.is_clockwise { turn_rad } else { -turn_rad };
    let turned_m = |share: f64| nalgebra::Rotation2::new(share * towards_end) * end.position_m;
    let (mut edge_m, mut returns) = ([end.position_m, turned_m(1.0)], [Some(end.number), None]);
    if !wall.is_clockwise {
        edge_m.reverse();
        returns.reverse();
    }
    Some(Opening {
        bearing_rad: bearing_rad(turned_m(0.5)),
        width_m: turned_m(1.0).normalize().perp(&wall.anchor_m(outline)).abs(),
        walls: [outline.wall(wall.at); 2],
        returns,
        gaps: Vec::new(),
        evidence: Evidence::NoReturn,
        known: Known::Judged,
        edge_m: edge_m.map(point),
        p: None,
    })
}

fn bearing_rad(position_m: Position) -> f64 {
    position_m.y.atan2(position_m.x)
}

fn point(position_m: Position) -> Point {
    Point::new(position_m.x, position_m.y, 0.0)
}

//! The edges that decide a count.

use crosscut_stage::Frame;

use crate::bottleneck::Bottlenecks;
use crate::change::{self, Change};
use crate::closest;
use crate::doubtful::may_be_none;
use crate::nearest::{Nearest, nearest};
use crate::wall_edges::{Edge, WallEdges};

/// The explanation of the count of one revolution.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// The edges of each wall, by its number.
    pub walls: Vec<WallEdges>,
    /// Changes that would give another count, the smallest first.
    pub changes: Vec<Change>,
    /// If W has no edge between walls: the two closest returns of different walls, after their walls.
    pub closest: Option<([u32; 2], [usize; 2])>,
    /// The gap at which another decision gives the nearest other count.
    pub nearest: Option<Nearest>,
    /// The wall without which the count is one less, if it has few returns or stands free inside a gap.
    pub may_be_none: Option<u32>,
}

impl Explanation {
    /// Explains a frame whose stages have all run.
    pub fn of(frame: &Frame) -> Self {
        let walls = walls_of(frame);
        let weights = &frame.affinity.weights;
        let bottlenecks = Bottlenecks::of(weights, &walls);
        let walls = edges_of(&sums_of(frame, walls.len(), &bottlenecks.first_side), bottlenecks);
        let changes = change::changes(frame, &walls);
        let apart = walls.len() > 1 && walls.iter().all(|wall| wall.strongest.is_none());
        let closest = apart.then(|| closest::pair(frame)).flatten();
        let nearest = nearest(frame, &changes, closest);
        Self { walls, changes, closest, nearest, may_be_none: may_be_none(frame).map(|wall| wall.id) }
    }
}

/// The returns of each wall; none if the parts of the frame do not fit each other, or rows of W are no returns.
fn walls_of(frame: &Frame) -> Vec<Vec<usize>> {
    let (n, wall_of) = (frame.revolution.len(), &frame.junction.wall_of_return);
    if frame.affinity.dual.is_some()
        || wall_of.len() != n
        || frame.affinity.weights.n() != n
        || frame.affinity.degrees.len() != n
    {
        return Vec::new();
    }
    let walls = wall_of.iter().flatten().max().map_or(0, |&last| last as usize + 1);
    let mut returns = vec![Vec::new(); walls];
    for (i, wall) in wall_of.iter().enumerate() {
        if let Some(wall) = wall {
            returns[*wall as usize].push(i);
        }
    }
    returns
}

/// Cuts and volumes of one wall.
#[derive(Clone, Default)]
struct Sums {
    /// Sum of the weights across the weakest edge.
    inner_cut: f64,
    /// Sum of the degrees on the other side of the weakest edge, and on the first.
    side_volumes: [f64; 2],
    /// Sum of the weights to all other walls.
    outer_cut: f64,
    strongest: Option<(u32, Edge)>,
}

/// The sums of each of `walls` walls; each pair of returns occurs twice in W, once for either return.
fn sums_of(frame: &Frame, walls: usize, first_side: &[bool]) -> Vec<Sums> {
    let mut sums = vec![Sums::default(); walls];
    if walls == 0 {
        return sums;
    }
    let wall_of = &frame.junction.wall_of_return;
    for (i, degree) in frame.affinity.degrees.iter().enumerate() {
        if let Some(wall) = wall_of[i] {
            sums[wall as usize].side_volumes[usize::from(first_side[i])] += degree;
        }
    }
    frame.affinity.weights.for_each(|i, j, weight| {
        let (Some(own), Some(other)) = (wall_of[i], wall_of[j]) else { return };
        let Sums { inner_cut, outer_cut, strongest, .. } = &mut sums[own as usize];
        if own != other {
            *outer_cut += weight;
            if weight > strongest.map_or(0.0, |(_, edge)| edge.weight) {
                *strongest = Some((other, Edge { returns: [i, j], weight }));
            }
        } else if first_side[i] && !first_side[j] {
            *inner_cut += weight;
        }
    });
    sums
}

/// The edges of each wall, with the quotients that they make.
fn edges_of(sums: &[Sums], bottlenecks: Bottlenecks) -> Vec<WallEdges> {
    let all: f64 = sums.iter().flat_map(|of_wall| of_wall.side_volumes).sum();
    let walls = (0..).zip(sums).zip(bottlenecks.edges.into_iter().zip(bottlenecks.parts));
    let of_wall = |((wall, of_wall), (weakest, parts)): ((u32, &Sums), (Option<Edge>, usize))| {
        let [one, other] = of_wall.side_volumes;
        WallEdges {
            wall,
            weakest,
            parts,
            breaks_at: quotient(of_wall.inner_cut, one, other),
            strongest: of_wall.strongest,
            parts_at: quotient(of_wall.outer_cut, one + other, all - one - other),
        }
    };
    walls.map(of_wall).collect()
}

/// q(A, B); 0 if a side is empty.
fn quotient(cut: f64, volume_a: f64, volume_b: f64) -> f64 {
    if volume_a > 0.0 && volume_b > 0.0 { cut * (volume_a.recip() + volume_b.recip()) } else { 0.0 }
}

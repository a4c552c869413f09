//! The edges that decide a count.

use crosscut_stage::{Frame, Weights};

use crate::bottleneck::Bottlenecks;
use crate::change::{self, Change};
use crate::closest;
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
}

impl Explanation {
    /// Explains a frame whose stages have all run.
    pub fn of(frame: &Frame) -> Self {
        let walls = walls_of(frame);
        let weights = &frame.affinity.weights;
        let bottlenecks = Bottlenecks::of(weights, &walls);
        let walls = Sums::of(frame, &walls, &bottlenecks.first_side).into_edges(bottlenecks);
        let changes = change::changes(frame, &walls);
        let apart = walls.len() > 1 && walls.iter().all(|wall| wall.strongest.is_none());
        let closest = apart.then(|| closest::pair(frame)).flatten();
        Self { walls, changes, closest }
    }

    /// The strongest edge between two walls, after the numbers of these walls.
    pub fn strongest(&self) -> Option<([u32; 2], Edge)> {
        let edges = self.walls.iter().filter_map(|wall| wall.strongest.map(|(to, edge)| ([wall.wall, to], edge)));
        edges.max_by(|a, b| a.1.weight.total_cmp(&b.1.weight))
    }
}

/// The returns of each wall; none if the parts of the frame do not fit each other.
fn walls_of(frame: &Frame) -> Vec<Vec<usize>> {
    let (n, wall_of) = (frame.revolution.len(), &frame.junction.wall_of_return);
    if wall_of.len() != n || frame.affinity.weights.n() != n || frame.affinity.degrees.len() != n {
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

/// Cuts and volumes, by wall.
struct Sums {
    /// Sum of the weights across the weakest edge.
    inner_cut: Vec<f64>,
    /// Sum of the degrees on the other side of the weakest edge, and on the first.
    side_volumes: Vec<[f64; 2]>,
    /// Sum of the weights to all other walls.
    outer_cut: Vec<f64>,
    strongest: Vec<Option<(u32, Edge)>>,
}

impl Sums {
    fn of(frame: &Frame, walls: &[Vec<usize>], first_side: &[bool]) -> Self {
        let mut sums = Self {
            inner_cut: vec![0.0; walls.len()],
            side_volumes: vec![[0.0; 2]; walls.len()],
            outer_cut: vec![0.0; walls.len()],
            strongest: vec![None; walls.len()],
        };
        if walls.is_empty() {
            return sums;
        }
        let wall_of = &frame.junction.wall_of_return;
        for (i, degree) in frame.affinity.degrees.iter().enumerate() {
            if let Some(wall) = wall_of[i] {
                sums.side_volumes[wall as usize][usize::from(first_side[i])] += degree;
            }
        }
        sums.add_weights(&frame.affinity.weights, wall_of, first_side);
        sums
    }

    /// Adds every weight. Each pair of returns occurs twice, once for either return.
    fn add_weights(&mut self, weights: &Weights, wall_of: &[Option<u32>], first_side: &[bool]) {
        weights.for_each(|i, j, weight| {
            let (Some(own), Some(other)) = (wall_of[i], wall_of[j]) else { return };
            let wall = own as usize;
            if own != other {
                self.outer_cut[wall] += weight;
                if weight > self.strongest[wall].map_or(0.0, |(_, edge)| edge.weight) {
                    self.strongest[wall] = Some((other, Edge { returns: [i, j], weight }));
                }
            } else if first_side[i] && !first_side[j] {
                self.inner_cut[wall] += weight;
            }
        });
    }

    fn into_edges(self, bottlenecks: Bottlenecks) -> Vec<WallEdges> {
        let all: f64 = self.side_volumes.iter().flatten().sum();
        let walls = bottlenecks.edges.into_iter().zip(bottlenecks.parts).enumerate();
        let of_wall = |(wall, (weakest, parts)): (usize, (Option<Edge>, usize))| {
            let [one, other] = self.side_volumes[wall];
            WallEdges {
                wall: u32::try_from(wall).unwrap_or(u32::MAX),
                weakest,
                parts,
                breaks_at: quotient(self.inner_cut[wall], one, other),
                strongest: self.strongest[wall],
                parts_at: quotient(self.outer_cut[wall], one + other, all - one - other),
            }
        };
        walls.map(of_wall).collect()
    }
}

/// q(A, B); 0 if a side is empty.
fn quotient(cut: f64, volume_a: f64, volume_b: f64) -> f64 {
    if volume_a > 0.0 && volume_b > 0.0 { cut * (volume_a.recip() + volume_b.recip()) } else { 0.0 }
}

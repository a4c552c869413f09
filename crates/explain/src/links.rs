//! The links that decide a count.

use crosscut_stage::{Frame, Weights};

use crate::bottleneck::Bottlenecks;
use crate::change::{self, Change};
use crate::closest;

/// A weight of W between two returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Which returns, by their index; the lower one need not come first.
    pub returns: [usize; 2],
    /// W_ij.
    pub weight: f64,
}

/// What holds one wall together, and what ties it to the others.
#[derive(Clone, Debug, PartialEq)]
pub struct WallLinks {
    /// The wall's number.
    pub wall: u32,
    /// The bottleneck of its maximum spanning tree; `None` if it has one return, or falls apart.
    pub weakest: Option<Link>,
    /// Parts of the wall that no weight joins: 1 for a wall that W holds together.
    pub pieces: usize,
    /// q of the two sides of the weakest link: about the eigenvalue that breaking the wall there stands for.
    pub breaks_at: f64,
    /// The strongest link to another wall, and which; `None` if W has none.
    pub strongest: Option<(u32, Link)>,
    /// q of this wall and all other walls: about the eigenvalue that keeping it apart stands for.
    pub parts_at: f64,
}

/// Why the count of one revolution is what it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// Each wall, by its number.
    pub walls: Vec<WallLinks>,
    /// What would change the count, the least change first.
    pub changes: Vec<Change>,
    /// Where W has no link between walls: the two returns of different walls that lie closest, and their walls.
    pub closest: Option<([u32; 2], [usize; 2])>,
}

impl Explanation {
    /// Of a frame whose stages all ran.
    pub fn of(frame: &Frame) -> Self {
        let walls = walls_of(frame);
        let weights = &frame.affinity.weights;
        let bottlenecks = Bottlenecks::of(weights, &walls);
        let walls = Sums::of(frame, &walls, &bottlenecks.first_side).into_links(bottlenecks);
        let changes = change::changes(frame, &walls);
        let apart = walls.len() > 1 && walls.iter().all(|wall| wall.strongest.is_none());
        let closest = apart.then(|| closest::pair(frame)).flatten();
        Self { walls, changes, closest }
    }

    /// The strongest link between two walls, and which walls.
    pub fn strongest(&self) -> Option<([u32; 2], Link)> {
        let links = self.walls.iter().filter_map(|wall| wall.strongest.map(|(to, link)| ([wall.wall, to], link)));
        links.max_by(|a, b| a.1.weight.total_cmp(&b.1.weight))
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
    /// Across the weakest link.
    inner_cut: Vec<f64>,
    /// D of the returns on the first side of the weakest link, and on the other.
    side_volumes: Vec<[f64; 2]>,
    /// To all other walls.
    outer_cut: Vec<f64>,
    strongest: Vec<Option<(u32, Link)>>,
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

    /// Each pair of returns comes twice, once for either return.
    fn add_weights(&mut self, weights: &Weights, wall_of: &[Option<u32>], first_side: &[bool]) {
        weights.for_each(|i, j, weight| {
            let (Some(own), Some(other)) = (wall_of[i], wall_of[j]) else { return };
            let wall = own as usize;
            if own != other {
                self.outer_cut[wall] += weight;
                if weight > self.strongest[wall].map_or(0.0, |(_, link)| link.weight) {
                    self.strongest[wall] = Some((other, Link { returns: [i, j], weight }));
                }
            } else if first_side[i] && !first_side[j] {
                self.inner_cut[wall] += weight;
            }
        });
    }

    fn into_links(self, bottlenecks: Bottlenecks) -> Vec<WallLinks> {
        let all: f64 = self.side_volumes.iter().flatten().sum();
        let walls = bottlenecks.links.into_iter().zip(bottlenecks.pieces).enumerate();
        let of_wall = |(wall, (weakest, pieces)): (usize, (Option<Link>, usize))| {
            let [one, other] = self.side_volumes[wall];
            WallLinks {
                wall: u32::try_from(wall).unwrap_or(u32::MAX),
                weakest,
                pieces,
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

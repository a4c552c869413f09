//! The weakest edge of each wall: the bottleneck of the maximum spanning tree of its part of W.

use crosscut_stage::{DisjointSets, Weights};

use crate::wall_edges::Edge;

/// The weakest edges of all walls, and the two sides of each.
pub(crate) struct Bottlenecks {
    /// By wall: its weakest edge; `None` for a wall of at most one return, or of several parts.
    pub(crate) edges: Vec<Option<Edge>>,
    /// By wall: its number of parts, between which W has no edge.
    pub(crate) parts: Vec<usize>,
    /// By return: whether it is on the first side of its wall's weakest edge.
    pub(crate) first_side: Vec<bool>,
}

impl Bottlenecks {
    /// `walls[w]` lists the returns of wall w, ascending. Kruskal's algorithm: the strongest edges join parts first; the edge
    /// that joins the last two parts of a wall is its weakest.
    pub(crate) fn of(weights: &Weights, walls: &[Vec<usize>]) -> Self {
        let mut wall_of = vec![None; weights.n()];
        for (wall, returns) in walls.iter().enumerate() {
            returns.iter().for_each(|&i| wall_of[i] = Some(wall));
        }
        let mut of_walls = Vec::new();
        weights.for_each(|i, j, weight| {
            if let Some(wall) = wall_of[i].filter(|_| i < j && weight > 0.0 && wall_of[i] == wall_of[j]) {
                of_walls.push((wall, Edge { returns: [i, j], weight }));
            }
        });
        of_walls.sort_by(|(_, a), (_, b)| b.weight.total_cmp(&a.weight).then(a.returns.cmp(&b.returns)));
        let mut sets = DisjointSets::default();
        sets.reset(weights.n());
        let mut edges = vec![None; walls.len()];
        let mut parts: Vec<usize> = walls.iter().map(Vec::len).collect();
        let mut first_side = vec![false; weights.n()];
        for (wall, edge) in of_walls {
            let [a, b] = edge.returns.map(|i| sets.root(i));
            if a == b {
                continue;
            }
            if parts[wall] == 2 {
                edges[wall] = Some(edge);
                walls[wall].iter().for_each(|&i| first_side[i] = sets.root(i) == a);
            }
            sets.join(a, b);
            parts[wall] -= 1;
        }
        Self { edges, parts, first_side }
    }
}

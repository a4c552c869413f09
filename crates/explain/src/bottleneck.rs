//! The weakest edge of each wall: the bottleneck of the maximum spanning tree of its part of W.

use crosscut_stage::{DisjointSets, Weights};

use crate::Edge;

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
    /// `walls[w]` lists the returns of wall w, ascending.
    pub(crate) fn of(weights: &Weights, walls: &[Vec<usize>]) -> Self {
        let none = Self {
            edges: vec![None; walls.len()],
            parts: walls.iter().map(|returns| usize::from(!returns.is_empty())).collect(),
            first_side: vec![false; weights.n()],
        };
        match weights {
            Weights::Dense(w) => {
                let weight = |i: usize, j: usize| w[(i, j)];
                none.grow_trees(walls, weight)
            }
            Weights::Sparse(_) => none.join_parts(weights, walls),
            _ => none,
        }
    }

    /// Prim's algorithm: a tree grows by the strongest edge that leaves it, O(m²) for a wall of m returns.
    fn grow_trees(mut self, walls: &[Vec<usize>], weight: impl Fn(usize, usize) -> f64) -> Self {
        for (wall, returns) in walls.iter().enumerate() {
            let grown = grow_tree(returns, &weight);
            self.parts[wall] += grown.iter().filter(|growth| growth.weight == 0.0).count();
            let weakest = grown.iter().enumerate().min_by(|a, b| a.1.weight.total_cmp(&b.1.weight));
            let Some((broken, growth)) = weakest.filter(|(_, growth)| growth.weight > 0.0) else { continue };
            self.edges[wall] = Some(Edge { returns: [growth.from, growth.to], weight: growth.weight });
            // The first side is the far end of the weakest edge and all that grew from it later.
            self.first_side[growth.to] = true;
            for later in &grown[broken + 1..] {
                self.first_side[later.to] = self.first_side[later.from];
            }
        }
        self
    }

    /// Kruskal's algorithm: the strongest edges join parts first; the edge that joins a wall's last two parts is its
    /// weakest.
    fn join_parts(mut self, weights: &Weights, walls: &[Vec<usize>]) -> Self {
        let mut wall_of = vec![None; weights.n()];
        for (wall, returns) in walls.iter().enumerate() {
            returns.iter().for_each(|&i| wall_of[i] = Some(wall));
        }
        let mut edges = Vec::new();
        weights.for_each(|i, j, weight| {
            if i < j && weight > 0.0 && wall_of[i] == wall_of[j] && wall_of[i].is_some() {
                edges.push(Edge { returns: [i, j], weight });
            }
        });
        edges.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.returns.cmp(&b.returns)));
        let mut sets = DisjointSets::default();
        sets.reset(weights.n());
        let mut parts_left: Vec<usize> = walls.iter().map(Vec::len).collect();
        for edge in edges {
            let [i, j] = edge.returns;
            let Some(wall) = wall_of[i] else { continue };
            let (a, b) = (sets.root(i), sets.root(j));
            if a == b {
                continue;
            }
            if parts_left[wall] == 2 {
                self.edges[wall] = Some(edge);
                walls[wall].iter().for_each(|&r| self.first_side[r] = sets.root(r) == a);
            }
            sets.join(a, b);
            parts_left[wall] -= 1;
        }
        self.parts = parts_left;
        self
    }
}

/// One return that a tree grew by, with the edge to it.
struct Growth {
    from: usize,
    to: usize,
    weight: f64,
}

fn grow_tree(returns: &[usize], weight: impl Fn(usize, usize) -> f64) -> Vec<Growth> {
    let Some((&root, others)) = returns.split_first() else { return Vec::new() };
    let edge = |from: usize, to: usize| Growth { from, to, weight: weight(from, to) };
    let mut outside: Vec<Growth> = others.iter().map(|&to| edge(root, to)).collect();
    let mut grown = Vec::with_capacity(outside.len());
    while let Some((at, _)) = outside.iter().enumerate().max_by(|a, b| a.1.weight.total_cmp(&b.1.weight)) {
        let next = outside.swap_remove(at);
        for other in &mut outside {
            let from_next = edge(next.to, other.to);
            if from_next.weight > other.weight {
                *other = from_next;
            }
        }
        grown.push(next);
    }
    grown
}

//! The weakest link of each wall: the bottleneck of the maximum spanning tree of its W.

use crosscut_stage::Weights;

use crate::Link;

/// Where each wall would break first.
pub(crate) struct Bottlenecks {
    /// By wall: its weakest link; `None` for a wall of one return or none, or one that W does not hold together.
    pub(crate) links: Vec<Option<Link>>,
    /// By wall: into how many parts without any link between them W lets it fall.
    pub(crate) pieces: Vec<usize>,
    /// By return: whether it lies on the first side of its wall's weakest link.
    pub(crate) first_side: Vec<bool>,
}

impl Bottlenecks {
    /// `walls[w]` lists the returns of wall w, ascending.
    pub(crate) fn of(weights: &Weights, walls: &[Vec<usize>]) -> Self {
        let none = Self {
            links: vec![None; walls.len()],
            pieces: walls.iter().map(|returns| usize::from(!returns.is_empty())).collect(),
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

    /// Prim: a tree that grows by the strongest link out of it, O(m²) for a wall of m returns.
    fn grow_trees(mut self, walls: &[Vec<usize>], weight: impl Fn(usize, usize) -> f64) -> Self {
        for (wall, returns) in walls.iter().enumerate() {
            let grown = grow_tree(returns, &weight);
            self.pieces[wall] += grown.iter().filter(|step| step.weight == 0.0).count();
            let weakest = grown.iter().enumerate().min_by(|a, b| a.1.weight.total_cmp(&b.1.weight));
            let Some((broken, step)) = weakest.filter(|(_, step)| step.weight > 0.0) else { continue };
            self.links[wall] = Some(Link { returns: [step.from, step.to], weight: step.weight });
            // What grew out of the far end of the broken step, in the order in which it grew.
            self.first_side[step.to] = true;
            for later in &grown[broken + 1..] {
                self.first_side[later.to] = self.first_side[later.from];
            }
        }
        self
    }

    /// Kruskal: parts joined by the strongest links first; the link that joins a wall's last two parts is its weakest.
    fn join_parts(mut self, weights: &Weights, walls: &[Vec<usize>]) -> Self {
        let mut wall_of = vec![None; weights.n()];
        for (wall, returns) in walls.iter().enumerate() {
            returns.iter().for_each(|&i| wall_of[i] = Some(wall));
        }
        let mut links = Vec::new();
        weights.for_each(|i, j, weight| {
            if i < j && weight > 0.0 && wall_of[i] == wall_of[j] && wall_of[i].is_some() {
                links.push(Link { returns: [i, j], weight });
            }
        });
        links.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.returns.cmp(&b.returns)));
        let mut parts = Parts::new(weights.n());
        let mut left: Vec<usize> = walls.iter().map(Vec::len).collect();
        for link in links {
            let [i, j] = link.returns;
            let Some(wall) = wall_of[i] else { continue };
            let (a, b) = (parts.root(i), parts.root(j));
            if a == b {
                continue;
            }
            if left[wall] == 2 {
                self.links[wall] = Some(link);
                walls[wall].iter().for_each(|&r| self.first_side[r] = parts.root(r) == a);
            }
            parts.parent[a] = b;
            left[wall] -= 1;
        }
        self.pieces = left;
        self
    }
}

/// How a tree grew by one return.
struct Step {
    from: usize,
    to: usize,
    weight: f64,
}

fn grow_tree(returns: &[usize], weight: impl Fn(usize, usize) -> f64) -> Vec<Step> {
    let Some((&root, others)) = returns.split_first() else { return Vec::new() };
    let step = |from: usize, to: usize| Step { from, to, weight: weight(from, to) };
    let mut outside: Vec<Step> = others.iter().map(|&to| step(root, to)).collect();
    let mut grown = Vec::with_capacity(outside.len());
    while let Some((at, _)) = outside.iter().enumerate().max_by(|a, b| a.1.weight.total_cmp(&b.1.weight)) {
        let next = outside.swap_remove(at);
        for other in &mut outside {
            let link = step(next.to, other.to);
            if link.weight > other.weight {
                *other = link;
            }
        }
        grown.push(next);
    }
    grown
}

/// Union-find over the returns.
struct Parts {
    parent: Vec<usize>,
}

impl Parts {
    fn new(n: usize) -> Self {
        Self { parent: (0..n).collect() }
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }
}

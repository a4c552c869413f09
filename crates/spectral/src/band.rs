//! One block's Laplacian as a band matrix, and its second eigenvalue.

use std::collections::VecDeque;

use crosscut_stage::{Affinity, Weights};

/// Steps of inverse iteration at most, the last ones with the Rayleigh quotient as shift.
const INVERSE_STEPS: usize = 12;
const RAYLEIGH_STEPS: usize = 8;
/// The shift of the first steps: L itself is singular.
const SHIFT: f64 = -1e-9;
/// How far from an eigenvalue the pivots are asked, relative to it.
const BRACKET: f64 = 1e-9;

/// The normalised Laplacian of one block, rows in breadth-first order from its far end, so that entries stay near
/// the diagonal: as near as the neighbours of a return along its wall.
#[derive(Clone, Debug, Default)]
pub(crate) struct Band {
    n: usize,
    /// Entries below the diagonal that a row has at most.
    width: usize,
    /// Row by row: the `width` entries left of the diagonal, and the diagonal.
    entries: Vec<f64>,
    /// L - shift·I = M Δ Mᵀ: M below its unit diagonal, Δ on it.
    factor: Vec<f64>,
    /// D^1/2 1 / ‖D^1/2 1‖.
    zero: Vec<f64>,
    vector: Vec<f64>,
}

impl Band {
    /// Takes the block of `members`; `leaks` are the weights of each return's links to other blocks, set aside.
    pub(crate) fn form(&mut self, affinity: &Affinity, members: &[u32], leaks: &[f64]) {
        self.n = members.len();
        let mut place = vec![usize::MAX; affinity.degrees.len()];
        members.iter().enumerate().for_each(|(at, &i)| place[i as usize] = at);
        let edges = edges(&affinity.weights, members, &place);
        let far = *breadth_first(&edges, 0).last().unwrap_or(&0);
        let mut rank = vec![0; self.n];
        breadth_first(&edges, far).iter().enumerate().for_each(|(at, &i)| rank[i] = at);

        let spans = edges.iter().enumerate().flat_map(|(i, row)| row.iter().map(move |&(j, _)| (i, j)));
        self.width = spans.map(|(i, j)| rank[i].abs_diff(rank[j])).max().unwrap_or(0);
        self.entries.clear();
        self.entries.resize(self.n * (self.width + 1), 0.0);
        let degree = |i: usize| affinity.degrees[members[i] as usize];
        self.zero.clear();
        self.zero.resize(self.n, 0.0);
        for (i, row) in edges.iter().enumerate() {
            self.zero[rank[i]] = degree(i).sqrt();
            for &(j, weight) in row.iter().filter(|&&(j, _)| rank[j] <= rank[i]) {
                let scaled = weight * (degree(i).sqrt().recip() * degree(j).sqrt().recip());
                let at = rank[i] * (self.width + 1) + self.width - (rank[i] - rank[j]);
                self.entries[at] = if i == j { 1.0 - scaled - leaks[members[i] as usize] / degree(i) } else { -scaled };
            }
        }
        let norm = dot(&self.zero, &self.zero).sqrt();
        self.zero.iter_mut().for_each(|x| *x /= norm);
    }

    /// The second eigenvalue, if the pivots confirm it.
    pub(crate) fn second_eigenvalue(&mut self) -> Option<f64> {
        // Any start will do that is not orthogonal to the eigenvector; its nodes are unknown, so no symmetric one.
        let mut state = 0x9E37_79B9_u32;
        self.vector.clear();
        for _ in 0..self.n {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            self.vector.push(f64::from(state) / f64::from(u32::MAX) - 0.5);
        }
        self.factorise(SHIFT);
        for _ in 0..INVERSE_STEPS {
            self.step();
        }
        let mut quotient = self.rayleigh_quotient();
        for _ in 0..RAYLEIGH_STEPS {
            self.factorise(quotient);
            self.step();
            let next = self.rayleigh_quotient();
            let settled = (next - quotient).abs() <= 4.0 * f64::EPSILON;
            quotient = next;
            if settled {
                break;
            }
        }
        let bracket = BRACKET * quotient.abs();
        let confirmed = self.factorise(quotient - bracket) == 1 && self.factorise(quotient + bracket) >= 2;
        confirmed.then_some(quotient)
    }

    /// Factorises L - shift·I; the number of its negative pivots is that of eigenvalues below the shift.
    fn factorise(&mut self, shift: f64) -> usize {
        let (w, stride) = (self.width, self.width + 1);
        self.factor.clone_from(&self.entries);
        let mut negative = 0;
        for i in 0..self.n {
            let first = i.saturating_sub(w);
            // Entry (i, j) of a row is at i·stride + w - (i - j).
            for j in first..i {
                let common = first.max(j.saturating_sub(w));
                let mut sum = self.factor[i * stride + w + j - i];
                for m in common..j {
                    sum -= self.factor[i * stride + w + m - i] * self.factor[j * stride + w + m - j];
                }
                self.factor[i * stride + w + j - i] = sum;
            }
            let mut pivot = self.factor[i * stride + w] - shift;
            for j in first..i {
                let at = i * stride + w + j - i;
                let scaled = self.factor[at] / self.factor[j * stride + w];
                pivot -= scaled * self.factor[at];
                self.factor[at] = scaled;
            }
            if pivot.abs() < f64::MIN_POSITIVE {
                pivot = f64::EPSILON * f64::EPSILON;
            }
            self.factor[i * stride + w] = pivot;
            negative += usize::from(pivot < 0.0);
        }
        negative
    }

    /// One step of inverse iteration on `vector`, without its part along the known eigenvector.
    fn step(&mut self) {
        let (w, stride) = (self.width, self.width + 1);
        for i in 0..self.n {
            for j in i.saturating_sub(w)..i {
                self.vector[i] -= self.factor[i * stride + w + j - i] * self.vector[j];
            }
        }
        for i in (0..self.n).rev() {
            self.vector[i] /= self.factor[i * stride + w];
        }
        for i in (0..self.n).rev() {
            for j in i.saturating_sub(w)..i {
                self.vector[j] -= self.factor[i * stride + w + j - i] * self.vector[i];
            }
        }
        let along = dot(&self.vector, &self.zero);
        self.vector.iter_mut().zip(&self.zero).for_each(|(x, z)| *x -= along * z);
        let norm = dot(&self.vector, &self.vector).sqrt();
        self.vector.iter_mut().for_each(|x| *x /= norm);
    }

    /// vᵀ L v of the unit vector.
    fn rayleigh_quotient(&self) -> f64 {
        let (w, stride, v) = (self.width, self.width + 1, &self.vector);
        let row = |i: usize| {
            let left: f64 = (i.saturating_sub(w)..i).map(|j| self.entries[i * stride + w + j - i] * v[j]).sum();
            v[i] * (2.0 * left + self.entries[i * stride + w] * v[i])
        };
        (0..self.n).map(row).sum()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// The edges of each member, by their places among the members.
fn edges(weights: &Weights, members: &[u32], place: &[usize]) -> Vec<Vec<(usize, f64)>> {
    let mut edges = vec![Vec::new(); members.len()];
    let mut add = |i: usize, j: usize, weight: f64| {
        if weight != 0.0 && place[j] != usize::MAX {
            edges[place[i]].push((place[j], weight));
        }
    };
    match weights {
        Weights::Sparse(w) => {
            for &i in members {
                let (columns, values) = w.row(i as usize);
                columns.iter().zip(values).for_each(|(&j, &weight)| add(i as usize, j as usize, weight));
            }
        }
        other => other.for_each(|i, j, weight| {
            if place[i] != usize::MAX {
                add(i, j, weight);
            }
        }),
    }
    edges
}

/// All nodes of a connected graph, nearest to `start` first.
fn breadth_first(edges: &[Vec<(usize, f64)>], start: usize) -> Vec<usize> {
    let (mut seen, mut order) = (vec![false; edges.len()], Vec::with_capacity(edges.len()));
    let mut queue = VecDeque::from([start]);
    seen[start] = true;
    while let Some(i) = queue.pop_front() {
        order.push(i);
        for &(j, _) in &edges[i] {
            if !std::mem::replace(&mut seen[j], true) {
                queue.push_back(j);
            }
        }
    }
    order
}

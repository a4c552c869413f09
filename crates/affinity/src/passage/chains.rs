//! The graph of walls: edges along each, weaker across gaps.

use std::ops::Range;

use crosscut_stage::Affinity;

use super::gap::Judge;
use super::pieces::Pieces;
use super::ring::Ring;

/// A return that no wall was found for goes to the nearest wall, if it is no farther than this.
const NEAR_M: f64 = 3.0;
/// The weight of that edge, and of a gap that was joined against its direction.
const WEAK: f64 = 0.1;
/// A verdict twice as decided is further from the zero tolerance by this power of 2.
const DECIDED_POWER: i32 = 4;

/// Writes W; holds its buffers. Walls and islands are chains of returns.
#[derive(Clone, Debug)]
pub(super) struct Chains {
    pub(super) neighbours: usize,
    /// The numbers of their returns, one chain after the other.
    numbers: Vec<u32>,
    /// Of each of those, the weights of its edges to the next `neighbours` of its chain; 0 beyond the end.
    weights: Vec<f64>,
    /// The places of each chain in `numbers`.
    chains: Vec<Range<usize>>,
    /// The weights of one chain's edges from each return to the next, and `neighbours` zeros.
    links: Vec<f64>,
    /// The chain of each return, and its place in `numbers`.
    places: Vec<Option<(u32, u32)>>,
    /// Edges from one chain to another, and of returns that are left over: in both directions.
    others: Vec<(u32, u32, f64)>,
    /// The weights of one row along its chain, and the row if there are other edges in it.
    row_weights: Vec<f64>,
    row: Vec<(u32, f64)>,
}

impl Chains {
    pub(super) fn new(neighbours: usize) -> Self {
        Self {
            neighbours,
            numbers: Vec::new(),
            weights: Vec::new(),
            chains: Vec::new(),
            links: Vec::new(),
            places: Vec::new(),
            others: Vec::new(),
            row_weights: Vec::new(),
            row: Vec::new(),
        }
    }

    /// W and D of `walls` and `islands`, each a list of returns in order; walls as they follow each other around the
    /// sensor. An eigenvalue of `leak` stands for a verdict between two walls that could as well be the other.
    pub(super) fn write(
        &mut self,
        ring: &Ring,
        judge: &Judge<'_>,
        (walls, islands): (&Pieces, &Pieces),
        left_over: &[usize],
        leak: f64,
        out: &mut Affinity,
    ) {
        self.numbers.clear();
        self.weights.clear();
        self.chains.clear();
        self.others.clear();
        for chain in walls.iter().chain(islands.iter()) {
            self.tie_along(ring, judge, chain);
        }
        if leak > 0.0 {
            self.tie_across(ring, judge, walls, leak);
        }
        let on_walls = || walls.returns().iter().chain(islands.returns());
        for &i in left_over {
            let squared = on_walls().map(|&j| ((ring.position_m(j) - ring.position_m(i)).norm_squared(), j));
            if let Some((_, j)) = squared.min_by(|a, b| a.0.total_cmp(&b.0))
                && ring.distance_m(i, j) < NEAR_M
            {
                self.tie(ring, i, j, WEAK);
            }
        }
        self.write_rows(ring.len(), out);
    }

    /// Edges along a chain, as strong as its gaps were cheap to close.
    fn tie_along(&mut self, ring: &Ring, judge: &Judge<'_>, chain: &[usize]) {
        let link = |at: usize| match judge.cost(&chain[..at], &chain[at..]) {
            Some(0.0) => 1.0,
            Some(cost) => (-cost).exp(),
            None => WEAK,
        };
        self.links.clear();
        self.links.extend((1..chain.len()).map(link));
        self.links.resize(chain.len() + self.neighbours, 0.0);
        let start = self.weights.len();
        self.weights.resize(start + chain.len() * self.neighbours, 0.0);
        let rows = self.weights[start..].chunks_exact_mut(self.neighbours);
        for (weights, links) in rows.zip(self.links.windows(self.neighbours)) {
            let mut product = 1.0;
            for (weight, link) in weights.iter_mut().zip(links) {
                product *= link;
                *weight = product;
            }
        }
        let start = self.numbers.len();
        self.numbers.extend(chain.iter().map(|&i| ring.returns[i].number));
        self.chains.push(start..self.numbers.len());
    }

    /// A weak edge over each way on from one wall to the next. An edge of weight w between walls A and B makes an
    /// eigenvalue w / vol A + w / vol B on its own. That is made half of `leak`, or less, the more decided the verdict is;
    /// half, because two edges at one wall may add up.
    fn tie_across(&mut self, ring: &Ring, judge: &Judge<'_>, walls: &Pieces, leak: f64) {
        let gaps = match walls.len() {
            0 | 1 => 0,
            n if ring.full_turn => n,
            n => n - 1,
        };
        let volumes: Vec<f64> = (0..walls.len()).map(|chain| self.volume(chain)).collect();
        for at in 0..gaps {
            let next = (at + 1) % walls.len();
            let (a, b) = (&walls[at], &walls[next]);
            let eigenvalue = 0.5 * leak / judge.decidedness(a, b).powi(DECIDED_POWER);
            let weight = eigenvalue / (1.0 / volumes[at] + 1.0 / volumes[next]);
            self.tie(ring, a[a.len() - 1], b[0], weight);
        }
    }

    /// Σ D_ii over a chain, as far as it is tied to itself: each edge counts at both of its ends.
    fn volume(&self, chain: usize) -> f64 {
        let chain = self.chains[chain].clone();
        let weights = &self.weights[self.neighbours * chain.start..self.neighbours * chain.end];
        let ahead = weights.chunks_exact(self.neighbours).map(|weights| weights.iter().sum::<f64>());
        chain.len() as f64 + 2.0 * ahead.sum::<f64>()
    }

    fn tie(&mut self, ring: &Ring, i: usize, j: usize, weight: f64) {
        let [i, j] = [i, j].map(|i| ring.returns[i].number);
        self.others.extend([(i, j, weight), (j, i, weight)]);
    }

    fn write_rows(&mut self, n: usize, out: &mut Affinity) {
        self.places.clear();
        self.places.resize(n, None);
        for (chain, places) in self.chains.iter().enumerate() {
            for (at, &number) in places.clone().zip(&self.numbers[places.clone()]) {
                self.places[number as usize] = Some((chain as u32, at as u32));
            }
        }
        self.others.sort_unstable_by_key(|&(from, to, _)| (from, to));
        let mut others = self.others.iter().peekable();
        let (mut row, mut weights) = (std::mem::take(&mut self.row), std::mem::take(&mut self.row_weights));
        let csr = out.weights.make_sparse();
        out.degrees.clear();
        for (number, place) in (0..).zip(&self.places) {
            let columns = self.row_along(&number, *place, &mut weights);
            let has_others = others.peek().is_some_and(|&&(from, ..)| from == number);
            // Not so where a chain runs clockwise or over the first beam.
            if columns.is_sorted() && !has_others {
                csr.push_row(columns, &weights);
                out.degrees.push(weights.iter().sum());
                continue;
            }
            row.clear();
            row.extend(columns.iter().copied().zip(weights.iter().copied()));
            while let Some(&(_, to, weight)) = others.next_if(|&&(from, ..)| from == number) {
                row.push((to, weight));
            }
            row.sort_unstable_by_key(|&(column, _)| column);
            row.iter().for_each(|&(column, weight)| csr.push(column, weight));
            csr.end_row();
            out.degrees.push(row.iter().map(|(_, weight)| weight).sum());
        }
        (self.row, self.row_weights) = (row, weights);
    }

    /// The numbers of the returns that a return is tied to along its chain, itself among them, with the weights of those edges.
    fn row_along<'a>(&'a self, number: &'a u32, place: Option<(u32, u32)>, weights: &mut Vec<f64>) -> &'a [u32] {
        weights.clear();
        let Some((chain, at)) = place else {
            weights.push(1.0);
            return std::slice::from_ref(number);
        };
        let (chain, at, neighbours) = (&self.chains[chain as usize], at as usize, self.neighbours);
        let first = at.saturating_sub(neighbours).max(chain.start);
        let last = (at + neighbours).min(chain.end - 1);
        weights.extend((first..at).map(|from| self.weights[from * neighbours + (at - from - 1)]));
        weights.push(1.0);
        weights.extend_from_slice(&self.weights[at * neighbours..][..last - at]);
        &self.numbers[first..=last]
    }
}

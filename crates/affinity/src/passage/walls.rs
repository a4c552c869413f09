//! The graph of walls: edges along each, weaker across gaps.

use crosscut_stage::Affinity;

use super::gap::Judge;
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
    /// The weights of one chain's edges from each return to the next.
    links: Vec<f64>,
    /// The place of each return in `numbers`.
    places: Vec<Option<u32>>,
    /// Edges from one chain to another, and of returns that are left over: in both directions.
    others: Vec<(u32, u32, f64)>,
    row: Vec<(u32, f64)>,
}

impl Chains {
    pub(super) fn new(neighbours: usize) -> Self {
        let (numbers, weights, links) = (Vec::new(), Vec::new(), Vec::new());
        Self { neighbours, numbers, weights, links, places: Vec::new(), others: Vec::new(), row: Vec::new() }
    }

    /// W and D of `walls` and `islands`, each a list of returns in order; walls as they follow each other around the
    /// sensor. An eigenvalue of `leak` stands for a verdict between two walls that could as well be the other.
    pub(super) fn write(
        &mut self,
        ring: &Ring,
        judge: &Judge<'_>,
        (walls, islands): (&[Vec<usize>], &[Vec<usize>]),
        left_over: &[usize],
        leak: f64,
        out: &mut Affinity,
    ) {
        self.numbers.clear();
        self.weights.clear();
        self.others.clear();
        for chain in walls.iter().chain(islands) {
            self.tie_along(ring, judge, chain);
        }
        if leak > 0.0 {
            self.tie_across(ring, judge, walls, leak);
        }
        let on_walls = || walls.iter().chain(islands).flatten();
        for &i in left_over {
            let squared = on_walls().map(|&j| ((ring.place_m(j) - ring.place_m(i)).norm_squared(), j));
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
        let link = |at: usize| judge.cost(&chain[..at], &chain[at..]).map_or(WEAK, |cost| (-cost).exp());
        self.links.clear();
        self.links.extend((1..chain.len()).map(link));
        for (at, &i) in chain.iter().enumerate() {
            self.numbers.push(ring.returns[i].number);
            let row_end = self.weights.len() + self.neighbours;
            let mut weight = 1.0;
            self.weights.extend(self.links[at..].iter().take(self.neighbours).map(|link| {
                weight *= link;
                weight
            }));
            self.weights.resize(row_end, 0.0);
        }
    }

    /// A weak edge over each way on from one wall to the next. An edge of weight w between walls A and B makes an
    /// eigenvalue w / vol A + w / vol B on its own. That is made half of `leak`, or less, the more decided the verdict is;
    /// half, because two edges at one wall may add up.
    fn tie_across(&mut self, ring: &Ring, judge: &Judge<'_>, walls: &[Vec<usize>], leak: f64) {
        let gaps = match walls.len() {
            0 | 1 => 0,
            n if ring.full_turn => n,
            n => n - 1,
        };
        let mut start = 0;
        let volume = |wall: &Vec<usize>| {
            let chain = start..start + wall.len();
            start = chain.end;
            self.volume(chain)
        };
        let volumes: Vec<f64> = walls.iter().map(volume).collect();
        for at in 0..gaps {
            let next = (at + 1) % walls.len();
            let (a, b) = (&walls[at], &walls[next]);
            let eigenvalue = 0.5 * leak / judge.decidedness(a, b).powi(DECIDED_POWER);
            let weight = eigenvalue / (1.0 / volumes[at] + 1.0 / volumes[next]);
            self.tie(ring, a[a.len() - 1], b[0], weight);
        }
    }

    /// Σ D_ii over a chain, by its places, as far as it is tied to itself.
    fn volume(&self, chain: std::ops::Range<usize>) -> f64 {
        let degree = |at: usize| 1.0 + self.before(at).chain(self.after(at)).map(|(_, weight)| weight).sum::<f64>();
        chain.map(degree).sum()
    }

    /// The numbers of the returns before a place in its chain, nearest last, with the weights of their edges.
    fn before(&self, at: usize) -> impl Iterator<Item = (u32, f64)> {
        let first = at.saturating_sub(self.neighbours);
        let edge = move |from: usize| (self.numbers[from], self.weights[from * self.neighbours + (at - from - 1)]);
        (first..at).map(edge).filter(|&(_, weight)| weight > 0.0)
    }

    /// The same of those after it, nearest first.
    fn after(&self, at: usize) -> impl Iterator<Item = (u32, f64)> {
        let weights = &self.weights[at * self.neighbours..][..self.neighbours];
        let edges = self.numbers[at + 1..].iter().copied().zip(weights.iter().copied());
        edges.filter(|&(_, weight)| weight > 0.0)
    }

    fn tie(&mut self, ring: &Ring, i: usize, j: usize, weight: f64) {
        let [i, j] = [i, j].map(|i| ring.returns[i].number);
        self.others.extend([(i, j, weight), (j, i, weight)]);
    }

    fn write_rows(&mut self, n: usize, out: &mut Affinity) {
        self.places.clear();
        self.places.resize(n, None);
        for (at, &number) in self.numbers.iter().enumerate() {
            self.places[number as usize] = Some(at as u32);
        }
        self.others.sort_unstable_by_key(|&(from, to, _)| (from, to));
        let mut others = self.others.iter().peekable();
        let csr = out.weights.make_sparse();
        out.degrees.clear();
        let mut row = std::mem::take(&mut self.row);
        for number in 0..n as u32 {
            row.clear();
            match self.places[number as usize].map(|at| at as usize) {
                Some(at) => {
                    self.before(at).for_each(|edge| row.push(edge));
                    row.push((number, 1.0));
                    self.after(at).for_each(|edge| row.push(edge));
                }
                None => row.push((number, 1.0)),
            }
            while let Some(&(_, to, weight)) = others.next_if(|&&(from, ..)| from == number) {
                row.push((to, weight));
            }
            // Not so where a chain runs clockwise or over the first beam, and with other edges.
            if !row.is_sorted_by_key(|&(column, _)| column) {
                row.sort_unstable_by_key(|&(column, _)| column);
            }
            csr.push_row(&row);
            out.degrees.push(row.iter().map(|(_, weight)| weight).sum());
        }
        self.row = row;
    }
}

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

/// Writes W; holds its buffers.
#[derive(Clone, Debug)]
pub(super) struct Chains {
    pub(super) neighbours: usize,
    rows: Vec<Vec<(u32, f64)>>,
}

impl Chains {
    pub(super) fn new(neighbours: usize) -> Self {
        Self { neighbours, rows: Vec::new() }
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
        let n = ring.len();
        self.rows.iter_mut().for_each(Vec::clear);
        self.rows.resize_with(n.max(self.rows.len()), Vec::new);
        for i in 0..n {
            self.tie(ring, i, i, 1.0);
        }
        for wall in walls.iter().chain(islands) {
            self.tie_along(ring, judge, wall);
        }
        if leak > 0.0 {
            self.tie_across(ring, judge, walls, leak);
        }
        let on_walls = || walls.iter().chain(islands).flatten();
        for &i in left_over {
            let nearest = on_walls().map(|&j| (ring.distance_m(i, j), j));
            if let Some((distance_m, j)) = nearest.min_by(|a, b| a.0.total_cmp(&b.0))
                && distance_m < NEAR_M
            {
                self.tie(ring, i, j, WEAK);
                self.tie(ring, j, i, WEAK);
            }
        }
        self.write_rows(n, out);
    }

    /// Edges along a wall, as strong as its gaps were cheap to close.
    fn tie_along(&mut self, ring: &Ring, judge: &Judge<'_>, wall: &[usize]) {
        let link = |at: usize| judge.cost(&wall[..at], &wall[at..]).map_or(WEAK, |cost| (-cost).exp());
        let links: Vec<f64> = (1..wall.len()).map(link).collect();
        for (at, &i) in wall.iter().enumerate() {
            let mut weight = 1.0;
            for (&j, link) in wall[at + 1..].iter().zip(&links[at..]).take(self.neighbours) {
                weight *= link;
                self.tie(ring, i, j, weight);
                self.tie(ring, j, i, weight);
            }
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
        let volumes: Vec<f64> = walls.iter().map(|wall| self.volume(ring, wall)).collect();
        for at in 0..gaps {
            let next = (at + 1) % walls.len();
            let (a, b) = (&walls[at], &walls[next]);
            let eigenvalue = 0.5 * leak / judge.decidedness(a, b).powi(DECIDED_POWER);
            let weight = eigenvalue / (1.0 / volumes[at] + 1.0 / volumes[next]);
            let (p, q) = (a[a.len() - 1], b[0]);
            self.tie(ring, p, q, weight);
            self.tie(ring, q, p, weight);
        }
    }

    /// Σ D_ii over a wall, as far as it is tied.
    fn volume(&self, ring: &Ring, wall: &[usize]) -> f64 {
        let rows = wall.iter().map(|&i| &self.rows[ring.returns[i].number as usize]);
        rows.flatten().map(|(_, weight)| weight).sum()
    }

    fn tie(&mut self, ring: &Ring, i: usize, j: usize, weight: f64) {
        self.rows[ring.returns[i].number as usize].push((ring.returns[j].number, weight));
    }

    fn write_rows(&mut self, n: usize, out: &mut Affinity) {
        let csr = out.weights.make_sparse();
        out.degrees.clear();
        for row in &mut self.rows[..n] {
            row.sort_unstable_by_key(|&(column, _)| column);
            let mut degree = 0.0;
            for &(column, weight) in row.iter() {
                csr.push(column, weight);
                degree += weight;
            }
            csr.end_row();
            out.degrees.push(degree);
        }
    }
}

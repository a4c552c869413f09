//! The graph of walls: edges along each, weaker across gaps.

use crosscut_stage::Affinity;

use super::ring::Ring;

/// A return that no wall was found for goes to the nearest wall, if it is no farther than this.
const NEAR_M: f64 = 3.0;
/// The weight of that edge, and of a gap that was joined against its direction.
const WEAK: f64 = 0.1;

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

    /// W and D of `walls`, each a list of returns in order. `cost` is that of a wall going on from one part to the next.
    pub(super) fn write(
        &mut self,
        ring: &Ring,
        walls: &[Vec<usize>],
        left_over: &[usize],
        cost: impl Fn(&[usize], &[usize]) -> Option<f64>,
        out: &mut Affinity,
    ) {
        let n = ring.len();
        self.rows.iter_mut().for_each(Vec::clear);
        self.rows.resize_with(n.max(self.rows.len()), Vec::new);
        for i in 0..n {
            self.tie(ring, i, i, 1.0);
        }
        for wall in walls {
            let links: Vec<f64> =
                (1..wall.len()).map(|at| cost(&wall[..at], &wall[at..]).map_or(WEAK, |cost| (-cost).exp())).collect();
            for (at, &i) in wall.iter().enumerate() {
                let mut weight = 1.0;
                for (&j, link) in wall[at + 1..].iter().zip(&links[at..]).take(self.neighbours) {
                    weight *= link;
                    self.tie(ring, i, j, weight);
                    self.tie(ring, j, i, weight);
                }
            }
        }
        for &i in left_over {
            let on_walls = walls.iter().flatten().map(|&j| (ring.distance_m(i, j), j));
            if let Some((distance_m, j)) = on_walls.min_by(|a, b| a.0.total_cmp(&b.0))
                && distance_m < NEAR_M
            {
                self.tie(ring, i, j, WEAK);
                self.tie(ring, j, i, WEAK);
            }
        }
        self.write_rows(n, out);
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

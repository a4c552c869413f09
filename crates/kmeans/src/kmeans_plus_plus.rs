//! `kmeans++`: the last step of the paper's Algorithm 1.

use crosscut_stage::NoteCode::{N074, N075};
use crosscut_stage::{Count, Kind, KmeansStage, Notes, Number, ParamSpec, Params, Partition, Spectrum, StageError};
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::lloyd::Lloyd;
use crate::no_zeros::without_clusters;
use crate::numbering::by_first_return;
use crate::row_distances::RowDistances;
use crate::rows::Rows;
use crate::seeding::{Seeding, draws};

const SEED: Count =
    Count::new("seed", "", 0).to(u32::MAX).doc("where the random numbers start, again for every revolution");

const RESTARTS: Count =
    Count::new("restarts", "", 10).from(1).to(1000).doc("how often the centres are seeded; the best result is kept");

const MAX_ITERATIONS: Count = Count::new("max_iterations", "", 300)
    .from(1)
    .to(100_000)
    .doc("iterations after which one restart ends, settled or not");

const TOLERANCE: Number = Number::new("tolerance", "of the mean variance of U's columns", 0.0)
    .from(0.0)
    .to(1.0)
    .doc("a restart ends when the squared steps of all centres sum to no more than this; 0: when no label changes");

const PARAMS: &[ParamSpec] = &[SEED.spec, RESTARTS.spec, MAX_ITERATIONS.spec, TOLERANCE.spec];

/// The paper's k-means.
pub const KIND: Kind<dyn KmeansStage> =
    Kind::kmeans("kmeans++", "k-means++ on the rows of U, not normalised, as in the paper", |params| {
        Box::new(KmeansPlusPlus::new(params))
    })
    .params(PARAMS);

/// k-means on the rows of U: k-means++ seeding, Lloyd's iteration, several restarts, of which the one with the smallest
/// objective is kept (the first of equals). Random numbers: PCG XSL 128/64, from the seed again at every call.
///
/// Fewer distinct rows than k give as many clusters as there are distinct rows, with a note. k = 0 leaves every return
/// without a cluster. Turning U changes no label but by rounding; returns in another order are other random draws.
#[derive(Clone, Debug)]
pub(crate) struct KmeansPlusPlus {
    seed: u64,
    restarts: usize,
    max_iterations: usize,
    tolerance: f64,
    rows: Rows,
    distances: RowDistances,
    seeding: Seeding,
    lloyd: Lloyd,
    best: Lloyd,
}

impl Default for KmeansPlusPlus {
    fn default() -> Self {
        Self::new(&Params::defaults(PARAMS))
    }
}

impl KmeansPlusPlus {
    fn new(params: &Params) -> Self {
        Self {
            seed: params.get(SEED) as u64,
            restarts: params.get(RESTARTS),
            max_iterations: params.get(MAX_ITERATIONS),
            tolerance: params.get(TOLERANCE),
            rows: Rows::default(),
            distances: RowDistances::default(),
            seeding: Seeding::default(),
            lloyd: Lloyd::default(),
            best: Lloyd::default(),
        }
    }

    /// Leaves the restart with the smallest objective in `self.best`; n and k > 0.
    fn restart(&mut self, notes: &mut Notes) {
        let mut rng = Pcg64::seed_from_u64(self.seed);
        let still = self.tolerance * self.rows.mean_variance();
        let k = self.rows.dimension();
        self.distances.begin(&self.rows, self.restarts * k * draws(k));
        let mut least = None;
        for _ in 0..self.restarts {
            let chosen = self.seeding.choose(&self.rows, &mut self.distances, &mut rng);
            self.lloyd.start_at(&self.rows, &mut self.distances, &chosen);
            let settled = self.lloyd.run(&self.rows, self.max_iterations, still);
            let inertia = self.lloyd.inertia();
            if least.is_none_or(|(least, _)| inertia < least) {
                least = Some((inertia, settled));
                std::mem::swap(&mut self.best, &mut self.lloyd);
            }
            // No restart beats 0, and one cluster comes out the same each time.
            if inertia == 0.0 || k == 1 {
                break;
            }
        }
        if let Some((_, false)) = least {
            notes.add(
                N074,
                format!("k-means: the best restart had not settled after {} iterations", self.max_iterations),
            );
        }
    }
}

impl KmeansStage for KmeansPlusPlus {
    fn partition(&mut self, spectrum: &Spectrum, out: &mut Partition, notes: &mut Notes) -> Result<(), StageError> {
        self.rows.copy_from(spectrum)?;
        let (n, k) = (self.rows.len(), self.rows.dimension());
        if n == 0 || k == 0 {
            without_clusters(n, k, out, notes);
            return Ok(());
        }
        self.restart(notes);
        let Lloyd { centroids, labels, .. } = &self.best;
        let numbers = by_first_return(labels.iter().copied(), centroids.len() / k);
        out.labels.clear();
        out.labels.extend(labels.iter().map(|&label| numbers[label as usize]));
        out.clusters = numbers.iter().flatten().count();
        out.inertia = self.best.inertia();
        let ordered = out.centroids.make_dense(out.clusters, k);
        for (number, centroid) in numbers.iter().zip(centroids.chunks_exact(k)) {
            if let Some(number) = number {
                for (j, &x) in centroid.iter().enumerate() {
                    ordered[(*number as usize, j)] = x;
                }
            }
        }
        if out.clusters < k {
            notes.add(N075, format!("k-means: only {} distinct rows of U for k = {k}", out.clusters));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::rows::SQUARES;

    const RETURNS: usize = 340;
    const WALLS: usize = 4;

    /// U of four walls of one size, and of this many returns that are each a component of its own.
    fn walls_and(alone: usize) -> Spectrum {
        let (k, returns) = (WALLS + alone, RETURNS - alone);
        let column = |i: usize| if i < returns { i * WALLS / returns } else { WALLS + i - returns };
        let degree = |i: usize| 2.0 + (i as f64).sin();
        let volume = |c: usize| (0..RETURNS).filter(|&i| column(i) == c).map(degree).sum::<f64>();
        let volumes: Vec<f64> = (0..k).map(volume).collect();
        let entry = |i: usize, c: usize| if column(i) == c { (degree(i) / volumes[c]).sqrt() } else { 0.0 };
        Spectrum { k, u: Mat::from_fn(RETURNS, k, entry).into(), ..Spectrum::default() }
    }

    /// The partition, and the squares in all distances that it takes.
    fn partition(spectrum: &Spectrum) -> (Partition, u64) {
        let (mut out, before) = (Partition::default(), SQUARES.get());
        KmeansPlusPlus::default().partition(spectrum, &mut out, &mut Notes::default()).expect("a sound U");
        (out, SQUARES.get() - before)
    }

    #[test]
    fn many_zeros_cost_less_than_a_hundred_usual_scans() {
        let (_, usual) = partition(&walls_and(0));
        for alone in [20, 85, 170, 255, RETURNS - WALLS] {
            let (found, squares) = partition(&walls_and(alone));
            assert!(squares < 100 * usual, "{alone}: {squares}, and {usual} of four walls");
            let labels: Vec<_> = found.labels.iter().flatten().collect();
            assert_eq!((found.clusters, labels.len()), (WALLS + alone, RETURNS));
        }
    }
}

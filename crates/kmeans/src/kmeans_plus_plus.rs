//! `kmeans++`: the last step of the paper's Algorithm 1.

use crosscut_stage::NoteCode::{N074, N075};
use crosscut_stage::{Count, Kind, KmeansStage, Notes, ParamSpec, Params, Partition, Spectrum, StageError};
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::lloyd::Lloyd;
use crate::no_zeros::without_clusters;
use crate::numbering::by_first_return;
use crate::rows::Rows;
use crate::seeding::Seeding;

const SEED: Count =
    Count::new("seed", "", 0).to(u32::MAX).doc("where the random numbers start, again for every revolution");

const RESTARTS: Count =
    Count::new("restarts", "", 10).from(1).to(1000).doc("how often the centres are seeded; the best result is kept");

const MAX_ITERATIONS: Count = Count::new("max_iterations", "", 300)
    .from(1)
    .to(100_000)
    .doc("iterations after which one restart ends, settled or not");

const PARAMS: &[ParamSpec] = &[SEED.spec, RESTARTS.spec, MAX_ITERATIONS.spec];

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
    rows: Rows,
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
            rows: Rows::default(),
            seeding: Seeding::default(),
            lloyd: Lloyd::default(),
            best: Lloyd::default(),
        }
    }

    /// Leaves the restart with the smallest objective in `self.best`; n and k > 0.
    fn restart(&mut self, notes: &mut Notes) {
        let mut rng = Pcg64::seed_from_u64(self.seed);
        let mut least = None;
        for _ in 0..self.restarts {
            self.lloyd.start_at(&self.rows, &self.seeding.choose(&self.rows, &mut rng));
            let settled = self.lloyd.run(&self.rows, self.max_iterations);
            let inertia = self.lloyd.inertia();
            if least.is_none_or(|(least, _)| inertia < least) {
                least = Some((inertia, settled));
                std::mem::swap(&mut self.best, &mut self.lloyd);
            }
            // No restart beats 0, and one cluster comes out the same each time.
            if inertia == 0.0 || self.rows.dimension() == 1 {
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
        out.centroids.resize_with(out.clusters, k, |_, _| 0.0);
        for (number, centroid) in numbers.iter().zip(centroids.chunks_exact(k)) {
            if let Some(number) = number {
                for (j, &x) in centroid.iter().enumerate() {
                    out.centroids[(*number as usize, j)] = x;
                }
            }
        }
        if out.clusters < k {
            notes.add(N075, format!("k-means: only {} distinct rows of U for k = {k}", out.clusters));
        }
        Ok(())
    }
}

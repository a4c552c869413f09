//! `components`: the zero eigenvalues without a decomposition, of the graph without its weak edges.
//!
//! The components of the graph, by union-find. Every weight of at least 1e-4 is an edge; weaker ones
//! are not there, in L as well.
//!
//! That L has the eigenvalue 0 once for each component C, with the eigenvector D^1/2 1_C / ‖D^1/2 1_C‖: these are U,
//! components in the order of their first return. Nothing else is computed: `eigenvalues` holds the k exact zeros without
//! the next one, so that there is no margin, and `tolerance` is the smallest normal number, which any positive number
//! could replace.

use crosscut_stage::{Affinity, DisjointSets, Eigenvalues, Kind, Notes, SpectralStage, Spectrum, StageError};

use crate::degrees::{check_degrees, sum_volumes};
use crate::embedding::make_zero;

/// An edge of a smaller weight is none, as the weak edges of affinity `passage` are, and those of `rbf` over 2.5 m.
const LEAST_WEIGHT: f64 = 1e-4;

/// Union-find in place of a decomposition.
pub const KIND: Kind<dyn SpectralStage> = Kind::spectral(
    "components",
    "the zero eigenvalues alone, exact: one for each connected component of the edges that are not weak (baseline)",
    |_| Box::new(ComponentZeros::default()),
)
.eigenvalues(Eigenvalues::Zeros)
.stays_sparse();

#[derive(Default)]
struct ComponentZeros {
    sets: DisjointSets,
    /// Σ of the edges at each return.
    degrees: Vec<f64>,
    /// Σ D_ii over the component of each number.
    volumes: Vec<f64>,
}

impl ComponentZeros {
    /// Joins the returns of each edge, and sums the edges at each return.
    fn follow_edges(&mut self, affinity: &Affinity) -> Result<(), StageError> {
        let Self { sets, degrees, .. } = self;
        let n = affinity.weights.n();
        sets.reset(n);
        degrees.clear();
        degrees.resize(n, 0.0);
        let mut not_finite = None;
        affinity.weights.for_each(|i, j, weight| {
            if !weight.is_finite() {
                not_finite.get_or_insert(i);
            } else if weight >= LEAST_WEIGHT {
                sets.join(i, j);
                degrees[i] += weight;
            }
        });
        not_finite.map_or(Ok(()), |index| Err(StageError::NotFinite { what: "the affinity", index }))
    }
}

impl SpectralStage for ComponentZeros {
    fn spectrum(&mut self, affinity: &Affinity, out: &mut Spectrum, _: &mut Notes) -> Result<(), StageError> {
        check_degrees(affinity)?;
        self.follow_edges(affinity)?;
        let Self { sets, degrees, volumes, .. } = self;
        let component_of_return = sets.number_components();
        sum_volumes(component_of_return, degrees, volumes);

        out.k = volumes.len();
        out.eigenvalues.clear();
        out.eigenvalues.resize(out.k, 0.0);
        (out.tolerance, out.margin_decades) = (f64::MIN_POSITIVE, None);
        make_zero(&mut out.u, degrees.len(), out.k)?;
        for (i, (degree, &component)) in degrees.iter().zip(component_of_return).enumerate() {
            out.u[(i, component as usize)] = (degree / volumes[component as usize]).sqrt();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;

    fn k(weights: [f64; 3]) -> usize {
        let mut affinity = Affinity::default();
        let w = affinity.weights.make_dense(4);
        w.fill(0.0);
        w.diagonal_mut().fill(1.0);
        for (i, weight) in weights.into_iter().enumerate() {
            let j = i + 1;
            (w[(i, j)], w[(j, i)]) = (weight, weight);
        }
        affinity.sum_degrees();
        let mut out = Spectrum::default();
        let mut stage = KIND.with(&[]).expect("no parameters");
        stage.spectrum(&affinity, &mut out, &mut Notes::default()).expect("a sound affinity");
        let u = &out.u;
        assert!((u.transpose() * u - Mat::<f64>::identity(out.k, out.k)).norm_max() < 1e-15, "UᵀU = I: {u:?}");
        out.k
    }

    #[test]
    fn a_weak_edge_joins_no_components() {
        let of_path = [[0.5, 1e-7, 0.5], [0.5, 1e-4, 0.5], [1e-9, 1e-7, 0.0]];
        assert_eq!(of_path.map(k), [2, 1, 4]);
    }
}

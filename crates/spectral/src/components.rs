//! `components`: the zero eigenvalues without a decomposition, of the graph without its weak edges.
//!
//! The components of the graph, by union-find. Every weight of at least `least_weight` is an edge; weaker ones, and those
//! of 0, are not there, in L as well.
//!
//! That L has the eigenvalue 0 once for each component C, with the eigenvector D^1/2 1_C / ‖D^1/2 1_C‖: these are U,
//! components in the order of their first return. Nothing else is computed: `eigenvalues` holds the k exact zeros without
//! the next one, so that there is no margin, and `tolerance` is the smallest normal number, which any positive number
//! could replace.

use crosscut_stage::{Affinity, DisjointSets, Eigenvalues, Kind, Notes, Number, SpectralStage, Spectrum, StageError};

use crate::degrees::{check_degrees, sum_volumes};

const LEAST_WEIGHT: Number = Number::new("least_weight", "", 1e-4)
    .from(0.0)
    .to(1.0)
    .follows("affinity.leak", 1e4)
    .doc("an edge of less is none, as the leaks of preset default are, and returns 2.5 m apart by rbf; 0: every weight is one");

/// Union-find in place of a decomposition.
pub const KIND: Kind<dyn SpectralStage> = Kind::spectral(
    "components",
    "the zero eigenvalues alone, exact: one for each connected component of the edges that are not weak (baseline)",
    |params| Box::new(Components { least_weight: params.get(LEAST_WEIGHT), ..Components::default() }),
)
.params(&[LEAST_WEIGHT.spec])
.eigenvalues(Eigenvalues::Zeros)
.stays_sparse();

#[derive(Default)]
struct Components {
    least_weight: f64,
    sets: DisjointSets,
    /// Σ of the edges at each return.
    degrees: Vec<f64>,
    /// Σ D_ii over the component of each number.
    volumes: Vec<f64>,
}

impl Components {
    /// Joins the returns of each edge, and sums the edges at each return.
    fn follow_edges(&mut self, affinity: &Affinity) -> Result<(), StageError> {
        let Self { least_weight, sets, degrees, .. } = self;
        let n = affinity.weights.n();
        sets.reset(n);
        degrees.clear();
        degrees.resize(n, 0.0);
        let mut not_finite = None;
        affinity.weights.for_each(|i, j, weight| {
            if !weight.is_finite() {
                not_finite.get_or_insert(i);
            } else if weight >= *least_weight && weight != 0.0 {
                sets.join(i, j);
                degrees[i] += weight;
            }
        });
        not_finite.map_or(Ok(()), |index| Err(StageError::NotFinite { what: "the affinity", index }))
    }
}

impl SpectralStage for Components {
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
        out.u.write_rows(degrees.len(), out.k, |i, row| {
            let component = component_of_return[i];
            row.push((component, (degrees[i] / volumes[component as usize]).sqrt()));
        });
        Ok(())
    }

    fn memory_bytes(&self, n: usize, _: usize) -> u64 {
        // A parent, a degree and at most one volume a return.
        (n as u64).saturating_mul(4 + 8 + 8)
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;

    fn k(least_weight: f64) -> usize {
        // 0 and 1 are one wall, 2 and 3 another; the two leak.
        let mut affinity = Affinity::default();
        let w = affinity.weights.make_dense(4);
        w.fill(0.0);
        w.diagonal_mut().fill(1.0);
        for (i, j, weight) in [(0, 1, 0.5), (1, 2, 1e-7), (2, 3, 0.5)] {
            (w[(i, j)], w[(j, i)]) = (weight, weight);
        }
        affinity.sum_degrees();
        let mut out = Spectrum::default();
        let mut stage = KIND.with(&[("least_weight", least_weight.into())]).expect("a weight");
        stage.spectrum(&affinity, &mut out, &mut Notes::default()).expect("a sound affinity");
        let u = out.u.to_dense();
        assert!((u.transpose() * &u - Mat::<f64>::identity(out.k, out.k)).norm_max() < 1e-15, "UᵀU = I: {u:?}");
        out.k
    }

    #[test]
    fn a_weak_edge_joins_no_components_unless_every_weight_is_an_edge() {
        assert_eq!((k(1e-4), k(0.0), k(0.6)), (2, 1, 4));
    }

    #[test]
    fn a_least_weight_that_is_none_is_refused() {
        let is_refused = |weight: f64| KIND.with(&[("least_weight", weight.into())]).is_err();
        assert!([-1e-9, 1.1, f64::NAN].into_iter().all(is_refused));
    }
}

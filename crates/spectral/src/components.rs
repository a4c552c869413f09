//! `components`: the zero eigenvalues without a decomposition, for 0/1 graphs.

use crosscut_stage::{Affinity, Kind, Notes, SpectralStage, Spectrum, StageError};

use crate::degrees::check_degrees;
use crate::forest::Forest;

pub(crate) const KIND: Kind<dyn SpectralStage> = Kind {
    name: "components",
    doc: "the zero eigenvalues alone, exact: one for each connected component, however weak its edges (baseline)",
    params: &[],
    build: |_| Box::new(Components::default()),
};

/// The components of the graph, by union-find. Every weight that is not 0 is an edge.
///
/// L has the eigenvalue 0 once for each component C, with the eigenvector D^1/2 1_C / ‖D^1/2 1_C‖: these are U,
/// components in the order of their first return. Nothing else is computed: `eigenvalues` holds the k exact zeros
/// without the next one, so that there is no margin, and `tolerance` is the smallest normal number, which any positive
/// number could replace.
#[derive(Clone, Debug, Default)]
pub struct Components {
    forest: Forest,
    /// Σ D_ii over the component of each number.
    volumes: Vec<f64>,
}

impl SpectralStage for Components {
    fn spectrum(&mut self, affinity: &Affinity, out: &mut Spectrum, _: &mut Notes) -> Result<(), StageError> {
        check_degrees(affinity)?;
        let n = affinity.degrees.len();
        let component_of_return = self.forest.components(&affinity.weights)?;
        self.volumes.clear();
        for (&component, &degree) in component_of_return.iter().zip(&affinity.degrees) {
            match self.volumes.get_mut(component as usize) {
                Some(volume) => *volume += degree,
                None => self.volumes.push(degree), // components appear in the order of their numbers
            }
        }

        out.k = self.volumes.len();
        out.eigenvalues.clear();
        out.eigenvalues.resize(out.k, 0.0);
        (out.tolerance, out.margin_decades) = (f64::MIN_POSITIVE, None);
        (out.zeros_bound, out.span_bound) = (0.0, 0.0);
        out.u.write_rows(n, out.k, |i, row| {
            let component = component_of_return[i];
            row.push((component, (affinity.degrees[i] / self.volumes[component as usize]).sqrt()));
        });
        Ok(())
    }

    fn memory_bytes(&self, n: usize, _: usize) -> u64 {
        // A parent and at most one volume a return.
        (n as u64).saturating_mul(4 + 8)
    }
}

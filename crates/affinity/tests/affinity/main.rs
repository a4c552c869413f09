//! Every affinity against values worked out by hand, and what all of them promise.

mod breakpoint;
mod conformance;
mod passage;
mod rbf;
mod threshold;

use crosscut_stage::Affinity;

/// The smallest return of the component of each return, by the edges above this weight.
fn components(affinity: &Affinity, above: f64) -> Vec<usize> {
    let mut smallest: Vec<usize> = (0..affinity.degrees.len()).collect();
    loop {
        let before = smallest.clone();
        affinity.weights.for_each(|i, j, weight| {
            if weight > above {
                smallest[i] = smallest[i].min(smallest[j]);
            }
        });
        if smallest == before {
            return smallest;
        }
    }
}

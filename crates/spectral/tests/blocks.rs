//! What `blocks` does beyond the shared tests: it needs no full decomposition for the graphs that it is made for.

use crosscut_spectral::{Blocks, NalgebraEvd, ZeroRule};
use crosscut_stage::{Affinity, Notes, SpectralStage, Spectrum};

/// Chains of the given lengths, each node tied to the `reach` next ones; nodes of all chains in one shuffled order.
fn chains(lengths: &[usize], reach: usize) -> Affinity {
    let n: usize = lengths.iter().sum();
    let starts = lengths.iter().scan(0, |sum, length| Some(std::mem::replace(sum, *sum + length)));
    let chain_of: Vec<(usize, usize)> =
        starts.zip(lengths).flat_map(|(start, length)| (0..*length).map(move |_| (start, start + length))).collect();
    let mut affinity = Affinity::default();
    let w = affinity.weights.make_dense(n);
    w.fill(0.0);
    let place = |i: usize| i * 7 % n; // a permutation, as 7 does not divide n
    for i in 0..n {
        for j in i..(i + reach + 1).min(chain_of[i].1) {
            let weight = if i == j { 1.0 } else { 0.3 + 0.1 * ((i + 2 * j) % 7) as f64 };
            (w[(place(i), place(j))], w[(place(j), place(i))]) = (weight, weight);
        }
    }
    let degrees = (0..n).map(|j| w.col(j).iter().sum()).collect();
    affinity.degrees = degrees;
    affinity
}

fn spectrum(stage: &mut dyn SpectralStage, affinity: &Affinity) -> (Spectrum, usize) {
    let (mut out, mut notes) = (Spectrum::default(), Notes::default());
    stage.spectrum(affinity, &mut out, &mut notes).expect("a sound affinity");
    (out, notes.iter().len())
}

#[test]
fn chains_need_no_full_decomposition_and_the_next_eigenvalue_is_that_of_one() {
    for (lengths, reach) in [(&[150, 91, 1, 60][..], 4), (&[40, 2, 3], 1), (&[299], 4)] {
        let affinity = chains(lengths, reach);
        let rule = ZeroRule::Tolerance(1e-8);
        let (found, notes) = spectrum(&mut Blocks::new(rule).expect("allowed"), &affinity);
        let (all, _) = spectrum(&mut NalgebraEvd::new(rule).expect("allowed"), &affinity);
        assert_eq!((found.k, notes), (lengths.len(), 0), "{lengths:?}");
        let (next, expected) = (found.eigenvalues[found.k], all.eigenvalues[all.k]);
        assert!((next - expected).abs() < 1e-13, "{lengths:?}: {next} is {expected} by full decomposition");
    }
}

#[test]
fn a_second_eigenvalue_below_the_tolerance_counts_as_zero_and_is_noted() {
    let mut affinity = chains(&[20, 21], 2);
    let w = affinity.weights.make_dense(41);
    (w[(0, 40)], w[(40, 0)]) = (1e-10, 1e-10); // places of both chains
    let rule = ZeroRule::Tolerance(1e-8);
    let (found, notes) = spectrum(&mut Blocks::new(rule).expect("allowed"), &affinity);
    assert_eq!((found.k, notes), (2, 1), "{:?}", found.eigenvalues);
}

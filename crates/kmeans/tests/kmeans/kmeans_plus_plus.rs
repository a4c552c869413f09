//! `kmeans++` against every possible partition, and its stated rules.

use crosscut_conformance::for_many;
use crosscut_kmeans::kmeans_plus_plus::KIND;
use crosscut_stage::{Notes, Partition, Spectrum};
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::embeddings::{arbitrary, spectrum};

fn run(seed: u32, restarts: u32, max_iterations: u32, spectrum: &Spectrum) -> (Partition, Notes) {
    let (mut out, mut notes) = (Partition::default(), Notes::default());
    let values = [("seed", seed), ("restarts", restarts), ("max_iterations", max_iterations)];
    let mut stage = KIND.with(&values.map(|(name, value)| (name, value.into()))).expect("in range");
    stage.partition(spectrum, &mut out, &mut notes).expect("finite");
    (out, notes)
}

/// The smallest objective over all kⁿ assignments of n rows to k clusters.
fn smallest_inertia(spectrum: &Spectrum) -> f64 {
    let (n, k) = (spectrum.u.nrows(), spectrum.k);
    (0..k.pow(n as u32)).map(|code| inertia_of(spectrum, code)).fold(f64::INFINITY, f64::min)
}

/// The objective of the assignment whose digits to the base k are `code`: the spread of each cluster about its mean.
fn inertia_of(spectrum: &Spectrum, code: usize) -> f64 {
    let (n, k) = (spectrum.u.nrows(), spectrum.k);
    let cluster = |i: usize| code / k.pow(i as u32) % k;
    let spread = |c: usize, j: usize| {
        let members = || (0..n).filter(move |&i| cluster(i) == c).map(move |i| spectrum.u[(i, j)]);
        let mean = members().sum::<f64>() / members().count() as f64;
        members().map(|x| (x - mean).powi(2)).sum::<f64>()
    };
    (0..k).flat_map(|c| (0..k).map(move |j| (c, j))).map(|(c, j)| spread(c, j)).sum()
}

#[test]
fn no_partition_of_a_few_returns_is_better() {
    for_many("kmeans++", 60, &arbitrary(1..7), |spectrum| {
        let (found, optimum) = (run(0, 50, 300, &spectrum).0.inertia, smallest_inertia(&spectrum));
        assert!((found - optimum).abs() <= 1e-12, "{found}, but {optimum} can be had");
    });
}

#[test]
fn no_return_is_nearer_to_another_centroid_than_its_own() {
    for_many("kmeans++", 100, &arbitrary(1..40), |spectrum| {
        let partition = run(0, 10, 300, &spectrum).0;
        for (i, label) in partition.labels.iter().enumerate() {
            let offset = |c: usize, j: usize| spectrum.u[(i, j)] - partition.centroids[(c, j)];
            let distance = |c: usize| (0..spectrum.k).map(|j| offset(c, j).powi(2)).sum::<f64>();
            let own = distance(label.expect("every return has a cluster") as usize);
            let nearest = (0..partition.clusters).map(distance).fold(f64::INFINITY, f64::min);
            assert!(own <= nearest, "return {i} is in cluster {label:?}");
        }
    });
}

/// Twelve tight blobs, the corners of a 4×3 grid in the first two coordinates.
fn blobs() -> Spectrum {
    spectrum(Mat::from_fn(120, 12, |i, j| {
        let jitter = 0.01 * ((i * 7919 + j * 104_729) % 101) as f64 / 101.0;
        match j {
            0 => (i % 4) as f64 + jitter,
            1 => (i % 12 / 4) as f64 + jitter,
            _ => jitter,
        }
    }))
}

#[test]
fn well_separated_blobs_are_told_apart_from_every_seed() {
    let expected: Vec<_> = (0..120).map(|i| Some(i % 12)).collect();
    for seed in 0..50 {
        assert_eq!(run(seed, 10, 300, &blobs()).0.labels, expected, "seed {seed}");
    }
}

#[test]
fn more_restarts_never_give_a_larger_objective() {
    let mut rng = Pcg64::seed_from_u64(1);
    let scattered = spectrum(Mat::from_fn(80, 8, |_, _| rng.random::<f64>()));
    let inertia: Vec<f64> = (1..30).map(|restarts| run(3, restarts, 300, &scattered).0.inertia).collect();
    assert!(inertia.is_sorted_by(|a, b| a >= b), "{inertia:?}");
    assert!(inertia[0] > inertia[28], "a case in which restarts matter: {inertia:?}");
}

#[test]
fn fewer_distinct_rows_than_k_give_fewer_clusters_and_a_note() {
    let rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, -0.0]];
    let (partition, notes) = run(0, 10, 300, &spectrum(Mat::from_fn(4, 3, |i, j| rows[i][j])));
    assert_eq!((partition.clusters, partition.inertia), (2, 0.0));
    assert_eq!(partition.labels, [Some(0), Some(1), Some(0), Some(1)]);
    assert_eq!(notes.iter().collect::<Vec<_>>(), ["k-means: only 2 distinct rows of U for k = 3"]);
}

#[test]
fn a_run_cut_off_by_max_iterations_says_so() {
    let spread = spectrum(Mat::from_fn(200, 2, |i, j| ((i * (37 + j) + i * i) % 211) as f64));
    assert!(run(0, 1, 1, &spread).1.iter().any(|note| note.contains("not settled after 1 iterations")));
    assert!(run(0, 1, 300, &spread).1.is_empty());
}

#[test]
fn each_number_out_of_range_is_refused() {
    for name in ["restarts", "max_iterations"] {
        assert!(KIND.with(&[(name, 0.into())]).is_err(), "{name}");
    }
}

#[test]
fn a_u_of_too_many_columns_is_refused_with_its_size() {
    let spectrum = Spectrum { k: 5000, u: Mat::identity(5000, 5000), ..Spectrum::default() };
    let mut stage = KIND.with(&[]).expect("the defaults");
    let refused = stage.partition(&spectrum, &mut Partition::default(), &mut Notes::default()).expect_err("too many");
    assert!(refused.to_string().contains("191 MB and more than 1e11 operations"), "{refused}");
}

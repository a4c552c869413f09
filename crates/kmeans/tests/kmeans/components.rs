//! `components`: what is left out, and what it makes of a U that mixes its columns.

use crosscut_kmeans::components::KIND;
use crosscut_stage::{Notes, Partition, Spectrum};
use faer::{Mat, mat};

fn run(min_cluster: u32, u: Mat<f64>) -> (Partition, Vec<String>) {
    let (mut out, mut notes) = (Partition::default(), Notes::default());
    let mut stage = KIND.with(&[("min_cluster", min_cluster.into())]).expect("in range");
    let spectrum = Spectrum { k: u.ncols(), u, ..Spectrum::default() };
    stage.partition(&spectrum, &mut out, &mut notes).expect("any U will do");
    (out, notes.iter().map(str::to_owned).collect())
}

/// Components of 1, 3 and 2 returns, degrees not all equal.
fn u() -> Mat<f64> {
    mat![[1.0, 0.0, 0.0], [0.0, 0.6, 0.0], [0.0, 0.0, 0.8], [0.0, 0.48, 0.0], [0.0, 0.64, 0.0], [0.0, 0.0, 0.6]]
}

#[test]
fn small_components_get_no_cluster_and_a_note() {
    let (all, notes) = run(1, u());
    assert_eq!(all.labels, [Some(0), Some(1), Some(2), Some(1), Some(1), Some(2)]);
    assert!(notes.is_empty());

    let (without_noise, notes) = run(2, u());
    assert_eq!(without_noise.labels, [None, Some(0), Some(1), Some(0), Some(0), Some(1)]);
    assert_eq!((without_noise.clusters, without_noise.centroids.nrows()), (2, 2));
    assert!((without_noise.inertia - 0.101_6 / 3.0).abs() < 1e-15);
    assert_eq!(notes, ["components: 1 of fewer than 2 returns left out, 1 return in all"]);

    let (nothing, notes) = run(9, u());
    assert_eq!((nothing.clusters, nothing.labels), (0, vec![None; 6]));
    assert_eq!(notes, ["components: 3 of fewer than 9 returns left out, 6 returns in all"]);
}

#[test]
fn a_u_whose_columns_share_a_row_or_leave_one_out_has_the_clusters_of_kmeans_and_a_note() {
    for mixed in [mat![[1.0, 0.0], [0.6, 0.8], [0.6, 0.8]], mat![[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]]] {
        let (partition, notes) = run(1, mixed);
        assert_eq!(partition.labels, [Some(0), Some(1), Some(1)]);
        let told =
            "components: some rows of U do not have exactly one entry, so kmeans++ clusters them, small clusters too";
        assert_eq!(notes[0], told);
    }
}

#[test]
fn a_u_too_large_for_kmeans_is_refused_with_the_solver_to_choose() {
    let u = Mat::from_fn(5000, 5000, |i, j| f64::from(u8::from(i == j && i > 0)));
    let spectrum = Spectrum { k: 5000, u, ..Spectrum::default() };
    let mut stage = KIND.with(&[]).expect("the defaults");
    let refused = stage.partition(&spectrum, &mut Partition::default(), &mut Notes::default()).expect_err("too large");
    assert!(refused.to_string().ends_with("choose spectral.kind = \"components\""), "{refused}");
}

#[test]
fn a_least_size_of_nothing_is_refused() {
    assert!(KIND.with(&[("min_cluster", 0.into())]).is_err());
}

#[test]
fn many_components_have_the_clusters_of_few() {
    let (n, k) = (3000, 1000);
    let u = Mat::from_fn(n, k, |i, j| if i % k == j { 0.25 * (1 + i / k) as f64 } else { 0.0 });
    let (mut out, mut notes) = (Partition::default(), Notes::default());
    let spectrum = Spectrum { k, u, ..Spectrum::default() };
    KIND.with(&[]).expect("the defaults").partition(&spectrum, &mut out, &mut notes).expect("disjoint columns");
    assert_eq!((out.clusters, out.centroids.nrows(), out.centroids.ncols()), (k, k, k));
    assert!((0..n).all(|i| out.labels[i] == Some((i % k) as u32)));
    assert_eq!(out.centroids, Mat::from_fn(k, k, |i, j| if i == j { 0.5 } else { 0.0 }));
    assert!((out.inertia - 2.0 * 0.0625 * k as f64).abs() < 1e-9, "0.25 off on either side: {}", out.inertia);
}

//! One body of tests for every assignment in `KINDS`: what the rest of the program relies on.

use std::fmt::Debug;
use std::ops::Range;

use crosscut_conformance::for_many;
use crosscut_kmeans::KINDS;
use crosscut_stage::{Kind, KmeansStage, Notes, Partition, Spectrum, StageError};
use faer::Mat;
use proptest::collection::vec;
use proptest::prelude::{Strategy, any, prop_oneof};

use crate::embeddings::{arbitrary, spectrum};

type AssignmentKind = Kind<dyn KmeansStage>;

fn build(kind: &AssignmentKind) -> Box<dyn KmeansStage> {
    kind.with(&[]).expect("the defaults")
}

fn partition(kind: &AssignmentKind, spectrum: &Spectrum) -> Partition {
    let mut out = Partition::default();
    let done = build(kind).partition(spectrum, &mut out, &mut Notes::default());
    done.unwrap_or_else(|error| panic!("{}: {error}", kind.name));
    out
}

/// The partition of a U of separate components.
fn partition_of(kind: &AssignmentKind, component_of_return: &[usize]) -> Partition {
    partition(kind, &of_components(component_of_return))
}

/// U of a graph whose returns belong to these components (0, 1, … without a gap): column c is 1/√|C| on component c.
fn of_components(component_of_return: &[usize]) -> Spectrum {
    let k = component_of_return.iter().max().map_or(0, |last| last + 1);
    let size = |c: usize| component_of_return.iter().filter(|&&other| other == c).count() as f64;
    let entry = |i: usize, c: usize| if component_of_return[i] == c { size(c).sqrt().recip() } else { 0.0 };
    spectrum(Mat::from_fn(component_of_return.len(), k, entry))
}

/// Up to `n` returns of up to seven components, numbered by their first return.
fn components(n: Range<usize>) -> impl Strategy<Value = Vec<usize>> {
    vec(0..7usize, n).prop_map(|drawn| {
        let mut seen = Vec::new();
        let number = |c: usize| {
            seen.iter().position(|&other| other == c).unwrap_or_else(|| {
                seen.push(c);
                seen.len() - 1
            })
        };
        drawn.into_iter().map(number).collect()
    })
}

fn any_spectrum() -> impl Strategy<Value = Spectrum> {
    prop_oneof![arbitrary(0..40), components(0..40).prop_map(|c| of_components(&c))]
}

/// Runs `body`, which asserts, on every kind and many inputs.
fn for_every_kind<T: Debug>(inputs: &impl Strategy<Value = T>, body: impl Fn(&AssignmentKind, T)) {
    KINDS.iter().for_each(|kind| for_many(kind.name, 100, inputs, |input| body(kind, input)));
}

fn distance_squared(spectrum: &Spectrum, i: usize, partition: &Partition, c: usize) -> f64 {
    (0..spectrum.k).map(|j| (spectrum.u[(i, j)] - partition.centroids[(c, j)]).powi(2)).sum()
}

#[test]
fn separate_components_are_the_clusters_numbered_by_their_first_return() {
    for_every_kind(&components(0..60), |kind, component_of_return| {
        let partition = partition_of(kind, &component_of_return);
        let expected: Vec<_> = component_of_return.iter().map(|&c| Some(c as u32)).collect();
        assert_eq!(partition.labels, expected);
        assert!(partition.inertia.abs() < 1e-28, "rows of a component coincide: {}", partition.inertia);
    });
}

#[test]
fn clusters_are_numbered_by_their_first_return_and_have_a_centroid_each() {
    for_every_kind(&any_spectrum(), |kind, spectrum| {
        let partition = partition(kind, &spectrum);
        assert_eq!(partition.labels.len(), spectrum.u.nrows());
        let mut next = 0;
        for label in partition.labels.iter().flatten() {
            assert!(*label <= next, "{label} before {next} in {:?}", partition.labels);
            next = next.max(label + 1);
        }
        let shape = (partition.centroids.nrows(), partition.centroids.ncols());
        assert_eq!((partition.clusters, shape), (next as usize, (next as usize, spectrum.k)));
        assert!(partition.clusters <= spectrum.k, "{} clusters for k = {}", partition.clusters, spectrum.k);
    });
}

#[test]
fn centroids_are_means_and_the_inertia_is_that_of_labels_and_centroids() {
    for_every_kind(&any_spectrum(), |kind, spectrum| {
        let partition = partition(kind, &spectrum);
        let labels = &partition.labels;
        let members = |c: u32| (0..labels.len()).filter(move |&i| labels[i] == Some(c));
        let mut inertia = 0.0;
        for c in 0..partition.clusters {
            let size = members(c as u32).count() as f64;
            for j in 0..spectrum.k {
                let mean = members(c as u32).map(|i| spectrum.u[(i, j)]).sum::<f64>() / size;
                assert!((partition.centroids[(c, j)] - mean).abs() < 1e-14);
            }
            inertia += members(c as u32).map(|i| distance_squared(&spectrum, i, &partition, c)).sum::<f64>();
        }
        assert!((partition.inertia - inertia).abs() <= 1e-12 * inertia.max(1e-12), "{}", partition.inertia);
    });
}

#[test]
fn turning_u_changes_no_label() {
    for_every_kind(&(components(0..40), vec(-3.0..3.0f64, 6)), |kind, (component_of_return, angles_rad)| {
        let spectrum = of_components(&component_of_return);
        let mut u = spectrum.u.clone();
        for (p, angle_rad) in angles_rad.iter().enumerate().filter(|(p, _)| p + 1 < spectrum.k) {
            let (sin, cos) = angle_rad.sin_cos();
            for i in 0..u.nrows() {
                let (x, y) = (u[(i, p)], u[(i, p + 1)]);
                (u[(i, p)], u[(i, p + 1)]) = (cos * x - sin * y, sin * x + cos * y);
            }
        }
        let turned = Spectrum { u, ..spectrum };
        let after = partition(kind, &turned);
        assert_eq!(after.labels, partition_of(kind, &component_of_return).labels);
    });
}

#[test]
fn returns_in_another_order_only_rename_the_clusters() {
    for_every_kind(&(components(1..40), vec(any::<u32>(), 40)), |kind, (component_of_return, keys)| {
        let mut order: Vec<usize> = (0..component_of_return.len()).collect();
        order.sort_by_key(|&i| keys[i]);
        let u = of_components(&component_of_return).u;
        let reordered = Mat::from_fn(u.nrows(), u.ncols(), |row, j| u[(order[row], j)]);
        let after = partition(kind, &spectrum(reordered));
        let before = partition_of(kind, &component_of_return);
        for (row_a, &a) in order.iter().enumerate() {
            for (row_b, &b) in order.iter().enumerate() {
                let together = before.labels[a] == before.labels[b];
                assert_eq!(after.labels[row_a] == after.labels[row_b], together, "returns {a} and {b}");
            }
        }
    });
}

#[test]
fn a_used_stage_and_a_used_buffer_give_the_same_bits_as_new_ones() {
    for_every_kind(&(any_spectrum(), any_spectrum()), |kind, (first, second)| {
        let (mut stage, mut out) = (build(kind), Partition::default());
        for spectrum in [&first, &second, &first, &second] {
            let fresh = partition(kind, spectrum);
            stage.partition(spectrum, &mut out, &mut Notes::default()).expect("as before");
            assert_eq!((out.clusters, &out.labels, out.inertia), (fresh.clusters, &fresh.labels, fresh.inertia));
            assert_eq!(out.centroids, fresh.centroids);
        }
    });
}

#[test]
fn no_zero_eigenvalue_leaves_every_return_without_a_cluster_and_says_so() {
    for kind in KINDS {
        for n in [0, 3] {
            let (mut out, mut notes) = (partition_of(kind, &[0, 1, 0]), Notes::default());
            build(kind).partition(&spectrum(Mat::zeros(n, 0)), &mut out, &mut notes).expect("defined");
            assert_eq!((out.clusters, out.inertia, out.labels), (0, 0.0, vec![None; n]), "{}", kind.name);
            assert_eq!(notes.is_empty(), n == 0, "{}", kind.name);
        }
    }
}

#[test]
fn one_cluster_and_a_cluster_for_each_return_are_found() {
    for kind in KINDS {
        assert_eq!(partition_of(kind, &[0, 0, 0]).labels, [Some(0); 3], "{}", kind.name);
        assert_eq!(partition_of(kind, &[0, 1, 2]).labels, [Some(0), Some(1), Some(2)], "{}", kind.name);
    }
}

#[test]
fn values_that_are_not_finite_and_a_u_of_the_wrong_width_are_refused() {
    for kind in KINDS {
        let refused = |spectrum: &Spectrum| {
            build(kind)
                .partition(spectrum, &mut Partition::default(), &mut Notes::default())
                .expect_err("must be refused")
        };
        for bad in [f64::NAN, f64::INFINITY] {
            let mut u = of_components(&[0, 1, 0, 1]).u;
            u[(2, 0)] = bad;
            assert_eq!(
                refused(&spectrum(u)),
                StageError::NotFinite { what: "the embedding U", index: 2 },
                "{}",
                kind.name
            );
        }
        let too_narrow = Spectrum { k: 3, ..of_components(&[0, 1]) };
        assert!(refused(&too_narrow).to_string().contains("2 columns, but k is 3"), "{}", kind.name);
    }
}

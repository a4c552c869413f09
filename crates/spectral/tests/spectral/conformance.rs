//! One body of tests for every solver in `KINDS`, and the Laplacian that they share, against a decomposition and a
//! component count of the test's own.

use std::fmt::Debug;

use crosscut_conformance::for_many;
use crosscut_spectral::{KINDS, Laplacian};
use crosscut_stage::{Affinity, Eigenvalues, Kind, Notes, SpectralStage, Spectrum, StageError};
use faer::Mat;
use proptest::prelude::{Strategy, any};

use crate::graphs::{self, Graph, graph};
use crate::independent;

type SpectralKind = Kind<dyn SpectralStage>;

/// The default of every solver.
const TOLERANCE: f64 = 1e-7;
/// Random inputs of a test.
const CASES: u32 = 60;

fn build(kind: &SpectralKind) -> Box<dyn SpectralStage> {
    kind.with(&[]).expect("the defaults")
}

fn spectrum(kind: &SpectralKind, affinity: &Affinity) -> Spectrum {
    let mut out = Spectrum::default();
    build(kind).spectrum(affinity, &mut out, &mut Notes::default()).expect("a sound affinity");
    out
}

fn laplacian(affinity: &Affinity) -> Mat<f64> {
    Laplacian::default().form(affinity).expect("a sound affinity").to_owned()
}

/// What rounding leaves in a decomposition of n rows.
fn rounding(n: usize) -> f64 {
    100.0 * n.max(1) as f64 * f64::EPSILON
}

/// Runs `body`, which asserts, on every kind and many inputs.
fn for_every_kind<T: Debug>(inputs: &impl Strategy<Value = T>, body: impl Fn(&SpectralKind, T)) {
    KINDS.iter().for_each(|kind| for_many(kind.name, CASES, inputs, |input| body(kind, input)));
}

#[test]
fn the_laplacian_is_that_of_equation_2_exactly_symmetric_and_takes_the_root_of_the_degrees_to_zero() {
    for_many("the Laplacian", CASES, &graph(0..40), |graph| {
        let affinity = graph.dense();
        let l = laplacian(&affinity);
        let root: Vec<f64> = affinity.degrees.iter().map(|degree| degree.sqrt()).collect();
        affinity.weights.for_each(|i, j, weight| {
            let expected = f64::from(u8::from(i == j)) - weight / (root[i] * root[j]);
            assert!((l[(i, j)] - expected).abs() <= 4.0 * f64::EPSILON, "L[{i}, {j}] = {}, not {expected}", l[(i, j)]);
            assert_eq!(l[(i, j)].to_bits(), l[(j, i)].to_bits(), "symmetry at {i}, {j}");
        });
        for i in 0..graph.n {
            let image: f64 = (0..graph.n).map(|j| l[(i, j)] * root[j]).sum();
            assert!(image.abs() <= rounding(graph.n), "(L D^1/2 1)[{i}] = {image}");
        }
    });
}

#[test]
fn as_many_eigenvalues_are_zero_as_the_graph_has_components() {
    for_every_kind(&graph(0..40), |kind, graph| {
        let spectrum = spectrum(kind, &graph.dense());
        assert_eq!(spectrum.k, graph.components(), "λ = {:?}", spectrum.eigenvalues);
        assert_eq!((spectrum.u.nrows(), spectrum.u.ncols()), (graph.n, spectrum.k));
    });
}

#[test]
fn eigenvalues_ascend_from_0_to_at_most_2_and_are_those_of_an_independent_decomposition() {
    for_every_kind(&graph(0..40), |kind, graph| {
        let affinity = graph.dense();
        let spectrum = spectrum(kind, &affinity);
        let found = &spectrum.eigenvalues;
        assert!(found.is_sorted() && found.len() <= graph.n, "{found:?}");
        // Without a margin, the zeros are all that the kind claims to know.
        let least = spectrum.k + usize::from(spectrum.margin_decades.is_some());
        assert!(found.len() >= least.min(graph.n), "the zeros and the next: {found:?}");
        let bound = rounding(graph.n);
        assert!(found.iter().all(|&lambda| (-bound..=2.0 + bound).contains(&lambda)), "{found:?}");
        for (found, expected) in found.iter().zip(graphs::jacobi_eigenvalues(&laplacian(&affinity))) {
            assert!((found - expected).abs() <= bound, "{found} is {expected} by Jacobi rotations");
        }
    });
}

#[test]
fn columns_of_u_are_orthonormal_eigenvectors_of_the_zeros() {
    for_every_kind(&graph(0..40), |kind, graph| {
        let affinity = graph.dense();
        let (l, Spectrum { u, eigenvalues, k, .. }) = (laplacian(&affinity), spectrum(kind, &affinity));
        let bound = rounding(graph.n);
        let gram = u.transpose() * &u - Mat::<f64>::identity(k, k);
        assert!(gram.norm_max() <= bound, "UᵀU - I = {gram:?}");
        for (j, &lambda) in eigenvalues.iter().enumerate().take(k) {
            let residual = &l * u.col(j) - faer::Scale(lambda) * u.col(j);
            assert!(residual.norm_l2() <= bound, "‖Lu - λu‖ = {} for λ_{j}", residual.norm_l2());
        }
    });
}

#[test]
fn the_span_of_u_is_that_of_the_components_indicators() {
    for_every_kind(&graph(0..40), |kind, graph| {
        let spectrum = spectrum(kind, &graph.dense());
        let next = spectrum.eigenvalues.get(spectrum.k).copied().unwrap_or(2.0);
        let exact = graph.indicators();
        let u = &spectrum.u;
        let difference = u * u.transpose() - &exact * exact.transpose();
        let bound = rounding(graph.n) / next;
        assert!(difference.norm_max() <= bound, "U·Uᵀ is off by {}, allowed {bound}", difference.norm_max());
    });
}

#[test]
fn k_and_span_are_those_of_another_library_when_walls_leak() {
    for_every_kind(&(graph(2..40), -13.0..-10.0f64), |kind, (graph, leak_decades)| {
        let affinity = graph.leaking(10f64.powf(leak_decades)).dense();
        let (found, expected) = (spectrum(kind, &affinity), independent::spectrum(&affinity, TOLERANCE));
        assert_eq!((found.k, expected.k), (graph.components(), graph.components()), "λ = {:?}", found.eigenvalues);
        if kind.properties.eigenvalues == Eigenvalues::Zeros {
            return; // its U is that of the graph without leaks
        }
        let gap = expected.eigenvalues.get(expected.k).map_or(2.0, |next| next - expected.eigenvalues[expected.k - 1]);
        let (u, v) = (&found.u, &expected.u);
        let difference = u * u.transpose() - v * v.transpose();
        // What all leaks of a return may weigh, beside a degree of 1 at least.
        let leak = if kind.name == "blocks" { graph.n as f64 * 10f64.powf(leak_decades) } else { 0.0 };
        let bound = (rounding(graph.n) + leak) / gap;
        assert!(difference.norm_max() <= bound, "U·Uᵀ differs by {}, allowed {bound}", difference.norm_max());
    });
}

#[test]
fn the_entry_of_largest_magnitude_is_positive_in_every_column_of_u() {
    for_every_kind(&graph(1..40), |kind, graph| {
        let u = spectrum(kind, &graph.dense()).u;
        for j in 0..u.ncols() {
            let (lowest, highest) = u.col(j).iter().fold((0.0f64, 0.0f64), |(a, b), &x| (a.min(x), b.max(x)));
            assert!(highest >= -lowest, "column {j} goes from {lowest} to {highest}");
        }
    });
}

#[test]
fn sparse_and_dense_weights_give_the_same_bits() {
    for_every_kind(&graph(0..40), |kind, graph| {
        assert_same(&spectrum(kind, &graph.sparse()), &spectrum(kind, &graph.dense()));
    });
}

#[test]
fn a_used_stage_and_a_used_buffer_give_the_same_bits_as_new_ones() {
    // From 128 rows on faer divides and conquers.
    for_every_kind(&(graph(130..150), graph(0..20)), |kind, (big, small)| {
        let (mut stage, mut out) = (build(kind), Spectrum::default());
        for affinity in [big.dense(), small.sparse(), big.sparse(), small.dense()] {
            stage.spectrum(&affinity, &mut out, &mut Notes::default()).expect("a sound affinity");
            assert_same(&out, &spectrum(kind, &affinity));
        }
    });
}

fn assert_same(a: &Spectrum, b: &Spectrum) {
    assert_eq!((a.k, a.margin_decades, &a.eigenvalues), (b.k, b.margin_decades, &b.eigenvalues));
    assert_eq!(a.u, b.u);
}

#[test]
fn graphs_solved_by_hand() {
    for kind in KINDS {
        let close = |affinity: &Affinity, expected: &[f64], k: usize| {
            let found = spectrum(kind, affinity);
            assert_eq!(found.k, k, "{}: {found:?}", kind.name);
            for (found, expected) in found.eigenvalues.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14, "{}: {found} for {expected}", kind.name);
            }
        };
        close(&Graph::complete(0, 1.0).dense(), &[], 0);
        close(&Graph::complete(1, 1.0).dense(), &[0.0], 1);
        // Two returns: λ = 0 and 2w / (1 + w).
        close(&Graph::complete(2, 0.25).dense(), &[0.0, 0.4], 1);
        // All returns in one place: W is all ones, L = I - 11ᵀ/n.
        close(&Graph::complete(5, 1.0).dense(), &[0.0, 1.0, 1.0, 1.0, 1.0], 1);
        // No two similar: L = 0 and k = n.
        close(&Graph::complete(4, 0.0).sparse(), &[0.0; 4], 4);
    }
}

#[test]
fn the_margin_says_how_far_the_tolerance_is_from_another_count() {
    for kind in KINDS {
        assert_eq!(spectrum(kind, &Graph::complete(0, 1.0).dense()).margin_decades, None, "{}", kind.name);
        let Some(margin) = spectrum(kind, &Graph::complete(2, 1e-6).dense()).margin_decades else {
            assert_eq!(kind.properties.eigenvalues, Eigenvalues::Zeros, "{}", kind.name);
            continue;
        };
        // τ = 1e-7, λ = 0 (so 2·2.2e-16) and 2e-6: 8.35 decades on one side, 1.30 on the other.
        assert!((margin - 1.301).abs() < 1e-3, "{}: {margin}", kind.name);
    }
}

#[test]
fn values_that_no_affinity_has_are_errors_and_neither_loop_nor_panic() {
    for_every_kind(&(graph(2..20), any::<usize>()), |kind, (graph, at)| {
        let at = at % graph.n;
        let refused = |spoil: fn(&mut Affinity, usize)| {
            let mut affinity = graph.dense();
            spoil(&mut affinity, at);
            build(kind)
                .spectrum(&affinity, &mut Spectrum::default(), &mut Notes::default())
                .expect_err("must be refused")
        };
        let n = graph.n;
        let error = refused(|affinity, at| affinity.degrees[at] = f64::NAN);
        assert_eq!(error, StageError::NotFinite { what: "the degree", index: at });
        let error =
            refused(|affinity, at| affinity.weights.make_dense(affinity.degrees.len())[(at, at)] = f64::INFINITY);
        assert_eq!(error, StageError::NotFinite { what: "the affinity", index: at });
        assert!(refused(|affinity, at| affinity.degrees[at] = 0.0).to_string().contains(&format!("return {at} is 0")));
        assert!(refused(|affinity, _| affinity.degrees.clear()).to_string().contains(&format!("{n}x{n}")));
    });
}

#[test]
fn a_tolerance_below_rounding_or_above_2_is_refused() {
    for (allowed, tolerance) in
        [(false, 0.0), (false, -1e-8), (false, f64::NAN), (false, 1e-15), (true, 1e-14), (true, 2.0), (false, 2.1)]
    {
        for kind in KINDS.iter().filter(|kind| kind.properties.eigenvalues != Eigenvalues::Zeros) {
            let built = kind.with(&[("zero_tolerance", tolerance.into())]);
            assert_eq!(built.is_ok(), allowed, "{} with τ = {tolerance}", kind.name);
        }
    }
}

#[test]
fn few_returns_far_from_each_other_whose_links_are_next_to_nothing_are_decomposed() {
    let mut state = 88_172_645_463_325_252_u64;
    let mut place_m = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        20.0 * ((state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    };
    for n in (4..8).cycle().take(6000) {
        let places_m: Vec<_> = (0..n).map(|_| [place_m(), place_m()]).collect();
        let squared =
            |i: usize, j: usize| (0..2).map(|axis| (places_m[i][axis] - places_m[j][axis]).powi(2)).sum::<f64>();
        let mut affinity = Affinity::default();
        *affinity.weights.make_dense(n) = Mat::from_fn(n, n, |i, j| (-1.5 * squared(i, j)).exp());
        affinity.degrees = (0..n).map(|i| (0..n).map(|j| (-1.5 * squared(i, j)).exp()).sum()).collect();
        for kind in KINDS {
            let mut found = Spectrum::default();
            let done = build(kind).spectrum(&affinity, &mut found, &mut Notes::default());
            assert!(done.is_ok(), "{}: {done:?} at {places_m:?}", kind.name);
            assert!(found.eigenvalues.iter().all(|l| (-1e-14..2.0 + 1e-14).contains(l)), "{}: {places_m:?}", kind.name);
        }
    }
}

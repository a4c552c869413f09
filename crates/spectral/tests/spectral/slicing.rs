//! `slicing` against the full decomposition, on the dense W of walls that leak into each other.

use std::cell::Cell;

use crate::solving::{solver, spectrum};
use crosscut_conformance::for_many;
use crosscut_spectral::{faer_evd, slicing};
use crosscut_stage::{Affinity, SpectralStage};
use proptest::collection::vec;
use proptest::prelude::Strategy;

const TOLERANCE: f64 = 1e-7;
const EIGENVALUES: usize = 16;

fn slicing(eigenvalues: usize) -> Box<dyn SpectralStage> {
    slicing_at(TOLERANCE, eigenvalues)
}

fn slicing_at(tolerance: f64, eigenvalues: usize) -> Box<dyn SpectralStage> {
    let values = [("zero_tolerance", tolerance.into()), ("eigenvalues", (eigenvalues as u32).into())];
    slicing::KIND.with(&values).expect("allowed")
}

/// Equation (1) with σ = 1.5 per m² over parallel walls, each some metres from the one before it, and of returns
/// that lie closer and closer.
fn walls() -> impl Strategy<Value = Affinity> {
    vec((0.3..7.0f64, 1..80usize, 0.01..0.4f64, 1.0..1.05f64), 1..6).prop_map(|walls| {
        let mut points_m: Vec<[f64; 2]> = Vec::new();
        let mut y_m = 0.0;
        for (apart_m, returns, mut spacing_m, growth) in walls {
            y_m += apart_m;
            let mut x_m = -2.0;
            for _ in 0..returns {
                points_m.push([x_m, y_m]);
                x_m += spacing_m;
                spacing_m *= growth;
            }
        }
        let square =
            |i: usize, j: usize| (0..2).map(|axis| (points_m[i][axis] - points_m[j][axis]).powi(2)).sum::<f64>();
        dense(points_m.len(), |i, j| (-1.5 * square(i, j)).exp())
    })
}

/// n returns with such weights, and their degrees.
fn dense(n: usize, weight: impl Fn(usize, usize) -> f64) -> Affinity {
    let mut affinity = Affinity::default();
    let w = affinity.weights.make_dense(n);
    for j in 0..n {
        (0..n).for_each(|i| w[(i, j)] = weight(i, j));
    }
    affinity.degrees = (0..n).map(|j| w.col(j).iter().sum()).collect();
    affinity
}

#[test]
fn zeros_span_k_and_the_lowest_eigenvalues_are_those_of_the_full_decomposition() {
    let (compared, undecided, fallbacks) = (Cell::new(0), Cell::new(0), Cell::new(0));
    let count = |counter: &Cell<usize>| counter.set(counter.get() + 1);
    for_many("slicing", 150, &walls(), |affinity| {
        let n = affinity.degrees.len();
        let rounding = 100.0 * n as f64 * f64::EPSILON;
        let (all, _) = spectrum(solver(&faer_evd::KIND, TOLERANCE).as_mut(), &affinity);
        for eigenvalues in [1, EIGENVALUES] {
            let (found, notes) = spectrum(slicing(eigenvalues).as_mut(), &affinity);
            (0..notes).for_each(|_| count(&fallbacks));
            assert_eq!(found.eigenvalues.len(), eigenvalues.max(found.k + 1).min(n));
            for (j, (ours, full)) in found.eigenvalues.iter().zip(&all.eigenvalues).enumerate() {
                let allowed = if j < all.k { rounding.min(1e-12) } else { 1e-12 };
                assert!((ours - full).abs() <= allowed, "λ_{j} of {n}: {ours} is {full}");
            }
            if all.eigenvalues.iter().any(|lambda| (lambda - TOLERANCE).abs() <= rounding) {
                count(&undecided);
                continue;
            }
            assert_eq!(found.k, all.k, "{:?} is {:?}", found.eigenvalues, &all.eigenvalues[..all.k + 1]);
            let gap = all.eigenvalues.get(all.k).map_or(2.0, |next| next - all.eigenvalues[all.k - 1]);
            let (u, v) = (&found.u, &all.u);
            let sines = (u - v * (v.transpose() * u)).norm_l2();
            assert!(sines <= rounding / gap, "the span is off by {sines}, allowed {}", rounding / gap);
            count(&compared);
        }
    });
    let (compared, undecided, fallbacks) = (compared.get(), undecided.get(), fallbacks.get());
    // Of 300: nearly all are compared, and so few in full that they do not decide how long the solver takes.
    assert!(compared > 280 && fallbacks < 5, "{compared} compared, {undecided} undecided, {fallbacks} in full");
}

/// Groups of 8 returns in a ring, whose neighbours have weak edges; and beside them, not connected with them, a chain.
/// The chain has most of the trace of D^-1/2 W D^-1/2, the groups most of the smallest eigenvalues.
fn groups_and_a_chain() -> Affinity {
    let (groups, size, chain) = (15, 8, 120);
    let ring = groups * size;
    let weight = |i: usize, j: usize| match (i < ring, j < ring) {
        (true, true) if i / size == j / size => 1.0,
        (true, true) if i.is_multiple_of(size) && j.is_multiple_of(size) => {
            let apart = (i / size).abs_diff(j / size);
            if apart == 1 || apart == groups - 1 { 0.01 } else { 0.0 }
        }
        (false, false) if i.abs_diff(j) <= 1 => 1.0,
        _ => 0.0,
    };
    dense(ring + chain, weight)
}

#[test]
fn a_part_that_has_more_of_the_smallest_eigenvalues_than_its_share_gives_them_all() {
    let affinity = groups_and_a_chain();
    let (all, _) = spectrum(solver(&faer_evd::KIND, TOLERANCE).as_mut(), &affinity);
    for eigenvalues in [2, 8, EIGENVALUES] {
        let (found, _) = spectrum(slicing(eigenvalues).as_mut(), &affinity);
        assert_eq!((found.k, found.eigenvalues.len()), (2, eigenvalues.max(3)));
        for (j, (ours, full)) in found.eigenvalues.iter().zip(&all.eigenvalues).enumerate() {
            assert!((ours - full).abs() <= 1e-12, "λ_{j} of {eigenvalues}: {ours} is {full}");
        }
    }
}

#[test]
fn a_zero_that_rounding_lifts_above_the_tolerance_keeps_its_eigenvector() {
    let n = 300;
    let mut wall = dense(n, |i, j| (-1.5 * (0.05 * i.abs_diff(j) as f64).powi(2)).exp());
    // Sums of n weights may be off by n·ε of themselves.
    wall.degrees.iter_mut().for_each(|degree| *degree *= 1.0 + 100.0 * f64::EPSILON);
    let volume: f64 = wall.degrees.iter().sum();
    for eigenvalues in [1, EIGENVALUES] {
        let (found, _) = spectrum(slicing_at(1e-14, eigenvalues).as_mut(), &wall);
        assert_eq!((found.k, found.eigenvalues.len()), (1, eigenvalues.max(2)));
        let off = (0..n).map(|i| (found.u[(i, 0)] - (wall.degrees[i] / volume).sqrt()).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "the eigenvector of the zero is off by {off}");
    }
}

//! `dbscan`: its components are DBSCAN's clusters, as scikit-learn gives them and as the definition does.

use std::collections::BTreeMap;

use crosscut_affinity::dbscan::KIND;
use crosscut_conformance::for_many;
use crosscut_stage::{Affinity, Notes, Point, Revolution};
use nalgebra::distance_squared;
use proptest::collection::vec;

/// The smallest return of the component of each return.
fn components(eps_m: f64, min_points: u32, points_m: &[Point]) -> Vec<usize> {
    let revolution = Revolution { points_m: points_m.to_vec(), ..Revolution::default() };
    let mut out = Affinity::default();
    let mut stage = KIND.with(&[("eps_m", eps_m.into()), ("min_points", min_points.into())]).expect("in range");
    stage.affinity(&revolution, &mut out, &mut Notes::default()).expect("finite points");
    crate::components(&out, 0.0)
}

/// Labels (`None` for noise) as components: the smallest return with the same label, or the return itself.
fn smallest_of_label(labels: &[Option<usize>]) -> Vec<usize> {
    let first = |label: usize| labels.iter().position(|&other| other == Some(label));
    labels.iter().enumerate().map(|(i, label)| label.and_then(first).unwrap_or(i)).collect()
}

#[test]
fn clusters_are_those_of_scikit_learn() {
    let mut clouds = BTreeMap::<usize, (f64, u32, Vec<Point>, Vec<Option<usize>>)>::new();
    for line in include_str!("clouds.csv").lines() {
        let field: Vec<f64> = line.split(',').map(|text| text.parse().expect("a number")).collect();
        let cloud = clouds.entry(field[0] as usize).or_insert((field[1], field[2] as u32, Vec::new(), Vec::new()));
        cloud.2.push(Point::new(field[3], field[4], field[5]));
        cloud.3.push((field[6] >= 0.0).then_some(field[6] as usize));
    }
    assert_eq!(clouds.len(), 24);
    for (number, (eps_m, min_points, points_m, labels)) in clouds {
        assert_eq!(components(eps_m, min_points, &points_m), smallest_of_label(&labels), "cloud {number}");
    }
}

/// DBSCAN by its definition, with the order of scikit-learn: clusters are numbered by their first core, and a border
/// point belongs to the first cluster that has a core in reach.
fn by_definition(eps_m: f64, min_points: u32, points_m: &[Point]) -> Vec<Option<usize>> {
    let n = points_m.len();
    let near = |i: usize, j: usize| distance_squared(&points_m[i], &points_m[j]) <= eps_m * eps_m;
    let core: Vec<bool> = (0..n).map(|i| (0..n).filter(|&j| near(i, j)).count() >= min_points as usize).collect();
    // The first core that a core can reach through cores, by repeated passes over all pairs.
    let mut first: Vec<usize> = (0..n).collect();
    for _ in 0..n {
        for i in (0..n).filter(|&i| core[i]) {
            for j in (0..n).filter(|&j| core[j] && near(i, j)) {
                first[i] = first[i].min(first[j]);
            }
        }
    }
    (0..n)
        .map(
            |i| {
                if core[i] { Some(first[i]) } else { (0..n).filter(|&j| core[j] && near(i, j)).map(|j| first[j]).min() }
            },
        )
        .collect()
}

#[test]
fn clusters_are_those_of_the_definition_on_clouds_full_of_ties() {
    let clouds = (vec([0..6i32, 0..6i32, 0..2i32], 0..40), 1..7u32);
    for_many("dbscan", 300, &clouds, |(lattice, min_points)| {
        let points_m: Vec<Point> = lattice.iter().map(|p| Point::from(p.map(f64::from))).collect();
        let expected = smallest_of_label(&by_definition(1.0, min_points, &points_m));
        assert_eq!(components(1.0, min_points, &points_m), expected);
    });
}

#[test]
fn a_border_return_between_two_clusters_joins_the_first() {
    // Two rows of three; the return half-way between them has a core of each in reach, 1 m away.
    let x_m = [0.0, 0.5, 1.0, 2.0, 3.0, 3.5, 4.0];
    let points_m: Vec<Point> = x_m.iter().map(|&x| Point::new(x, 0.0, 0.0)).collect();
    assert_eq!(components(1.0, 4, &points_m), [0, 0, 0, 0, 4, 4, 4], "three returns make no core of it");
    assert_eq!(components(1.0, 3, &points_m), [0; 7], "they do, and it connects the rows");
    assert_eq!(components(0.9, 3, &points_m), [0, 0, 0, 3, 4, 4, 4], "noise is alone");
}

#[test]
fn each_number_out_of_range_is_refused() {
    assert!(KIND.with(&[("eps_m", 0.0.into())]).is_err());
    assert!(KIND.with(&[("min_points", 0.into())]).is_err());
}

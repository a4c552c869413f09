use std::f64::consts::{FRAC_PI_2, TAU};

use crosscut_flight::{Constraint, PoseGraph, PoseGraphError, read_g2o, write_g2o};
use nalgebra::{Isometry2, Matrix3, Vector2, Vector3};
use proptest::prelude::*;
use rand::SeedableRng as _;
use rand_pcg::Pcg64Mcg;

fn pose(x_m: f64, y_m: f64, yaw_rad: f64) -> Isometry2<f64> {
    Isometry2::new(Vector2::new(x_m, y_m), yaw_rad)
}

/// Poses on a circle, each measured from the one before and the first from the last; measurements are off by up to `noise`.
fn loop_of(poses: usize, noise: f64, seed: u64) -> PoseGraph {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let at = |i: usize| {
        let angle_rad = TAU * i as f64 / poses as f64;
        pose(10.0 * angle_rad.sin(), 10.0 - 10.0 * angle_rad.cos(), angle_rad)
    };
    let mut graph = PoseGraph { poses: (0..poses).map(at).collect(), edges: Vec::new() };
    for from in 0..poses {
        let to = (from + 1) % poses;
        let mut off = || rng.random_range(-noise..=noise);
        let measured = graph.poses[from].inv_mul(&graph.poses[to]) * pose(off(), off(), off());
        let information = Matrix3::from_diagonal(&Vector3::new(100.0, 50.0, 400.0));
        graph.edges.push(Constraint { from, to, measured, information });
    }
    graph
}

#[test]
fn a_consistent_loop_is_solved_exactly_from_a_distorted_start() {
    let truth = loop_of(40, 0.0, 1);
    let mut graph = truth.clone();
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    for free in &mut graph.poses[1..] {
        let mut off = || rng.random_range(-0.3..=0.3);
        *free *= pose(off(), off(), off());
    }
    let solved = graph.solve().expect("determined");
    assert!(solved.error_before > 1.0 && solved.error_after < 1e-12, "{solved:?}");
    for (found, true_pose) in graph.poses.iter().zip(&truth.poses) {
        let off = true_pose.inv_mul(found);
        assert!(off.translation.vector.norm() < 1e-6 && off.rotation.angle().abs() < 1e-6);
    }
}

/// At the least error no small change of a pose lowers it: derivatives by differences, which the solver does not use.
#[test]
fn at_the_solution_every_derivative_of_the_error_is_zero() {
    let mut graph = loop_of(30, 0.05, 3);
    graph.solve().expect("determined");
    let step = 1e-6;
    for at in 1..graph.poses.len() {
        for axis in 0..3 {
            let moved = |by: f64| {
                let mut moved = graph.clone();
                let old = moved.poses[at];
                let [dx, dy, dyaw] = std::array::from_fn(|i| if i == axis { by } else { 0.0 });
                let position_m = old.translation.vector + Vector2::new(dx, dy);
                moved.poses[at] = Isometry2::new(position_m, old.rotation.angle() + dyaw);
                moved.error()
            };
            let derivative = (moved(step) - moved(-step)) / (2.0 * step);
            assert!(derivative.abs() < 1e-4, "pose {at}, axis {axis}: {derivative}");
        }
    }
}

#[test]
fn a_loop_closure_spreads_the_drift_over_the_loop() {
    // A square, 10 m a side, whose odometry turns 2° too far at each corner; by the closure pose 4 is pose 0.
    let side = pose(10.0, 0.0, FRAC_PI_2 + 2f64.to_radians());
    let information = Matrix3::identity();
    let mut graph = PoseGraph { poses: vec![Isometry2::identity()], edges: Vec::new() };
    for from in 0..4 {
        graph.poses.push(graph.poses[from] * side);
        graph.edges.push(Constraint { from, to: from + 1, measured: side, information });
    }
    let off_before_m = graph.poses[4].translation.vector.norm();
    graph.edges.push(Constraint { from: 4, to: 0, measured: Isometry2::identity(), information: information * 1e6 });
    graph.solve().expect("determined");
    assert!(off_before_m > 0.5 && graph.poses[4].translation.vector.norm() < 1e-3);
    let corner_m = graph.poses[2].translation.vector;
    assert!((corner_m - Vector2::new(10.0, 10.0)).norm() < 0.3, "{corner_m}");
}

#[test]
fn poses_that_no_edge_determines_are_an_error() {
    let mut graph = loop_of(5, 0.0, 4);
    graph.poses.push(Isometry2::identity());
    let before = graph.clone();
    assert_eq!(graph.solve(), Err(PoseGraphError::Undetermined));
    assert_eq!(graph, before);
    graph.edges[2].to = 17;
    let error = graph.solve().expect_err("no pose 17");
    assert_eq!(error.to_string(), "edge 2 joins pose 2 to pose 17, of 6 poses");
}

#[test]
fn graphs_without_edges_or_poses_are_solved() {
    assert_eq!(PoseGraph::default().solve().expect("nothing to do").iterations, 0);
    let mut alone = PoseGraph { poses: vec![pose(1.0, 2.0, 3.0)], edges: Vec::new() };
    assert_eq!(alone.solve().expect("nothing to do").iterations, 0);
}

#[test]
fn a_g2o_file_reads_back_as_the_same_graph() {
    let graph = loop_of(12, 0.1, 5);
    let back = read_g2o(&write_g2o(&graph)).expect("our own");
    assert_eq!(back.poses.len(), 12);
    for (a, b) in graph.poses.iter().zip(&back.poses) {
        assert!(a.inv_mul(b).translation.vector.norm() < 1e-12 && a.rotation.angle_to(&b.rotation).abs() < 1e-12);
    }
    for (a, b) in graph.edges.iter().zip(&back.edges) {
        assert_eq!((a.from, a.to, a.information), (b.from, b.to, b.information));
    }
}

#[test]
fn a_g2o_file_of_another_program_is_read() {
    let text = "# comment\nVERTEX_SE2 7 0 0 0\nFIX 7\n\nVERTEX_SE2 3 1 2 0.5\nEDGE_SE2 7 3 1 2 0.5 1 0 0 2 0 3\n";
    let graph = read_g2o(text).expect("well formed");
    assert_eq!((graph.edges[0].from, graph.edges[0].to), (1, 0), "poses are in the order of their ids");
    assert_eq!(graph.edges[0].information, Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0)));
    for (wrong, expected) in [
        ("VERTEX_SE3 0 0 0 0", "line 1: `VERTEX_SE3` is not a vertex or an edge of SE2"),
        ("VERTEX_SE2 0 0 0", "line 1: expected a number, the line ends"),
        ("VERTEX_SE2 0 0 0 NaN", "line 1: NaN is not finite"),
        ("\nEDGE_SE2 0 1 0 0 0 1 0 0 1 0 1", "line 2: no vertex 0"),
        ("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 0 0 0", "line 2: vertex 0 stands in the file twice"),
        ("VERTEX_SE2 x 0 0 0", "line 1: expected a vertex id, found `x`"),
    ] {
        assert_eq!(read_g2o(wrong).expect_err(wrong).to_string(), expected);
    }
}

proptest! {
    #[test]
    fn solving_never_raises_the_error(poses in 3usize..20, noise in 0.0..0.5f64, seed: u64) {
        let mut graph = loop_of(poses, noise, seed);
        let solved = graph.solve().expect("determined");
        prop_assert!(solved.error_after <= solved.error_before);
        prop_assert!((graph.error() - solved.error_after).abs() < 1e-9);
    }
}

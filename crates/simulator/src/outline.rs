//! The outlines of free space: tunnels swept along their centrelines, joints, chambers and alcoves, united.

use std::f64::consts::{PI, TAU};

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;

use crate::network::{Network, Point, Tunnel, left_of, unit};

/// Where rock begins, as closed contours: the rim of the mine, and the blocks of rock between its tunnels.
pub(crate) fn rock(network: &Network) -> Vec<Vec<Point>> {
    let joints = (0..network.nodes.len()).filter_map(|node| {
        let chamber_m = network.nodes[node].chamber_radius_m;
        let joint_m = if network.degree(node) > 1 { network.half_width_at_m(node) } else { 0.0 };
        let radius_m = chamber_m.max(joint_m);
        (radius_m > 0.0).then(|| circle(network.nodes[node].position_m, radius_m))
    });
    let alcoves = network.alcoves.iter().map(|alcove| circle(alcove.centre_m, alcove.radius_m));
    // All contours turn left, so that where they overlap, windings add up and never cancel.
    let pieces: Vec<Vec<[f64; 2]>> = network
        .tunnels
        .iter()
        .map(swept)
        .chain(joints)
        .chain(alcoves)
        .map(|contour| contour.iter().map(|point| [point.x, point.y]).collect())
        .collect();
    let shapes = pieces.simplify_shape(FillRule::NonZero);
    shapes.into_iter().flatten().map(|contour| contour.iter().map(|&[x, y]| Point::new(x, y)).collect()).collect()
}

/// The outline of one tunnel, cut off square at both ends.
fn swept(tunnel: &Tunnel) -> Vec<Point> {
    let side =
        |i: usize, sign: f64| tunnel.centreline_m[i] + left_of(tunnel.tangent(i)) * (sign * tunnel.half_widths_m[i]);
    let n = tunnel.centreline_m.len();
    (0..n).map(|i| side(i, -1.0)).chain((0..n).rev().map(|i| side(i, 1.0))).collect()
}

/// A circle as a contour whose edges stay within 5 mm of it.
pub(crate) fn circle(centre_m: Point, radius_m: f64) -> Vec<Point> {
    // An edge of one n-th of the turn lies r·(1 - cos(π/n)) ≈ r·π²/2n² inside the circle.
    let corners = (PI * (radius_m / 0.01).sqrt()).ceil().max(8.0) as usize;
    (0..corners).map(|i| centre_m + unit(TAU * i as f64 / corners as f64) * radius_m).collect()
}

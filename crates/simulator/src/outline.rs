//! The outlines of free space: tunnels swept along their centrelines, joints, chambers and alcoves, united.

use std::f64::consts::{PI, TAU};

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;

use crosscut_stage::unit;

use crate::network::{Network, Point, Tunnel, left_of};

/// The border of the rock as closed contours: the rim of the mine, and the blocks between its tunnels.
pub(crate) fn rock(network: &Network) -> Vec<Vec<Point>> {
    let joints = (0..network.nodes.len()).filter_map(|node| {
        let chamber_m = network.nodes[node].chamber_radius_m;
        let joint_m = if network.degree(node) > 1 { network.half_width_at_m(node) } else { 0.0 };
        let radius_m = chamber_m.max(joint_m);
        (radius_m > 0.0).then(|| circle(network.nodes[node].position_m, radius_m))
    });
    let alcoves = network.alcoves.iter().map(|alcove| circle(alcove.centre_m, alcove.radius_m));
    // All contours turn left, so that windings add where contours overlap.
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

/// The outline of one tunnel, with square ends.
fn swept(tunnel: &Tunnel) -> Vec<Point> {
    let side =
        |i: usize, sign: f64| tunnel.centreline_m[i] + left_of(tunnel.tangent(i)) * (sign * tunnel.half_widths_m[i]);
    let n = tunnel.centreline_m.len();
    (0..n).map(|i| side(i, -1.0)).chain((0..n).rev().map(|i| side(i, 1.0))).collect()
}

/// A circle as a contour whose edges are within 5 mm of it.
pub(crate) fn circle(centre_m: Point, radius_m: f64) -> Vec<Point> {
    // An edge of one n-th of the circle is at most r·(1 - cos(π/n)) ≈ r·π²/2n² inside it.
    let corners = (PI * (radius_m / 0.01).sqrt()).ceil().max(8.0) as usize;
    (0..corners).map(|i| centre_m + unit(TAU * i as f64 / corners as f64) * radius_m).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_m2(contour: &[Point]) -> f64 {
        let next = contour.iter().cycle().skip(1);
        contour.iter().zip(next).map(|(a, b)| 0.5 * a.coords.perp(&b.coords)).sum()
    }

    fn cross(half_length_m: f64) -> Network {
        let mut network = Network::new(4.0);
        let centre = network.add_node(Point::origin());
        for quarter in 0..4 {
            let end = Point::origin() + unit(TAU / 4.0 * f64::from(quarter)) * half_length_m;
            network.add_branch(centre, vec![Point::origin(), end], vec![2.0; 2]);
        }
        network
    }

    #[test]
    fn crossing_tunnels_become_one_outline() {
        let contours = rock(&cross(20.0));
        assert_eq!(contours.len(), 1);
        assert!((area_m2(&contours[0]).abs() - (2.0 * 40.0 * 4.0 - 16.0)).abs() < 1e-3);
    }

    #[test]
    fn rock_between_tunnels_is_a_separate_contour() {
        let mut network = Network::new(4.0);
        let corners = [(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (0.0, 20.0)].map(|(x, y)| Point::new(x, y));
        let nodes = corners.map(|corner| network.add_node(corner));
        for i in 0..4 {
            let j = (i + 1) % 4;
            network.add_tunnel(nodes[i], nodes[j], vec![corners[i], corners[j]], vec![2.0; 2]);
        }
        let mut areas: Vec<f64> = rock(&network).iter().map(|contour| area_m2(contour).abs()).collect();
        areas.sort_by(f64::total_cmp);
        assert_eq!(areas.len(), 2);
        assert!((areas[0] - 256.0).abs() < 1e-3, "the block of 16 m x 16 m has {} m²", areas[0]);
    }

    #[test]
    fn a_circle_stays_within_5_mm() {
        for radius_m in [0.3, 2.0, 8.0] {
            let contour = circle(Point::new(1.0, 2.0), radius_m);
            let middle = contour[0] + 0.5 * (contour[1] - contour[0]);
            let sagitta_m = radius_m - (middle - Point::new(1.0, 2.0)).norm();
            assert!((0.0..0.005).contains(&sagitta_m), "{sagitta_m}");
        }
    }
}

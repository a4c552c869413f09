//! Pillars, and tips between branches that look like one.

use std::f64::consts::TAU;

use crosscut_stage::Beam;
use nalgebra::Vector2;

use super::{Segment, TUNNEL, all, components, mixed, scan, walls};

/// With twelve corners.
fn pillar(centre_m: [f64; 2], radius_m: f64) -> Vec<Segment> {
    let corner = |k: u32| {
        let (sin, cos) = (f64::from(k) * TAU / 12.0).sin_cos();
        [centre_m[0] + radius_m * cos, centre_m[1] + radius_m * sin]
    };
    (0..12).map(|k| [corner(k), corner(k + 1)]).collect()
}

#[test]
fn a_dead_end_is_one_wall_also_behind_a_pillar() {
    let dead_end = [TUNNEL[0], TUNNEL[1], [[6.0, -2.0], [6.0, 2.0]]];
    for y_m in [-0.9, 0.0, 0.9] {
        let scene = [&dead_end[..], &pillar([3.0, y_m], 0.7)].concat();
        let sizes = components(&scan(&scene, all), &[]);
        assert_eq!(sizes.len(), 2, "the wall and the pillar, which is {y_m} m to the left: {sizes:?}");
    }
}

#[test]
fn a_pillar_in_a_closed_room_is_of_no_wall_though_there_is_but_one() {
    let corners = [[-5.0, -4.0], [6.0, -4.0], [6.0, 4.0], [-5.0, 4.0], [-5.0, -4.0]];
    let room: Vec<Segment> = corners.windows(2).map(|ends| [ends[0], ends[1]]).collect();
    for centre_m in [[3.0, 0.3], [2.5, -2.0], [-3.0, 1.0]] {
        let sizes = components(&scan(&[&room[..], &pillar(centre_m, 0.5)].concat(), all), &[]);
        assert!(sizes.len() == 2 && sizes[1] >= 15, "the wall and the pillar at {centre_m:?}: {sizes:?}");
    }
    assert_eq!(components(&scan(&room, all), &[]), [360]);
}

#[test]
fn a_pillar_is_a_component_of_its_own_and_both_walls_go_on() {
    let scene = [&TUNNEL[..], &pillar([5.0, 0.3], 0.5)].concat();
    let sizes = components(&scan(&scene, all), &[]);
    assert_eq!(sizes.len(), 3, "{sizes:?}");
    assert!(sizes[2] >= 8, "the pillar covers 12°: {sizes:?}");
}

#[test]
fn the_legs_of_the_vehicle_part_no_wall_though_they_are_nearer_to_it_than_a_vehicle_is_wide() {
    for half_m in [1.0, 1.2, 1.5] {
        let tunnel = TUNNEL.map(|wall| wall.map(|[x_m, y_m]| [x_m, 0.5 * half_m * y_m]));
        for (x_m, y_m) in [(0.3, 0.3), (0.35, 0.25), (0.25, 0.35)] {
            let legs = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
            let legs = legs.map(|[x, y]| pillar([x * x_m, y * y_m], 0.08)).concat();
            let sizes = components(&scan(&[&tunnel[..], &legs].concat(), all), &[]);
            assert_eq!(sizes.len(), 2 + 4, "walls {half_m} m off, legs at {x_m}, {y_m}: {sizes:?}");
        }
    }
}

#[test]
fn mixed_returns_at_the_edges_of_a_pillar_tie_it_to_no_wall() {
    for (x_m, y_m, radius_m) in [(4.0, 0.3, 0.4), (2.6, 1.1, 0.25), (3.2, -0.88, 0.5), (3.2, 0.88, 0.5)] {
        let scene = [&TUNNEL[..], &pillar([x_m, y_m], radius_m)].concat();
        let seen = scan(&scene, all);
        let on_pillar = |i: usize| {
            let Beam::Return(number) = seen.beams().expect("a sweep").beams[i] else { return false };
            (seen.points_m[number as usize].coords.xy() - Vector2::new(x_m, y_m)).norm() < radius_m + 0.1
        };
        let [first, last] = [(0..360).find(|&i| on_pillar(i)), (0..360).rfind(|&i| on_pillar(i))].map(Option::unwrap);
        for beams in [[first, last], [first - 1, last + 1], [first, last + 1]] {
            for share in [0.2, 0.4, 0.6, 0.8] {
                let found = walls(&mixed(&scene, &beams, share));
                assert_eq!(found, 3, "pillar at {x_m}, {y_m}, share {share} of {beams:?}");
            }
        }
    }
}

#[test]
fn two_pillars_beside_each_other_are_components_of_their_own_though_neither_hides_the_other() {
    // Between them nothing is seen, past both of them the walls of the tunnel are.
    let scene = [&TUNNEL[..], &pillar([2.5, 0.65], 0.3), &pillar([2.5, -0.65], 0.3)].concat();
    let sizes = components(&scan(&scene, all), &[]);
    assert_eq!(sizes.len(), 4, "two walls and both pillars: {sizes:?}");
    assert!(sizes[1] > 100 && sizes[2] < 20 && sizes[2] == sizes[3], "the scene is its own mirror image: {sizes:?}");
}

#[test]
fn a_pillar_in_a_branch_is_not_of_the_wall_behind_it_that_another_pillar_hides() {
    let right = [[[-30.0, -2.0], [2.0, -2.0]], [[7.0, -30.0], [7.0, -2.0]], [[7.0, -2.0], [30.0, -2.0]]];
    let walls = [&[TUNNEL[0]], &right[..]].concat();
    // On the line of the wall that goes on behind the branch; what is between them lies in the shadow of the nearer
    // pillar.
    let scene = [&walls[..], &pillar([4.0, -2.2], 0.4), &pillar([2.35, -0.9], 0.28)].concat();
    let sizes = components(&scan(&scene, all), &[]);
    assert_eq!(sizes.len(), 5, "three walls and both pillars: {sizes:?}");
}

/// A wall through `corners` that zigzags by `bump_m` to either side.
fn zigzag(corners: &[[f64; 2]], bump_m: f64) -> Vec<Segment> {
    let mut points = Vec::new();
    for pair in corners.windows(2) {
        let [dx, dy] = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
        let length_m = dx.hypot(dy);
        let steps = (length_m / 0.4).ceil();
        points.extend((0..=steps as usize).map(|k| {
            let (along, aside_m) = (k as f64 / steps, if k % 2 == 0 { bump_m } else { -bump_m });
            [pair[0][0] + along * dx - aside_m * dy / length_m, pair[0][1] + along * dy + aside_m * dx / length_m]
        }));
    }
    points.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

#[test]
fn what_stands_between_two_branches_is_their_tip_if_the_walls_are_as_rough_as_it_stands_out() {
    let fork = |bump_m: f64| {
        let around = [[12.0, 12.0], [0.0, 3.0], [-8.0, 3.0], [-8.0, -3.0], [0.0, -3.0], [12.0, -12.0]];
        let behind = [[14.0, 8.1], [5.5, 1.3], [5.5, -1.3], [14.0, -8.1]];
        let in_front = [[[4.0, -0.9], [4.0, 0.9]]];
        let scene = [zigzag(&around, bump_m), zigzag(&behind, bump_m), in_front.to_vec()].concat();
        components(&scan(&scene, all), &[]).iter().filter(|size| **size > 3).count()
    };
    assert_eq!((fork(0.0), fork(0.1)), (3, 2), "of smooth walls it is a pillar");
}

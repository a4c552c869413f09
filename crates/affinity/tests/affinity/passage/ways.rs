//! Ways on: where walls end.

use std::f64::consts::PI;

use super::{
    Segment, TUNNEL, all, bumps, components, mixed, scan, scan_as_far_as, scan_by, walls, with_branch, with_branch_at,
};

#[test]
fn a_mixed_return_at_the_edge_of_a_wall_closes_no_way_on() {
    for (near_m, width_m) in [(3.0, 2.5), (7.0, 4.0), (7.5, 3.0), (8.0, 3.5), (8.5, 3.5), (9.0, 3.0), (9.5, 4.0)] {
        let branch = with_branch_at(near_m, width_m);
        // The last beam into the branch, and the first on the near wall: beam 180 points half a degree left of ahead.
        let edge = 180 + (2.0_f64.atan2(near_m).to_degrees() - 0.5) as usize;
        for beam in [edge, edge + 1] {
            for share in [0.1, 0.3, 0.5, 0.7, 0.9] {
                assert_eq!(walls(&mixed(&branch, &[beam], share)), 3, "{near_m} {width_m} {beam} {share}");
            }
        }
    }
}

#[test]
fn ranges_that_are_not_exact_close_no_way_on() {
    // By 2 % of the range, as of small lidars.
    let mut state = 1_u64;
    let mut normal = || {
        let mut even = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| even()).sum::<f64>() - 6.0
    };
    let mut found = 0;
    for _ in 0..40 {
        let errors: Vec<f64> = (0..360).map(|_| 1.0 + 0.02 * normal()).collect();
        // A tunnel that meets another one ahead of it, 8 m away, at an angle.
        let tee = [[[-30.0, 2.0], [4.0, 2.0]], [[-30.0, -2.0], [4.0, -2.0]], [[10.0, -30.0], [7.0, 30.0]]];
        found += usize::from(walls(&scan(&tee, |beam, range_m| range_m.map(|m| m * errors[beam]))) == 3);
    }
    // A vehicle scans a place many times on its way, so one scan in twenty may be wrong.
    assert!(20 * found >= 19 * 40, "{found} of 40");
}

#[test]
fn inexact_ranges_make_no_wall_rough() {
    // By 3 cm, from beam to beam: bumps as high would hide as narrow a side passage.
    let inexact = |beam: usize, range_m: Option<f64>| range_m.map(|range_m| range_m + [0.0, 0.03, -0.03][beam % 3]);
    assert_eq!(walls(&scan(&with_branch(1.0), inexact)), 3);
    assert_eq!(walls(&scan(&with_branch(1.0), bumps(0.035))), 2);
}

#[test]
fn a_dark_patch_beside_the_vehicle_is_no_way_on_however_wide_the_angle() {
    let narrow = TUNNEL.map(|wall| wall.map(|[x_m, y_m]| [x_m, 0.6 * y_m]));
    for half_deg in [20, 30, 40] {
        let dark = |beam: usize, range_m| if beam.abs_diff(270) < half_deg { None } else { range_m };
        assert_eq!(components(&scan(&narrow, dark), &[]).len(), 2, "{half_deg}° to either side");
    }
}

#[test]
fn nothing_seen_is_a_way_on_where_no_other_beam_is_lost() {
    let dead_end = [TUNNEL[0], TUNNEL[1], [[6.0, -2.0], [6.0, 2.0]]];
    let nothing_seen = |beam: usize, range_m| if (190..206).contains(&beam) { None } else { range_m };
    assert_eq!(components(&scan(&dead_end, nothing_seen), &[]).len(), 2);
}

#[test]
fn walls_on_one_side_of_the_sensor_are_not_one_around_its_dark_other_side() {
    let line = |points_m: &[[f64; 2]]| points_m.windows(2).map(|ends| [ends[0], ends[1]]).collect::<Vec<Segment>>();
    let right = line(&[[3.7, 0.2], [3.6, 1.2], [3.9, 2.3], [4.3, 3.9], [3.8, 5.3], [3.0, 6.6], [2.3, 7.0]]);
    for out_m in [[-2.9, 5.3], [-3.3, 5.2], [-3.2, 5.6]] {
        // The left wall turns away from the sensor at its end.
        let left = line(&[[-1.1, 5.7], [-1.5, 5.0], [-2.1, 4.8], out_m]);
        assert_eq!(walls(&scan_as_far_as(12.0, 360, &[right.clone(), left].concat(), all)), 2, "{out_m:?}");
    }
}

#[test]
fn a_door_in_the_end_of_a_tunnel_is_a_way_on_unless_several_beams_in_a_row_get_lost_elsewhere() {
    let walls = |half_m: f64, lost: &[usize]| {
        let face = [[[6.0, -2.0], [6.0, -half_m]], [[6.0, half_m], [6.0, 2.0]]];
        let report = |beam: usize, range_m| if lost.contains(&beam) { None } else { range_m };
        components(&scan(&[&TUNNEL[..], &face].concat(), report), &[]).len()
    };
    assert_eq!((walls(0.3, &[]), walls(0.7, &[])), (1, 2), "0.6 m are too narrow");
    assert_eq!(walls(0.7, &[40, 80, 120]), 2, "single beams get lost anywhere");
    assert_eq!(walls(0.7, &[80, 81]), 1, "two in a row are enough to doubt the others");
}

#[test]
fn the_few_beams_that_a_dense_lidar_loses_close_no_door() {
    let face = [[[6.0, -2.0], [6.0, -0.7]], [[6.0, 0.7], [6.0, 2.0]]];
    // Pairs of beams a quarter of a degree apart, on both sides.
    let report = |beam: usize, range_m| if [320, 321, 360, 361, 1100, 1101].contains(&beam) { None } else { range_m };
    assert_eq!(components(&scan_by(1440, &[&TUNNEL[..], &face].concat(), report), &[]).len(), 2);
}

#[test]
fn a_branch_at_an_acute_angle_is_a_way_on_where_its_wall_is_seen_deep_behind_the_other_one() {
    let fork = |turn_deg: f64, roughness_m: f64| {
        // The sensor has passed it: its far wall leaves the left wall 8 m behind, and ends out of sight.
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        let branch = [[-8.0, 2.0], [-8.0 + 20.0 * cos, 2.0 + 20.0 * sin]];
        let left = [[[-30.0, 2.0], [-8.0, 2.0]], branch, [[-1.5, 2.0], [30.0, 2.0]]];
        components(&scan(&[&left[..], &TUNNEL[1..]].concat(), bumps(roughness_m)), &[]).len()
    };
    assert_eq!((fork(30.0, 0.0), fork(25.0, 0.0)), (3, 3));
    assert_eq!(fork(30.0, 0.1), 2, "a bump of such walls hides as much");
}

#[test]
fn a_branch_seen_from_straight_in_front_is_a_way_on_and_a_patch_of_lost_beams_is_none() {
    let side = |x_m: f64| [[[15.0 * x_m, 2.0], [x_m, 2.0]], [[x_m, 2.0], [x_m, 30.0]]];
    let front = [&side(-2.0)[..], &side(2.0), &TUNNEL[1..]].concat();
    assert_eq!(components(&scan(&front, all), &[]).len(), 3);
    let patch = |beam, range_m: Option<f64>| range_m.filter(|_| !(258..283).contains(&beam));
    assert_eq!(components(&scan(&TUNNEL, patch), &[]).len(), 2);
}

#[test]
fn where_nothing_is_seen_over_a_wide_angle_a_short_wall_that_points_across_closes_no_way() {
    // The face of the wall on the right runs towards the corner on the left, 3.9 m away.
    let corner = [[[3.9, 1.2], [2.8, 1.2]], [[2.8, 1.2], [2.8, 3.4]]];
    let scene = [&[[[3.2, -3.4], [3.2, -2.6]], [[-3.0, 4.0], [-3.0, -4.0]]][..], &corner].concat();
    assert_eq!(components(&scan(&scene, all), &[]).len(), 3);
}

#[test]
fn no_way_on_is_narrower_than_the_vehicle_however_deep_it_is_seen() {
    let walls = |width_m| components(&scan(&with_branch_at(0.3, width_m), all), &[]).len();
    assert_eq!((walls(0.5), walls(0.9)), (2, 3));
}

#[test]
fn a_gap_much_narrower_than_the_place_ends_no_wall_whose_bumps_may_hide_it_and_one_as_wide_does() {
    let walls = |width_m| components(&scan(&with_branch(width_m), bumps(0.06)), &[]).len();
    assert_eq!((walls(0.8), walls(4.0)), (2, 3));
    assert_eq!(components(&scan(&with_branch(0.8), all), &[]).len(), 3, "smooth");
}

#[test]
fn a_side_passage_is_a_way_on_also_where_only_the_face_of_its_corner_tells_it_from_a_hidden_stretch_of_wall() {
    // Its far side, 10 m ahead, is seen over half a metre; behind that corner the wall goes straight on.
    let sizes = components(&scan(&with_branch_at(8.0, 2.25), all), &[]);
    let [.., face] = sizes[..] else { panic!("no walls") };
    assert!(sizes.len() == 3 && sizes[1] > 100 && face < 20, "two long walls and a face: {sizes:?}");
}

#[test]
fn a_bend_is_no_end_of_a_tunnel_for_a_lidar_that_sees_the_outer_wall_far_behind_the_inner_one() {
    // The tunnel bends to the left ahead and behind; the beam past its inner wall goes on along that.
    let bent = |radius_m: f64, half_m: f64| -> Vec<Segment> {
        let wall = |offset_m: f64| {
            let corner = move |i: i32| {
                let (sin, cos) = (PI * f64::from(i) / 720.0).sin_cos();
                [(radius_m + offset_m) * sin, radius_m - (radius_m + offset_m) * cos]
            };
            (-360..360).map(move |i| [corner(i), corner(i + 1)])
        };
        wall(half_m).chain(wall(-half_m)).collect()
    };
    for (radius_m, half_m) in [30.0, 45.0, 60.0, 80.0, 110.0].into_iter().flat_map(|m| [1.2, 1.75, 2.5].map(|h| (m, h)))
    {
        for beams in [360, 720] {
            let seen = scan_as_far_as(60.0, beams, &bent(radius_m, half_m), all);
            assert_eq!(walls(&seen), 2, "radius {radius_m} m, half width {half_m} m, {beams} beams");
        }
    }
}

#[test]
fn a_side_passage_half_as_wide_as_the_tunnel_is_a_way_on_from_afar() {
    let walls = |near_m, width_m| components(&scan(&with_branch_at(near_m, width_m), all), &[]).len();
    assert_eq!((walls(4.0, 2.0), walls(8.0, 2.0), walls(9.0, 2.5)), (3, 3, 3));
}

#[test]
fn a_passage_that_leads_back_behind_a_wall_is_a_way_on_though_the_wall_behind_it_runs_almost_as_that_one() {
    let near = [[-7.5, 12.0], [-4.5, 1.5]];
    let behind = [[[-20.0, 12.0], [-4.5, -3.5]], [[-4.5, -3.5], [-4.5, -30.0]]];
    let opposite = [[1.0, -30.0], [1.0, 30.0]];
    assert_eq!(components(&scan(&[near, behind[0], behind[1], opposite], all), &[]).len(), 3);
}

#[test]
fn walls_that_two_far_returns_have_joined_are_cut_where_a_vehicle_passes_between_all_of_them() {
    // Of the far side of a branch 14.8 m ahead two returns are seen. They have no direction, so each gap beside them is
    // closed by what lies on a line; then both walls of the tunnel are one, and its end is a gap between two long
    // walls.
    let end_of_wall_lost = |beam: usize, range_m| if (195..215).contains(&beam) { None } else { range_m };
    let sizes = components(&scan(&with_branch_at(7.25, 7.5), end_of_wall_lost), &[]);
    assert!(sizes.len() == 2 && sizes[1] > 100, "two long walls: {sizes:?}");
}

#[test]
fn a_way_on_is_one_in_a_hall_as_well() {
    // A hall of 19 m; beside its corners passages 4 m wide lead off, of which one side is seen and then nothing: the
    // range ends.
    let half = |side: f64| {
        let (wall, far) = (side * 9.5, side * 40.0);
        let passage = [[[wall, side * 3.0], [far, side * 3.0]], [[wall, side * 7.0], [far, side * 7.0]]];
        let hall =
            [[[-wall, wall], [wall, wall]], [[wall, -wall], [wall, side * 3.0]], [[wall, side * 7.0], [wall, wall]]];
        [&passage[..], &hall].concat()
    };
    let hall = [half(-1.0), half(1.0)].concat();
    assert_eq!(components(&scan(&hall, all), &[]).len(), 2);
}

#[test]
fn the_end_of_a_fork_is_a_wall_of_its_own_though_its_branches_do_not_turn_back() {
    // Seen from the stem, 3.3 m before it: branches lead off 10° more ahead than at a T, so walls turn by 100° only.
    let rise = (10.0_f64).to_radians().tan();
    let branch = |side: f64| {
        let (near, far) = (side * 2.5, side * 30.0);
        [[[near, -30.0], [near, 3.3]], [[near, 3.3], [far, 3.3 + rise * 27.5]], [[0.0, 5.9], [far, 5.9 + rise * 30.0]]]
    };
    let fork = scan(&[branch(-1.0), branch(1.0)].concat(), all);
    assert_eq!(components(&fork, &[]).len(), 3);
}

#[test]
fn a_drift_across_the_end_of_a_wider_one_is_two_ways_on_at_whatever_angle() {
    // A stem 6 m wide, a drift of 3 to 4 m: on its acute side the far wall is seen no more than 1.6 m behind that of the stem.
    for (turn_deg, mouth_m, width_m) in
        [(70.0, 6.0, 4.0), (70.0, 8.0, 4.0), (60.0, 8.0, 3.0), (110.0, 7.0, 3.5), (90.0, 8.0, 3.0)]
    {
        let (sin, cos) = f64::to_radians(turn_deg).sin_cos();
        let (corner, far_m) = (|y: f64| [mouth_m + y * cos / sin, y], mouth_m + width_m / sin);
        let along = |[x, y]: [f64; 2], far_m: f64| [x + far_m * cos, y + far_m * sin];
        let side = |y: f64, far_m: f64| [[[-30.0, y], corner(y)], [corner(y), along(corner(y), far_m)]];
        let opposite = [along([far_m, 0.0], -30.0), along([far_m, 0.0], 30.0)];
        let walls = [&side(3.0, 30.0)[..], &side(-3.0, -30.0), &[opposite]].concat();
        let found = components(&scan_by(720, &walls, all), &[]).len();
        assert_eq!(found, 3, "{turn_deg}°, {mouth_m} m ahead, {width_m} m wide");
    }
}

#[test]
fn a_wall_seen_through_a_mouth_is_another_one_though_it_goes_on_as_straight_as_that_around_the_mouth() {
    // A room of 8 m by 6 m, its mouth in the middle of one side, and a drift along that side.
    let walls = |mouth_m: f64, drift_m: f64| {
        let (half_m, far_m) = (0.5 * mouth_m, 3.0 + drift_m);
        let left = [[[-4.0, -3.0], [-4.0, 3.0]], [[-4.0, 3.0], [-half_m, 3.0]], [[-25.0, far_m], [25.0, far_m]]];
        let right = [[[4.0, -3.0], [4.0, 3.0]], [[half_m, 3.0], [4.0, 3.0]], [[-4.0, -3.0], [4.0, -3.0]]];
        components(&scan_by(720, &[left, right].concat(), all), &[]).len()
    };
    for mouth_m in [1.5, 2.0, 3.0, 4.0] {
        assert_eq!((walls(mouth_m, 3.0), walls(mouth_m, 4.0)), (2, 2), "mouth of {mouth_m} m");
    }
    assert_eq!(walls(3.0, 1.0), 1, "a niche 1 m deep");
}

#[test]
fn a_wall_seen_at_a_slant_through_a_mouth_far_aside_is_another_one() {
    for (from_m, near_m) in [(2.5, 2.0), (3.0, 2.0), (3.0, 2.4), (3.5, 2.6)] {
        for drift_m in [2.0, 2.5, 3.0] {
            let (to_m, far_m) = (from_m + 3.0, near_m + drift_m);
            let side = [[[-3.0, near_m], [from_m, near_m]], [[to_m, near_m], [8.0, near_m]]];
            let ends = [[[-3.0, -2.0], [-3.0, near_m]], [[8.0, -2.0], [8.0, near_m]]];
            let along = [[[-3.0, -2.0], [8.0, -2.0]], [[-25.0, far_m], [25.0, far_m]]];
            let found = walls(&scan_by(720, &[side, ends, along].concat(), all));
            assert_eq!(found, 2, "from {from_m} m on, {near_m} m beside, a drift of {drift_m} m");
        }
    }
}

#[test]
fn a_wall_seen_through_a_door_is_another_one_though_it_runs_as_the_wall_around_the_door_does() {
    // A room of 6 m by 5 m, its door somewhere in one side, and a corridor along that side, 2 m wide.
    for (from_m, door_m) in [(-2.8, 0.9), (-1.0, 0.9), (0.5, 1.0), (1.8, 1.1)] {
        for beside_m in [1.0, 2.0, 3.5] {
            let (left_m, right_m, near_m, far_m) = (-3.0, 3.0, beside_m, beside_m + 2.0);
            let sides = [[[left_m, near_m - 5.0], [left_m, near_m]], [[right_m, near_m - 5.0], [right_m, near_m]]];
            let door = [[[left_m, near_m], [from_m, near_m]], [[from_m + door_m, near_m], [right_m, near_m]]];
            let ends = [[[left_m, near_m - 5.0], [right_m, near_m - 5.0]], [[-25.0, far_m], [25.0, far_m]]];
            for bump_m in [0.0, 0.015] {
                let room = scan_by(720, &[sides, door, ends].concat(), bumps(bump_m));
                assert_eq!(walls(&room), 2, "{door_m} m from {from_m} m on, {beside_m} m ahead, bumps {bump_m} m");
            }
        }
    }
}

#[test]
fn a_slit_that_no_vehicle_passes_parts_no_wall_though_another_one_is_seen_through_it() {
    // A box half a metre and more in front of the wall on the left, and a slit between it and the next, of which the far
    // side is seen.
    let mut parted = Vec::new();
    for wall_m in [2.3, 2.4, 2.5] {
        for from_m in [0.3, 0.5, 1.0, 2.0, 3.0] {
            for slit_m in [0.2, 0.3, 0.4] {
                let to_m = from_m + slit_m;
                let belt = [[[-30.0, 1.7], [from_m, 1.7]], [[to_m, 1.7], [30.0, 1.7]]];
                let slit = [[[from_m, 1.7], [from_m, wall_m]], [[to_m, 1.7], [to_m, wall_m]]];
                let sides = [[[-30.0, wall_m], [30.0, wall_m]], TUNNEL[1]];
                if walls(&scan_by(720, &[belt, slit, sides].concat(), all)) != 2 {
                    parted.push((wall_m, from_m, slit_m));
                }
            }
        }
    }
    assert_eq!(parted, [], "the wall, from where on the slit, how wide");
}

#[test]
fn a_bend_is_no_dead_end_though_little_is_seen_of_its_far_wall_behind_the_corner() {
    // The tunnel turns right; past its inner corner, three to five beams meet the outer wall up to 0.13 to 0.43 m behind the line.
    let mut closed = Vec::new();
    for (half_m, corner_m, turn_deg) in [(1.0, 5.0, 105.0), (1.0, 6.0, 100.0), (1.4, 7.0, 110.0), (1.75, 8.0, 100.0)] {
        let (sin, cos) = f64::to_radians(turn_deg).sin_cos();
        let width_m = 2.0 * half_m;
        let onward = |[x, y]: [f64; 2]| [[x, y], [x + 20.0 * cos, y - 20.0 * sin]];
        let [inner, outer] = [[corner_m, -half_m], [corner_m + width_m * (1.0 + cos) / sin, half_m]];
        let sides = [[[-30.0, -half_m], inner], [[-30.0, half_m], outer]];
        if walls(&scan_by(720, &[sides, [onward(inner), onward(outer)]].concat(), all)) != 2 {
            closed.push((half_m, corner_m, turn_deg));
        }
    }
    assert_eq!(closed, [], "half width, how far ahead the corner is, how far the tunnel turns");
}

#[test]
fn a_row_of_props_along_a_wall_parts_it_nowhere_though_each_hides_the_wall_behind_it() {
    // Timber sets: square props 0.05 or 0.1 m in front of both walls. Far along them only the props are seen.
    let mut parted = Vec::new();
    for spacing_m in [1.1, 1.3, 1.5, 1.7, 1.9] {
        for (size_m, off_m) in [(0.15, 0.05), (0.2, 0.05), (0.3, 0.05), (0.3, 0.1)] {
            for half_m in [1.5, 2.0] {
                let sets = (0..60).map(|set| spacing_m * (f64::from(set) - 30.0 + 0.3));
                let props = sets.flat_map(|x| [(x, -1.0), (x, 1.0)]).flat_map(|(x, side)| {
                    let [near, far] = [half_m - off_m - size_m, half_m - off_m].map(|y| side * y);
                    let corners = [[x, near], [x + size_m, near], [x + size_m, far], [x, far], [x, near]];
                    [0, 1, 2, 3].map(|k| [corners[k], corners[k + 1]])
                });
                let sides = [1.0, -1.0].map(|side| [[-60.0, side * half_m], [60.0, side * half_m]]);
                let tunnel: Vec<Segment> = sides.into_iter().chain(props).collect();
                if walls(&scan_by(720, &tunnel, all)) != 2 {
                    parted.push((spacing_m, size_m, off_m, half_m));
                }
            }
        }
    }
    assert_eq!(parted, [], "spacing, size, in front of the wall, half width");
}

#[test]
fn a_wall_that_runs_away_behind_a_door_is_another_one() {
    // Through a door in the left wall one side of the room behind it is seen, which leads away from the tunnel.
    let door = [[[-30.0, 2.0], [3.0, 2.0]], [[5.5, 2.0], [30.0, 2.0]]];
    let room = [[9.6, 3.45], [7.5, 10.5]];
    assert_eq!(components(&scan_by(720, &[&door[..], &TUNNEL[1..], &[room]].concat(), all), &[]).len(), 4);
}

#[test]
fn a_room_seen_through_a_door_is_no_other_side_of_the_tunnel() {
    // The room is seen over a wide angle, and its side walls run back towards the line of the wall with the door.
    for (door_m, deep_m) in [(1.0, 6.0), (1.5, 6.0), (1.8, 6.0), (2.0, 6.0), (2.0, 7.0)] {
        for side in [1.0, -1.0] {
            let (near_m, far_m, half_m) = (2.0 * side, (2.0 + deep_m) * side, door_m / 2.0);
            let door = [[[-30.0, near_m], [-half_m, near_m]], [[half_m, near_m], [30.0, near_m]]];
            let ends = [[[-4.0, near_m], [-4.0, far_m]], [[4.0, near_m], [4.0, far_m]]];
            let across = [[[-4.0, far_m], [4.0, far_m]], [[-30.0, -near_m], [30.0, -near_m]]];
            let found = walls(&scan(&[door, ends, across].concat(), all));
            assert_eq!(found, 4, "a door of {door_m} m into a room {deep_m} m deep, side {side}");
        }
    }
}

#[test]
fn a_drift_across_the_end_of_a_narrow_tunnel_is_two_ways_on_though_few_beams_show_that_the_sides_end() {
    // The last returns of the sides are a metre apart and more, and the next beams pass some centimetres behind them.
    for (half_m, ahead_m) in [(0.7, 8.0), (0.8, 9.5), (0.9, 8.5), (1.0, 9.5), (1.2, 9.5)] {
        let side = |side: f64| {
            [[[-30.0, side * half_m], [ahead_m, side * half_m]], [[ahead_m, side * half_m], [ahead_m, side * 30.0]]]
        };
        let far = [[ahead_m + 2.0, -30.0], [ahead_m + 2.0, 30.0]];
        let found = components(&scan(&[&side(1.0)[..], &side(-1.0), &[far]].concat(), all), &[]).len();
        assert_eq!(found, 3, "{ahead_m} m ahead, {} m wide", 2.0 * half_m);
    }
}

#[test]
fn a_narrow_side_passage_that_leads_back_is_a_way_on_unless_the_walls_are_so_rough_that_they_hide_as_much() {
    // Of its far side, which leaves the tunnel at 120° to 140°, half a metre is seen.
    let walls = |turn_deg: f64, width_m: f64, near_m: f64, half_m: f64, roughness_m: f64| {
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        let side = |x: f64| [[x, half_m], [x + 12.0 * cos, half_m + 12.0 * sin]];
        let far_m = near_m + width_m / sin;
        let left = [[[-30.0, half_m], [near_m, half_m]], side(near_m), side(far_m), [[far_m, half_m], [30.0, half_m]]];
        let right = [[-30.0, -half_m], [30.0, -half_m]];
        components(&scan(&[&left[..], &[right]].concat(), bumps(roughness_m)), &[]).len()
    };
    for (turn_deg, width_m, near_m, half_m) in [(120.0, 2.0, 6.0, 1.0), (130.0, 1.2, 6.0, 2.0), (140.0, 1.2, 6.0, 1.5)]
    {
        let walls = |roughness_m| walls(turn_deg, width_m, near_m, half_m, roughness_m);
        assert_eq!((walls(0.0), walls(0.12)), (3, 2), "{turn_deg}°, {width_m} m wide, {near_m} m ahead");
    }
}

#[test]
fn a_door_narrower_than_the_vehicle_ends_no_wall() {
    let side_door = [TUNNEL[0], [[-30.0, -2.0], [0.0, -2.0]], [[0.5, -2.0], [30.0, -2.0]], [[-2.0, -9.0], [2.0, -9.0]]];
    let narrow = components(&scan(&side_door, all), &[]);
    assert_eq!(narrow.iter().filter(|size| **size > 20).count(), 2, "{narrow:?}");
}

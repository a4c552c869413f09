//! Walls that go on: dead ends, bumps, lost beams.

use super::{Segment, TUNNEL, all, components, scan, scan_as_far_as, scan_by};

#[test]
fn a_wall_goes_on_across_beams_that_were_lost_and_behind_a_bump() {
    let lost = |beam: usize, range_m| if (75..90).contains(&beam) { None } else { range_m };
    assert_eq!(components(&scan(&TUNNEL, lost), &[]).len(), 2);
    let bump = [TUNNEL[0], TUNNEL[1], [[4.0, -2.0], [4.2, -1.5]], [[4.2, -1.5], [4.4, -2.0]]];
    assert_eq!(components(&scan(&bump, all), &[]).len(), 2);
    let dead_end = [TUNNEL[0], TUNNEL[1], [[6.0, -2.0], [6.0, 2.0]]];
    let corner_lost = |beam: usize, range_m| if (190..206).contains(&beam) { None } else { lost(beam, range_m) };
    assert_eq!(components(&scan(&dead_end, corner_lost), &[]).len(), 1);
}

#[test]
fn a_dead_end_is_one_wall_though_single_beams_are_lost_along_its_sides() {
    for end_m in [6.0, 8.0, 10.0, 12.0] {
        let dead_end = [TUNNEL[0], TUNNEL[1], [[end_m, -2.0], [end_m, 2.0]]];
        for odd in 0..2 {
            let lost = |beam: usize, range_m| {
                if (185..220).contains(&beam) && beam % 2 == odd { None } else { range_m }
            };
            assert_eq!(components(&scan(&dead_end, lost), &[]).len(), 1, "{end_m} {odd}");
        }
    }
}

#[test]
fn narrow_dead_ends_with_bumps_seldom_have_a_way_on() {
    // 2 m wide, its end 4 to 5 widths ahead, with bumps of up to 6 cm: 141 of these had an opening where one hides the wall.
    let mut wrong = 0;
    for (place, end_m) in (0..200).zip([8.0, 8.5, 9.0, 9.5, 10.0].into_iter().cycle()) {
        let bump_m = |x: f64, phase: f64| {
            [1.3, 2.1, 3.7, 6.1].map(|wave| 0.015 * (wave * x + phase * wave.sqrt()).sin()).iter().sum::<f64>()
        };
        let side = |y: f64| -> Vec<Segment> {
            let phase = f64::from(place) + y;
            let corners = (0..=250).map(|i| end_m - 0.1 * f64::from(i)).map(|x| [x, y + bump_m(x, phase)]);
            let corners: Vec<[f64; 2]> = corners.collect();
            corners.windows(2).map(|pair| [pair[0], pair[1]]).collect()
        };
        let segments = [side(1.0), side(-1.0), vec![[[end_m, -1.1], [end_m, 1.1]]]].concat();
        wrong += usize::from(components(&scan_by(720, &segments, all), &[]).len() != 1);
    }
    // A vehicle scans a place many times on its way, so one scan in twenty may be wrong.
    assert!(20 * wrong <= 200, "{wrong} of 200 dead ends have an opening");
}

#[test]
fn a_dead_end_is_one_wall_though_its_end_goes_on_past_the_line_of_the_nearer_side() {
    // Of the nearer side's end nothing is seen from 8 m on, over a metre; from 6 m on it would be taken for a bend.
    let end = [[8.8, -2.0], [9.4, 2.2]];
    let sides = [[[-30.0, -0.8], [8.0, -0.8]], [[-30.0, 2.2], [9.4, 2.2]]];
    assert_eq!(components(&scan(&[&[end][..], &sides].concat(), all), &[]).len(), 1);
}

#[test]
fn a_dead_end_is_one_wall_from_wherever_its_end_is_seen() {
    // Its sides are seen at a grazing angle: their last returns are farther from each other than a vehicle is wide.
    for (width_m, share) in [1.2, 1.6, 2.2, 3.0, 4.0].into_iter().flat_map(|m| [0.3, 0.4, 0.5].map(|share| (m, share)))
    {
        let (right_m, left_m) = (-share * width_m, (1.0 - share) * width_m);
        for end_m in (1..=24).map(|half| 0.5 * f64::from(half)) {
            let side = |y_m: f64| [[-30.0, y_m], [end_m, y_m]];
            let dead_end = [side(right_m), side(left_m), [[end_m, right_m], [end_m, left_m]]];
            let walls = components(&scan(&dead_end, all), &[]).len();
            assert_eq!(walls, 1, "{width_m} m wide, {share} of it to the right, end {end_m} m ahead");
        }
    }
}

#[test]
fn a_dead_end_is_one_wall_also_where_it_is_seen_so_far_away_that_returns_of_its_sides_are_metres_apart() {
    for (half_m, end_m) in [1.0, 1.5, 2.0].into_iter().flat_map(|half| [15.0, 20.0, 25.0].map(|end| (half, end))) {
        let side = |y_m: f64| [[-80.0, y_m], [end_m, y_m]];
        let dead_end = [side(half_m), side(-half_m), [[end_m, half_m], [end_m, -half_m]]];
        let walls = components(&scan_as_far_as(40.0, 360, &dead_end, all), &[]).len();
        assert_eq!(walls, 1, "{half_m} m to either side, end {end_m} m ahead");
    }
}

#[test]
fn a_bend_by_more_than_a_right_angle_is_no_dead_end_though_its_outer_wall_comes_back() {
    let half_m = 1.5;
    let (sin, cos) = (120.0_f64).to_radians().sin_cos();
    let corner_m = half_m * (60.0_f64).to_radians().tan();
    for ahead_m in [3.0, 4.0, 5.0, 6.0] {
        let walls = [(-corner_m, half_m), (corner_m, -half_m)].map(|(x, y)| {
            let corner = [ahead_m + x, y];
            [[[-30.0, y], corner], [corner, [corner[0] + 30.0 * cos, corner[1] + 30.0 * sin]]]
        });
        assert_eq!(components(&scan(walls.as_flattened(), all), &[]).len(), 2, "bend {ahead_m} m ahead");
    }
}

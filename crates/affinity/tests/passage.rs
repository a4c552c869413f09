//! The graph of passages on scenes computed by hand: straight walls, one ray per degree, range limit 15 m.

use std::f64::consts::{PI, TAU};

use crosscut_affinity::Passage;
use crosscut_stage::{Affinity, AffinityStage, Beam, Notes, Point, Revolution, Sweep, Value, wrap_angle_rad};

/// A wall from one end to the other.
type Segment = [[f64; 2]; 2];

/// Edges between walls are weaker.
const LEAK: f64 = 1e-5;

/// Both walls of a tunnel along x, 4 m wide.
const TUNNEL: [Segment; 2] = [[[-30.0, 2.0], [30.0, 2.0]], [[-30.0, -2.0], [30.0, -2.0]]];

/// Where a ray from the origin meets a segment.
fn hit_m([a, b]: &Segment, bearing_rad: f64) -> Option<f64> {
    let ((dy, dx), (ex, ey)) = (bearing_rad.sin_cos(), (b[0] - a[0], b[1] - a[1]));
    let det = ex * dy - ey * dx;
    let (range_m, along) = ((ex * a[1] - ey * a[0]) / det, (dx * a[1] - dy * a[0]) / det);
    (range_m > 0.0 && (0.0..=1.0).contains(&along)).then_some(range_m)
}

/// 360 beams from -π; `report` may change what a beam of this number reports.
fn scan(segments: &[Segment], report: impl Fn(usize, Option<f64>) -> Option<f64>) -> Revolution {
    scan_by(360, segments, report)
}

/// The same with so many beams.
fn scan_by(beams: usize, segments: &[Segment], report: impl Fn(usize, Option<f64>) -> Option<f64>) -> Revolution {
    let step_rad = TAU / beams as f64;
    let (mut points_m, mut sweep) =
        (Vec::new(), Sweep { step_rad, range_max_m: 15.0, full_turn: true, ..Sweep::default() });
    for beam in 0..beams {
        let bearing_rad = wrap_angle_rad(-PI + (beam as f64 + 0.5) * step_rad);
        let seen_m = segments.iter().filter_map(|segment| hit_m(segment, bearing_rad)).min_by(f64::total_cmp);
        sweep.bearings_rad.push(bearing_rad);
        sweep.beams.push(match report(beam, seen_m.filter(|range_m| *range_m < 15.0)) {
            Some(range_m) => {
                points_m.push(Point::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin(), 0.0));
                Beam::Return(points_m.len() as u32 - 1)
            }
            None => Beam::NoReturn,
        });
    }
    Revolution { points_m, sweep: Some(sweep), ..Revolution::default() }
}

/// As reported.
fn all(_: usize, range_m: Option<f64>) -> Option<f64> {
    range_m
}

/// The tunnel with a side branch of that width, of which the far wall is seen and none of the near one.
fn with_branch(width_m: f64) -> Vec<Segment> {
    with_branch_at(3.0, width_m)
}

/// The same, so many metres ahead.
fn with_branch_at(near_m: f64, width_m: f64) -> Vec<Segment> {
    let far_m = near_m + width_m;
    let left = [[[-30.0, 2.0], [near_m, 2.0]], [[near_m, 2.0], [near_m, 30.0]], [[far_m, 30.0], [far_m, 2.0]]];
    [&left[..], &[[[far_m, 2.0], [30.0, 2.0]], TUNNEL[1]]].concat()
}

/// Sizes of the components of the graph without its leaks, largest first.
fn components(revolution: &Revolution, settings: &[(&'static str, Value)]) -> Vec<usize> {
    let mut affinity = Affinity::default();
    let mut stage = Passage::new(settings).expect("allowed");
    stage.affinity(revolution, &mut affinity, &mut Notes::default()).expect("a scan");
    let mut component: Vec<usize> = (0..revolution.len()).collect();
    for _ in 0..revolution.len() {
        affinity.weights.for_each(|i, j, weight| {
            if weight > LEAK {
                component[i] = component[i].min(component[j]);
            }
        });
    }
    let size = |root: usize| component.iter().filter(|c| **c == root).count();
    let mut sizes: Vec<usize> = (0..revolution.len()).map(size).filter(|size| *size > 0).collect();
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes
}

#[test]
fn a_tunnel_is_two_walls_a_dead_end_one_and_a_crossing_four() {
    let n = scan(&TUNNEL, all).len();
    assert_eq!(components(&scan(&TUNNEL, all), &[]), [n / 2, n / 2]);
    let dead_end = [TUNNEL[0], TUNNEL[1], [[6.0, -2.0], [6.0, 2.0]]];
    assert_eq!(components(&scan(&dead_end, all), &[]).len(), 1);
    let corner =
        |x: f64, y: f64| [[[x * 2.0, y * 2.0], [x * 2.0, y * 30.0]], [[x * 2.0, y * 2.0], [x * 30.0, y * 2.0]]];
    let crossing = [corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)].concat();
    assert_eq!(components(&scan(&crossing, all), &[]).len(), 4);
}

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
fn nothing_seen_is_a_way_on_where_no_other_beam_is_lost() {
    let dead_end = [TUNNEL[0], TUNNEL[1], [[6.0, -2.0], [6.0, 2.0]]];
    let nothing_seen = |beam: usize, range_m| if (190..206).contains(&beam) { None } else { range_m };
    assert_eq!(components(&scan(&dead_end, nothing_seen), &[]).len(), 2);
}

#[test]
fn a_door_in_the_end_of_a_tunnel_is_a_way_on_unless_beams_get_lost_elsewhere() {
    let walls = |half_m: f64, lost: &[usize]| {
        let face = [[[6.0, -2.0], [6.0, -half_m]], [[6.0, half_m], [6.0, 2.0]]];
        let report = |beam: usize, range_m| if lost.contains(&beam) { None } else { range_m };
        components(&scan(&[&TUNNEL[..], &face].concat(), report), &[]).len()
    };
    assert_eq!((walls(0.3, &[]), walls(0.7, &[])), (1, 2), "0.6 m are too narrow");
    assert_eq!(walls(0.7, &[80]), 1, "one lost beam is enough to doubt the others");
}

#[test]
fn a_branch_at_an_acute_angle_is_a_way_on_where_its_wall_is_seen_deep_behind_the_other_one() {
    let fork = |turn_deg: f64, roughness_m: f64| {
        // The sensor has passed it: its far wall leaves the left wall 8 m behind, and ends out of sight.
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        let branch = [[-8.0, 2.0], [-8.0 + 20.0 * cos, 2.0 + 20.0 * sin]];
        let left = [[[-30.0, 2.0], [-8.0, 2.0]], branch, [[-1.5, 2.0], [30.0, 2.0]]];
        let bumps = |beam: usize, range_m: Option<f64>| {
            range_m.map(|range_m| range_m + roughness_m * [0.0, 1.0, -1.0][beam % 3])
        };
        components(&scan(&[&left[..], &TUNNEL[1..]].concat(), bumps), &[]).len()
    };
    assert_eq!((fork(30.0, 0.0), fork(25.0, 0.0)), (3, 3));
    assert_eq!(fork(30.0, 0.1), 2, "a bump of such walls hides as much");
}

#[test]
fn narrow_dead_ends_with_bumps_seldom_have_a_way_on() {
    // 2 m wide, its end 4 to 5 widths ahead, with bumps of up to 6 cm: 141 of these had a way on where one hides the wall.
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
    assert!(wrong <= 8, "{wrong} of 200 dead ends have a way on");
}

#[test]
fn a_branch_seen_from_straight_in_front_is_a_way_on_and_a_patch_of_lost_beams_is_none() {
    let front = [[[-30.0, 2.0], [-2.0, 2.0]], [[2.0, 2.0], [30.0, 2.0]], TUNNEL[1]];
    assert_eq!(components(&scan(&front, all), &[]).len(), 3);
    let patch = |beam, range_m: Option<f64>| range_m.filter(|_| !(258..283).contains(&beam));
    assert_eq!(components(&scan(&TUNNEL, patch), &[]).len(), 2);
}

#[test]
fn a_piece_too_small_for_a_wall_is_one_if_the_end_of_the_view_cuts_it() {
    let in_view_from_behind = |stub: Segment| {
        let mut revolution = scan(&[[[3.0, -2.0], [3.0, 2.0]], stub], all);
        revolution.sweep.as_mut().expect("a sweep").full_turn = false;
        components(&revolution, &[("wall_deg", Value::Number(10.0))])
    };
    assert_eq!(in_view_from_behind([[-3.0, -0.26], [-3.0, 0.0]]), [68, 5]);
    assert_eq!(in_view_from_behind([[-3.0, -0.76], [-3.0, -0.5]])[1], 1, "seen whole");
}

#[test]
fn a_few_returns_amid_a_limited_view_are_no_wall_though_the_view_ends_without_a_lost_beam() {
    let corners = [[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0], [-3.0, -3.0]];
    let room: Vec<Segment> = corners.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    let mut revolution = scan(&[&room[..], &[[[1.2, -0.04], [1.2, 0.04]]]].concat(), all);
    revolution.sweep.as_mut().expect("a sweep").full_turn = false;
    let settings = [("wall_deg", Value::Number(10.0)), ("island_m", Value::Number(0.0))];
    assert_eq!(components(&revolution, &settings), [360]);
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
    let bumps = |beam: usize, range_m: Option<f64>| range_m.map(|range_m| range_m + [0.0, 0.06, -0.06][beam % 3]);
    let walls = |width_m| components(&scan(&with_branch(width_m), bumps), &[]).len();
    assert_eq!((walls(0.8), walls(4.0)), (2, 3));
    assert_eq!(components(&scan(&with_branch(0.8), all), &[]).len(), 3, "smooth");
}

#[test]
fn a_side_passage_is_a_way_on_also_where_only_the_face_of_its_corner_tells_it_from_a_hidden_stretch_of_wall() {
    // Its far side, 10 m ahead, is seen over half a metre; behind that corner the wall goes straight on.
    assert_eq!(components(&scan(&with_branch_at(8.0, 2.25), all), &[]), [164, 158, 6]);
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
fn a_dead_end_is_one_wall_though_its_end_goes_on_past_the_line_of_the_nearer_side() {
    // Of the nearer side's end nothing is seen from 6 m on, over as much as the place is wide.
    let end = [[[9.4, -4.7], [10.0, -2.5]], [[10.0, -2.5], [11.2, 2.0]]];
    let sides = [[[-30.0, -1.5], [6.0, -1.5]], [[-30.0, 2.0], [11.2, 2.0]]];
    assert_eq!(components(&scan(&[end, sides].concat(), all), &[]).len(), 1);
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

#[test]
fn walls_that_two_far_returns_have_joined_are_cut_where_a_vehicle_passes_between_all_of_them() {
    // Of the far side of a branch 14.8 m ahead two returns are seen. They have no direction, so each gap beside them is
    // closed by what lies on a line; then both walls of the tunnel are one, and its end is a gap between two long
    // walls.
    let end_of_wall_lost = |beam: usize, range_m| if (195..215).contains(&beam) { None } else { range_m };
    assert_eq!(components(&scan(&with_branch_at(7.25, 7.5), end_of_wall_lost), &[]), [164, 139]);
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
fn dust_and_the_vehicle_itself_are_tied_to_nothing() {
    let dusty = |beam: usize, range_m| if beam % 45 == 10 { Some(0.4 + 0.003 * beam as f64) } else { range_m };
    let sizes = components(&scan(&TUNNEL, dusty), &[]);
    assert_eq!((sizes.len(), sizes.iter().filter(|size| **size == 1).count()), (2 + 8, 8), "{sizes:?}");
    let own_rig = |beam: usize, range_m| if (80..100).contains(&beam) { Some(0.1) } else { range_m };
    let hidden = scan(&TUNNEL, own_rig);
    let sizes = components(&hidden, &[]);
    assert_eq!((sizes.len(), sizes.iter().filter(|size| **size == 1).count()), (2 + 20, 20), "{sizes:?}");
    let mut notes = Notes::default();
    Passage::new(&[]).expect("allowed").affinity(&hidden, &mut Affinity::default(), &mut notes).expect("a scan");
    let told = "passage: 20 returns within the vehicle, nearer than 0.3 m, tied to none";
    assert_eq!(notes.iter().collect::<Vec<_>>(), [told]);
}

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
fn a_pillar_is_a_component_of_its_own_and_both_walls_go_on() {
    let scene = [&TUNNEL[..], &pillar([5.0, 0.3], 0.5)].concat();
    let sizes = components(&scan(&scene, all), &[]);
    assert_eq!(sizes.len(), 3, "{sizes:?}");
    assert!(sizes[2] >= 8, "the pillar covers 12°: {sizes:?}");
}

#[test]
fn two_pillars_beside_each_other_are_components_of_their_own_though_neither_hides_the_other() {
    // Between them nothing is seen, past both of them the walls of the tunnel are.
    let scene = [&TUNNEL[..], &pillar([2.5, 0.65], 0.3), &pillar([2.5, -0.65], 0.3)].concat();
    assert_eq!(components(&scan(&scene, all), &[]), [151, 151, 13, 13]);
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

#[test]
fn a_door_narrower_than_the_vehicle_ends_no_wall() {
    let side_door = [TUNNEL[0], [[-30.0, -2.0], [0.0, -2.0]], [[0.5, -2.0], [30.0, -2.0]], [[-2.0, -9.0], [2.0, -9.0]]];
    let narrow = components(&scan(&side_door, all), &[]);
    assert_eq!(narrow.iter().filter(|size| **size > 20).count(), 2, "{narrow:?}");
}

/// The edges weaker than any within a wall.
fn leaks(revolution: &Revolution, settings: &[(&'static str, Value)]) -> Vec<f64> {
    let mut affinity = Affinity::default();
    let mut stage = Passage::new(settings).expect("allowed");
    stage.affinity(revolution, &mut affinity, &mut Notes::default()).expect("a scan");
    let mut leaks = Vec::new();
    affinity.weights.for_each(|i, j, weight| {
        if i < j && weight < LEAK {
            leaks.push(weight);
        }
    });
    leaks
}

#[test]
fn a_doubtful_way_on_leaks_more_than_a_clear_one_and_none_does_without_leak() {
    let most = |width_m| leaks(&scan(&with_branch(width_m), all), &[]).into_iter().fold(0.0, f64::max);
    assert_eq!(leaks(&scan(&TUNNEL, all), &[]).len(), 2);
    assert!(most(4.0) > 2.0 * most(7.0), "{} {}", most(4.0), most(7.0));
    assert!(leaks(&scan(&TUNNEL, all), &[("leak", Value::Number(0.0))]).is_empty());
}

#[test]
fn a_number_out_of_range_is_refused_by_its_name() {
    for (name, bad) in [("passage_m", 0.0), ("straight_deg", 181.0), ("stretch_m", -1.0), ("island_m", f64::NAN)] {
        let refused = Passage::new(&[(name, Value::Number(bad))]).expect_err("must be refused");
        assert_eq!(refused.name, name);
    }
}

#[test]
fn verdicts_say_where_walls_end_and_where_they_go_on_over_a_gap() {
    // A tee whose far wall has lost 5 beams straight ahead of the sensor.
    let patch = |beam: usize, range_m| if (88..93).contains(&beam) { None } else { range_m };
    let revolution = scan(&with_branch(3.0), patch);
    let mut affinity = Affinity::default();
    for _ in 0..2 {
        let mut stage = Passage::new(&[]).expect("allowed");
        stage.affinity(&revolution, &mut affinity, &mut Notes::default()).expect("a scan");
        let ways: Vec<_> = affinity.verdicts.iter().filter(|verdict| verdict.is_way).collect();
        assert_eq!(ways.len(), 3, "ahead, behind and into the branch, in a used buffer too: {:?}", affinity.verdicts);
        assert!(ways.iter().all(|way| way.room_ratio > 1.0), "{ways:?}");
        let closed: Vec<_> = affinity.verdicts.iter().filter(|verdict| !verdict.is_way).collect();
        assert!(!closed.is_empty() && closed.iter().all(|gap| gap.room_ratio < 1.0), "{closed:?}");
    }
}

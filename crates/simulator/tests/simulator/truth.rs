//! Truth of scenes whose walls and openings can be computed by hand: smooth walls, and a lidar without errors.

use std::f64::consts::{FRAC_PI_2, PI};

use crosscut_simulator::lidar::{Echo, Lidar};
use crosscut_simulator::network::{Disc, Network, Point};
use crosscut_simulator::pose::{Motion, Pose};
use crosscut_simulator::surface::{Surface, Texture};
use crosscut_simulator::truth::Scenery;
use crosscut_simulator::{Mine, Places};
use crosscut_stage::wrap_angle_rad;
use proptest::prelude::{Strategy, prop_assert, prop_assert_eq, proptest};

/// Half the width of the tunnels.
const HALF_M: f64 = 2.0;

fn at(x: f64, y: f64) -> Point {
    Point::new(x, y)
}

/// Straight tunnels from the first point to each of the others.
fn star(centre: Point, ends: &[Point], half_width_m: f64) -> Network {
    let mut network = Network::new(4.0);
    let node = network.add_node(centre);
    for &end in ends {
        network.add_branch(node, vec![centre, end], vec![half_width_m; 2]);
    }
    network
}

fn straight() -> Network {
    star(at(-30.0, 0.0), &[at(30.0, 0.0)], HALF_M)
}

fn look(network: Network, lidar: &Lidar, position_m: Point, heading_rad: f64) -> (Scenery, Vec<Echo>) {
    let surface = Surface::new(&network, &Texture::SMOOTH, 0);
    let motion = Motion::still(Pose::level(position_m, heading_rad));
    let mine = Mine::new(network, surface);
    let view = lidar.view(mine.surface(), mine.network().height_m, &motion);
    (mine.scenery(lidar, &motion, &view), view)
}

fn scenery(network: Network, position_m: Point, heading_rad: f64) -> Scenery {
    look(network, &Lidar::CLEAN, position_m, heading_rad).0
}

/// Walls, islands, and the openings as (bearing in degrees, width), each within half a degree and 5 cm.
#[track_caller]
fn assert_scenery(scenery: &Scenery, walls: u32, islands: u32, openings: &[(f64, f64)]) {
    let found: Vec<(f64, f64)> = scenery.openings.iter().map(|o| (o.bearing_rad.to_degrees(), o.width_m)).collect();
    assert_eq!((scenery.walls, scenery.islands, found.len()), (walls, islands, openings.len()), "{found:?}");
    for (found, wanted) in found.iter().zip(openings) {
        let turned = wrap_angle_rad((found.0 - wanted.0).to_radians()).to_degrees();
        assert!(turned.abs() < 0.5 && (found.1 - wanted.1).abs() < 0.05, "{found:?} is not {wanted:?}");
    }
}

/// The wall that the beam nearest to a bearing meets.
fn wall_at(scenery: &Scenery, bearing_deg: f64) -> Option<u32> {
    let beams = scenery.wall_of_beam.len() as f64;
    scenery.wall_of_beam[((bearing_deg + 180.0) / 360.0 * beams).round() as usize]
}

#[test]
fn a_straight_tunnel_has_two_walls_numbered_from_the_first_beam() {
    let scenery = scenery(straight(), at(0.0, 0.0), 0.0);
    assert_scenery(&scenery, 2, 0, &[(0.0, 4.0), (180.0, 4.0)]);
    assert_eq!((wall_at(&scenery, -90.0), wall_at(&scenery, 90.0)), (Some(0), Some(1)));
    // 15 m away, the wall 2 m to the side is seen up to asin(2/15) = 7.7° from the axis.
    assert_eq!((wall_at(&scenery, 7.0), wall_at(&scenery, 9.0)), (None, Some(1)));
    assert_eq!((wall_at(&scenery, -7.0), wall_at(&scenery, -9.0)), (None, Some(0)));
}

#[test]
fn the_bearing_of_an_opening_is_that_of_the_centreline_at_8_m() {
    let scenery = scenery(straight(), at(0.0, 1.0), 0.0);
    let bearing_deg = -(1.0_f64 / 8.0).asin().to_degrees();
    assert_scenery(&scenery, 2, 0, &[(-180.0 - bearing_deg, 4.0), (bearing_deg, 4.0)]);
}

#[test]
fn a_tee_opens_where_corners_hide_its_branches() {
    let tee = star(at(10.0, 0.0), &[at(-20.0, 0.0), at(10.0, 30.0), at(10.0, -30.0)], HALF_M);
    let scenery = scenery(tee, at(0.0, 0.0), 0.0);
    // The line of sight past the corner (8, 2) meets the branch's centreline x = 10 at y = 2.5, farther than 8 m.
    let side_deg = (2.5_f64 / 10.0).atan().to_degrees();
    assert_scenery(&scenery, 3, 0, &[(-side_deg, 4.0), (side_deg, 4.0), (180.0, 4.0)]);
    let walls = [-90.0, 0.0, 90.0].map(|bearing_deg| wall_at(&scenery, bearing_deg));
    assert_eq!(walls, [Some(0), Some(1), Some(2)]);
    // The corner is at atan(2/8) = 14.04°; the far wall shows up to there.
    assert_eq!((wall_at(&scenery, 14.0), wall_at(&scenery, 15.0)), (Some(1), Some(2)));
}

#[test]
fn a_dead_end_is_one_wall_with_one_opening() {
    let scenery = scenery(star(at(5.0, 0.0), &[at(-30.0, 0.0)], HALF_M), at(0.0, 0.0), 0.0);
    assert_scenery(&scenery, 1, 0, &[(180.0, 4.0)]);
    assert_eq!(
        (wall_at(&scenery, -90.0), wall_at(&scenery, 0.0), wall_at(&scenery, 90.0)),
        (Some(0), Some(0), Some(0))
    );
}

#[test]
fn a_room_without_exits_is_closed() {
    assert_scenery(&scenery(star(at(5.0, 0.0), &[at(-5.0, 0.0)], HALF_M), at(0.0, 0.0), 0.3), 1, 0, &[]);
}

#[test]
fn a_crossing_has_four_walls() {
    let cross = star(at(0.0, 0.0), &[at(30.0, 0.0), at(0.0, 30.0), at(-30.0, 0.0), at(0.0, -30.0)], HALF_M);
    let scenery = scenery(cross, at(0.0, 0.0), 0.0);
    assert_scenery(&scenery, 4, 0, &[(-90.0, 4.0), (0.0, 4.0), (90.0, 4.0), (180.0, 4.0)]);
    let walls = [-135.0, -45.0, 45.0, 135.0].map(|bearing_deg| wall_at(&scenery, bearing_deg));
    assert_eq!(walls, [Some(0), Some(1), Some(2), Some(3)]);
}

#[test]
fn a_bend_opens_where_its_inner_corner_hides_the_centreline() {
    let bend = star(at(6.0, 0.0), &[at(-30.0, 0.0), at(6.0, 30.0)], HALF_M);
    // Past the inner corner (4, 2) the sight reaches x = 6 at y = 3, which is nearer than 8 m.
    assert_scenery(
        &scenery(bend, at(0.0, 0.0), 0.0),
        2,
        0,
        &[((3.0_f64 / 6.0).atan().to_degrees(), 4.0), (180.0, 4.0)],
    );
}

#[test]
fn a_dead_end_is_an_opening_until_its_face_is_visible() {
    let side = || {
        let mut network = star(at(0.0, 0.0), &[at(-30.0, 0.0), at(30.0, 0.0)], HALF_M);
        network.add_branch(0, vec![at(0.0, 0.0), at(0.0, 9.0)], vec![1.5; 2]);
        network
    };
    assert_scenery(&scenery(side(), at(0.0, 0.0), 0.0), 2, 0, &[(0.0, 4.0), (180.0, 4.0)]);
    // From 6 m away the corner (1.5 - 3, 2) hides the branch from y = 2·6/4.5 on.
    let branch_deg = (2.0_f64 / 4.5).atan().to_degrees();
    assert_scenery(&scenery(side(), at(-6.0, 0.0), 0.0), 3, 0, &[(0.0, 4.0), (branch_deg, 3.0), (180.0, 4.0)]);
}

#[test]
fn a_shallow_alcove_is_part_of_its_wall() {
    let mut network = straight();
    network.alcoves.push(Disc { centre_m: at(4.0, 2.0), radius_m: 1.0 });
    let scenery = scenery(network, at(0.0, 0.0), 0.0);
    assert_scenery(&scenery, 2, 0, &[(0.0, 4.0), (180.0, 4.0)]);
    assert!((15..165).all(|bearing_deg| wall_at(&scenery, f64::from(bearing_deg)) == Some(1)));
}

#[test]
fn a_pillar_is_an_island_and_hides_no_opening() {
    for (y, bearing_deg) in [(0.0, 0.0), (0.7, 0.7_f64.atan2(5.0).to_degrees())] {
        let mut network = straight();
        network.pillars.push(Disc { centre_m: at(5.0, y), radius_m: 0.5 });
        let scenery = scenery(network, at(0.0, 0.0), 0.0);
        assert_scenery(&scenery, 2, 1, &[(0.0, 4.0), (180.0, 4.0)]);
        let pillar = wall_at(&scenery, bearing_deg).expect("the pillar is met");
        // It spans 2·asin(0.5/5) = 11.5°.
        let beams = scenery.wall_of_beam.iter().filter(|&&wall| wall == Some(pillar)).count();
        assert!((11..=12).contains(&beams), "the pillar is met by {beams} beams");
        let sides = [wall_at(&scenery, -90.0), wall_at(&scenery, 90.0)];
        assert!(!sides.contains(&Some(pillar)) && sides[0] != sides[1]);
    }
}

#[test]
fn outside_the_view_walls_do_not_join_and_nothing_opens() {
    let lidar = Lidar { beams: 181, field_of_view_rad: PI, ..Lidar::CLEAN };
    let (ahead, _) = look(straight(), &lidar, at(0.0, 0.0), 0.0);
    assert_scenery(&ahead, 2, 0, &[(0.0, 4.0)]);
    // A dead end behind joins the two walls, unseen.
    let dead_end = star(at(-5.0, 0.0), &[at(30.0, 0.0)], HALF_M);
    assert_scenery(&look(dead_end, &lidar, at(0.0, 0.0), 0.0).0, 2, 0, &[(0.0, 4.0)]);
}

#[test]
fn an_opening_at_the_edge_of_the_view_must_fit_the_vehicle() {
    let lidar = Lidar { beams: 181, field_of_view_rad: PI, ..Lidar::CLEAN };
    let openings = |heading_deg: f64| {
        let (scenery, _) = look(straight(), &lidar, at(0.0, 0.0), heading_deg.to_radians());
        scenery.openings.iter().map(|opening| opening.bearing_rad.to_degrees()).collect::<Vec<f64>>()
    };
    // The end of the range spans 7.66° to both sides of the axis. Turned to 96°, the two beams at -90° and -89° see
    // nothing, 0.26 m apart; turned to 94°, the four from -90° to -87° do, over 0.79 m.
    assert_eq!(openings(96.0).len(), 1);
    let straddling = openings(94.0);
    assert_eq!(straddling.len(), 2);
    assert!((straddling[0] + 88.0).abs() < 0.6, "the opening is in view: {straddling:?}");
    assert!((straddling[1] - 86.0).abs() < 0.5);
}

#[test]
fn a_centreline_visible_again_soon_has_not_left() {
    // A tunnel 2 m wide that swings aside by `swing_m` over 8 m, and back.
    let swinging = |swing_m: f64| {
        let line: Vec<Point> = (0..=100)
            .map(|i| -20.0 + 0.5 * f64::from(i))
            .map(|x| at(x, if (4.0..12.0).contains(&x) { swing_m * (PI * (x - 4.0) / 8.0).sin().powi(2) } else { 0.0 }))
            .collect();
        let mut network = Network::new(4.0);
        let start = network.add_node(line[0]);
        let widths = vec![1.0; line.len()];
        network.add_branch(start, line.clone(), widths);
        let surface = Surface::new(&network, &Texture::SMOOTH, 0);
        let hidden = line.iter().filter(|p| (0.0..12.5).contains(&p.x) && !surface.sees(at(0.0, 0.0), **p)).count();
        (network, hidden)
    };
    let (network, hidden) = swinging(1.6);
    assert!((1..=4).contains(&hidden), "the swing hides {hidden} points half a metre apart");
    // 8 m away the swing is at its widest.
    let ahead_deg = (1.6_f64 / 8.0).asin().to_degrees();
    assert_scenery(&scenery(network, at(0.0, 0.0), 0.0), 2, 0, &[(ahead_deg, 2.0), (180.0, 2.0)]);
}

#[test]
fn centrelines_that_leave_through_one_edge_are_one_opening() {
    // Two branches part 14 m ahead, at ±30°; the rock between them begins beyond the range.
    let fork = star(at(14.0, 0.0), &[at(-30.0, 0.0), at(31.0, 10.0), at(31.0, -10.0)], HALF_M);
    assert_scenery(&scenery(fork, at(0.0, 0.0), 0.0), 2, 0, &[(0.0, 4.0), (180.0, 4.0)]);
}

#[test]
fn a_crack_is_no_opening() {
    let mut network = star(at(0.0, 0.0), &[at(-30.0, 0.0), at(30.0, 0.0)], HALF_M);
    network.add_branch(0, vec![at(0.0, 0.0), at(0.0, 30.0)], vec![0.25; 2]);
    assert_scenery(&scenery(network, at(0.0, 0.0), 0.0), 2, 0, &[(0.0, 4.0), (180.0, 4.0)]);
}

#[test]
fn the_floor_seen_by_a_tilted_sensor_is_no_wall() {
    let surface = Surface::new(&straight(), &Texture::SMOOTH, 0);
    let mine = Mine::new(straight(), surface);
    let pose = Pose { pitch_rad: 0.2, ..Pose::level(at(0.0, 0.0), 0.0) };
    let motion = Motion::still(pose);
    let view = Lidar::CLEAN.view(mine.surface(), mine.network().height_m, &motion);
    // Ahead the beam dips by 0.2 rad from 2 m above the floor.
    assert!(matches!(view[180], Echo::Floor { range_m } if (range_m - 2.0 / 0.2_f64.sin()).abs() < 1e-9));
    let scenery = mine.scenery(&Lidar::CLEAN, &motion, &view);
    assert_scenery(&scenery, 2, 0, &[(0.0, 4.0), (180.0, 4.0)]);
    assert_eq!(scenery.wall_of_beam[180], None);
}

#[test]
fn while_moving_an_opening_is_where_its_beam_sees_it() {
    let surface = Surface::new(&straight(), &Texture::SMOOTH, 0);
    let mine = Mine::new(straight(), surface);
    // The nose turns left by 0.1 rad during the sweep; the beam that looks ahead comes half-way, 0.05 rad in.
    let motion = Motion { start: Pose::level(at(0.0, 0.0), 0.0), end: Pose::level(at(0.0, 0.0), 0.1) };
    let view = Lidar::CLEAN.view(mine.surface(), 4.0, &motion);
    let ahead = mine.scenery(&Lidar::CLEAN, &motion, &view).openings[0];
    assert!((ahead.bearing_rad + 0.05).abs() < 2e-3, "{}", ahead.bearing_rad);
}

/// A junction of 2 to 4 branches at random directions, and a place near it.
fn junctions() -> impl Strategy<Value = (Vec<Point>, Point)> {
    let branch = (1.2_f64..FRAC_PI_2, 2.0_f64..3.0);
    (proptest::collection::vec(branch, 2..=4), -1.0_f64..1.0, -1.0_f64..1.0).prop_map(|(gaps, x, y)| {
        let mut bearing_rad = 0.37;
        let end = |(gap_rad, _): (f64, f64)| {
            bearing_rad += gap_rad;
            at(30.0 * bearing_rad.cos(), 30.0 * bearing_rad.sin())
        };
        (gaps.into_iter().map(end).collect(), at(x, y))
    })
}

proptest! {
    #[test]
    fn turning_the_sensor_turns_the_openings((ends, place) in junctions(), beams in 1_usize..360) {
        let still = scenery(star(at(0.0, 0.0), &ends, 1.8), place, 0.0);
        let turned = scenery(star(at(0.0, 0.0), &ends, 1.8), place, (beams as f64).to_radians());
        prop_assert_eq!((still.walls, still.openings.len()), (turned.walls, turned.openings.len()));
        for opening in &still.openings {
            let wanted_rad = opening.bearing_rad - (beams as f64).to_radians();
            let error_rad = |other: f64| wrap_angle_rad(other - wanted_rad).abs();
            prop_assert!(turned.openings.iter().any(|o| error_rad(o.bearing_rad) < 1e-6), "{wanted_rad}");
        }
        // Two neighbouring beams are of one wall before as after, but for beams that graze a corner.
        let same = |scenery: &Scenery, beam: usize| {
            let walls = [beam % 360, (beam + 1) % 360].map(|beam| scenery.wall_of_beam[beam]);
            walls[0].is_some() && walls[0] == walls[1]
        };
        let differing = (0..360).filter(|&beam| same(&still, beam + beams) != same(&turned, beam)).count();
        prop_assert!(differing <= 4, "{differing} beams differ");
    }

    #[test]
    fn a_mirrored_mine_has_mirrored_openings((ends, place) in junctions()) {
        let mirrored = |p: &Point| at(p.x, -p.y);
        let mirror_ends: Vec<Point> = ends.iter().map(mirrored).collect();
        let plain = scenery(star(at(0.0, 0.0), &ends, 1.8), place, 0.4);
        let mirror = scenery(star(at(0.0, 0.0), &mirror_ends, 1.8), mirrored(&place), -0.4);
        prop_assert_eq!((plain.walls, plain.openings.len()), (mirror.walls, mirror.openings.len()));
        for opening in &plain.openings {
            let twin = |o: &&crosscut_messages::TruthOpening| wrap_angle_rad(o.bearing_rad + opening.bearing_rad).abs() < 0.02;
            let found = mirror.openings.iter().find(twin);
            prop_assert!(found.is_some_and(|o| (o.width_m - opening.width_m).abs() < 0.05), "{opening:?}");
        }
    }
}

#[test]
#[should_panic(expected = "is suitable")]
fn places_too_narrow_for_their_pillars_are_refused() {
    Places { width_m: [1.0, 1.5], pillars: [1, 1], ..Places::CLEAN }.scene(3, 1, 0);
}

//! Openings on scenes computed by hand, one ray per degree.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::Range;

use crate::scenes::{Segment, scan, tee, tunnel};
use crosscut_report::openings::{OpeningRule, find};
use crosscut_report::{PARAMS, Reporter, VEHICLE_PARAMS, WallRing};
use crosscut_stage::{
    Affinity, Beam, Evidence, Junction, Known, KnownGaps, Notes, Opening, Params, Partition, Revolution, Spectrum,
    Verdict,
};

fn openings(segments: &[(Segment, u32)]) -> Vec<Opening> {
    openings_of(&scan(segments, 360, |_| false))
}

fn openings_of(scan: &(Revolution, Vec<Option<u32>>)) -> Vec<Opening> {
    openings_by(OpeningRule::FreeSpace, scan)
}

fn openings_by(rule: OpeningRule, scan: &(Revolution, Vec<Option<u32>>)) -> Vec<Opening> {
    openings_with(rule, scan, &[])
}

fn openings_with(
    rule: OpeningRule,
    (revolution, walls): &(Revolution, Vec<Option<u32>>),
    verdicts: &[Verdict],
) -> Vec<Opening> {
    let (mut outline, mut found) = (WallRing::default(), Vec::new());
    if let Some(sweep) = &revolution.sweep {
        outline.fill(revolution, sweep, walls).expect("in message order");
    }
    find(rule, revolution, verdicts, &outline, 0.6, &mut found);
    found
}

/// A verdict on the gap between the returns on both sides of a bearing.
fn verdict(revolution: &Revolution, bearing_rad: f64, is_opening: bool) -> Verdict {
    let turn_rad = |i: u32| (revolution.bearing_rad(i as usize) - bearing_rad).rem_euclid(2.0 * PI);
    let returns = || 0..revolution.len() as u32;
    let by_turn = |a: &u32, b: &u32| turn_rad(*a).total_cmp(&turn_rad(*b));
    let (before, after) = (returns().max_by(by_turn).expect("a return"), returns().min_by(by_turn).expect("a return"));
    Verdict { returns: [before, after], is_opening, room_ratio: 2.0, p: None, reason: "width", measured: None }
}

fn dead_end() -> Vec<(Segment, u32)> {
    vec![
        (Segment([-30.0, 1.75], [4.0, 1.75]), 0),
        (Segment([4.0, 1.75], [4.0, -1.75]), 0),
        (Segment([4.0, -1.75], [-30.0, -1.75]), 0),
    ]
}

fn assert_opening(opening: &Opening, bearing_rad: f64, width_m: f64) {
    let off = crosscut_stage::wrap_angle_rad(opening.bearing_rad - bearing_rad).abs();
    assert!(off < 0.06, "bearing {} instead of {bearing_rad}", opening.bearing_rad);
    assert!((opening.width_m - width_m).abs() < 0.1 * width_m, "width {} instead of {width_m}", opening.width_m);
}

#[test]
fn a_tunnel_is_open_ahead_and_behind_between_its_two_walls() {
    let found = openings(&tunnel());
    assert_eq!(found.len(), 2, "{found:#?}");
    let (behind, ahead) = if found[0].bearing_rad < -FRAC_PI_2 { (0, 1) } else { (1, 0) };
    assert_opening(&found[behind], PI, 3.5);
    assert_opening(&found[ahead], 0.0, 3.5);
    assert_eq!(found[ahead].walls, [1, 0], "clockwise side first");
    assert_eq!(found[behind].walls, [0, 1]);
    assert_eq!(found[ahead].evidence, Evidence::NoReturn);
}

#[test]
fn a_side_passage_whose_inside_is_seen_is_open() {
    let found = openings(&tee());
    assert_eq!(found.len(), 3, "{found:#?}");
    let side = found.iter().find(|o| o.evidence == Evidence::SeenThrough).expect("the passage");
    assert_eq!(side.walls, [1, 0]);
    // Its middle, x = 4.75, goes out of sight behind the corner (3, 1.75).
    assert_opening(side, 1.75f64.atan2(3.0), 3.5);
}

#[test]
fn a_dead_end_is_open_only_backwards_and_has_the_same_wall_on_both_sides() {
    let found = openings(&dead_end());
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_opening(&found[0], PI, 3.5);
    assert_eq!(found[0].walls, [0, 0]);
}

#[test]
fn a_chamber_whose_walls_come_near_elsewhere_is_left_through_its_exit() {
    // Around (0, 2), 9 m in radius, with an exit 3.6 m wide to the left: 8 m away are its walls to the right alone.
    let corner = |turn_rad: f64| [9.0 * turn_rad.cos(), 9.0 * turn_rad.sin() + 2.0];
    let (half_exit_rad, pieces) = (0.2f64, 60);
    let turn_rad =
        |piece: usize| FRAC_PI_2 + half_exit_rad + (2.0 * PI - 2.0 * half_exit_rad) * piece as f64 / pieces as f64;
    let chamber = (0..pieces).map(|piece| (Segment(corner(turn_rad(piece)), corner(turn_rad(piece + 1))), 0));
    let found = openings(&chamber.collect::<Vec<_>>());
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_opening(&found[0], FRAC_PI_2, 3.6);
}

#[test]
fn a_closed_room_is_not_open() {
    let room = vec![
        (Segment([-4.0, 2.0], [4.0, 2.0]), 0),
        (Segment([4.0, 2.0], [4.0, -2.0]), 0),
        (Segment([4.0, -2.0], [-4.0, -2.0]), 0),
        (Segment([-4.0, -2.0], [-4.0, 2.0]), 0),
    ];
    assert!(openings(&room).is_empty());
}

#[test]
fn one_wall_with_nothing_over_half_a_turn_is_open_there() {
    // Straight; with an end turned a little towards the sensor; seen aslant.
    for [left_m, right_m] in [[2.0, 2.0], [2.0, 1.0], [1.0, 8.0]] {
        let wall = [(Segment([12.0, right_m], [0.0, 2.0]), 0), (Segment([0.0, 2.0], [-12.0, left_m]), 0)];
        for rule in [OpeningRule::FreeSpace, OpeningRule::BetweenWalls] {
            let found = openings_by(rule, &scan(&wall, 360, |_| false));
            assert_eq!(found.len(), 1, "{left_m} {right_m}: {found:#?}");
            assert!((found[0].bearing_rad + FRAC_PI_2).abs() < 0.5, "{found:#?}");
        }
    }
    let masked = scan(&[(Segment([12.0, 2.0], [-12.0, 2.0]), 0)], 360, |bearing_rad| bearing_rad < 0.0);
    let found = openings_by(OpeningRule::BetweenWalls, &masked);
    assert!(found.iter().all(Opening::is_cut_by_view), "of the masked side nothing is known: {found:#?}");
}

/// A room of 6 m x 6 m whose wall ahead has a door.
fn room_with_door(door_m: f64) -> [(Segment, u32); 5] {
    [
        (Segment([-3.0, 3.0], [3.0, 3.0]), 0),
        (Segment([3.0, 3.0], [3.0, door_m / 2.0]), 0),
        (Segment([3.0, -door_m / 2.0], [3.0, -3.0]), 0),
        (Segment([3.0, -3.0], [-3.0, -3.0]), 0),
        (Segment([-3.0, -3.0], [-3.0, 3.0]), 0),
    ]
}

#[test]
fn openings_are_the_verdicts_and_know_their_returns() {
    let door_m = 1.0;
    let room = room_with_door(door_m);
    let scan = scan(&room, 720, |_| false);
    let by = |is_opening: bool| {
        let verdict = verdict(&scan.0, 0.0, is_opening);
        (openings_with(OpeningRule::BetweenWalls, &scan, &[verdict]), verdict)
    };
    let (open, verdict) = by(true);
    assert_eq!(open.len(), 1, "{open:#?}");
    assert_opening(&open[0], 0.0, door_m);
    assert_eq!((open[0].returns, open[0].walls), (verdict.returns.map(Some), [0, 0]));
    assert!(by(false).0.is_empty(), "the affinity decides");
}

#[test]
fn an_island_in_an_opening_leaves_one_opening_and_a_wall_makes_it_two() {
    // Ahead, a piece of no wall stands in the tunnel: the affinity found an opening on both sides of it.
    let mut with_piece = tunnel();
    with_piece.push((Segment([8.0, -0.4], [8.0, 0.4]), 2));
    let (revolution, walls) = scan(&with_piece, 360, |_| false);
    let verdicts = [PI, -0.06, 0.06].map(|bearing_rad| verdict(&revolution, bearing_rad, true));
    let across = Verdict { returns: [verdicts[1].returns[0], verdicts[2].returns[1]], ..verdicts[1] };
    let with_wall = (revolution.clone(), walls.clone());
    let found = openings_with(OpeningRule::BetweenWalls, &with_wall, &[verdicts[0], across]);
    assert_eq!(found.len(), 3, "a wall that stands in a gap splits it: {found:#?}");
    let without_piece = (revolution, walls.into_iter().map(|wall| wall.filter(|&wall| wall != 2)).collect());
    let found = openings_with(OpeningRule::BetweenWalls, &without_piece, &verdicts);
    assert_eq!(found.len(), 2, "{found:#?}");
    let ahead = found.iter().find(|o| o.bearing_rad.abs() < 1.0).expect("the way ahead");
    assert_opening(ahead, 0.0, 3.5);
    assert_eq!(ahead.returns, across.returns.map(Some));
}

/// A tunnel with a door in its side: walls 0 and 1 are beside it, 2 is the far wall of the room behind it.
fn side_door(door_m: f64) -> [(Segment, u32); 4] {
    [
        (Segment([-30.0, 1.75], [-door_m / 2.0, 1.75]), 0),
        (Segment([door_m / 2.0, 1.75], [30.0, 1.75]), 1),
        (Segment([-4.0, 8.0], [4.0, 8.0]), 2),
        (Segment([-30.0, -1.75], [30.0, -1.75]), 3),
    ]
}

#[test]
fn two_gaps_behind_one_door_are_one_opening() {
    for door_m in [0.8, 1.0, 1.5, 2.0] {
        let scan = scan(&side_door(door_m), 720, |_| false);
        let by_walls = openings_by(OpeningRule::BetweenWalls, &scan);
        let gaps = [PI, 0.0, (1.75 / (door_m / 2.0)).atan(), (-1.75 / (door_m / 2.0)).atan() + PI];
        let verdicts = gaps.map(|bearing_rad| verdict(&scan.0, bearing_rad, true));
        for found in [by_walls, openings_with(OpeningRule::BetweenWalls, &scan, &verdicts)] {
            assert_eq!(found.len(), 3, "{found:#?}");
            let (door, along): (Vec<_>, Vec<_>) = found.iter().partition(|opening| opening.walls == [1, 0]);
            assert_opening(door[0], FRAC_PI_2, door_m);
            assert!(along.iter().all(|opening| opening.width_m > 3.0), "{found:#?}");
        }
        // The affinity says that the wall goes on at one of the gaps: the way in by the other is no wider than the door.
        let found = openings_with(OpeningRule::BetweenWalls, &scan, &verdicts[..3]);
        assert_eq!(found.len(), 3, "{found:#?}");
        let into_room = found.iter().find(|opening| opening.walls.contains(&2)).expect("one gap");
        assert!((into_room.width_m - door_m).abs() < 0.1 * door_m, "{into_room:#?}");
    }
}

#[test]
fn a_side_passage_wider_than_a_door_may_have_two_openings_at_its_end() {
    let found = openings_by(OpeningRule::BetweenWalls, &scan(&side_door(3.0), 720, |_| false));
    assert_eq!(found.len(), 4, "{found:#?}");
}

#[test]
fn the_range_of_an_opening_is_that_of_its_nearer_end() {
    let found = openings(&tee());
    let side = found.iter().find(|o| o.evidence == Evidence::SeenThrough).expect("the passage");
    assert!((side.range_m() - 3.0f64.hypot(1.75)).abs() < 0.1, "from the corner (3, 1.75): {}", side.range_m());
}

#[test]
fn a_gap_narrower_than_the_vehicle_is_not_open() {
    let mut slit = vec![
        (Segment([-4.0, 2.0], [4.0, 2.0]), 0),
        (Segment([4.0, 2.0], [4.0, 0.2]), 0),
        (Segment([4.0, -0.2], [4.0, -2.0]), 1),
        (Segment([4.0, -2.0], [-4.0, -2.0]), 1),
        (Segment([-4.0, -2.0], [-4.0, 2.0]), 1),
    ];
    assert!(openings(&slit).is_empty());
    slit[1] = (Segment([4.0, 2.0], [4.0, 0.5]), 0);
    slit[2] = (Segment([4.0, -0.5], [4.0, -2.0]), 1);
    assert_eq!(openings(&slit).len(), 1, "the same gap, 1 m wide");
}

#[test]
fn a_masked_sector_is_not_an_opening() {
    let ahead_blind = scan(&tunnel(), 360, |bearing| bearing.abs() < 0.3);
    let found = openings_of(&ahead_blind);
    assert_eq!(found.len(), 1, "only the one behind is seen: {found:#?}");
    assert_opening(&found[0], PI, 3.5);
}

#[test]
fn a_side_passage_that_is_seen_far_in_is_looked_at_8_m_away() {
    // From the middle of its mouth both its sides are seen.
    let moved =
        tee().into_iter().map(|(Segment([ax, ay], [bx, by]), wall)| (Segment([ax - 4.75, ay], [bx - 4.75, by]), wall));
    let found = openings(&moved.collect::<Vec<_>>());
    let side = found.iter().find(|o| o.walls == [1, 0]).expect("the passage");
    assert_opening(side, FRAC_PI_2, 3.5);
    // A little into the tunnel the near side ends 2.5 m away, and the middle 8 m away is still in sight.
    let moved =
        tee().into_iter().map(|(Segment([ax, ay], [bx, by]), wall)| (Segment([ax - 3.75, ay], [bx - 3.75, by]), wall));
    let found = openings(&moved.collect::<Vec<_>>());
    let side = found.iter().find(|o| o.walls == [1, 0]).expect("the passage");
    assert_opening(side, (63f64).sqrt().atan2(1.0), 3.5);
}

#[test]
fn returns_lost_where_a_way_is_looked_at_do_not_turn_or_narrow_it() {
    // Of the left wall ahead, nothing from 4 m to 13 m away came back.
    let found = openings_of(&without(scan(&tunnel(), 360, |_| false), 188..206));
    let ahead = found.iter().find(|o| o.bearing_rad.abs() < 1.0).expect("the way ahead");
    assert!(ahead.bearing_rad.abs() < 0.02 && (ahead.width_m - 3.5).abs() < 0.05, "{ahead:?}");
}

/// A scan of which nothing comes back from some beams.
fn without(
    (mut revolution, walls): (Revolution, Vec<Option<u32>>),
    lost: Range<usize>,
) -> (Revolution, Vec<Option<u32>>) {
    let sweep = revolution.sweep.as_mut().expect("a sweep");
    let (mut points_m, mut kept_walls) = (Vec::new(), Vec::new());
    for (at, beam) in sweep.beams.iter_mut().enumerate() {
        let Beam::Return(i) = *beam else { continue };
        *beam = if lost.contains(&at) {
            Beam::NoReturn
        } else {
            points_m.push(revolution.points_m[i as usize]);
            kept_walls.push(walls[i as usize]);
            Beam::Return(points_m.len() as u32 - 1)
        };
    }
    revolution.points_m = points_m;
    (revolution, kept_walls)
}

/// The part of a scan between two bearings.
fn part((mut revolution, walls): (Revolution, Vec<Option<u32>>), view: Range<f64>) -> (Revolution, Vec<Option<u32>>) {
    let sweep = revolution.sweep.as_mut().expect("a sweep");
    let kept: Vec<usize> = (0..sweep.len()).filter(|&beam| view.contains(&sweep.bearings_rad[beam])).collect();
    let (mut points_m, mut kept_walls) = (Vec::new(), Vec::new());
    sweep.beams = kept.iter().map(|&beam| sweep.beams[beam]).collect();
    sweep.bearings_rad = kept.iter().map(|&beam| sweep.bearings_rad[beam]).collect();
    sweep.ranges_m = kept.iter().map(|&beam| sweep.ranges_m[beam]).collect();
    sweep.full_turn = false;
    for beam in &mut sweep.beams {
        if let Beam::Return(i) = beam {
            points_m.push(revolution.points_m[*i as usize]);
            kept_walls.push(walls[*i as usize]);
            *i = points_m.len() as u32 - 1;
        }
    }
    revolution.points_m = points_m;
    (revolution, kept_walls)
}

#[test]
fn outside_a_limited_view_is_not_an_opening() {
    let found = openings_of(&part(scan(&tunnel(), 360, |_| false), -2.0..2.0));
    assert_eq!(found.len(), 1, "the way behind lies outside: {found:#?}");
    assert_opening(&found[0], 0.0, 3.5);
    assert!(!found[0].is_cut_by_view());
}

#[test]
fn an_opening_that_the_end_of_the_view_cuts_is_one_as_far_as_it_is_seen() {
    let found = openings_of(&part(scan(&tunnel(), 360, |_| false), 0.0..2.0));
    let [ahead] = found.as_slice() else { panic!("only ahead is in view: {found:#?}") };
    // The view ends on the axis, 1.75 m from the left wall, of which the last return is 7.5° off.
    assert_opening(ahead, 4_f64.to_radians(), 1.75);
    assert!(ahead.is_cut_by_view() && ahead.walls == [0, 0], "{ahead:?}");
    assert_eq!(ahead.evidence, Evidence::NoReturn);
    let mirrored = openings_of(&part(scan(&tunnel(), 360, |_| false), -2.0..0.0));
    assert!((mirrored[0].bearing_rad + ahead.bearing_rad).abs() < 0.01, "{mirrored:#?}");
}

#[test]
fn a_single_beam_of_which_nothing_is_known_hides_no_opening_at_the_end_of_the_view() {
    // The last returns are 7.5° off the axis, where the view ends; one beam a degree.
    let unknown =
        |from_rad: f64, to_rad: f64| part(scan(&tunnel(), 360, |b| (from_rad..to_rad).contains(&b)), 0.0..2.0);
    let [none, single, two] =
        [unknown(0.0, 0.0), unknown(0.03, 0.046), unknown(0.03, 0.064)].map(|masked| openings_of(&masked));
    assert_eq!((none.len(), single.len(), two.len()), (1, 1, 0));
    assert_eq!(none[0].bearing_rad, single[0].bearing_rad);
}

#[test]
fn the_end_of_the_view_is_no_opening_where_a_wall_reaches_it_or_nothing_is_known() {
    let beside = |blind: bool| part(scan(&tunnel(), 360, |b| blind && b < 0.3), 0.0..2.0);
    assert_eq!(openings_of(&beside(false)).len(), 1);
    assert!(openings_of(&beside(true)).is_empty(), "masked up to the wall");
    assert!(openings_of(&part(scan(&tunnel(), 360, |_| false), 0.13..2.0)).is_empty(), "too little of it is in view");
}

#[test]
fn listing_the_beams_clockwise_changes_nothing() {
    let (mut revolution, mut walls) = scan(&tee(), 360, |_| false);
    let mut expected = openings_of(&(revolution.clone(), walls.clone()));
    let n = revolution.points_m.len() as u32;
    for number in expected.iter_mut().flat_map(|opening| &mut opening.returns).flatten() {
        *number = n - 1 - *number;
    }
    revolution.points_m.reverse();
    walls.reverse();
    let sweep = revolution.sweep.as_mut().expect("a sweep");
    sweep.bearings_rad.reverse();
    sweep.beams.reverse();
    for beam in &mut sweep.beams {
        if let Beam::Return(i) = beam {
            *i = n - 1 - *i;
        }
    }
    assert_eq!(openings_of(&(revolution, walls)), expected);
}

#[test]
fn sparse_returns_at_grazing_incidence_are_no_opening_within_one_wall() {
    // Half as many beams: along the walls the farthest returns are more than 2 m apart.
    assert_eq!(openings_of(&scan(&tunnel(), 180, |_| false)).len(), 2);
}

#[test]
fn no_returns_have_no_openings() {
    assert!(openings_of(&(Revolution::default(), Vec::new())).is_empty());
    assert!(openings(&[]).is_empty(), "nothing hit at all");
}

#[test]
fn a_stray_return_at_the_end_of_what_is_seen_of_a_wall_does_not_narrow_the_way_on() {
    let mut with_stray = tunnel();
    with_stray.push((Segment([14.5, 1.0], [14.5, 1.3]), 1));
    let found = openings(&with_stray);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert_opening(found.iter().find(|o| o.bearing_rad.abs() < 1.0).expect("the way ahead"), 0.0, 3.5);
}

#[test]
fn a_stray_return_deep_inside_a_branch_does_not_make_it_two() {
    let mut with_stray = tunnel();
    with_stray.push((Segment([12.0, -0.2], [12.0, 0.0]), 0));
    let found = openings(&with_stray);
    assert_eq!(found.len(), 2, "{found:#?}");
    let ahead = found.iter().find(|o| o.bearing_rad.abs() < 1.0).expect("the way ahead");
    assert_eq!(ahead.walls, [1, 0]);
    assert_opening(ahead, 0.0, 3.5);
}

#[test]
fn a_door_is_seen_through_until_walls_lose_as_many_beams() {
    let room = room_with_door(1.2);
    let known = |lost_rad: f64| {
        let (mut revolution, walls) = scan(&room, 720, |bearing_rad| (bearing_rad - 2.0).abs() < lost_rad);
        let beams = &mut revolution.sweep.as_mut().expect("a sweep").beams;
        beams.iter_mut().filter(|beam| **beam == Beam::Unknown).for_each(|beam| *beam = Beam::NoReturn);
        let partition = Partition { clusters: 1, labels: walls, ..Partition::default() };
        let verdicts = vec![verdict(&revolution, 0.0, true), verdict(&revolution, 2.0, false)];
        let affinity = Affinity { verdicts, ..Affinity::default() };
        let mut report = Params::defaults(PARAMS);
        report.set("openings", "between_walls").expect("there is such a rule");
        report.set("island_m", 0.0).expect("allowed");
        let mut reporter = Reporter::new(&report, &Params::defaults(VEHICLE_PARAMS));
        let (mut junction, mut notes) = (Junction::default(), Notes::default());
        let spectrum = Spectrum::default();
        reporter
            .report(&revolution, &affinity, &spectrum, &partition, &mut junction, &mut notes)
            .expect("one label each");
        (junction.openings[0].known, junction.gaps)
    };
    assert_eq!(known(0.0).0, Known::Seen);
    assert_eq!(known(0.15).0, Known::Judged, "half as many beams are lost elsewhere");
    assert_eq!(known(0.0).1, KnownGaps { seen: 1, proved: 1, judged: 0 }, "neighbours in a wall are no gap for 0.6 m");
}

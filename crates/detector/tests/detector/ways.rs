//! Preset `3d`: ways on of clouds, and of level scans, which have as many as walls.

use std::f64::consts::FRAC_PI_2;

use crosscut_detector::{Detector, Preset, Settings};
use crosscut_messages::Cloud;
use crosscut_simulator::{Split, suites};
use crosscut_stage::{Frame, Junction, WayKind};
use nalgebra::{UnitQuaternion, Vector3};

fn detector(preset: Preset) -> Detector {
    Settings::new(preset).build().expect("the preset")
}

/// A level gallery, 4 m wide and 3.2 m high, with a raise of 2.4 m by 2.4 m above the sensor, as 128 x 512 beams see it that
/// look from one elevation to another, about an axis that is tilted so.
fn under_a_raise(view_deg: [f64; 2]) -> Cloud {
    seen_tilted(view_deg, &UnitQuaternion::default())
}

/// See [`under_a_raise`].
fn seen_tilted(view_deg: [f64; 2], tilt: &UnitQuaternion<f64>) -> Cloud {
    let [low, high] = view_deg.map(f64::to_radians);
    let point = |at: usize| {
        let (ring, column) = ((at / 512) as f64, (at % 512) as f64);
        let (up, out) = (low + (high - low) * (ring + 0.5) / 128.0).sin_cos();
        let (sin, cos) = (column / 512.0 * std::f64::consts::TAU).sin_cos();
        let towards: [f64; 3] = (tilt * Vector3::new(out * cos, out * sin, up)).into();
        // From where on a beam is beyond two planes at this distance on both sides.
        let leaves = |axis: usize, half_m: f64| half_m / towards[axis].abs().max(1e-9);
        let in_gallery_m = leaves(1, 2.0).min(leaves(2, 1.6));
        let in_raise_m = leaves(0, 1.2).min(leaves(1, 1.2));
        let range_m =
            if towards[2] > 0.0 && in_raise_m > leaves(2, 1.6) { in_raise_m.max(in_gallery_m) } else { in_gallery_m };
        if range_m < 40.0 { towards.map(|part| part * range_m) } else { [f64::NAN; 3] }
    };
    Cloud { points_m: (0..128 * 512).map(point).collect(), ..Cloud::default() }
}

fn answer(preset: Preset, cloud: &Cloud) -> Frame {
    let frame = answer_tilted(preset, cloud, UnitQuaternion::default());
    assert_eq!(frame.affinity.dual.is_some(), preset == Preset::ThreeD);
    assert_eq!(frame.revolution.cloud_m.is_empty(), preset != Preset::ThreeD, "a cloud is kept where it is wanted");
    frame
}

/// The answer for a cloud that was turned level.
fn answer_tilted(preset: Preset, cloud: &Cloud, tilt: UnitQuaternion<f64>) -> Frame {
    let write = |sensor: &crosscut_sensor::Sensor, frame: &mut Frame| {
        sensor.cloud(cloud, &mut frame.revolution, &mut frame.notes);
        frame.revolution.cloud_tilt = tilt;
    };
    detector(preset).detect_with(write).expect("a cloud").clone()
}

fn kinds(junction: &Junction) -> Vec<WayKind> {
    junction.ways.iter().flatten().map(crosscut_stage::Way::kind).collect()
}

#[test]
fn a_raise_above_a_gallery_is_a_way_and_the_gallery_has_two_openings_and_two_walls() {
    let cloud = under_a_raise([-90.0, 90.0]);
    let frame = answer(Preset::ThreeD, &cloud);
    let found = &frame.junction;
    let mut of_kinds = kinds(found);
    of_kinds.sort_by_key(ToString::to_string);
    assert_eq!(of_kinds, [WayKind::Level, WayKind::Level, WayKind::ShaftUp], "{:#?}", found.ways);
    let ways = found.ways.as_ref().expect("ways");
    let raise = ways.iter().find(|way| way.kind() == WayKind::ShaftUp).expect("a raise");
    assert!((raise.clearance_m - 2.4).abs() < 0.4, "{raise:?}");
    assert_eq!((found.openings.len(), found.junctions), (2, 2), "{:#?}", found.openings);
    let bearings_rad = found.openings.iter().map(|opening| opening.bearing_rad.abs());
    assert!(bearings_rad.clone().all(|rad| rad.min((rad - std::f64::consts::PI).abs()) < 0.15), "{:?}", found.openings);
    let dual = frame.affinity.dual.as_ref().expect("directions");
    assert_eq!(dual.between.len(), 2, "{:?}", dual.between);
    for between in &dual.between {
        let off_rad = between.ways.map(|way| dual.ways[way as usize].direction.angle(&between.direction));
        assert!(off_rad.iter().all(|rad| *rad < 2.0) && between.reach_m < dual.cut_m, "{between:?} is off {off_rad:?}");
    }
    let level = answer(Preset::Default, &cloud).junction;
    assert_eq!((level.ways, level.junctions), (None, 2));
}

#[test]
fn a_sensor_that_cannot_see_up_says_how_far_it_sees() {
    let cloud = under_a_raise([-15.0, 15.0]);
    let mut detector = detector(Preset::ThreeD);
    let frame = detector
        .detect_with(|sensor, frame| sensor.cloud(&cloud, &mut frame.revolution, &mut frame.notes))
        .expect("a cloud");
    assert_eq!(kinds(&frame.junction), [WayKind::Level; 2]);
    let [low_rad, high_rad] = frame.affinity.dual.as_ref().expect("directions").view_rad;
    assert!((-0.36..=-0.2).contains(&low_rad) && (0.2..=0.36).contains(&high_rad), "{low_rad} to {high_rad}");
}

/// A gallery as high as wide from 0.8 m above its floor, as 64 x 512 beams see it between elevations; turned by so much nose up.
fn low_in_a_gallery(half_m: f64, half_view_deg: f64, slope_rad: f64) -> Cloud {
    let point = |at: usize| {
        let (ring, column) = ((at / 512) as f64, (at % 512) as f64);
        let (up, out) = (half_view_deg.to_radians() * ((ring + 0.5) / 32.0 - 1.0)).sin_cos();
        let (sin, cos) = (column / 512.0 * std::f64::consts::TAU).sin_cos();
        let high_m = if up > 0.0 { 2.0 * half_m - 0.8 } else { 0.8 };
        let range_m = (half_m / (out * sin).abs().max(1e-9)).min(high_m / up.abs());
        let turned = UnitQuaternion::from_euler_angles(0.0, -slope_rad, 0.0);
        (turned * Vector3::new(out * cos, out * sin, up) * range_m.min(40.0)).into()
    };
    Cloud { points_m: (0..64 * 512).map(point).collect(), ..Cloud::default() }
}

#[test]
fn kinds_go_by_the_slope_of_ways_wherever_the_sensor_stands() {
    for half_view_deg in [90.0, 45.0, 22.5] {
        let level = answer(Preset::ThreeD, &low_in_a_gallery(2.0, half_view_deg, 0.0)).junction;
        assert_eq!(kinds(&level), [WayKind::Level; 2], "{half_view_deg}: {:#?}", level.ways);
        let seen_rad = level.ways.iter().flatten().map(crosscut_stage::Way::elevation_rad);
        assert!(seen_rad.clone().all(|rad| half_view_deg < 30.0 || rad > 0.18), "{:?}", seen_rad.collect::<Vec<_>>());
        assert_eq!(level.openings.len(), 2, "{half_view_deg}: {:#?}", level.openings);
    }
    let ramp = answer(Preset::ThreeD, &low_in_a_gallery(2.0, 90.0, 0.4)).junction;
    let mut of_kinds = kinds(&ramp);
    of_kinds.sort_by_key(ToString::to_string);
    assert_eq!(of_kinds, [WayKind::RampDown, WayKind::RampUp], "{:#?}", ramp.ways);
    assert!(ramp.openings.is_empty(), "{:#?}", ramp.openings);
}

#[test]
fn near_the_ground_the_room_is_that_of_the_place() {
    for (half_m, roll_rad) in [(2.0, 0.0), (4.0, 0.0), (7.0, 0.0), (4.0, FRAC_PI_2)] {
        let tilt = UnitQuaternion::from_euler_angles(roll_rad, 0.0, 0.0);
        let frame = answer_tilted(Preset::ThreeD, &low_in_a_gallery(half_m, 90.0, 0.0), tilt);
        let room_m = frame.affinity.dual.as_ref().expect("directions").room_m;
        assert!((room_m / half_m - 1.0).abs() < 0.1, "{room_m} of {half_m}, rolled by {roll_rad}");
        assert_eq!(kinds(&frame.junction), [WayKind::Level; 2], "{half_m}: {:#?}", frame.junction.ways);
    }
    // Below open sky a ball rises no farther than the sensor is above the ground; below what is very far, in few steps.
    let ground = (0..10_000).map(|at| [0.2 * f64::from(at % 100) - 10.0, 0.2 * f64::from(at / 100) - 10.0, -0.8]);
    let far = ground.clone().map(|[x, y, _]| [x, y, 5.0].map(|along| 1e9 * along));
    for points_m in [ground.clone().collect(), ground.chain(far).collect()] {
        assert!(answer_of_any(&Cloud { points_m, ..Cloud::default() }).ways.is_some());
    }
}

#[test]
fn a_tilted_band_of_elevations_leaves_nothing_open_beside_it() {
    let tilt = UnitQuaternion::from_euler_angles(0.25, 0.1, 0.0);
    let cloud = seen_tilted([-15.0, 15.0], &tilt);
    let frame = answer_tilted(Preset::ThreeD, &cloud, tilt);
    assert_eq!(kinds(&frame.junction), [WayKind::Level; 2], "{:#?}", frame.junction.ways);
    let [low_rad, high_rad] = frame.affinity.dual.as_ref().expect("directions").view_rad;
    assert!(low_rad < -0.4 && high_rad > 0.4, "{low_rad} to {high_rad}");
}

#[test]
fn dust_at_the_edge_of_a_narrow_view_is_no_wall_beside_the_sensor() {
    let mut cloud = under_a_raise([-22.0, 22.0]);
    // One ring in the next row of cells, of which every eighth beam meets dust, few beams to a cell.
    let edge = under_a_raise([22.6, 22.7]).points_m.into_iter().take(512).step_by(2).enumerate();
    cloud
        .points_m
        .extend(edge.map(|(at, point_m)| if at % 8 == 0 { point_m.map(|part| 0.12 * part) } else { point_m }));
    let found = answer(Preset::ThreeD, &cloud).junction;
    assert_eq!(kinds(&found), [WayKind::Level; 2], "{:#?}", found.ways);
}

#[test]
fn the_vehicle_around_the_sensor_is_no_place_with_a_sure_way() {
    // A shell 0.32 m off behind the sensor.
    let mut cloud = under_a_raise([-90.0, 90.0]);
    for point_m in cloud.points_m.iter_mut().filter(|[x, ..]| *x < 0.0) {
        let range_m = Vector3::from(*point_m).norm();
        *point_m = point_m.map(|part| part * 0.32 / range_m);
    }
    let found = answer(Preset::ThreeD, &cloud).junction;
    assert!(
        found.ways.expect("ways").iter().all(|way| way.p <= 0.3) && found.confidence.is_none_or(|sure| sure <= 0.5)
    );
}

#[test]
fn nothing_and_a_handful_of_points_have_an_answer() {
    for points in [0, 1, 5, 60] {
        let at = |i: usize| [2.0 * (i as f64).cos(), 2.0 * (i as f64).sin(), 0.1 * (i % 7) as f64];
        let found = answer_of_any(&Cloud { points_m: (0..points).map(at).collect(), ..Cloud::default() });
        assert!(found.ways.is_some_and(|ways| ways.iter().all(|way| way.direction.norm() > 0.99)));
    }
}

fn answer_of_any(cloud: &Cloud) -> Junction {
    let mut detector = detector(Preset::ThreeD);
    let write = |sensor: &crosscut_sensor::Sensor, frame: &mut crosscut_stage::Frame| {
        sensor.cloud(cloud, &mut frame.revolution, &mut frame.notes);
    };
    detector.detect_with(write).expect("few points are no error").junction.clone()
}

/// At clear places of level scans, which are those at which the ways stay by themselves at every distance and the answer of
/// the default is sure.
#[test]
fn a_level_ring_has_as_many_ways_as_the_default_finds_openings() {
    let (mut default, mut dual) = (detector(Preset::Default), detector(Preset::ThreeD));
    let (mut same, mut clear, mut all) = (0, 0, 0);
    for suite in suites().iter().filter(|suite| ["clean6", "clean35"].contains(&suite.name)) {
        for scene in suite.scenes(Split::Dev).step_by(2) {
            let wanted = default.detect(&scene.scan).expect("a scan").clone();
            let found = dual.detect(&scene.scan).expect("a scan");
            let ways = found.ways.as_ref().expect("ways");
            all += 1;
            let stays = ways.iter().all(|way| way.p >= 0.95);
            if stays && wanted.confidence.is_some_and(|confidence| confidence >= 0.9) {
                clear += 1;
                same += usize::from(wanted.openings.len() == ways.len());
            }
        }
    }
    println!("{same} of {clear} clear places of {all} have the same count");
    assert!(100 * same >= 99 * clear && 4 * clear >= all, "{same} of {clear} of {all}");
}

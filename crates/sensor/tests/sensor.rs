//! The stated rules for odd scans, one by one, and what holds for all scans.

use std::f32::consts::{PI as PI32, TAU as TAU32};
use std::f64::consts::{FRAC_PI_2, PI};

use crosscut_messages::LaserScan;
use crosscut_sensor::{PARAMS, Sensor, VEHICLE_PARAMS};
use crosscut_stage::{Beam, Notes, Params, Revolution, Sweep, Value};
use proptest::prelude::{Just, Strategy, any, prop, prop_assert, prop_assert_eq, prop_oneof, proptest};

fn sensor(given: &[(&str, Value)]) -> Sensor {
    let mut params = Params::defaults(PARAMS);
    for (name, value) in given {
        params.set(name, value.clone()).expect("allowed");
    }
    Sensor::new(&params, &Params::defaults(VEHICLE_PARAMS))
}

fn revolution_of(scan: &LaserScan, sensor: &Sensor) -> (Revolution, Vec<String>) {
    let (mut out, mut notes) = (Revolution::default(), Notes::default());
    sensor.revolution(scan, &mut out, &mut notes);
    (out, notes.iter().map(str::to_owned).collect())
}

fn plain(scan: &LaserScan) -> (Revolution, Vec<String>) {
    revolution_of(scan, &sensor(&[]))
}

fn sweep(revolution: &Revolution) -> &Sweep {
    revolution.sweep.as_ref().expect("a scan has beams")
}

/// Beams at 0, 0.1, 0.2... rad, limits 0.1 to 30 m.
fn scan(ranges: &[f32]) -> LaserScan {
    LaserScan {
        angle_max: 0.1 * ranges.len().saturating_sub(1) as f32,
        angle_increment: 0.1,
        range_min: 0.1,
        range_max: 30.0,
        ranges: ranges.to_vec(),
        ..LaserScan::default()
    }
}

/// `beams` beams over a full turn from -π, the last one step before the first.
fn full_turn(beams: usize) -> LaserScan {
    let angle_increment = TAU32 / beams as f32;
    LaserScan { angle_min: -PI32, angle_max: PI32 - angle_increment, angle_increment, ..scan(&vec![5.0; beams]) }
}

fn assert_near(actual: f64, expected: f64) {
    assert!((actual - expected).abs() < 1e-6, "{actual} instead of {expected}");
}

#[test]
fn returns_stand_where_their_beam_and_range_put_them_in_f64() {
    let (revolution, notes) = plain(&scan(&[1.0, f32::NAN, 2.0]));
    assert_eq!(sweep(&revolution).beams, [Beam::Return(0), Beam::NoReturn, Beam::Return(1)]);
    let angle_rad = 2.0 * f64::from(0.1f32);
    assert_eq!(revolution.points_m[1].coords.as_slice(), [2.0 * angle_rad.cos(), 2.0 * angle_rad.sin(), 0.0]);
    assert_eq!(notes, Vec::<String>::new(), "an ordinary scan has no notes");
}

#[test]
fn each_kind_of_range_means_what_the_table_says() {
    let table: &[(f32, Beam, Option<&str>)] = &[
        (f32::NAN, Beam::NoReturn, None),
        (f32::INFINITY, Beam::NoReturn, None),
        (f32::NEG_INFINITY, Beam::Unknown, Some("1 beam of range -inf, too near to measure, left out")),
        (0.0, Beam::NoReturn, Some("1 beam of range 0 read as no return")),
        (-0.0, Beam::NoReturn, Some("1 beam of range 0 read as no return")),
        (-1.0, Beam::NoReturn, Some("1 beam of negative range read as no return")),
        (30.0, Beam::NoReturn, Some("1 beam at or beyond range_max 30 m read as no return")),
        (29.999_998, Beam::NoReturn, Some("1 beam at or beyond range_max 30 m read as no return")),
        (65.535, Beam::NoReturn, Some("1 beam at or beyond range_max 30 m read as no return")),
        (29.99, Beam::Return(0), None),
        (0.099, Beam::Unknown, Some("1 beam below range_min 0.1 m left out")),
        (0.1, Beam::Return(0), None),
    ];
    for &(range, beam, note) in table {
        let (revolution, notes) = plain(&scan(&[range]));
        assert_eq!(sweep(&revolution).beams, [beam], "range {range}");
        assert_eq!(notes, note.into_iter().collect::<Vec<_>>(), "range {range}");
    }
}

#[test]
fn unusable_limits_are_no_limits_and_are_noted() {
    let with = |range_min: f32, range_max: f32| plain(&LaserScan { range_min, range_max, ..scan(&[50.0, 0.01]) });
    let noted = |range_min: f32, range_max: f32, note: &str| {
        let (revolution, notes) = with(range_min, range_max);
        assert_eq!(notes, [note]);
        assert_eq!((revolution.len(), sweep(&revolution).range_max_m), (2, f64::INFINITY), "{note}");
    };
    noted(0.0, 0.0, "range_max 0 m is no range: taken as no limit");
    noted(0.0, f32::NAN, "range_max NaN m is no range: taken as no limit");
    noted(0.0, -3.0, "range_max -3 m is no range: taken as no limit");
    noted(2.0, 1.0, "range_max 1 m is not above range_min 2 m: both taken as no limit");
    noted(f32::NAN, f32::INFINITY, "range_min NaN m is no range: taken as 0");
    noted(-1.0, f32::INFINITY, "range_min -1 m is no range: taken as 0");
    let (revolution, notes) = with(0.0, f32::INFINITY);
    assert_eq!((revolution.len(), notes.len()), (2, 0), "an infinite range_max is a statement, not a fault");
}

#[test]
fn ranges_in_millimetres_are_noted_and_a_single_far_return_is_not() {
    let far = |ranges: &[f32]| plain(&LaserScan { range_max: 60_000.0, ..scan(ranges) }).1;
    let asked = "2 beams farther than 500 m: ranges are read in metres; of millimetres, --set ingest.range_scale=0.001";
    assert_eq!(far(&[1800.0, 2500.0, 300.0]), [asked]);
    assert_eq!(far(&[1800.0, 2.5, 3.0]), Vec::<String>::new());
}

#[test]
fn a_scale_brings_ranges_and_their_limits_to_metres() {
    let mut params = Params::defaults(PARAMS);
    params.set("range_scale", 0.001).expect("a scale");
    let sensor = Sensor::new(&params, &Params::defaults(VEHICLE_PARAMS));
    for range_max in [10_000.0, 10.0] {
        let (mut revolution, mut notes) = (Revolution::default(), Notes::default());
        let message = LaserScan { range_max, ..scan(&[1800.0, 2500.0, 3000.0]) };
        sensor.revolution(&message, &mut revolution, &mut notes);
        assert_eq!(revolution.len(), 3, "{range_max}: a limit in metres is left as it is");
        assert_near(revolution.points_m[0].coords.norm(), 1.8);
    }
}

#[test]
fn angles_in_degrees_are_taken_as_such_with_a_note() {
    for (angle_min, angle_max, angle_increment, what) in [
        (-90.0, 90.0, 1.0, "angle_min, angle_max and angle_increment are in degrees"),
        (-1.570_796_4, 1.570_796_4, 1.0, "angle_increment 1 is in degrees"),
        (-90.0, 90.0, 0.017_453_292, "angle_min and angle_max are in degrees"),
    ] {
        let (revolution, notes) =
            plain(&LaserScan { angle_min, angle_max, angle_increment, range_max: 50.0, ..scan(&[1.0; 181]) });
        assert_eq!(notes, [what], "{angle_min} {angle_increment}");
        let sweep = sweep(&revolution);
        assert!((sweep.bearings_rad[180] - std::f64::consts::FRAC_PI_2).abs() < 1e-4);
    }
}

#[test]
fn a_clockwise_sensor_gives_falling_bearings_and_a_positive_step() {
    let clockwise = LaserScan { angle_min: 0.1, angle_max: -0.1, angle_increment: -0.1, ..scan(&[1.0; 3]) };
    let (revolution, notes) = plain(&clockwise);
    let sweep = sweep(&revolution);
    for (bearing, expected) in sweep.bearings_rad.iter().zip([0.1, 0.0, -0.1]) {
        assert_near(*bearing, expected);
    }
    assert_near(sweep.step_rad, 0.1);
    assert!(notes.is_empty());
}

#[test]
fn an_unusable_increment_is_derived_from_the_ends_and_noted() {
    for increment in [0.0, f32::NAN, f32::INFINITY, 1e-9, 7.0] {
        let odd = LaserScan { angle_min: -0.2, angle_max: 0.2, angle_increment: increment, ..scan(&[1.0; 5]) };
        let (revolution, notes) = plain(&odd);
        assert_near(sweep(&revolution).bearings_rad[1], -0.1);
        assert_eq!(notes, [format!("angle_increment {increment} replaced by (angle_max - angle_min) / steps")]);
    }
}

#[test]
fn without_any_bearing_the_revolution_is_empty_noted_and_keeps_its_beams() {
    let odd = [
        LaserScan { angle_min: f32::NAN, ..scan(&[1.0; 3]) },
        LaserScan { angle_min: f32::NEG_INFINITY, ..scan(&[1.0; 3]) },
        LaserScan { angle_min: -180.0, ..scan(&[1.0; 3]) },
        LaserScan { angle_increment: 0.0, angle_max: 0.0, ..scan(&[1.0; 3]) },
        LaserScan { angle_increment: f32::NAN, angle_max: f32::NAN, ..scan(&[1.0; 3]) },
        LaserScan { angle_increment: 0.0, angle_max: 100.0, ..scan(&[1.0; 3]) },
    ];
    for scan in &odd {
        let (revolution, notes) = plain(scan);
        assert!(revolution.is_empty());
        assert_eq!((sweep(&revolution).len(), &sweep(&revolution).ranges_m[..]), (3, &[1.0f32; 3][..]));
        assert!(sweep(&revolution).beams.iter().all(|beam| *beam == Beam::Unknown));
        assert!(notes.len() == 1 && notes[0].ends_with("no beam has a bearing"), "{notes:?}");
    }
}

#[test]
fn an_angle_max_that_contradicts_the_count_is_noted_and_not_believed() {
    let (revolution, notes) = plain(&LaserScan { angle_max: 3.0, ..scan(&[1.0; 5]) });
    assert_near(sweep(&revolution).bearings_rad[4], 0.4);
    assert_eq!(notes, ["angle_max 3 does not fit 5 beams: bearings are those of angle_min and angle_increment"]);
    let (_, notes) = plain(&LaserScan { angle_max: f32::NAN, ..scan(&[1.0; 5]) });
    assert_eq!(notes.len(), 1);
    let (_, notes) = plain(&LaserScan { angle_max: 0.5, ..scan(&[1.0; 5]) });
    assert!(notes.is_empty(), "one step past the last beam is how many drivers write it");
}

#[test]
fn a_last_beam_on_top_of_the_first_is_left_out_and_the_turn_is_full() {
    let closed = LaserScan { angle_min: -PI32, angle_max: PI32, angle_increment: TAU32 / 360.0, ..scan(&[5.0; 361]) };
    let (revolution, notes) = plain(&closed);
    assert_eq!((revolution.len(), sweep(&revolution).len()), (360, 360));
    assert!(sweep(&revolution).full_turn);
    assert_eq!(notes, ["the last beam looks where the first one does: left out"]);
}

#[test]
fn beams_beyond_a_full_turn_are_left_out() {
    let wound = LaserScan { angle_max: -PI32 + TAU32 * 399.0 / 360.0, ranges: vec![5.0; 400], ..full_turn(360) };
    let (revolution, notes) = plain(&wound);
    assert_eq!((revolution.len(), sweep(&revolution).len(), sweep(&revolution).full_turn), (360, 360, true));
    assert_eq!(sweep(&revolution).ranges_m.len(), 400, "as on the wire");
    assert_eq!(notes, ["40 beams beyond a full turn left out"]);
}

#[test]
fn the_turn_is_full_only_if_the_beams_go_all_the_way_round() {
    for beams in [3, 180, 360, 720, 1081, 4096] {
        let (revolution, notes) = plain(&full_turn(beams));
        assert!(sweep(&revolution).full_turn && notes.is_empty(), "{beams} beams: {notes:?}");
        assert_eq!(revolution.len(), beams);
    }
}

#[test]
fn a_turn_that_is_a_little_short_of_full_is_one_with_a_blind_sector_and_a_limited_view_is_not() {
    let short = |beams: usize, step_rad: f32| LaserScan {
        angle_increment: step_rad,
        ranges: vec![5.0; beams],
        ..full_turn(beams)
    };
    // As a driver does that has a step of 0.007 rad and room for as many as fit.
    let of_driver = short(897, 0.007);
    let degree = TAU32 / 360.0;
    for (scan, missing) in [(of_driver, 1), (short(359, degree), 1), (short(355, degree), 5)] {
        let (revolution, notes) = plain(&scan);
        let sweep = sweep(&revolution);
        assert_eq!((sweep.full_turn, sweep.missing, sweep.len()), (true, missing, scan.ranges.len()));
        assert_eq!(sweep.view().len, scan.ranges.len() + missing);
        assert!(notes.iter().any(|note| note.contains("short of a full turn")), "{notes:?}");
    }
    let (revolution, _) = plain(&short(354, degree));
    assert_eq!((sweep(&revolution).full_turn, sweep(&revolution).missing), (false, 0));
}

#[test]
fn empty_and_one_beam_scans_are_defined() {
    let (revolution, notes) = plain(&scan(&[]));
    assert_eq!((revolution.len(), sweep(&revolution).len()), (0, 0));
    assert_eq!(notes, ["the scan has no beams"]);

    let (revolution, notes) = plain(&LaserScan { angle_min: 0.5, angle_increment: 0.0, ..scan(&[2.0]) });
    assert_near(revolution.bearing_rad(0), 0.5);
    assert!(!sweep(&revolution).full_turn && notes.is_empty());
}

#[test]
fn intensities_of_another_length_are_noted() {
    let (revolution, notes) = plain(&LaserScan { intensities: vec![1.0; 7], ..scan(&[2.0; 3]) });
    assert_eq!((revolution.len(), &notes[..]), (3, &["7 intensities for 3 ranges: not used".to_owned()][..]));
}

#[test]
fn yaw_turns_and_upside_down_mirrors_before_the_yaw() {
    let mounted = |upside_down: bool| {
        sensor(&[("yaw_rad", Value::Float(FRAC_PI_2)), ("upside_down", Value::Boolean(upside_down))])
    };
    let (upright, notes) = revolution_of(&scan(&[1.0, 1.0]), &mounted(false));
    assert_near(upright.bearing_rad(1), FRAC_PI_2 + 0.1);
    assert_eq!(notes, ["bearings turned by the sensor's yaw of 1.5707963267948966 rad"]);
    let (hanging, notes) = revolution_of(&scan(&[1.0, 1.0]), &mounted(true));
    assert_near(hanging.bearing_rad(1), FRAC_PI_2 - 0.1);
    assert_eq!(notes[0], "bearings mirrored: the sensor is mounted upside down");
    for (seen, upside_down) in [(&upright, false), (&hanging, true)] {
        let own_m = mounted(upside_down).in_sensor_frame(seen.points_m[1]);
        assert_near(own_m.y.atan2(own_m.x), 0.1);
    }
}

#[test]
fn a_constant_below_range_max_that_stands_for_no_return_is_read_so_and_equal_ranges_of_a_wall_are_not() {
    let wall = |step_m: f32| (0..80).map(move |i| ((2.0 + 0.003 * (i * i) as f32) / step_m).round() * step_m);
    let behind =
        |step_m: f32, constant_m: f32| -> Vec<f32> { wall(step_m).chain([constant_m; 6]).chain([2.5]).collect() };
    let read = |ranges: &[f32]| {
        let (revolution, notes) = plain(&LaserScan {
            range_max: 100.0,
            angle_increment: 0.01,
            angle_max: 0.01 * (ranges.len() - 1) as f32,
            ..scan(ranges)
        });
        (revolution.len(), notes)
    };
    let (returns, notes) = read(&behind(0.001, 30.0));
    assert_eq!(
        (returns, &notes[..]),
        (81, &["6 beams of exactly 30 m, the largest range, read as no return".to_owned()][..])
    );
    assert_eq!(read(&behind(0.001, 2.0)).0, 87, "not the largest");
    assert_eq!(read(&behind(2.0, 30.0)).0, 87, "ranges are coarse");
    assert_eq!(read(&[30.0; 87]).0, 87, "nothing else is seen");
    assert_eq!(read(&behind(0.001, 30.0)[..82]).0, 82, "two may be chance");
    let apart = |constants: usize| -> Vec<f32> {
        wall(0.001).enumerate().flat_map(|(i, m)| [Some(m), Some(30.0).filter(|_| i < constants)]).flatten().collect()
    };
    assert_eq!(
        (read(&apart(4)).0, read(&apart(5)).0),
        (84, 80),
        "four are as far in a place that is the same all around"
    );
}

#[test]
fn ranges_that_scatter_about_the_maximum_are_no_returns_and_a_wall_that_leaves_the_range_is_one() {
    let wall = |i: usize| 2.0 + 0.003 * i as f32;
    let noise_m = |i: usize| 0.001 + 0.0013 * ((i * 7) % 31) as f32;
    let read = |open: &dyn Fn(usize) -> f32| {
        let ranges: Vec<f32> = (0..80).map(|i| if i < 40 { wall(i) } else { open(i) }).collect();
        plain(&LaserScan { range_max: 10.0, angle_increment: 0.01, angle_max: 0.79, ..scan(&ranges) })
    };
    let (noisy, notes) = read(&|i| if i % 2 == 0 { 10.0 } else { 10.0 - noise_m(i) });
    assert_eq!(noisy.len(), 40);
    assert!(notes.contains(&"20 beams within noise of range_max 10 m read as no return".to_owned()), "{notes:?}");
    let leaving = read(&|i| if i < 60 { 9.96 + 0.0015 * (i - 40) as f32 } else { 10.0 }).0;
    assert_eq!(leaving.len(), 60, "a wall that leaves the range");
    let exact = read(&|i| if i < 76 { 10.0 } else { 9.999 - 0.001 * (i - 76) as f32 }).0;
    assert_eq!(exact.len(), 44, "too few for noise");
}

#[test]
fn noise_that_is_cut_off_at_the_maximum_is_known_by_its_half_below() {
    // Quantiles of a half normal distribution of 5 cm, every other beam cut off at 8 m.
    let below_m = |i: usize| 0.05 * [0.06, 0.19, 0.32, 0.45, 0.6, 0.75, 0.93, 1.15, 1.44, 1.96][i / 2 % 10];
    let ranges: Vec<f32> = (0..160).map(|i| 8.0 - if i % 2 == 0 { 0.0 } else { below_m(i) }).collect();
    let (empty, notes) = plain(&LaserScan { range_max: 8.0, angle_increment: 0.01, angle_max: 1.59, ..scan(&ranges) });
    assert_eq!(empty.len(), 0, "{notes:?}");
}

#[test]
fn a_limit_below_nearly_all_ranges_is_none() {
    let ranges: Vec<f32> = (0..40).map(|i| 1.5 + 0.1 * i as f32).collect();
    let (revolution, notes) = plain(&LaserScan { range_min: 0.0, range_max: 1e-4, ..scan(&ranges) });
    assert_eq!(revolution.len(), 40);
    assert!(
        notes.contains(&"range_max 0.0001 m is below nearly all ranges: taken as no limit".to_owned()),
        "{notes:?}"
    );
    let codes: Vec<f32> = (0..40).map(|i| if i % 7 == 0 { 5.0 } else { 65.533 }).collect();
    assert_eq!(plain(&scan(&codes)).0.len(), 6, "a code is no range, however many beams tell it");
}

#[test]
fn beams_that_a_filter_masked_are_unknown() {
    let (revolution, _) = plain(&scan(&[1.0, 31.0, 31.0, f32::INFINITY]));
    assert_eq!(sweep(&revolution).beams, [Beam::Return(0), Beam::Unknown, Beam::Unknown, Beam::NoReturn]);
    let (revolution, _) = plain(&scan(&[1.0, 31.0, 31.0, 2.0]));
    assert_eq!(sweep(&revolution).beams[1], Beam::NoReturn, "a driver may say so that nothing came back");
}

#[test]
fn configured_limits_cut_both_ends_and_the_smaller_maximum_holds() {
    let cut = sensor(&[("min_range_m", Value::Float(1.0)), ("max_range_m", Value::Float(10.0))]);
    let (revolution, notes) = revolution_of(&scan(&[0.5, 1.0, 10.0, 10.5]), &cut);
    assert_eq!(sweep(&revolution).beams, [Beam::Unknown, Beam::Return(0), Beam::Return(1), Beam::NoReturn]);
    assert_eq!(sweep(&revolution).range_max_m, 10.0);
    assert_eq!(
        notes,
        ["1 beam nearer than min_range_m 1 m left out", "1 beam beyond max_range_m 10 m read as no return"]
    );
    let (revolution, _) = revolution_of(&LaserScan { range_max: 8.0, ..scan(&[9.0]) }, &cut);
    assert_eq!((revolution.len(), sweep(&revolution).range_max_m), (0, 8.0));
}

#[test]
fn masked_sectors_are_in_the_body_frame_and_may_cross_the_back() {
    let masked = |pairs: &[[f64; 2]], yaw: f64| {
        let sensor = sensor(&[
            ("masked_sectors_rad", pairs.iter().map(|pair| pair.to_vec()).collect::<Vec<_>>().into()),
            ("yaw_rad", Value::Float(yaw)),
        ]);
        revolution_of(&full_turn(360), &sensor)
    };
    let unknown_at = |revolution: &Revolution, bearing_rad: f64| {
        let sweep = sweep(revolution);
        let distance = |i: &usize| (sweep.bearings_rad[*i] - bearing_rad).abs();
        let nearest = (0..sweep.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("beams");
        sweep.beams[nearest] == Beam::Unknown
    };
    let (back, notes) = masked(&[[3.0, -3.0]], 0.0);
    assert!(unknown_at(&back, 3.1) && unknown_at(&back, -3.1) && !unknown_at(&back, 0.0));
    assert!(notes[0].ends_with("beams in masked sectors left out"), "{notes:?}");
    let (turned, _) = masked(&[[-0.2, 0.2]], FRAC_PI_2);
    assert!(unknown_at(&turned, 0.0) && !unknown_at(&turned, FRAC_PI_2), "the mask does not turn with the sensor");
    let (seam, _) = masked(&[[-PI, -3.0]], 0.0);
    assert_eq!(sweep(&seam).beams[0], Beam::Unknown, "the first beam looks at f32 -π, which is beyond π");
    assert_ne!(sweep(&seam).beams[359], Beam::Unknown);
    let (all, notes) = masked(&[[-PI, PI]], 0.0);
    assert_eq!((all.len(), &notes[..]), (0, &["360 beams in masked sectors left out".to_owned()][..]));
}

fn odd_number() -> impl Strategy<Value = f32> {
    prop_oneof![any::<f32>(), -7.0f32..7.0, Just(0.0), Just(f32::NAN), Just(f32::INFINITY), Just(5.6)]
}

fn odd_scan() -> impl Strategy<Value = LaserScan> {
    let numbers = prop::array::uniform5(odd_number());
    (numbers, prop::collection::vec(odd_number(), 0..50), 0usize..60).prop_map(|(numbers, ranges, intensities)| {
        let [angle_min, angle_max, angle_increment, range_min, range_max] = numbers;
        let intensities = vec![0.0; intensities];
        LaserScan { angle_min, angle_max, angle_increment, range_min, range_max, ranges, intensities, ..scan(&[]) }
    })
}

proptest! {
    #[test]
    fn whatever_the_scan_says_the_revolution_is_sound(odd in odd_scan(), before in odd_scan(), yaw in -PI..PI) {
        let sensor = sensor(&[
            ("yaw_rad", Value::Float(yaw)),
            ("masked_sectors_rad", vec![vec![1.0, 1.5]].into()),
            ("max_range_m", Value::Float(100.0)),
        ]);
        let (fresh, _) = revolution_of(&odd, &sensor);
        let (mut reused, mut notes) = (Revolution::default(), Notes::default());
        sensor.revolution(&before, &mut reused, &mut notes);
        sensor.revolution(&odd, &mut reused, &mut notes);
        prop_assert_eq!(format!("{:?}", &fresh), format!("{:?}", &reused), "buffers must not leak");

        let sweep = sweep(&fresh);
        prop_assert!(sweep.beams.len() <= odd.ranges.len());
        prop_assert_eq!(sweep.ranges_m.len(), odd.ranges.len());
        prop_assert_eq!(sweep.bearings_rad.len(), odd.ranges.len());
        prop_assert!(sweep.range_max_m > 0.0 && sweep.range_max_m <= 100.0);
        prop_assert!(sweep.bearings_rad.iter().all(|&b| b > -PI - 1e-12 && b <= PI));
        let mut returns = 0;
        for (i, beam) in sweep.beams.iter().enumerate() {
            if let Beam::Return(point) = *beam {
                prop_assert_eq!(point as usize, returns, "returns are in message order");
                returns += 1;
                let (range_m, bearing_rad) = (fresh.range_m(point as usize), fresh.bearing_rad(point as usize));
                prop_assert!((range_m / f64::from(odd.ranges[i]) - 1.0).abs() < 1e-12);
                prop_assert!((bearing_rad - sweep.bearings_rad[i]).sin().abs() < 1e-9);
                prop_assert!(range_m <= sweep.range_max_m);
            }
        }
        prop_assert_eq!(returns, fresh.len());
    }
}

//! What the pose knows of its own doubt, on plans that are flown here.

use std::cell::Cell;
use std::collections::BTreeSet;

use crosscut_detector::{Preset, Settings};
use crosscut_flight::{Flight, FlightAnswer, Map, Mapper, PARAMS, PoseTracker};
use crosscut_sensor::Sensor;
use crosscut_simulator::{Plan, Scene};
use crosscut_stage::{Frame, Notes, Params, PoseDoubt, Revolution};
use nalgebra::Isometry2;

/// A tunnel of 120 m with two side ways, 40 m apart.
fn tunnel(roughness_m: f64) -> impl Iterator<Item = Scene> {
    let plan = format!(
        r#"{{"nodes":[{{"id":0,"x_m":0,"y_m":0}},{{"id":1,"x_m":40,"y_m":0}},{{"id":2,"x_m":80,"y_m":0}},{{"id":3,"x_m":120,"y_m":0}},
           {{"id":4,"x_m":40,"y_m":15}},{{"id":5,"x_m":80,"y_m":15}}],
           "edges":[{{"from":0,"to":1,"width_m":4}},{{"from":1,"to":2,"width_m":4}},{{"from":2,"to":3,"width_m":4}},
           {{"from":1,"to":4,"width_m":4}},{{"from":2,"to":5,"width_m":4}}],"roughness_m":{roughness_m}}}"#
    );
    Plan::from_json(&plan).and_then(|plan| plan.fly(1)).expect("a plan")
}

/// What was seen of a flight.
#[derive(Default)]
struct Seen {
    /// True pose, pose and doubt of each revolution.
    poses: Vec<[Isometry2<f64>; 2]>,
    doubts: Vec<PoseDoubt>,
    notes: BTreeSet<String>,
    map: Map,
}

impl Seen {
    fn sd_m(&self, at: usize) -> Option<f64> {
        self.doubts[at].from_start_sd_m(self.poses[at][1].translation.vector.into())
    }

    fn has_note(&self, part: &str) -> bool {
        self.notes.iter().any(|note| note.contains(part))
    }

    /// How far the last pose is off.
    fn off_m(&self) -> f64 {
        let ([first, _], [last, found]) = (self.poses[0], self.poses[self.poses.len() - 1]);
        first.inv_mul(&last).inv_mul(&found).translation.vector.norm()
    }
}

/// Follows scenes; `odometry` makes the odometry of the true pose.
fn follow(scenes: impl Iterator<Item = Scene>, odometry: impl Fn(&Isometry2<f64>) -> Option<Isometry2<f64>>) -> Seen {
    let (sensor, mut engine) = (Sensor::default(), Settings::new(Preset::Default).engine().expect("the preset"));
    let (mut flight, mut mapper) = (Flight::new(&Params::defaults(PARAMS), 0.6), Mapper::default());
    let (mut frame, mut seen) = (Frame::default(), Seen::default());
    for scene in scenes {
        frame.notes.clear();
        sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
        let pose = scene.pose.expect("a scene of a flight");
        let pose = Isometry2::new(pose.position_m.coords, pose.heading_rad);
        frame.revolution.odometry = odometry(&pose);
        engine.process(&mut frame).expect("no failure");
        flight.add(&mut frame);
        mapper.add(&frame);
        seen.poses.push([pose, FlightAnswer::of(&frame).pose.expect("a pose")]);
        seen.doubts.push(FlightAnswer::of(&frame).doubt.expect("with a pose"));
        seen.notes.extend(frame.notes.iter().map(str::to_owned));
    }
    seen.map = mapper.map();
    seen
}

const STILL: fn(&Isometry2<f64>) -> Option<Isometry2<f64>> = |_| Some(Isometry2::identity());
const EXACT: fn(&Isometry2<f64>) -> Option<Isometry2<f64>> = |pose| Some(*pose);
const NONE: fn(&Isometry2<f64>) -> Option<Isometry2<f64>> = |_| None;

#[test]
fn odometry_that_stands_still_does_not_hold_the_pose_between_rough_walls() {
    let seen = follow(tunnel(0.1).take(500), STILL);
    assert!(seen.has_note("the odometry moved by 0.0 m, the scans by 3."), "{:?}", seen.notes);
    assert!(seen.off_m() < 1.5, "{} m off", seen.off_m());
    assert!(seen.sd_m(499).is_some_and(|sd_m| sd_m < 2.0));
}

#[test]
fn exact_odometry_is_never_doubted() {
    let seen = follow(tunnel(0.1).take(300), EXACT);
    assert!(!seen.has_note("contradict") && !seen.has_note("a new stretch"), "{:?}", seen.notes);
}

/// The wheels spin for a second or two while the vehicle moves on: at 200 revolutions the odometry gains 1.5 m.
#[test]
fn wheels_that_slip_are_noted_with_both_figures() {
    let gained = Cell::new(0);
    let seen = follow(tunnel(0.1).take(300), |pose| {
        gained.set(gained.get() + 1);
        let slipped_m = 0.1 * f64::from((gained.get() - 200).clamp(0, 15));
        Some(pose * Isometry2::translation(slipped_m, 0.0))
    });
    assert!(seen.has_note("a slip or a jump: the odometry moved by"), "{:?}", seen.notes);
    assert!(seen.off_m() < 0.75, "{} m off", seen.off_m());
}

/// The wheels turn too fast, or slide, for ten metres: too little from scan to scan to be a jump.
#[test]
fn wheels_that_slip_for_metres_are_noted() {
    for times in [1.3, 0.7] {
        let state = Cell::new((None, Isometry2::identity(), 0.0));
        let seen = follow(tunnel(0.1).take(220), |pose| {
            let (before, odometry, way_m) = state.get();
            let step = before.map_or(Isometry2::identity(), |before: Isometry2<f64>| before.inv_mul(pose));
            let slips = (15.0..25.0).contains(&way_m);
            let moved_m = step.translation.vector * if slips { times } else { 1.0 };
            let odometry = odometry * Isometry2::new(moved_m, step.rotation.angle());
            state.set((Some(*pose), odometry, way_m + step.translation.vector.norm()));
            Some(odometry)
        });
        let is_noted = seen.has_note("they contradict each other") && seen.has_note("they agree again");
        assert!(is_noted && seen.off_m() < 0.5, "{times}: {} m off, {:?}", seen.off_m(), seen.notes);
    }
}

#[test]
fn odometry_that_drifts_slips_nowhere() {
    let seen = follow(tunnel(0.1).take(400), |pose| {
        Some(Isometry2::new(pose.translation.vector * 1.05, pose.rotation.angle()))
    });
    assert!(!seen.has_note("a slip"), "{:?}", seen.notes);
}

#[test]
fn the_length_of_a_smooth_tunnel_is_unknown_without_odometry() {
    let seen = follow(tunnel(0.0), NONE);
    assert!(seen.has_note("its length is not known"));
    assert_eq!(seen.sd_m(seen.poses.len() - 1), None);
    let between = seen.map.passages.iter().filter(|passage| passage.length_sd_m.is_none());
    assert!(between.count() > 0, "{:?}", seen.map.passages);
    let junctions = seen.map.nodes.iter().filter(|node| node.ways.len() == 3).count();
    assert!(junctions >= 2, "two tees that look alike are not one: {}", seen.map.summary());
}

#[test]
fn odometry_holds_the_length_of_a_smooth_tunnel() {
    let seen = follow(tunnel(0.0).take(500), |pose| {
        Some(Isometry2::new(pose.translation.vector * 1.03, pose.rotation.angle()))
    });
    let way_m: f64 = seen.poses.windows(2).map(|two| two[0][0].inv_mul(&two[1][0]).translation.vector.norm()).sum();
    assert!(
        seen.off_m() < 0.1 * way_m && seen.sd_m(499).is_some_and(|sd_m| sd_m > 0.3),
        "{} of {way_m} m",
        seen.off_m()
    );
    assert!(!seen.has_note("not known"), "{:?}", seen.notes);
}

#[test]
fn what_was_guessed_is_known_once_the_odometry_leads_across() {
    let scan = Cell::new(0);
    let seen = follow(tunnel(0.0).take(500), |pose| {
        scan.set(scan.get() + 1);
        Some(*pose).filter(|_| !(100..400).contains(&scan.get()))
    });
    let unknown = (0..500).filter(|at| seen.sd_m(*at).is_none());
    assert!(unknown.clone().count() > 100 && unknown.max() == Some(398), "the odometry is back at 399");
    assert!(seen.off_m() < 3.0 * seen.sd_m(499).expect("known"), "{} m off", seen.off_m());
}

#[test]
fn a_gap_begins_a_new_stretch_unless_odometry_leads_across() {
    let with_gap =
        || tunnel(0.1).take(400).enumerate().filter(|(at, _)| !(200..260).contains(at)).map(|(_, scene)| scene);
    let alone = follow(with_gap(), NONE);
    assert!(alone.has_note("6.1 s without a scan; a new stretch begins"), "{:?}", alone.notes);
    assert!(alone.sd_m(199).is_some() && alone.sd_m(200).is_none());
    assert_eq!(alone.doubts[339].stretch, 1);
    let led = follow(with_gap(), EXACT);
    assert!(led.off_m() < 1.0 && led.doubts[339].stretch == 0, "{} m off", led.off_m());
}

/// After the pause, the first scan comes before the odometry that tells what happened in it.
#[test]
fn odometry_that_comes_late_after_a_pause_leads_across() {
    let with_gap = tunnel(0.1).take(400).enumerate().filter(|(at, _)| !(200..260).contains(at)).map(|(_, scene)| scene);
    let (sensor, mut tracker) = (Sensor::default(), PoseTracker::new(&Params::defaults(PARAMS)));
    let (mut revolution, mut found, mut first) = (Revolution::default(), Vec::new(), None);
    for (at, scene) in with_gap.enumerate() {
        sensor.revolution(&scene.scan, &mut revolution, &mut Notes::default());
        let pose = scene.pose.expect("a scene of a flight");
        let pose = Isometry2::new(pose.position_m.coords, pose.heading_rad);
        let from_first = first.get_or_insert(pose).inv_mul(&pose);
        revolution.odometry = Some(from_first).filter(|_| !(200..202).contains(&at));
        let tracked = tracker.add(&revolution, &mut Notes::default());
        found.push(
            tracked.map(|tracked| (tracked.doubt.stretch, tracked.pose.inv_mul(&from_first).translation.vector.norm())),
        );
    }
    assert!(found[199].is_some() && found[200..202] == [None, None], "nothing leads across yet");
    assert!(
        found[202..].iter().all(|found| found.is_some_and(|(stretch, off_m)| stretch == 0 && off_m < 1.0)),
        "{found:?}"
    );
}

/// Halls 20 m wide: where scans show little, a match that lags behind must not outweigh the odometry.
#[test]
fn no_pose_is_farther_off_than_its_odometry() {
    let plan = r#"{"nodes":[{"id":0,"x_m":0,"y_m":0},{"id":1,"x_m":60,"y_m":0},{"id":2,"x_m":60,"y_m":60}],
        "edges":[{"from":0,"to":1,"width_m":20},{"from":1,"to":2,"width_m":20}],"roughness_m":0.02}"#;
    let scenes: Vec<Scene> = Plan::from_json(plan).and_then(|plan| plan.fly(1)).expect("a plan").collect();
    for (every, drift) in [(1, 0.02), (3, 0.05), (6, 0.05), (6, 0.2)] {
        let (sensor, mut tracker) = (Sensor::default(), PoseTracker::new(&Params::defaults(PARAMS)));
        let (mut revolution, mut before) = (Revolution::default(), None);
        let (mut from_first, mut odometry) = (Isometry2::identity(), Isometry2::identity());
        let [mut off_m2, mut odometry_off_m2] = [0.0; 2];
        for scene in scenes.iter().step_by(every) {
            let pose = scene.pose.expect("a scene of a flight");
            let pose = Isometry2::new(pose.position_m.coords, pose.heading_rad);
            let step =
                before.replace(pose).map_or(Isometry2::identity(), |before: Isometry2<f64>| before.inv_mul(&pose));
            let moved_m = step.translation.vector * (1.0 + drift);
            from_first *= step;
            odometry *= Isometry2::new(moved_m, step.rotation.angle() + 0.1 * drift * moved_m.norm());
            sensor.revolution(&scene.scan, &mut revolution, &mut Notes::default());
            revolution.odometry = Some(odometry);
            let tracked = tracker.add(&revolution, &mut Notes::default()).expect("there is odometry");
            off_m2 += (tracked.pose.translation.vector - from_first.translation.vector).norm_squared();
            odometry_off_m2 += (odometry.translation.vector - from_first.translation.vector).norm_squared();
        }
        let times = (off_m2 / odometry_off_m2).sqrt();
        assert!(times < 1.1, "every {every}, drift {drift}: {times} times as far off as the odometry");
    }
}

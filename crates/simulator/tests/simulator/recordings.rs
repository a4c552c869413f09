//! Suites, flights and their recordings.

use crosscut_messages::{LaserScan, Message, Odometry, TfMessage, Truth};
use crosscut_simulator::{SCENES, Scene, SceneRecorder, Split, scenarios, suites, write_mcap};

fn scenes(suite: &str, split: Split) -> Vec<Scene> {
    let suite = suites().iter().find(|known| known.name == suite).unwrap_or_else(|| panic!("no suite {suite}"));
    suite.scenes(split).collect()
}

fn share(scenes: &[Scene], label: i32) -> f64 {
    let labels = scenes.iter().flat_map(|scene| &scene.truth.labels);
    labels.clone().filter(|&&known| known == label).count() as f64 / labels.count() as f64
}

#[test]
fn every_scene_has_a_truth_that_fits_its_scan() {
    for suite in suites() {
        let mut count = 0;
        for scene in suite.scenes(Split::Dev) {
            count += 1;
            assert_eq!(scene.scan.ranges.len(), scene.truth.labels.len(), "{}", suite.name);
            Truth::from_json(&scene.truth.to_json()).unwrap_or_else(|error| panic!("{}: {error}", suite.name));
            for (range_m, &label) in scene.scan.ranges.iter().zip(&scene.truth.labels) {
                assert_eq!(range_m.is_finite(), label != Truth::NO_RETURN, "{}", suite.name);
            }
        }
        assert_eq!(count, SCENES, "{}", suite.name);
    }
}

#[test]
fn single_places_have_one_to_five_branches_equally_often() {
    for suite in ["clean6", "clean35", "sparse", "wet", "narrow", "dust", "rough", "offcentre", "dense720", "pillars"] {
        let mut counts = [0; 6];
        for scene in scenes(suite, Split::Dev) {
            assert_eq!(scene.truth.openings.len(), scene.truth.walls as usize, "{suite}: all around, as many as walls");
            counts[scene.truth.walls as usize] += 1;
        }
        assert_eq!(counts, [0, 120, 120, 120, 120, 120], "{suite}");
    }
}

#[test]
fn families_have_the_stated_loss_dust_and_beams() {
    let clean = scenes("clean6", Split::Dev);
    assert_eq!(share(&clean, Truth::NO_WALL), 0.0);
    let lost = |suite: &str, reference: &[Scene]| {
        let kept = |scenes: &[Scene]| 1.0 - share(scenes, Truth::NO_RETURN);
        1.0 - kept(&scenes(suite, Split::Dev)) / kept(reference)
    };
    // 20 % at random, and patches over 15 % of the beams.
    let wet = lost("wet", &clean);
    assert!((0.29..0.36).contains(&wet), "wet loses {wet}");
    let dust = share(&scenes("dust", Split::Dev), Truth::NO_WALL);
    assert!((0.035..0.045).contains(&dust), "dust makes {dust}");
    assert!(scenes("pillars", Split::Dev).iter().all(|scene| (1..=3).contains(&scene.truth.islands)));
    assert_eq!(scenes("dense720", Split::Dev)[0].scan.ranges.len(), 720);
    assert_eq!(scenes("view180", Split::Dev)[0].scan.angle_max, std::f32::consts::FRAC_PI_2);
}

#[test]
fn splits_share_no_scene_and_are_reproducible() {
    for suite in ["clean6", "flight_tunnel"] {
        let dev = scenes(suite, Split::Dev);
        assert!(dev == scenes(suite, Split::Dev), "{suite}");
        let report = scenes(suite, Split::Report);
        assert!(report.iter().all(|scene| dev.iter().all(|other| other.scan.ranges != scene.scan.ranges)), "{suite}");
    }
}

#[test]
fn flights_avoid_the_rock_and_visit_many_places() {
    for scenario in scenarios() {
        let mut kinds = std::collections::BTreeSet::new();
        for seed in 0..4 {
            for scene in (scenario.fly)(seed) {
                let nearest_m = scene.scan.ranges.iter().zip(&scene.truth.labels).filter(|(_, label)| **label >= 0);
                let nearest_m = nearest_m.map(|(range_m, _)| *range_m).fold(f32::MAX, f32::min);
                assert!(nearest_m > 0.3, "{} of seed {seed} comes within {nearest_m} m of a wall", scenario.name);
                kinds.insert(scene.truth.walls);
            }
        }
        let wanted: &[u32] = match scenario.name {
            "tee" => &[2, 3],
            "tunnel" => &[1, 2, 3, 4],
            _ => &[2, 3, 4],
        };
        assert!(wanted.iter().all(|kind| kinds.contains(kind)), "{}: {kinds:?}", scenario.name);
    }
}

#[test]
fn odometry_drifts_but_not_far() {
    let scenario = scenarios().iter().find(|scenario| scenario.name == "tunnel").expect("there is one");
    let positions = |seed| -> Vec<(f64, f64)> {
        (scenario.fly)(seed)
            .map(|scene| scene.odometry.expect("a flight has odometry").pose.pose.position)
            .map(|position| (position.x, position.y))
            .collect()
    };
    let track = positions(3);
    assert_eq!(track[0], (0.0, 0.0));
    let path_m: f64 = track.windows(2).map(|pair| (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1)).sum();
    // 1.5 m/s at ten sweeps a second; the scale error has a standard deviation of 2 %.
    let flown_m = 0.15 * (track.len() - 1) as f64;
    assert!((path_m / flown_m - 1.0).abs() < 0.08, "{path_m} of {flown_m} m");
    assert!((path_m - flown_m).abs() > 0.01, "odometry without any error");
}

#[test]
fn a_recording_reads_back_and_is_reproducible() {
    let folder = tempfile::tempdir().expect("a folder");
    let tee = scenarios().iter().find(|scenario| scenario.name == "tee").expect("there is one");
    let record = |name: &str, seed| {
        let path = folder.path().join(name);
        write_mcap(&path, (tee.fly)(seed)).expect("written");
        std::fs::read(path).expect("there")
    };
    let bytes = record("a.mcap", 1);
    assert!(bytes == record("b.mcap", 1), "two runs differ");
    assert!(bytes != record("c.mcap", 2), "the seed has no effect");
    assert!(bytes.len() < 400_000, "{} bytes are too many for a sample", bytes.len());

    let mut flight = (tee.fly)(1);
    let mut current = None;
    let mut topics = Vec::new();
    for message in mcap::MessageStream::new(&bytes).expect("an MCAP file") {
        let message = message.expect("a whole message");
        let topic = message.channel.topic.as_str();
        if topic == "/scan" {
            current = flight.next();
        }
        let scene = current.as_ref().expect("as many scans as scenes");
        assert_eq!(message.log_time, scene.stamp_ns, "{topic} has the log time of its scan");
        match topic {
            "/scan" => assert_eq!(LaserScan::decode(&message.data).expect("a scan"), scene.scan),
            "/truth" => assert!(message.data[..] == scene.truth.to_json(), "another truth"),
            "/truth/map" => {
                let map = scene.map.as_ref().expect("with the first scene alone");
                assert!(message.data[..] == map.to_json(), "another map");
            }
            "/odom" => assert_eq!(Some(Odometry::decode(&message.data).expect("odometry")), scene.odometry),
            "/tf" => assert_eq!(Some(TfMessage::decode(&message.data).expect("transforms")), scene.transforms()),
            other => panic!("what is {other}"),
        }
        topics.push(topic.to_owned());
    }
    assert!(flight.next().is_none(), "fewer scans than scenes");
    assert_eq!(topics[..6], ["/scan", "/truth", "/truth/map", "/odom", "/tf", "/scan"]);
}

#[test]
fn a_file_that_cannot_be_created_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("no/such/folder.mcap");
    let error = write_mcap(&path, std::iter::empty()).expect_err("there is no such folder").to_string();
    assert!(error.contains("cannot create the recording") && error.contains("folder.mcap"), "{error}");
}

#[test]
#[cfg(unix)]
fn a_recording_that_is_being_written_is_not_written_by_another() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("flight.mcap");
    let scene = &scenes("clean6", Split::Dev)[0];
    let mut first = SceneRecorder::create(&path).expect("writable");
    first.add(scene).expect("writable");
    assert!(SceneRecorder::create(&path).is_err());
    assert_eq!(first.finish().expect("writable"), 1);
    SceneRecorder::create(&path).expect("nobody writes it any more");
}

//! `crosscut simulate`.

use std::path::{Path, PathBuf};

use crosscut_messages::{LaserScan, Message, SCAN_TOPIC};

use crate::program::{run, shipped_flight};

fn simulate(folder: &Path, name: &str, seed: &str) -> PathBuf {
    let made = folder.join(name);
    let args = ["simulate".as_ref(), "tee".as_ref(), "--seed".as_ref(), seed.as_ref(), "--out".as_ref()];
    run(args.into_iter().chain([made.as_os_str()])).expect_code(0);
    made
}

fn scans(path: &Path) -> Vec<LaserScan> {
    let bytes = std::fs::read(path).expect("a recording");
    let messages = mcap::MessageStream::new(&bytes).expect("an MCAP").map(|message| message.expect("a message"));
    let scans = messages.filter(|message| message.channel.topic == SCAN_TOPIC);
    scans.map(|message| LaserScan::decode(&message.data).expect("a scan")).collect()
}

#[test]
fn the_shipped_flight_is_what_its_command_makes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (made, shipped) = (scans(&simulate(folder.path(), "tee.mcap", "1")), scans(&shipped_flight()));
    assert_eq!(made.len(), shipped.len());
    // Ranges are rounded to 1 mm, and sines differ in the last bit from one machine to another.
    let same = |a: &f32, b: &f32| a == b || (a - b).abs() < 0.0015;
    for (seq, (made, shipped)) in made.iter().zip(&shipped).enumerate() {
        assert_eq!(made.header, shipped.header);
        let differs = made.ranges.iter().zip(&shipped.ranges).position(|(a, b)| !same(a, b));
        assert_eq!(differs, None, "beam of scan {seq}: make the flight anew, see recordings/README.md");
    }
}

#[test]
fn equal_seeds_give_equal_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let fly = |name, seed| std::fs::read(simulate(folder.path(), name, seed)).expect("made");
    let reference = fly("a.mcap", "7");
    assert!(fly("b.mcap", "7") == reference, "the same seed");
    assert!(fly("c.mcap", "8") != reference, "another seed");
}

#[test]
fn scenarios_and_suites_are_listed_and_unknown_ones_refused() {
    let listed = run(["simulate", "--list"]).expect_code(0).stdout;
    assert!(listed.contains("tee") && listed.contains("clean35"), "{listed}");
    for unknown in [["teee", "--seed", "1"], ["--suite", "clean53", "--split=dev"]] {
        let ran = run(["simulate", "--out", "nowhere"].iter().chain(&unknown)).expect_code(2);
        assert!(ran.stderr.contains("there are:"), "{}", ran.stderr);
    }
}

#[test]
fn a_plan_is_flown_and_its_map_has_its_junctions() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (plan, flight, map) =
        (folder.path().join("plan.json"), folder.path().join("plan.mcap"), folder.path().join("map.json"));
    let text = r#"{"nodes": [{"id": "portal", "x_m": 0, "y_m": 0}, {"id": 1, "x_m": 40, "y_m": 0}, {"id": 2, "x_m": 40, "y_m": 40},
        {"id": 3, "x_m": 80, "y_m": 0}], "roughness_m": 0.05, "edges": [{"from": "portal", "to": 1, "width_m": 4},
        {"from": 1, "to": 2, "width_m": 4}, {"from": 1, "to": 3, "width_m": 4, "via_m": [[60, -5]]}]}"#;
    std::fs::write(&plan, text).expect("written");
    let simulate = |out: &Path| run([Path::new("simulate"), Path::new("--plan"), &plan, Path::new("--out"), out]);
    simulate(&flight).expect_code(0);
    let again = folder.path().join("again.mcap");
    simulate(&again).expect_code(0);
    assert_eq!(std::fs::read(&again).expect("written"), std::fs::read(&flight).expect("written"), "the same bytes");
    let said = run([Path::new("run"), &flight, Path::new("--map"), &map]).expect_code(0).stderr;
    assert!(said.starts_with("1 junction: 1 tee; "), "{said}");

    let refused = simulate(&plan).expect_code(2).stderr;
    assert!(refused.contains("would be overwritten"), "{refused}");
    std::fs::write(&plan, text.replace("\"to\": 3", "\"to\": 4")).expect("written");
    let refused = simulate(&flight).expect_code(2).stderr;
    assert!(refused.contains("plan.json: edge 2 names the node 4"), "{refused}");
}

fn topics(path: &Path) -> Vec<String> {
    let bytes = std::fs::read(path).expect("a recording");
    let messages = mcap::MessageStream::new(&bytes).expect("an MCAP").map(|message| message.expect("a message"));
    let mut topics: Vec<String> = messages.map(|message| message.channel.topic.clone()).collect();
    topics.sort();
    topics.dedup();
    topics
}

#[test]
fn a_flight_has_the_map_of_its_mine_and_the_odometry_that_was_asked_for() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let fly = |name: &str, options: &[&str]| {
        let made = folder.path().join(name);
        let args = ["simulate", "tee"].iter().chain(options).copied().chain(["--out"]).map(std::ffi::OsStr::new);
        run(args.chain([made.as_os_str()])).expect_code(0);
        made
    };
    let usual = fly("usual.mcap", &[]);
    assert_eq!(topics(&usual), ["/odom", "/scan", "/tf", "/truth", "/truth/map"]);
    assert_eq!(topics(&fly("scans.mcap", &["--drift", "none"])), ["/scan", "/truth", "/truth/map"]);
    let drifting = fly("drifting.mcap", &["--drift", "0.1"]);
    assert_eq!(scans(&usual), scans(&drifting), "drift changes the odometry alone");
    assert_ne!(std::fs::read(usual).expect("made"), std::fs::read(drifting).expect("made"));
    let refused = run(["simulate", "tee", "--drift", "2", "--out", "nowhere.mcap"]).expect_code(2).stderr;
    assert!(refused.contains("a share of the way"), "{refused}");
}

//! `crosscut explore`.

use std::path::Path;

use serde_json::Value;

use crate::program::{crosscut, results_of, run};

/// The outcome that a mission writes to standard output.
fn outcome(args: &[&str]) -> (String, String) {
    let all = ["explore"].iter().chain(args).chain(&["--json", "-"]);
    let ran = run(all).expect_code(0);
    (ran.stdout, ran.stderr)
}

#[test]
fn a_mission_reports_what_it_visited_and_its_map() {
    let (json, said) = outcome(&["tee", "--seed", "3"]);
    let value: Value = serde_json::from_str(&json).expect("one JSON object");
    assert_eq!((&value["ways"], &value["ways_visited"]), (&Value::from(3), &Value::from(3)), "{said}");
    assert_eq!((&value["home"], &value["crashes"]), (&Value::from(true), &Value::from(0)));
    let metres = |field: &str| value[field].as_f64().expect("a number");
    assert!(metres("way_m") < 1.25 * metres("depth_first_m") && metres("offline_m") > 50.0, "{json}");
    assert!(value["revolutions"].as_u64().is_some_and(|revolutions| revolutions > 300));
    assert_eq!(value["map"]["nodes"].as_array().map(Vec::len), Some(4), "a junction and three ends");
    assert_eq!(value["map"]["edges"].as_array().map(Vec::len), Some(3));
    assert!(said.starts_with("3 of 3 ways visited, home again, no crash"), "{said}");
    assert_eq!(outcome(&["tee", "--seed", "3", "--quiet"]), (json, String::new()), "the same seed, the same bytes");
}

#[test]
fn the_mine_of_a_plan_is_explored() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let plan = folder.path().join("plan.json");
    let text = r#"{"nodes": [{"id": "portal", "x_m": 0, "y_m": 0}, {"id": 1, "x_m": 20, "y_m": 0}, {"id": 2, "x_m": 20, "y_m": 16},
        {"id": 3, "x_m": 38, "y_m": 0}], "roughness_m": 0.05, "edges": [{"from": "portal", "to": 1, "width_m": 3},
        {"from": 1, "to": 2, "width_m": 3}, {"from": 1, "to": 3, "width_m": 3}]}"#;
    std::fs::write(&plan, text).expect("written");
    let name = plan.display().to_string();
    let (json, said) = outcome(&["--plan", &name, "--planner", "depth_first"]);
    let value: Value = serde_json::from_str(&json).expect("one JSON object");
    assert_eq!((&value["ways_visited"], &value["home"]), (&Value::from(3), &Value::from(true)), "{said}");

    let refused = run(["explore", "--plan", &name, "--json", &name]).expect_code(2).stderr;
    assert!(refused.contains("would be overwritten"), "{refused}");
    std::fs::write(&plan, text.replace("\"to\": 3", "\"to\": 4")).expect("written");
    let refused = run(["explore", "--plan", &name]).expect_code(2).stderr;
    assert!(refused.contains("plan.json: edge 2 names the node 4"), "{refused}");
}

#[test]
fn missions_and_planners_are_listed_and_unknown_ones_refused() {
    let listed = run(["explore", "--list"]).expect_code(0).stdout;
    assert!(listed.contains("look_alikes") && listed.contains("depth_first"), "{listed}");
    let refused = run(["explore", "lops"]).expect_code(2).stderr;
    assert!(refused.contains("did you mean loops?"), "{refused}");
    let refused = run(["explore", "tee", "--planner", "depth-first"]).expect_code(2).stderr;
    assert!(refused.contains("did you mean depth_first?"), "{refused}");
    let refused = run(["explore"]).expect_code(2).stderr;
    assert!(refused.contains("--list"), "{refused}");
    for several in [["tee", "--seed=1..2"], ["all", "--seed=1"]] {
        let refused = run(["explore", several[0], several[1], "--journal", "nowhere.mcap"]).expect_code(2).stderr;
        assert!(refused.contains("--journal is for one mission"), "{refused}");
    }
}

#[test]
fn several_missions_are_a_table() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let json = folder.path().join("missions.json");
    let args = ["explore", "tee", "--seed", "1..2", "--json"].map(std::ffi::OsStr::new);
    let ran = run(args.into_iter().chain([json.as_os_str()])).expect_code(0);
    let value: Value = serde_json::from_slice(&std::fs::read(&json).expect("written")).expect("a list");
    assert_eq!(value.as_array().map(Vec::len), Some(2));
    assert!(ran.stdout.contains("success %") && ran.stdout.contains("tee"), "{}", ran.stdout);
    assert_eq!(ran.stderr, "");
}

#[cfg(feature = "rerun")]
#[test]
fn a_mission_is_recorded_for_the_viewer() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let saved = folder.path().join("mission.rrd").display().to_string();
    run(["explore", "tee", "--seed", "3", "--save", &saved]).expect_code(0);
    let size = std::fs::metadata(&saved).expect("written").len();
    assert!((100_000..20_000_000).contains(&size), "{size} bytes");
    let rows_of = |saved: &str, entity: &str| -> Option<usize> {
        let listed = run(["rrd", "ls", saved]).expect_code(0).stdout;
        let line = listed.lines().find(|line| line.trim_start().starts_with(&format!("{entity} ")))?;
        line.split_whitespace().nth(1)?.parse().ok()
    };
    let revolutions = rows_of(&saved, "/mission/walls").expect("the mission");
    assert_eq!(rows_of(&saved, "/truth/json"), Some(revolutions), "the truth of each revolution");
    for stage in ["/affinity/W", "/spectral/eigenvalues", "/spectral/U", "/kmeans/labels", "/report/why"] {
        assert_eq!(rows_of(&saved, stage), Some(revolutions), "a mission can be asked why: {stage}");
    }
    let light = folder.path().join("light.rrd").display().to_string();
    let thinned = ["--set", "recording.detail=light", "--set", "recording.revolutions=[[20, 29]]", "--quiet"];
    run([&["explore", "tee", "--seed", "3", "--save", &light][..], &thinned].concat()).expect_code(0);
    let rows = ["/affinity/W", "/report/why", "/mission/walls"].map(|entity| rows_of(&light, entity));
    assert_eq!(rows, [None, Some(10), Some(revolutions)], "the mission is whole, the stages are not");
    let refused = run(["explore", "tee", "--save", &saved, "--json", &saved]).expect_code(2).stderr;
    assert!(refused.contains("would be overwritten"), "{refused}");
}

#[test]
fn a_killed_mission_is_resumed_from_its_journal() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let whole = path("whole.mcap");
    let (json, _) = outcome(&["tee", "--seed", "3", "--quiet", "--journal", &whole]);
    let whole_json: Value = serde_json::from_str(&json).expect("one JSON object");

    // Killed after a third of the flight, as its growing journal tells.
    let journal = path("killed.mcap");
    let mission = ["explore", "tee", "--seed", "3", "--quiet", "--journal", &journal];
    let mut child = crosscut(mission).spawn().expect("the program starts");
    let size = |path: &str| std::fs::metadata(path).map_or(0, |file| file.len());
    let third = size(&whole) / 3;
    while size(&journal) < third {
        assert!(child.try_wait().expect("a child").is_none(), "it ended before it was killed");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    child.kill().expect("it was running");
    child.wait().expect("it is gone");

    let (json, _) = outcome(&["tee", "--seed", "3", "--quiet", "--resume", &journal, "--journal", &path("rest.mcap")]);
    let resumed: Value = serde_json::from_str(&json).expect("one JSON object");
    assert_eq!((&resumed["ways_visited"], &resumed["home"]), (&Value::from(3), &Value::from(true)), "{json}");
    // Each journal is a flight as any other; that of the resumed mission has its past, too.
    let revolutions = |json: &Value| json["revolutions"].as_u64().expect("a count");
    let recorded = |name: &str| results_of(Path::new(&path(name)), &["--quiet"]).1.len() as u64;
    let known = recorded("killed.mcap");
    assert!((30..revolutions(&whole_json)).contains(&known), "{known} revolutions were known");
    assert_eq!(recorded("rest.mcap"), revolutions(&resumed), "{known} of them were known");
    assert!(revolutions(&resumed) > known);

    let resume = |other: &[&str], code: i32| {
        run([&["explore"], other, &["--resume", &journal]].concat()).expect_code(code).stderr
    };
    for (other, words) in [
        (&["loops", "--seed", "3"][..], "its mission is tee, not loops"),
        (&["tee", "--seed", "4"][..], "its seed is 3, not 4"),
        (&["tee", "--seed", "3", "--planner", "depth_first"][..], "its planner is nearest_frontier, not depth_first"),
        (&["tee", "--seed", "3", "--set", "flight.look_widths=1.6"][..], "its flight.look_widths is 1.5, not 1.6"),
        (&["tee", "--seed", "3", "--set", "vehicle.width_m=0.7"][..], "its vehicle.width_m is 0.6, not 0.7"),
    ] {
        let refused = resume(other, 2);
        assert!(refused.contains(words), "{refused}");
    }
    let flight = path("flight.mcap");
    run(["simulate", "tee", "--out", &flight]).expect_code(0);
    let refused = run(["explore", "tee", "--resume", &flight]).expect_code(2).stderr;
    assert!(refused.contains("does not state its mission"), "{refused}");

    let refused = run(["explore", "tee", "--resume", &journal, "--journal", &journal]).expect_code(2).stderr;
    assert!(refused.contains("would be overwritten"), "{refused}");
    let refused = run(["explore", "tee", "--resume", &path("none.mcap")]).expect_code(1).stderr;
    assert!(refused.contains("none.mcap"), "{refused}");
}

/// A journal whose first chunk holds one record, which states this length.
fn forged(journal: &[u8], length: u64) -> Vec<u8> {
    let mut at = mcap::MAGIC.len();
    while journal[at] != mcap::records::op::CHUNK {
        let length = u64::from_le_bytes(journal[at + 1..at + 9].try_into().expect("8 bytes"));
        at += 9 + usize::try_from(length).expect("small");
    }
    let records = [&[mcap::records::op::MESSAGE][..], &length.to_le_bytes(), &[0; 100]].concat();
    let compressed = zstd::encode_all(&records[..], 1).expect("in memory");
    let header = [&[0; 16][..], &(records.len() as u64).to_le_bytes(), &[0; 4], &4u32.to_le_bytes(), b"zstd"].concat();
    let body = [&header[..], &(compressed.len() as u64).to_le_bytes(), &compressed].concat();
    let chunk = [&[mcap::records::op::CHUNK][..], &(body.len() as u64).to_le_bytes(), &body].concat();
    [&journal[..at], &chunk].concat()
}

#[test]
fn a_forged_length_in_a_journal_is_refused_in_words() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [plan, journal] = ["plan.json", "journal.mcap"].map(|name| folder.path().join(name));
    let text = r#"{"nodes": [{"id": 0, "x_m": 0, "y_m": 0}, {"id": 1, "x_m": 8, "y_m": 0}],
        "edges": [{"from": 0, "to": 1, "width_m": 3.5}]}"#;
    std::fs::write(&plan, text).expect("written");
    let explore = |option: &str| {
        let words = ["explore", "--quiet", "--plan"].map(Path::new);
        run(words.into_iter().chain([plan.as_path(), Path::new(option), journal.as_path()]))
    };
    explore("--journal").expect_code(0);
    let written = std::fs::read(&journal).expect("written");
    for length in [1 << 46, 1 << 63] {
        std::fs::write(&journal, forged(&written, length)).expect("written");
        let said = explore("--resume").expect_code(1).stderr;
        assert!(said.starts_with("error: ") && !said.contains("panicked"), "{said}");
    }
}

//! `crosscut explore`.

use serde_json::Value;

use crate::program::run;

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
}

#[test]
fn several_missions_are_a_table() {
    let (json, said) = outcome(&["tee", "--seed", "1", "--count", "2"]);
    let value: Value = serde_json::from_str(&json).expect("a list");
    assert_eq!(value.as_array().map(Vec::len), Some(2));
    assert!(said.contains("success %") && said.contains("tee"), "{said}");
}

#[cfg(feature = "rerun")]
#[test]
fn a_mission_is_recorded_for_the_viewer() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let saved = folder.path().join("mission.rrd").display().to_string();
    run(["explore", "tee", "--seed", "3", "--save", &saved]).expect_code(0);
    let size = std::fs::metadata(&saved).expect("written").len();
    assert!((100_000..20_000_000).contains(&size), "{size} bytes");
    let refused = run(["explore", "tee", "--save", &saved, "--json", &saved]).expect_code(2).stderr;
    assert!(refused.contains("would be overwritten"), "{refused}");
}

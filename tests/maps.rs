//! `crosscut run --map`: the map of the shipped flight, which passes one junction, in every format.

use std::path::Path;

use serde_json::Value;

use crate::program::{Ran, run, shipped_flight};

fn map(out: &Path) -> Ran {
    run([Path::new("run"), &shipped_flight(), Path::new("--map"), out])
}

#[test]
fn the_map_has_the_fields_of_the_contract() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("tee.json");
    let ran = map(&out).expect_code(0);
    assert_eq!(ran.stderr, "1 junction: 1 tee; 0 dead ends; 0 loops; 1 way not taken\n");
    assert_eq!(ran.stdout, "", "the map alone has no tables");
    let map: Value = serde_json::from_slice(&std::fs::read(&out).expect("written")).expect("JSON");
    let node = &map["nodes"][0];
    assert_eq!((node["id"].as_u64(), node["kind"].as_str()), (Some(0), Some("junction")));
    assert!(node["x_m"].is_number() && node["y_m"].is_number() && node["visits"][0][1].is_u64());
    let ways = node["ways"].as_array().expect("ways");
    let has_fields =
        |way: &Value| way["bearing_rad"].is_number() && way["width_m"].is_number() && way["edge"].is_null();
    assert!(ways.len() == 3 && ways.iter().all(has_fields), "{ways:?}");
    assert!(map["edges"].as_array().is_some_and(Vec::is_empty) && map["merges"].as_array().is_some_and(Vec::is_empty));
    let again = folder.path().join("run.json");
    let results = folder.path().join("run.jsonl");
    let both = [Path::new("run"), &shipped_flight(), Path::new("--map"), &again, Path::new("-o"), &results];
    let ran = run(both).expect_code(0);
    assert!(ran.stderr.contains("\n1 junction: 1 tee; ") && ran.stdout.contains("median ms"), "{}", ran.stderr);
    assert_eq!(std::fs::read(&again).expect("written"), std::fs::read(&out).expect("written"));
}

#[test]
fn every_format_of_a_map_is_written_and_others_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, start) in
        [("tee.svg", "<svg "), ("TEE.SVG", "<svg "), ("tee.geojson", "{\"features\":"), ("tee.g2o", "VERTEX_SE2 0 ")]
    {
        let out = folder.path().join(name);
        map(&out).expect_code(0);
        let text = std::fs::read_to_string(&out).expect("written");
        assert!(text.starts_with(start), "{name}: {text:.80}");
    }
    let refused = map(&folder.path().join("tee.png")).expect_code(2).stderr;
    assert!(refused.contains("the name of a map ends in one of .json, .svg"), "{refused}");
    map(&folder.path().join("missing/tee.svg")).expect_code(1);
}

#[test]
fn an_empty_map_of_a_limited_view_says_why() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scenes = folder.path();
    run([Path::new("simulate"), Path::new("--suite"), Path::new("view180"), Path::new("--out"), scenes]).expect_code(0);
    let recording = scenes.join("view180.mcap");
    let out = scenes.join("map.json");
    let args = [Path::new("run"), &recording, Path::new("--every"), Path::new("50"), Path::new("--map"), &out];
    let said = run(args).expect_code(0).stderr;
    assert!(said.contains("A place is known once the scans have seen all around it"), "{said}");
}

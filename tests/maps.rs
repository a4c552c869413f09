//! `crosscut run --map`: the map of the shipped flight, which passes one junction, in every format.

use std::path::Path;

use serde_json::Value;

use crate::program::{Ran, root, run, shipped_flight};

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
    let args = [Path::new("run"), &recording, Path::new("--to"), Path::new("0.3"), Path::new("--map"), &out];
    let said = run(args).expect_code(0).stderr;
    assert!(said.contains("A place is known once the scans have seen all around it"), "{said}");
}

/// First and last second of each visit to a place, since the first scan.
fn visits_s(node: &Value) -> impl Iterator<Item = [f64; 2]> {
    let visits = node["visits"].as_array().into_iter().flatten();
    let since_s = |ns: &Value| (ns.as_u64().expect("a stamp") - 1_700_000_000_000_000_000) as f64 * 1e-9;
    visits.map(move |visit| [since_s(&visit[0]), since_s(&visit[1])])
}

#[test]
fn the_map_of_real_corridors_keeps_the_junctions_that_are_passed() {
    let data = root().join("../shared/data/gdc2");
    let Ok(truth) = std::fs::read(data.join("gdc2.map.json")) else {
        println!("skipped: {} is absent", data.display());
        return;
    };
    let truth: Value = serde_json::from_slice(&truth).expect("JSON");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("gdc2.json");
    run([Path::new("run"), &data.join("gdc2.mcap"), Path::new("--map"), &out]).expect_code(0);
    let map: Value = serde_json::from_slice(&std::fs::read(&out).expect("written")).expect("JSON");
    let nodes = map["nodes"].as_array().expect("nodes");
    let junctions: Vec<&Value> = nodes.iter().filter(|node| node["kind"] == "junction").collect();
    let passed: Vec<(&Value, [f64; 2])> = truth["visits"]
        .as_array()
        .expect("visits")
        .iter()
        .map(|visit| {
            let of = &truth["nodes"][visit["node"].as_u64().expect("a node") as usize];
            (of, ["t_enter", "t_leave"].map(|at| visit[at].as_f64().expect("seconds")))
        })
        .filter(|(of, _)| of["kind"] == "junction")
        .collect();
    let meet = |[from, to]: [f64; 2], [begin, end]: [f64; 2]| from <= end + 1.0 && begin <= to + 1.0;
    let ways = |node: &Value| node["ways"].as_array().map(|ways| ways.len() as u64);
    let is_kept = |(of, at): &&(&Value, [f64; 2])| {
        let is_at = |node: &&&Value| visits_s(node).any(|visit| meet(visit, *at));
        junctions.iter().filter(is_at).any(|node| ways(node) == of["degree"].as_u64())
    };
    let kept = passed.iter().filter(is_kept).count();
    assert!(passed.len() == 10 && kept >= 9, "{kept} of {} with the right number of ways", passed.len());
    let is_false = |node: &&&Value| !visits_s(node).any(|visit| passed.iter().any(|(_, at)| meet(visit, *at)));
    let added: Vec<_> = junctions.iter().filter(is_false).collect();
    assert!(added.len() <= 2, "in 164 m: {added:?}");
}

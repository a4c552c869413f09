//! The published share of right answers, on a sample of the scenes that it was published for.
//!
//! The other published share, on places of another generator, is checked by `tests/foreign/run elsewhere`.

use crosscut_simulator::{Split, suites, write_mcap};
use serde_json::Value;

use crate::program::{root, run};

/// The sample may be this far below the published share, in %.
const SLACK_PERCENT: f64 = 2.0;
/// Every 40th of the 600 scenes of each of the 14 families, as neighbouring scenes of a flight are alike.
const STEP: usize = 40;

#[test]
fn default_is_right_on_report_scenes_as_published() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for suite in suites() {
        let scenes = suite.scenes(Split::Report).step_by(STEP);
        write_mcap(&folder.path().join(format!("{}.mcap", suite.name)), scenes).expect("written");
    }
    let input = folder.path().to_str().expect("UTF-8");
    let ran = run(["compare", input, "--quiet", "--json", "-"]).expect_code(0);
    let figures: Value = serde_json::from_str(&ran.stdout).expect("JSON");
    let right = &figures["all"][0]["figures"]["right"];
    assert!(right["of"].as_u64() >= Some(200), "{right}");
    let percent = 100.0 * right["share"].as_f64().expect("a share");
    assert!(percent >= published_percent() - SLACK_PERCENT, "{percent:.1} %, published {} %", published_percent());
}

/// Share of all report scenes that preset `default` answers right, in %.
fn published_percent() -> f64 {
    let text = std::fs::read_to_string(root().join("docs/results.json")).expect("the published figures");
    let published: Value = serde_json::from_str(&text).expect("JSON");
    published["simulated"]["right"]["all"]["default"].as_f64().expect("a number")
}

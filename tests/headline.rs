//! The published share of right answers, on a sample of the scenes that it was published for.
//!
//! The other published share, on places of another generator, is checked by `tests/foreign/run elsewhere`.

use crosscut_simulator::{Split, suites, write_mcap};
use serde_json::Value;

use crate::program::run;

/// Share of the report scenes that preset `default` answers right, by the README.
const PUBLISHED_RIGHT: f64 = 0.963;
/// A change may cost at most two points.
const FLOOR: f64 = PUBLISHED_RIGHT - 0.02;
/// Scenes of each of the 14 families.
const SCENES: usize = 15;

#[test]
fn default_is_right_on_report_scenes_as_published() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for suite in suites() {
        // Neighbouring scenes of a flight are alike.
        let step = if suite.name.starts_with("flight") { 10 } else { 1 };
        let scenes = suite.scenes(Split::Report).step_by(step).take(SCENES);
        write_mcap(&folder.path().join(format!("{}.mcap", suite.name)), scenes).expect("written");
    }
    let input = folder.path().to_str().expect("UTF-8");
    let ran = run(["evaluate", input, "--quiet", "--json", "-"]).expect_code(0);
    let figures: Value = serde_json::from_str(&ran.stdout).expect("JSON");
    let right = &figures["all"][0]["figures"]["right"];
    assert!(right["of"].as_u64() >= Some(200), "{right}");
    assert!(right["share"].as_f64() >= Some(FLOOR), "{right}, at least {FLOOR}");
}

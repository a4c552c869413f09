//! The command line with an affinity of one's own.

use std::process::Command;

#[test]
fn the_affinity_is_chosen_by_its_name_and_answers_every_scan() {
    let flight = concat!(env!("CARGO_MANIFEST_DIR"), "/../../recordings/tee.mcap");
    let output = Command::new(env!("CARGO_BIN_EXE_own_affinity"))
        .args(["run", flight, "--every", "20", "--out", "-", "--quiet"])
        .args(["--preset", "paper", "--set", "affinity.kind=quartic", "--set", "affinity.scale_m=0.4"])
        .output()
        .expect("it starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let answers = String::from_utf8(output.stdout).expect("JSON");
    assert_eq!(answers.lines().count(), 8, "{errors}");
    assert!(answers.lines().all(|line| line.contains("\"junctions\":")), "{answers}");
}

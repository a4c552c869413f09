//! `crosscut simulate`.

use crate::program::{root, run};

#[test]
fn the_shipped_flight_is_what_its_command_makes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let made = folder.path().join("tee.mcap");
    run(["simulate".as_ref(), "tee".as_ref(), "--out".as_ref(), made.as_os_str()]).expect_code(0);
    let same =
        std::fs::read(&made).expect("made") == std::fs::read(root().join("recordings/tee.mcap")).expect("shipped");
    assert!(same, "recordings/tee.mcap is not what `crosscut simulate tee` makes now; see recordings/README.md");
}

#[test]
fn another_seed_is_another_flight() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let fly = |seed: &str| {
        let made = folder.path().join(seed);
        let args = ["simulate".as_ref(), "tee".as_ref(), "--seed".as_ref(), seed.as_ref(), "--out".as_ref()];
        run(args.into_iter().chain([made.as_os_str()])).expect_code(0);
        std::fs::read(made).expect("made")
    };
    assert!(fly("2") != fly("3"));
}

#[test]
fn scenarios_are_listed_and_an_unknown_one_is_refused() {
    let listed = run(["simulate", "--list"]).expect_code(0).stdout;
    assert!(listed.contains("tee"), "{listed}");
    let ran = run(["simulate", "teee", "--out", "/dev/null"]).expect_code(2);
    assert!(ran.stderr.contains("tee"), "{}", ran.stderr);
}

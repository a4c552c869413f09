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

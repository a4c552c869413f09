//! Tests on real recordings, which are not part of the repository. A test without its files is skipped, and the last
//! lines of the output name it.
//!
//! libtest can skip a test only at compile time, so this binary has a main of its own. Arguments without a dash select
//! tests whose names contain one of them.

mod corridors;
mod lines;
#[allow(dead_code)] // the tests of the whole program use the rest of it
#[path = "../program.rs"]
mod program;

use std::panic::catch_unwind;
use std::path::PathBuf;
use std::process::ExitCode;

/// The recordings of corridors, with their numbers of scans.
const CORRIDORS: [(&str, usize); 4] = [
    ("corridor_cross.mcap", 688),
    ("corridor_threeway.mcap", 233),
    ("corridor_dead.mcap", 285),
    ("corridor_left.mcap", 112),
];

/// Scans of [`CORRIDORS`] whose walls a person has counted.
const LABELS: &str = "labels.csv";

struct Test {
    name: &'static str,
    needs_labels: bool,
    run: fn(),
}

const TESTS: [Test; 4] = [
    Test {
        name: "labelled_scans_of_corridors_are_counted_as_a_person_does",
        needs_labels: true,
        run: corridors::labelled_scans_are_counted_as_a_person_does,
    },
    Test { name: "counts_along_corridors_rarely_flicker", needs_labels: false, run: corridors::counts_rarely_flicker },
    Test { name: "slicing_and_faer_agree_on_corridors", needs_labels: false, run: corridors::slicing_and_faer_agree },
    Test { name: "every_line_of_corridors_is_consistent", needs_labels: false, run: lines::every_line_is_consistent },
];

/// A file of real data.
fn data(name: &str) -> PathBuf {
    program::root().join("../shared/data").join(name)
}

impl Test {
    /// The first file that the test needs and that is absent.
    fn missing_file(&self) -> Option<PathBuf> {
        let labels = self.needs_labels.then_some(LABELS);
        let needed = CORRIDORS.iter().map(|(name, _)| *name).chain(labels);
        needed.map(data).find(|path| !path.is_file())
    }
}

fn main() -> ExitCode {
    let filters: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let is_selected = |test: &&Test| filters.is_empty() || filters.iter().any(|filter| test.name.contains(filter));
    let (mut passed, mut failed, mut skipped) = (0, 0, Vec::new());
    for test in TESTS.iter().filter(is_selected) {
        let outcome = match test.missing_file() {
            Some(missing) => {
                skipped.push(format!("skipped: {} (there is no {})", test.name, missing.display()));
                "skipped"
            }
            None if catch_unwind(test.run).is_ok() => {
                passed += 1;
                "ok"
            }
            None => {
                failed += 1;
                "FAILED"
            }
        };
        println!("test {} ... {outcome}", test.name);
    }
    println!("\ntest result: {passed} passed; {failed} failed; {} skipped", skipped.len());
    skipped.iter().for_each(|line| println!("{line}"));
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

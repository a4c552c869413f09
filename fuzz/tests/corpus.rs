//! Every target on its seeds, whole, cut and altered, and on what fuzzing found.

use std::path::Path;

use crosscut_fuzz::{TARGETS, seeds};

/// How often a seed is altered.
const ALTERED: usize = 150;

#[test]
fn every_target_has_seeds() {
    for (target, _) in TARGETS {
        assert!(!seeds::of(target).is_empty(), "{target}");
    }
}

#[test]
fn seeds_cut_or_altered_never_panic() {
    for (target, run) in TARGETS {
        for seed in seeds::of(target) {
            run(&seed);
            let step = seed.len().div_ceil(ALTERED);
            for at in (0..seed.len()).step_by(step) {
                run(&seed[..at]);
                for value in [seed[at] ^ 1, 0xff] {
                    let mut altered = seed.clone();
                    altered[at] = value;
                    run(&altered);
                }
            }
        }
    }
}

#[test]
fn findings_stay_mended() {
    for (target, run) in TARGETS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("findings").join(target);
        for entry in std::fs::read_dir(folder).into_iter().flatten() {
            let path = entry.expect("an entry of a folder").path();
            println!("{}", path.display());
            run(&std::fs::read(&path).expect("a finding"));
        }
    }
}

//! Writes the seeds into `corpus/TARGET/` of the folder given: `cargo run --no-default-features --bin seeds -- fuzz`.

use std::path::PathBuf;

use crosscut_fuzz::{TARGETS, seeds};

fn main() -> std::io::Result<()> {
    let folder = PathBuf::from(std::env::args_os().nth(1).unwrap_or_else(|| "fuzz".into()));
    for (target, _) in TARGETS {
        let corpus = folder.join("corpus").join(target);
        std::fs::create_dir_all(&corpus)?;
        for (i, seed) in seeds::of(target).iter().enumerate() {
            std::fs::write(corpus.join(format!("seed_{i}")), seed)?;
        }
    }
    Ok(())
}

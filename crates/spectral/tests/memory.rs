//! What a solver allocates against what it claims. A process of its own, as other tests allocate too.

use std::fs;

use crosscut_spectral::KINDS;
use crosscut_stage::{Affinity, Notes, SpectralStage, Spectrum};

/// Allocations are rounded up to pages, and the allocator has some of its own.
const SLACK_BYTES: u64 = 1 << 20;

/// A line of `/proc/self/status` in bytes; `None` where there is no such file.
fn status_bytes(name: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
    Some(line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()? << 10)
}

/// By how much a run of `stage` raises the memory of this process, beyond its result; `None` where that is not known.
fn growth_bytes(stage: &mut dyn SpectralStage, affinity: &Affinity) -> Option<u64> {
    let mut out = Spectrum::default();
    fs::write("/proc/self/clear_refs", "5").ok()?; // the peak starts anew
    let before = status_bytes("VmRSS")?;
    stage.spectrum(affinity, &mut out, &mut Notes::default()).expect("a sound affinity");
    let entries = (0..out.u.nrows()).map(|i| out.u.row(i).count() as u64).sum::<u64>();
    Some(status_bytes("VmHWM")?.saturating_sub(before + 16 * entries))
}

/// Rows of returns, each with edges to the two next ones on either side.
fn rows(returns: usize, n: usize) -> Affinity {
    let mut affinity = Affinity::default();
    let w = affinity.weights.make_sparse();
    for i in 0..n {
        let (first, end) = (i / returns * returns, ((i / returns + 1) * returns).min(n));
        let row = i.saturating_sub(2).max(first)..(i + 3).min(end);
        affinity.degrees.push(row.len() as f64);
        row.for_each(|j| w.push(j as u32, 1.0));
        w.end_row();
    }
    affinity
}

fn dense(sparse: &Affinity) -> Affinity {
    let mut affinity = Affinity { degrees: sparse.degrees.clone(), ..Affinity::default() };
    let w = affinity.weights.make_dense(sparse.degrees.len());
    w.fill(0.0);
    sparse.weights.for_each(|i, j, weight| w[(i, j)] = weight);
    affinity
}

#[test]
fn no_solver_allocates_more_than_it_claims() {
    // Stages live to the end, so that none takes memory that another one gave back.
    let mut stages = Vec::new();
    for kind in KINDS {
        let mut graphs = vec![("dense", dense(&rows(300, 1500)))];
        if kind.properties.stays_sparse {
            graphs.push(("sparse", rows(5000, 200_000)));
        }
        for (name, affinity) in graphs {
            let mut stage = kind.with(&[]).expect("the defaults");
            let n = affinity.degrees.len();
            let claimed = stage.memory_bytes(n, affinity.weights.stored());
            let Some(grown) = growth_bytes(stage.as_mut(), &affinity) else {
                println!("skipped: this system does not tell the memory of a process");
                return;
            };
            println!("{} {name}: {grown} bytes of {claimed}", kind.name);
            assert!(grown <= claimed + SLACK_BYTES, "{} {name}: {grown} bytes, claimed {claimed}", kind.name);
            stages.push(stage);
        }
    }
}

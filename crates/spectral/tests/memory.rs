//! What a solver allocates against what it states. Each is measured in a process of its own: memory that another solver or a
//! test gave back is taken again unseen.

use std::process::Command;
use std::{env, fs};

use crosscut_spectral::{KINDS, MOST_MATRICES};
use crosscut_stage::{Affinity, Notes, SpectralStage, Spectrum};

/// Allocations are rounded up to pages, and the allocator has some of its own.
const SLACK_BYTES: u64 = 1 << 20;
/// What a solver takes a return that states to stay sparse: buffers of a few numbers, and the edges.
const BYTES_PER_RETURN: u64 = 1024;

/// Names the case in the process that measures it, and marks the line that it prints.
const CASE: &str = "CROSSCUT_MEMORY_CASE";
const MEASURED: &str = "measured: ";

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
    let entries = (out.u.nrows() * out.u.ncols()) as u64;
    Some(status_bytes("VmHWM")?.saturating_sub(before + 8 * entries))
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

/// The graph of a case: all solvers take dense W, and those for which it stays sparse take more returns.
fn graph(name: &str) -> Affinity {
    if name == "sparse" { rows(5000, 400_000) } else { dense(&rows(300, 1500)) }
}

/// Measures the case that the process was started for, and prints it.
#[test]
fn one_solver_in_a_process_of_its_own() {
    let Ok(case) = env::var(CASE) else { return };
    let (kind, name) = case.split_once(' ').expect("a kind and a graph");
    let kind = KINDS.iter().find(|known| known.name == kind).expect("a kind");
    let affinity = graph(name);
    let mut stage = kind.with(&[]).expect("the defaults");
    let n = affinity.degrees.len() as u64;
    let claimed = if kind.properties.stays_sparse { BYTES_PER_RETURN * n } else { MOST_MATRICES * 8 * n * n };
    if let Some(grown) = growth_bytes(stage.as_mut(), &affinity) {
        println!("{MEASURED}{grown} {claimed}");
    }
}

/// What a process of its own measured: growth and claim; `None` where the system does not tell.
fn measured(case: &str) -> Option<(u64, u64)> {
    let test = ["--exact", "one_solver_in_a_process_of_its_own", "--nocapture"];
    let output = Command::new(env::current_exe().expect("this test")).args(test).env(CASE, case).output();
    let output = output.expect("a process");
    assert!(output.status.success(), "{case}: {}", String::from_utf8_lossy(&output.stdout));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let (_, numbers) = text.lines().find_map(|line| line.split_once(MEASURED))?;
    let (grown, claimed) = numbers.split_once(' ')?;
    Some((grown.parse().ok()?, claimed.parse().ok()?))
}

#[test]
fn no_solver_allocates_more_than_it_claims() {
    for kind in KINDS {
        let name = if kind.properties.stays_sparse { "sparse" } else { "dense" };
        let Some((grown, claimed)) = measured(&format!("{} {name}", kind.name)) else {
            println!("skipped: this system does not tell the memory of a process");
            return;
        };
        println!("{} {name}: {grown} bytes of {claimed}", kind.name);
        assert!(grown <= claimed + SLACK_BYTES, "{} {name}: {grown} bytes, claimed {claimed}", kind.name);
        assert!(claimed >= 4 * SLACK_BYTES, "{} {name}: the graph is too small to tell", kind.name);
    }
}

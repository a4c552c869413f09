//! How long one revolution takes, step by step, in the calling thread, without input and output.
//!
//! `cargo bench -p crosscut-detector --bench revolution` takes the development scenes of every family; `... --
//! [METHOD...] [FLIGHT.mcap...]` takes some of the methods, or recordings instead. One line per family or recording and
//! method, columns parted by commas: medians over the revolutions, of each the least of several passes, as another
//! program's turn only ever adds. The methods take turns, so that what else the machine does hits all of them alike.

mod scans;

use crosscut_detector::{Config, Engine, Layer, Preset, Registry};
use crosscut_stage::{Frame, Revolution, Step};
use scans::{Fallible, Scans, median};

/// Revolutions of each family or recording.
const REVOLUTIONS: usize = 100;
const PASSES: usize = 7;
/// Name, preset, and settings on top of it. `floor` is the default with its eigenvalues left out, `faer` the
/// paper with the full decomposition.
const METHODS: &[(&str, &str, &[&str])] = &[
    ("default", "default", &[]),
    ("floor", "default", &["spectral.kind=components"]),
    ("paper", "paper", &[]),
    ("faer", "paper", &["spectral.kind=faer"]),
];
const STEPS: [Step; 4] = [Step::Affinity, Step::Spectral, Step::Kmeans, Step::Report];

fn main() -> Fallible<()> {
    let registry = Registry::standard();
    // The first argument of a bench is `--bench`.
    let args: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with("--")).collect();
    let (names, recordings): (Vec<_>, Vec<_>) =
        args.into_iter().partition(|arg| METHODS.iter().any(|(method, ..)| method == arg));
    let methods: Vec<_> =
        METHODS.iter().filter(|(method, ..)| names.is_empty() || names.iter().any(|name| name == method)).collect();
    let configs = methods.iter().map(|(_, preset, settings)| {
        let settings: Vec<String> = settings.iter().map(ToString::to_string).collect();
        Config::resolve(&registry, &[Preset::named(preset)?.into(), Layer::settings("--set", &settings)?])
    });
    let mut engines: Vec<Engine> =
        configs.map(|config| config.map(|config| Engine::new(&config, &registry))).collect::<Result<_, _>>()?;

    print!("{:<16},{:>10},{:>12},{:>8}", "scans", "method", "revolutions", "returns");
    println!("{}", STEPS.map(|step| format!(",{:>12}", format!("{step}_us"))).concat() + ",    total_us");
    for Scans { name, revolutions } in scans::of(&recordings, REVOLUTIONS)? {
        let times_ns = time(&mut engines, &revolutions)?;
        let mut returns: Vec<usize> = revolutions.iter().map(Revolution::len).collect();
        for ((method, ..), times_ns) in methods.iter().zip(times_ns) {
            print!("{name:<16},{method:>10},{:>12},{:>8}", revolutions.len(), median(&mut returns));
            let columns = (0..=STEPS.len()).map(|step| {
                let mut column: Vec<u64> = times_ns.iter().map(|row| row[step]).collect();
                format!(",{:>12.1}", median(&mut column) as f64 / 1e3)
            });
            println!("{}", columns.collect::<String>());
        }
    }
    Ok(())
}

/// For each engine and revolution, the nanoseconds of each of [`STEPS`] and their sum, the least of the passes.
fn time(
    engines: &mut [Engine],
    revolutions: &[Revolution],
) -> Result<Vec<Vec<[u64; STEPS.len() + 1]>>, crosscut_stage::Failure> {
    let mut least = vec![vec![[u64::MAX; STEPS.len() + 1]; revolutions.len()]; engines.len()];
    let mut frame = Frame::default();
    for _ in 0..PASSES {
        for (engine, least) in engines.iter_mut().zip(&mut least) {
            for (least, revolution) in least.iter_mut().zip(revolutions) {
                frame.revolution.clone_from(revolution);
                engine.process(&mut frame)?;
                let times_ns = STEPS.map(|step| frame.timings.ns(step));
                let row = times_ns.into_iter().chain([times_ns.iter().sum()]);
                least.iter_mut().zip(row).for_each(|(least, ns)| *least = ns.min(*least));
            }
        }
    }
    Ok(least)
}

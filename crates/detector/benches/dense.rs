//! How much faster `slicing` is than faer's full decomposition, on the dense W of preset `paper`.
//!
//! `cargo bench -p crosscut-detector --bench dense` takes the development scenes of every family; `... --
//! FLIGHT.mcap...` recordings instead. One line per family or recording, columns parted by commas: medians over the
//! revolutions, times of each the least of several passes. The solvers take turns at every revolution, so that what
//! else the machine does hits all of them alike.

mod scans;

use std::time::Instant;

use crosscut_affinity::rbf;
use crosscut_spectral::{faer_evd, slicing};
use crosscut_stage::{Affinity, AffinityStage, Notes, Revolution, SpectralStage, Spectrum, StageError};
use scans::{Fallible, median};

/// Revolutions of each family or recording.
const REVOLUTIONS: usize = 60;
const PASSES: usize = 7;

fn main() -> Fallible<()> {
    let recordings: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with("--")).collect();
    let mut solvers: [Box<dyn SpectralStage>; 3] =
        [faer_evd::KIND.with(&[])?, slicing::KIND.with(&[])?, slicing::KIND.with(&[("eigenvalues", 16.into())])?];
    let mut rbf = rbf::KIND.with(&[])?;
    println!(
        "scans           , revolutions, returns,  faer_us, slicing_us, slicing16_us, ratio, ratio16, least, least16"
    );
    for scans in scans::of(&recordings, REVOLUTIONS)? {
        let mut rows = Vec::new();
        for revolution in &scans.revolutions {
            rows.push(times_ns(rbf.as_mut(), &mut solvers, revolution)?);
        }
        let mut returns: Vec<usize> = scans.revolutions.iter().map(Revolution::len).collect();
        let times_us =
            [0, 1, 2].map(|solver| median(&mut rows.iter().map(|row| row[solver]).collect::<Vec<_>>()) as f64 / 1e3);
        let ratios = [1, 2].map(|solver| {
            let mut hundredths: Vec<u64> = rows.iter().map(|row| 100 * row[0] / row[solver]).collect();
            let middle = median(&mut hundredths);
            [middle, hundredths[0]].map(|hundredths| hundredths as f64 / 100.0)
        });
        println!(
            "{:<16},{:>12},{:>8},{:>9.0},{:>11.0},{:>13.0},{:>6.1},{:>8.1},{:>6.1},{:>8.1}",
            scans.name,
            rows.len(),
            median(&mut returns),
            times_us[0],
            times_us[1],
            times_us[2],
            ratios[0][0],
            ratios[1][0],
            ratios[0][1],
            ratios[1][1]
        );
    }
    Ok(())
}

/// The least time of each solver over the passes, each of a W that was just made, and with what the pass before left in
/// the caches: as in the pipeline, which runs one solver only.
fn times_ns(
    rbf: &mut dyn AffinityStage,
    solvers: &mut [Box<dyn SpectralStage>; 3],
    revolution: &Revolution,
) -> Result<[u64; 3], StageError> {
    let mut least_ns = [u64::MAX; 3];
    let (mut affinity, mut out) = (Affinity::default(), Spectrum::default());
    for (solver, least_ns) in solvers.iter_mut().zip(&mut least_ns) {
        for _ in 0..PASSES {
            rbf.affinity(revolution, &mut affinity, &mut Notes::default())?;
            let start = Instant::now();
            solver.spectrum(&affinity, &mut out, &mut Notes::default())?;
            *least_ns = (*least_ns).min(start.elapsed().as_nanos() as u64);
        }
    }
    Ok(least_ns)
}

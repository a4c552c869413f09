//! `slicing` against `faer` on the paper's W of simulated scans, generated and read from a file.

use std::path::{Path, PathBuf};

use crosscut_affinity::rbf;
use crosscut_ingest::{ReadOptions, Recording};
use crosscut_sensor::Sensor;
use crosscut_simulator::{Split, suites};
use crosscut_spectral::{faer_evd, slicing};
use crosscut_stage::{Affinity, AffinityStage, Notes, Revolution, Source, SpectralStage, Spectrum};

/// That of preset `paper`.
const TOLERANCE: f64 = 1e-7;
/// At least this many eigenvalues are computed.
const EIGENVALUES: [u32; 2] = [1, 16];
/// One scan in this many is taken.
const SCENES_STEP: usize = 100;
const RECORDED_STEP: usize = 25;

/// The solvers, and what was compared.
struct Comparison {
    rbf: Box<dyn AffinityStage>,
    faer: Box<dyn SpectralStage>,
    slicing: [Box<dyn SpectralStage>; 2],
    compared: usize,
    /// Comparisons in which an eigenvalue is so near to τ that k depends on rounding.
    undecided: usize,
    in_full: usize,
}

impl Comparison {
    fn new() -> Self {
        let tolerance = ("zero_tolerance", TOLERANCE.into());
        let slicing = |eigenvalues: u32| {
            slicing::KIND.with(&[tolerance.clone(), ("eigenvalues", eigenvalues.into())]).expect("allowed")
        };
        Self {
            rbf: rbf::KIND.with(&[]).expect("the defaults are those of preset `paper`"),
            faer: faer_evd::KIND.with(std::slice::from_ref(&tolerance)).expect("allowed"),
            slicing: EIGENVALUES.map(slicing),
            compared: 0,
            undecided: 0,
            in_full: 0,
        }
    }

    fn compare(&mut self, revolution: &Revolution, name: &str) {
        let (mut affinity, mut all, mut found) = (Affinity::default(), Spectrum::default(), Spectrum::default());
        self.rbf.affinity(revolution, &mut affinity, &mut Notes::default()).expect("a sound scan");
        self.faer.spectrum(&affinity, &mut all, &mut Notes::default()).expect("a sound affinity");
        let rounding = 100.0 * revolution.len() as f64 * f64::EPSILON;
        for (slicing, eigenvalues) in self.slicing.iter_mut().zip(EIGENVALUES) {
            let mut notes = Notes::default();
            slicing.spectrum(&affinity, &mut found, &mut notes).expect("a sound affinity");
            self.in_full += notes.iter().len();
            self.compared += 1;
            let wanted = (eigenvalues as usize).max(found.k + 1).min(revolution.len());
            assert_eq!(found.eigenvalues.len(), wanted, "{name}");
            for (j, (ours, full)) in found.eigenvalues.iter().zip(&all.eigenvalues).enumerate() {
                let allowed = if j < all.k { rounding.min(1e-12) } else { 1e-12 };
                assert!((ours - full).abs() <= allowed, "{name}: λ_{j} = {ours} is {full}");
            }
            if all.eigenvalues.iter().any(|lambda| (lambda - TOLERANCE).abs() <= rounding) {
                self.undecided += 1;
                continue;
            }
            assert_eq!(found.k, all.k, "{name}");
            let gap = all.eigenvalues.get(all.k).map_or(2.0, |next| next - all.eigenvalues[all.k - 1]);
            let (u, v) = (&found.u, &all.u);
            let sines = (u - v * (v.transpose() * u)).norm_l2();
            assert!(sines <= rounding / gap, "{name}: the span is off by {sines}, allowed {}", rounding / gap);
        }
    }

    fn compare_recording(&mut self, path: PathBuf) {
        let name = path.display().to_string();
        let sensor = Sensor::default();
        let mut recording = Recording::open(&[path], &ReadOptions::default(), sensor).expect("a recording");
        let (mut revolution, mut number) = (Revolution::default(), 0);
        while recording.next(&mut revolution, &mut Notes::default()).expect("a recording") {
            if number % RECORDED_STEP == 0 && !revolution.is_empty() {
                self.compare(&revolution, &format!("{name}, scan {number}"));
            }
            number += 1;
        }
    }

    /// Whether nearly all scans were decided, and by the fast way.
    fn is_sound(&self) -> bool {
        100 * (self.undecided + self.in_full) < self.compared
    }

    fn print(&self, of: &str) {
        let Self { compared, undecided, in_full, .. } = self;
        println!("{of}: {compared} compared, {undecided} with an eigenvalue at τ, {in_full} parts in full");
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn zeros_span_and_k_of_simulated_scans_are_those_of_the_full_decomposition() {
    let sensor = Sensor::default();
    let mut comparison = Comparison::new();
    for suite in suites() {
        for (number, scene) in suite.scenes(Split::Dev).enumerate().step_by(SCENES_STEP) {
            let mut revolution = Revolution::default();
            sensor.revolution(&scene.scan, &mut revolution, &mut Notes::default());
            comparison.compare(&revolution, &format!("{} {number}", suite.name));
        }
    }
    comparison.compare_recording(root().join("recordings/tee.mcap"));
    comparison.print("simulated scans");
    assert!(comparison.compared > 150 && comparison.is_sound());
}

//! The door for a program of one's own.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crosscut_detector::{ConfigError, Detector, LaserScan, Preset, Registry};
use crosscut_stage::NoteCode::N101;
use crosscut_stage::{Affinity, AffinityStage, Notes, Revolution, StageError, Step};

/// Every return on its own, or an error for as many returns as are in `refused`; counts its scans.
struct Alone {
    scans: Arc<AtomicUsize>,
    refused: usize,
}

impl AffinityStage for Alone {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, notes: &mut Notes) -> Result<(), StageError> {
        self.scans.fetch_add(1, Ordering::Relaxed);
        if revolution.len() == self.refused {
            return Err(StageError::Unsupported("refused".to_owned()));
        }
        notes.add(N101, "each on its own");
        let w = out.weights.make_sparse();
        (0..revolution.len() as u32).for_each(|i| w.push_row(&[i], &[1.0]));
        Ok(())
    }
}

/// Returns 2 m away in all directions; a range of 0, which is noted, from the first beam.
fn scan(beams: usize) -> LaserScan {
    let mut ranges = vec![2.0; beams];
    ranges[0] = 0.0;
    let angle_increment = std::f32::consts::TAU / beams as f32;
    LaserScan { angle_increment, range_max: 30.0, ranges, ..LaserScan::default() }
}

#[test]
fn a_stage_given_as_a_value_keeps_its_state() {
    let scans = Arc::new(AtomicUsize::new(0));
    let own = Alone { scans: Arc::clone(&scans), refused: 9 };
    let builder = Detector::builder().preset(Preset::Paper).set("kmeans.kind", "components");
    let mut detector = builder.affinity(Box::new(own)).build().expect("known settings");
    assert_eq!(detector.detect(&scan(6)).expect("a scan").junctions, 5);
    let failure = detector.detect(&scan(10)).expect_err("9 returns are refused");
    assert_eq!((failure.step, failure.seq), (Step::Affinity, 1));
    assert_eq!(detector.detect(&scan(8)).expect("the next is as good as any").junctions, 7);
    assert_eq!(scans.load(Ordering::Relaxed), 3);
}

#[test]
fn notes_are_those_of_the_last_scan_alone() {
    let own = Alone { scans: Arc::default(), refused: 0 };
    let mut detector = Detector::builder().affinity(Box::new(own)).build().expect("the preset");
    for beams in [40, 60, 40] {
        detector.detect(&scan(beams)).expect("a scan");
        let frame = detector.frame();
        assert_eq!(frame.affinity.weights.n(), beams - 1);
        let own = frame.notes.iter().filter(|note| *note == "each on its own").count();
        let of_scan = frame.notes.iter().filter(|note| note.contains("range 0")).count();
        assert_eq!((own, of_scan), (1, 1), "{:?}", frame.notes);
        assert_eq!(frame.junction.confidence, None, "nothing was calibrated for it");
    }
}

#[test]
fn no_confidence_with_a_stage_of_ones_own_in_any_slot() {
    let registry = Registry::standard();
    let shipped = || Detector::builder().preset(Preset::Paper);
    let spectral = registry.spectral[0].with(&[]).expect("defaults");
    let kmeans = registry.kmeans[0].with(&[]).expect("defaults");
    let own = [shipped().spectral(spectral), shipped().kmeans(kmeans)];
    for (settings, is_calibrated) in [(shipped(), true)].into_iter().chain(own.map(|own| (own, false))) {
        let mut detector = settings.build().expect("the preset");
        detector.detect(&scan(60)).expect("a scan");
        assert_eq!(detector.frame().junction.confidence.is_some(), is_calibrated);
    }
}

#[test]
fn what_cannot_be_built_says_why() {
    let refused = |error: Option<ConfigError>| error.expect("refused");
    let missing = Detector::builder().config_file("no/such.toml").build().err();
    assert!(matches!(refused(missing), ConfigError::Unreadable { .. }));
    let unknown = Detector::builder().set("affinity.colour", 1.0).build().err();
    assert!(matches!(refused(unknown), ConfigError::UnknownKey { .. }));
}

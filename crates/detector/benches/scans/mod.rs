//! Revolutions to time: of the development scenes of every family, or of recordings.

use std::path::PathBuf;

use crosscut_ingest::{ReadOptions, Recording};
use crosscut_sensor::Sensor;
use crosscut_simulator::{Split, suites};
use crosscut_stage::{Notes, Revolution, Source};

pub(crate) type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// A family of scenes, or a recording.
pub(crate) struct Scans {
    pub(crate) name: String,
    pub(crate) revolutions: Vec<Revolution>,
}

/// Those of the recordings, or of all families if there are none: at most `most` of each, evenly spread.
pub(crate) fn of(recordings: &[String], most: usize) -> Fallible<Vec<Scans>> {
    let sensor = Sensor::default();
    if recordings.is_empty() {
        let revolution = |scan: &_| {
            let mut revolution = Revolution::default();
            sensor.revolution(scan, &mut revolution, &mut Notes::default());
            revolution
        };
        let of_suite = |suite: &crosscut_simulator::Suite| {
            let all = suite.scenes(Split::Dev).map(|scene| revolution(&scene.scan)).collect();
            Scans { name: suite.name.to_owned(), revolutions: spread(all, most) }
        };
        return Ok(suites().iter().map(of_suite).collect());
    }
    recordings
        .iter()
        .map(|path| {
            let path = PathBuf::from(path);
            let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
            let mut recording = Recording::open(&[path], &ReadOptions::default(), sensor.clone())?;
            let mut all = Vec::new();
            loop {
                let mut revolution = Revolution::default();
                if !recording.next(&mut revolution, &mut Notes::default())? {
                    return Ok(Scans { name, revolutions: spread(all, most) });
                }
                all.push(revolution);
            }
        })
        .collect()
}

fn spread(all: Vec<Revolution>, most: usize) -> Vec<Revolution> {
    let step = all.len().div_ceil(most).max(1);
    all.into_iter().step_by(step).collect()
}

pub(crate) fn median<T: Ord + Copy + Default>(values: &mut [T]) -> T {
    values.sort_unstable();
    values.get(values.len() / 2).copied().unwrap_or_default()
}

//! Recordings that are given together are the parts of one flight: those of different sensors are refused.

use std::path::{Path, PathBuf};

use crosscut_detector::Config;
use crosscut_ingest::{ReadOptions, ScanDescription, describe, parts_in};
use crosscut_sensor::Sensor;

use crate::exit::UsageError;
use crate::input::InputArgs;

/// Fields of view of one sensor differ by less than this.
const SAME_VIEW_DEG: f64 = 10.0;
/// Numbers of beams of one sensor differ by less than this factor.
const SAME_BEAMS: f64 = 1.2;

/// Refuses recordings that cannot be of one flight, unless `--join` asks for them.
///
/// # Errors
/// When the first scans of two files are of different frames, fields of view or numbers of beams; or when an input is not
/// there. Files that cannot be read are left to the reader.
pub(crate) fn refuse_unrelated(inputs: &[PathBuf], args: &InputArgs, config: &Config) -> anyhow::Result<()> {
    if args.join || inputs.iter().any(|input| input.as_os_str() == "-") {
        return Ok(());
    }
    let files = parts_in(inputs)?.files;
    if files.len() < 2 {
        return Ok(());
    }
    let (sensor, options) = (config.sensor(), args.read_options(config));
    let mut before: Option<(&Path, ScanDescription)> = None;
    for file in &files {
        let Some(scan) = first_scan(file, &sensor, &options) else { continue };
        if let Some((other, of_other)) = &before
            && !is_of_one_sensor(of_other, &scan)
        {
            return Err(UsageError(format!(
                "these are not parts of one flight: {} has {}, {} has {}; give each flight a command of its own, or --join to \
                 fly them as one",
                other.display(),
                words(of_other),
                file.display(),
                words(&scan)
            ))
            .into());
        }
        before.get_or_insert((file, scan));
    }
    Ok(())
}

fn first_scan(file: &Path, sensor: &Sensor, options: &ReadOptions) -> Option<ScanDescription> {
    let topics = describe(file, sensor, options).ok()?.topics.into_iter();
    let mut topics = topics.filter(|topic| options.topic.as_ref().is_none_or(|wanted| *wanted == topic.info.name));
    topics.find_map(|topic| topic.first_scan)
}

fn is_of_one_sensor(a: &ScanDescription, b: &ScanDescription) -> bool {
    let view_deg = |scan: &ScanDescription| if scan.full_turn { 360.0 } else { scan.field_of_view_rad.to_degrees() };
    let (fewer, more) = (a.beams.min(b.beams) as f64, a.beams.max(b.beams) as f64);
    a.frame_id == b.frame_id && (view_deg(a) - view_deg(b)).abs() < SAME_VIEW_DEG && more < SAME_BEAMS * fewer.max(1.0)
}

fn words(scan: &ScanDescription) -> String {
    let view_deg = scan.field_of_view_rad.to_degrees();
    format!("{} beams over {view_deg:.0}° in frame `{}`", scan.beams, scan.frame_id)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensors_differ_by_frame_view_or_beams() {
        let scan = |frame: &str, beams: usize, view_deg: f64| ScanDescription {
            frame_id: frame.to_owned(),
            beams,
            returns: beams,
            missing: 0.0,
            step_rad: 0.01,
            field_of_view_rad: view_deg.to_radians(),
            full_turn: view_deg > 350.0,
            range_m: [0.0, 15.0],
            notes: Vec::new(),
        };
        let one = scan("laser", 360, 359.0);
        assert!(is_of_one_sensor(&one, &scan("laser", 355, 360.0)), "a beam more or less");
        for other in [scan("front", 360, 359.0), scan("laser", 726, 359.0), scan("laser", 360, 255.0)] {
            assert!(!is_of_one_sensor(&one, &other), "{other:?}");
        }
    }
}

//! What is kept from scan to scan: where the beams look, and which of them are blind.

use crosscut_messages::{LaserScan, ScanMessage};
use crosscut_scan::LevelView;
use crosscut_stage::{Beam, Notes, Revolution};

use crate::blind::BlindSectors;
use crate::directions::BeamDirections;
use crate::turning::LEAST_TURN_RAD;
use crate::{Motion, Sensor};

/// This many scans show which beams never return.
pub const LEARNED_SCANS: usize = 100;

/// Writes the scans of one sensor as revolutions.
#[derive(Debug, Default)]
pub struct RevolutionWriter {
    directions: BeamDirections,
    blind: BlindSectors,
    level: LevelView,
}

impl RevolutionWriter {
    /// Looks for blind sectors in these scans; there are none if they differ in their beams.
    pub fn learn_blind(&mut self, scans: &[&LaserScan], sensor: &Sensor) {
        self.blind = BlindSectors::find(scans, sensor);
    }

    /// Writes the revolution that `scan` shows into `out`. `rad_per_beam` is the angle by which the sensor turned with its
    /// vehicle from beam to beam by the scan before, 0 if that is not known; `motion` is that of the vehicle meanwhile, if
    /// odometry tells it. [`RevolutionWriter::hide`] follows.
    pub fn show(
        &mut self,
        scan: &ScanMessage,
        rad_per_beam: f64,
        motion: Option<&Motion>,
        sensor: &Sensor,
        out: &mut Revolution,
        notes: &mut Notes,
    ) {
        match scan {
            ScanMessage::Scan(scan) => {
                let rad_per_beam = turned_rad_per_beam(rad_per_beam, scan.ranges.len(), motion, sensor);
                sensor.turning_revolution(&sensor.in_metres(scan), rad_per_beam, &mut self.directions, out, notes);
            }
            ScanMessage::Cloud(cloud) => sensor.moving_cloud(cloud, motion, out, notes),
        }
    }

    /// Makes those beams of `out`, which shows `scan`, unknown that are `missing`, and those of blind sectors. Of a cloud,
    /// `out` is then what a level vehicle sees.
    pub fn hide(
        &mut self,
        scan: &ScanMessage,
        missing: &[bool],
        sensor: &Sensor,
        out: &mut Revolution,
        notes: &mut Notes,
    ) {
        if let (Some(sweep), ScanMessage::Scan(scan)) = (&mut out.sweep, scan) {
            let missing = sweep.beams.iter_mut().zip(missing).filter(|(_, is_missing)| **is_missing);
            missing.for_each(|(beam, _)| *beam = Beam::Unknown);
            self.blind.hide(scan, out, notes);
        }
        sensor.level_in(&mut self.level, out, notes);
    }
}

/// The angle by which the sensor turned from one beam to the next, rad; 0 if that is not known or makes no difference.
/// Odometry tells it better than the scan before.
fn turned_rad_per_beam(by_scans: f64, beams: usize, motion: Option<&Motion>, sensor: &Sensor) -> f64 {
    let by_odometry = motion.filter(|motion| motion.times_s[0] != motion.times_s[1]);
    let rad_per_beam = by_odometry
        .map_or(by_scans, |motion| sensor.own_angle_rad(motion.turned_rad()) / beams.saturating_sub(1) as f64);
    if rad_per_beam.abs() * beams as f64 >= LEAST_TURN_RAD { rad_per_beam } else { 0.0 }
}

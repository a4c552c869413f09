//! Scans of a live robot, one after the other, to the revolutions that their recording gives.

use crosscut_messages::{LaserScan, ScanMessage};
use crosscut_stage::{Notes, Revolution};
use nalgebra::Isometry2;

use crate::motion::stamps_ns;
use crate::turning::stated_beam_s;
use crate::{Before, LEARNED_SCANS, Motion, Odometry, RevolutionWriter, Sensor, Turning, times_s};

/// What is known of a live robot by its scans so far.
///
/// A scan is shown at once, where a recording's reader reads 100 scans before the first: blind sectors are known from the
/// hundredth scan on, and messages that are parts of a turn are not joined.
#[derive(Debug, Default)]
pub struct Live {
    writer: RevolutionWriter,
    turning: Turning,
    before: Before,
    /// The first scans, as long as blind sectors are to be learned.
    first: Vec<LaserScan>,
    knows_blind: bool,
}

impl Live {
    /// Writes the revolution that the next message shows into `out`, corrected for the motion of the vehicle, and the
    /// vehicle's pose, by the poses in `odometry`. `notes` has what was corrected or left out. Both may hold anything before.
    ///
    /// `out.seq` is 0: only who counts the messages knows it. `out.stamp_ns` is 0 if the message has no stamp.
    pub fn show(
        &mut self,
        message: &ScanMessage,
        odometry: &Odometry,
        sensor: &Sensor,
        out: &mut Revolution,
        notes: &mut Notes,
    ) {
        notes.clear();
        let (mut rad_per_beam, mut beam_s) = (0.0, 0.0);
        if let ScanMessage::Scan(scan) = message {
            if sensor.deskews() {
                (rad_per_beam, beam_s) = self.turning.per_beam(scan);
            }
            if sensor.finds_blind_sectors() {
                self.look_at(scan, sensor);
            }
        }
        let times_s = if sensor.deskews() { times_s(message, beam_s) } else { [0.0; 2] };
        let motion = motion(message, times_s, odometry);
        self.writer.show(message, rad_per_beam, motion.as_ref(), sensor, out, notes);
        self.writer.hide(message, &[], sensor, out, notes);
        out.odometry = motion.map(|motion| motion.middle());
        if out.stamp_ns > 0 {
            self.before.compare(out, notes);
        }
    }

    /// Takes a copy of a scan as long as blind sectors are to be learned.
    fn look_at(&mut self, scan: &LaserScan, sensor: &Sensor) {
        if self.knows_blind {
            return;
        }
        self.first.push(scan.clone());
        if self.first.len() >= LEARNED_SCANS {
            self.writer.learn_blind(&self.first.iter().collect::<Vec<_>>(), sensor);
            (self.first, self.knows_blind) = (Vec::new(), true);
        }
    }

    /// When the first and the last point of a message were measured, as it states it, nanoseconds since the epoch.
    pub fn span_ns(message: &ScanMessage) -> [u64; 2] {
        stamps_ns(stamp_ns(message), stated_times_s(message))
    }

    /// The vehicle's pose in the middle of that time, or at the stamp if `odometry` does not reach so far.
    pub fn pose(message: &ScanMessage, odometry: &Odometry) -> Option<Isometry2<f64>> {
        motion(message, stated_times_s(message), odometry).map(|motion| motion.middle())
    }
}

fn stated_times_s(message: &ScanMessage) -> [f64; 2] {
    let beam_s = match message {
        ScanMessage::Scan(scan) => stated_beam_s(scan),
        ScanMessage::Cloud(_) => 0.0,
    };
    times_s(message, beam_s)
}

fn motion(message: &ScanMessage, times_s: [f64; 2], odometry: &Odometry) -> Option<Motion> {
    Motion::during(stamp_ns(message), times_s, |[from_ns, to_ns]| Some([odometry.at(from_ns)?, odometry.at(to_ns)?]))
}

fn stamp_ns(message: &ScanMessage) -> u64 {
    message.header().stamp.to_ns().unwrap_or(0)
}

//! What ingest made of a scan beside ranges and beams, so that its revolution can be rebuilt to the last bit.

use crosscut_stage::{Fan, Frame, Notes, Revolution, Sweep};
use nalgebra::Vector4;
use rerun::{Scalars, TextDocument};

use crate::rows::Rows;
use crate::schema::{SCAN_CLOUD_TILT, SCAN_ENTRIES, SCAN_NOTES, SCAN_ODOMETRY, SCAN_POINTS, SCAN_SWEEP};
use crate::tensors::{f64_matrix, f64_vector, i32_vector};

/// What was logged last of what is logged on change.
#[derive(Default)]
pub(crate) struct AsRead {
    sweep: Option<[u64; 8]>,
    notes: Option<String>,
}

impl AsRead {
    pub(crate) fn log(&mut self, rows: &mut Rows, frame: &Frame) {
        let revolution = &frame.revolution;
        if let Some(sweep) = revolution.beams() {
            let geometry = geometry(sweep);
            let bits = geometry.map(f64::to_bits); // NaN equals itself
            if self.sweep.replace(bits) != Some(bits) {
                rows.log_tensor(&SCAN_SWEEP, f64_vector(geometry.to_vec(), SCAN_SWEEP.dims), &[]);
            }
        }
        if !is_told(revolution) {
            let points = revolution.points_m.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
            rows.log_tensor(&SCAN_POINTS, f64_matrix(points, [revolution.len(), 3], SCAN_POINTS.dims), &[]);
        }
        if !revolution.entries.is_empty() {
            let entries = i32_vector(revolution.entries.iter().copied(), SCAN_ENTRIES.dims);
            rows.log_tensor(&SCAN_ENTRIES, entries, &[]);
        }
        let tilt = revolution.cloud_tilt.into_inner().coords;
        if tilt != Vector4::w() {
            rows.log(&SCAN_CLOUD_TILT, &Scalars::new(tilt.iter().copied()));
        }
        if let Some(pose) = &revolution.odometry {
            let (at, turned) = (pose.translation.vector, pose.rotation);
            rows.log(&SCAN_ODOMETRY, &Scalars::new([at.x, at.y, turned.re, turned.im])); // a tensor takes thrice as much
        }
        self.log_notes(rows, &frame.notes);
    }

    fn log_notes(&mut self, rows: &mut Rows, notes: &Notes) {
        let lines =
            notes.of_revolution().iter().map(|(code, note)| format!("{code:?} {note}")).collect::<Vec<_>>().join("\n");
        if self.notes.as_ref() != Some(&lines) {
            rows.log(&SCAN_NOTES, &TextDocument::new(lines.as_str()));
            self.notes = Some(lines);
        }
    }
}

/// Of a sweep that has no fan, numbers that are none.
fn geometry(sweep: &Sweep) -> [f64; 8] {
    let number = |yes: bool| f64::from(u8::from(yes));
    let [yaw_rad, upside_down, first_rad, increment_rad] = match sweep.fan {
        Some(Fan { yaw_rad, upside_down, first_rad, increment_rad }) => {
            [yaw_rad, number(upside_down), first_rad, increment_rad]
        }
        None => [f64::NAN; 4],
    };
    let full_turn = number(sweep.full_turn);
    let missing = sweep.missing as f64;
    [sweep.step_rad, sweep.range_max_m, full_turn, missing, yaw_rad, upside_down, first_rad, increment_rad]
}

/// Whether the returns follow from ranges and beams; those without beams, from their drawing in f32.
fn is_told(revolution: &Revolution) -> bool {
    let Some(sweep) = revolution.beams() else {
        let is_f32 = |x: f64| f64::from(x as f32).to_bits() == x.to_bits();
        return revolution.points_m.iter().all(|p| [p.x, p.y, p.z].into_iter().all(is_f32));
    };
    let Some(fan) = sweep.fan else { return revolution.is_empty() };
    let returns = sweep.beams.iter().zip(&sweep.ranges_m).enumerate();
    let mut returns = returns.filter_map(|(beam, (seen, range_m))| match seen {
        crosscut_stage::Beam::Return(i) => Some((revolution.points_m.get(*i as usize)?, fan.point_m(beam, *range_m))),
        _ => None,
    });
    returns.all(|(point, told)| *point == told)
}

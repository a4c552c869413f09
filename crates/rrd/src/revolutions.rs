//! Revolutions rebuilt from a recording as ingest made them, to the last bit.

use crosscut_stage::{Beam, Fan, NoteCode, Notes, Point, Revolution, Sweep};
use nalgebra::{Complex, Isometry2, Quaternion, Translation2, Unit, UnitComplex};

use crate::schema::{self, Entity};
use crate::{Array, Latest, Numbers, ReadError, Recording, Row, Rows, Value};

/// A scan as ingest gave it to the stages.
#[derive(Clone, Debug, Default)]
pub struct RecordedScan {
    /// Its returns and beams. The name of the sensor's frame is not recorded.
    pub revolution: Revolution,
    /// What ingest noted.
    pub notes: Notes,
    /// Its truth as JSON, where the flight had one.
    pub truth: Option<String>,
}

/// The scans of a recording, by revolution.
pub struct Revolutions<'a> {
    returns: Rows<'a>,
    ranges: Latest<'a>,
    seen: Latest<'a>,
    bearings: Latest<'a>,
    wire: Latest<'a>,
    sweep: Latest<'a>,
    points: Latest<'a>,
    entries: Latest<'a>,
    cloud: Latest<'a>,
    tilt: Latest<'a>,
    odometry: Latest<'a>,
    notes: Latest<'a>,
    truth: Latest<'a>,
}

impl Recording {
    /// The scans of all recorded revolutions.
    ///
    /// # Errors
    /// When the recording has none, or was written by a version that did not record all of a scan.
    pub fn revolutions(&self) -> Result<Revolutions<'_>, ReadError> {
        let returns = self.rows(schema::SCAN_RETURNS.path)?;
        self.rows(schema::SCAN_NOTES.path)?; // every version that records all of a scan writes it at the first one
        let latest = |entity: Entity| self.latest(entity);
        Ok(Revolutions {
            returns,
            ranges: latest(schema::SCAN_RANGES),
            seen: latest(schema::SCAN_SEEN),
            bearings: latest(schema::SCAN_BEAMS),
            wire: latest(schema::SCAN_BEAMS_WIRE),
            sweep: latest(schema::SCAN_SWEEP),
            points: latest(schema::SCAN_POINTS),
            entries: latest(schema::SCAN_ENTRIES),
            cloud: latest(schema::SCAN_CLOUD),
            tilt: latest(schema::SCAN_CLOUD_TILT),
            odometry: latest(schema::SCAN_ODOMETRY),
            notes: latest(schema::SCAN_NOTES),
            truth: latest(schema::TRUTH_JSON),
        })
    }
}

impl Iterator for Revolutions<'_> {
    type Item = Result<RecordedScan, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let row = self.returns.next()?;
        Some(row.and_then(|row| self.scan(&row)))
    }
}

impl Revolutions<'_> {
    fn scan(&mut self, row: &Row) -> Result<RecordedScan, ReadError> {
        let at = row.revolution;
        let mut scan = RecordedScan::default();
        let revolution = &mut scan.revolution;
        (revolution.seq, revolution.stamp_ns) = (at.cast_unsigned(), row.stamp_ns.unwrap_or(0).cast_unsigned());
        revolution.sweep = self.sweep(at)?;
        revolution.points_m = match (self.points.only_at(at)?, &revolution.sweep) {
            (Some(exact), _) => points(&exact.to_f64()),
            (None, Some(Sweep { fan: Some(fan), beams, ranges_m, .. })) => {
                let returns = beams.iter().enumerate().filter(|(_, beam)| matches!(beam, Beam::Return(_)));
                returns.map(|(beam, _)| fan.point_m(beam, ranges_m[beam])).collect()
            }
            (None, _) => points(&row.value(schema::SCAN_RETURNS.values)?.to_f64()),
        };
        let entries = self.entries.only_at(at)?.map(Value::to_f64).unwrap_or_default();
        revolution.entries = entries.into_iter().map(|entry| entry as i32).collect();
        revolution.cloud_m = self.cloud.only_at(at)?.map(|cloud| points(&cloud.to_f64())).unwrap_or_default();
        if let Some(&[x, y, z, w]) = self.tilt.only_at(at)?.map(Value::to_f64).as_deref() {
            revolution.cloud_tilt = Unit::new_unchecked(Quaternion::new(w, x, y, z));
        }
        revolution.odometry = match self.odometry.only_at(at)?.map(Value::to_f64).as_deref() {
            Some(&[x_m, y_m, cos, sin]) => {
                let rotation = UnitComplex::new_unchecked(Complex::new(cos, sin));
                Some(Isometry2::from_parts(Translation2::new(x_m, y_m), rotation))
            }
            _ => None,
        };
        if let Some(lines) = self.notes.at(at)?.and_then(text) {
            scan.notes.extend(lines.lines().map(coded));
        }
        scan.truth = self.truth.only_at(at)?.and_then(text).map(str::to_owned);
        match scan.revolution.fault() {
            Some(fault) => {
                let (entity, cause) = (schema::SCAN_SWEEP.path.to_owned(), format!("this is no scan: {fault}"));
                Err(ReadError::NotAValue { entity, component: format!("revolution {at}"), cause })
            }
            None => Ok(scan),
        }
    }

    /// The beams; `None` of returns without beams.
    fn sweep(&mut self, at: i64) -> Result<Option<Sweep>, ReadError> {
        let Some(ranges) = self.ranges.only_at(at)? else { return Ok(None) };
        let ranges_m = match ranges {
            Value::Numbers(Array { numbers: Numbers::F32(ranges_m), .. }) => ranges_m.clone(),
            other => other.to_f64().into_iter().map(|range_m| range_m as f32).collect(),
        };
        let seen = self.seen.only_at(at)?.map(Value::to_f64).unwrap_or_default();
        let mut returns = 0..;
        let beams = seen.into_iter().map(|seen| match seen {
            2.0 => returns.next().map_or(Beam::Unknown, Beam::Return),
            1.0 => Beam::NoReturn,
            _ => Beam::Unknown,
        });
        let mut sweep = Sweep { ranges_m, beams: beams.collect(), ..Sweep::default() };
        sweep.bearings_rad = self.bearings.at(at)?.map(Value::to_f64).unwrap_or_default();
        if let Some(Value::Numbers(Array { numbers: Numbers::F32(wire), .. })) = self.wire.at(at)?
            && let [_, _, _, _] = wire[..]
        {
            sweep.wire_geometry.copy_from_slice(wire);
        }
        if let Some(geometry) = self.sweep.at(at)?.map(Value::to_f64)
            && let [step_rad, range_max_m, full_turn, missing, yaw_rad, upside_down, first_rad, increment_rad] =
                geometry[..]
        {
            (sweep.step_rad, sweep.range_max_m) = (step_rad, range_max_m);
            (sweep.full_turn, sweep.missing) = (full_turn == 1.0, missing as usize);
            sweep.fan = (!first_rad.is_nan()).then_some(Fan {
                yaw_rad,
                upside_down: upside_down == 1.0,
                first_rad,
                increment_rad,
            });
        }
        Ok(Some(sweep))
    }
}

fn text(value: &Value) -> Option<&str> {
    match value {
        Value::Texts(texts) => texts.first().map(String::as_str),
        _ => None,
    }
}

/// A line of notes as recorded; of one without a code, as early versions recorded them, what a note of unknown kind has.
fn coded(line: &str) -> (NoteCode, &str) {
    let coded = line.split_once(' ').and_then(|(code, note)| Some((NoteCode::named(code)?, note)));
    coded.unwrap_or((NoteCode::N101, line))
}

fn points(coordinates: &[f64]) -> Vec<Point> {
    coordinates.chunks_exact(3).map(|p| Point::new(p[0], p[1], p[2])).collect()
}

//! Scans with several echoes a beam.

use serde::Serialize;

use crate::{DecodeError, Fields, LaserScan, MOST_BEAMS, Message, schema};

/// Which of the echoes of a beam is its range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Echo {
    /// The first, which is the nearest.
    #[default]
    First,
    /// The last, which sees through dust and mist.
    Last,
    /// The one of the highest intensity; the first where there are no intensities.
    Strongest,
}

/// `sensor_msgs/msg/MultiEchoLaserScan`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MultiEchoLaserScan {
    /// Everything but ranges and intensities, which are empty here.
    #[serde(serialize_with = "geometry_alone")]
    pub geometry: LaserScan,
    /// Ranges, m, one entry a beam; a beam without echoes saw nothing.
    pub ranges: Vec<LaserEcho>,
    /// Intensities in the sensor's own unit, one entry a beam, or none at all.
    pub intensities: Vec<LaserEcho>,
}

/// `sensor_msgs/msg/LaserEcho`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LaserEcho {
    /// One value an echo.
    pub echoes: Vec<f32>,
}

impl LaserEcho {
    /// The count of an empty one.
    const LEAST_BYTES: usize = 4;

    fn read(&mut self, from: &mut Fields<'_>, field: &'static str) -> Result<(), DecodeError> {
        from.f32s(field, &mut self.echoes)
    }
}

fn geometry_alone<S: serde::Serializer>(scan: &LaserScan, to: S) -> Result<S::Ok, S::Error> {
    let LaserScan {
        header,
        angle_min,
        angle_max,
        angle_increment,
        time_increment,
        scan_time,
        range_min,
        range_max,
        ..
    } = scan;
    (header, angle_min, angle_max, angle_increment, time_increment, scan_time, range_min, range_max).serialize(to)
}

impl MultiEchoLaserScan {
    /// Writes the scan that has one echo of each beam as its range into `out`.
    pub fn write_scan(&self, echo: Echo, out: &mut LaserScan) {
        out.clone_from(&self.geometry);
        out.intensities.clear();
        out.ranges.clear();
        out.ranges.extend(self.ranges.iter().enumerate().map(|(beam, LaserEcho { echoes })| {
            let intensities = self.intensities.get(beam).map_or(&[][..], |LaserEcho { echoes }| echoes);
            let strongest = || {
                (0..echoes.len().min(intensities.len()))
                    .rev()
                    .max_by(|&a, &b| intensities[a].total_cmp(&intensities[b]))
            };
            let chosen = match echo {
                Echo::First => echoes.first(),
                Echo::Last => echoes.last(),
                Echo::Strongest => echoes.get(strongest().unwrap_or(0)),
            };
            chosen.copied().unwrap_or(f32::INFINITY)
        }));
    }
}

impl Message for MultiEchoLaserScan {
    const SCHEMA_NAME: &'static str = "sensor_msgs/msg/MultiEchoLaserScan";
    const SCHEMA_TEXT: &'static str = schema::MULTI_ECHO_LASER_SCAN;

    fn read(&mut self, from: &mut Fields<'_>) -> Result<(), DecodeError> {
        self.geometry.read_geometry(from)?;
        for (field, echoes) in [("ranges", &mut self.ranges), ("intensities", &mut self.intensities)] {
            from.structures(field, LaserEcho::LEAST_BYTES, MOST_BEAMS, echoes, |from, echo| echo.read(from, field))?;
        }
        Ok(())
    }
}

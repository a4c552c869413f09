//! Rows of `ros2 topic echo --csv`: the fields of a LaserScan in the order of its definition, without a header.

use crosscut_messages::{Header, LaserScan, Time};

use super::dialect::Dialect;

/// The cells before the ranges.
const FIXED: usize = 10;

/// Whether this row is one of a LaserScan.
pub(super) fn is_scan(dialect: Dialect, cells: &[&str]) -> bool {
    scan(dialect, cells).is_ok()
}

/// Whether a row begins with the header of a message.
pub(super) fn has_header(dialect: Dialect, cells: &[&str]) -> bool {
    let [sec, nanosec, frame, ..] = cells else { return false };
    let is_stamp = sec.parse::<i32>().is_ok() && nanosec.parse::<u32>().is_ok_and(|nanosec| nanosec < 1_000_000_000);
    is_stamp && (frame.is_empty() || dialect.number(frame).is_none())
}

/// Whether the row was shortened when it was written.
pub(super) fn is_shortened(cells: &[&str]) -> bool {
    cells.iter().any(|cell| *cell == "..." || cell.starts_with("<sequence type"))
}

/// The scan in a row. Of the numbers behind its geometry, the first are ranges; the others, if the angles leave room for half of
/// them only, are intensities.
///
/// # Errors
/// When the row is not one of a LaserScan: why.
pub(super) fn scan(dialect: Dialect, cells: &[&str]) -> Result<LaserScan, String> {
    if !has_header(dialect, cells) || cells.len() <= FIXED {
        return Err("it does not begin with the fields of a LaserScan".to_owned());
    }
    if is_shortened(cells) {
        return Err("it was shortened when it was written".to_owned());
    }
    let mut scan = LaserScan::default();
    let parsed = |cell: &str, field: &str| cell.parse::<f32>().map_err(|_| format!("`{cell:.20}` is no {field}"));
    let fields = [
        (&mut scan.angle_min, "angle_min"),
        (&mut scan.angle_max, "angle_max"),
        (&mut scan.angle_increment, "angle_increment"),
        (&mut scan.time_increment, "time_increment"),
        (&mut scan.scan_time, "scan_time"),
        (&mut scan.range_min, "range_min"),
        (&mut scan.range_max, "range_max"),
    ];
    for ((field, name), cell) in fields.into_iter().zip(&cells[3..]) {
        *field = parsed(cell, name)?;
    }
    // Without intensities a row ends in a comma.
    let rest = cells[FIXED..].strip_suffix(&[""]).unwrap_or(&cells[FIXED..]);
    let stated = f64::from((scan.angle_max - scan.angle_min) / scan.angle_increment) + 1.0;
    let off = |beams: usize| (beams as f64 - stated).abs();
    let beams =
        if rest.len().is_multiple_of(2) && off(rest.len() / 2) < off(rest.len()) { rest.len() / 2 } else { rest.len() };
    let fits = off(beams) <= 2.0 + 0.05 * stated;
    if !fits {
        return Err(format!("{beams} numbers do not fit {stated:.0} beams, as its angles state"));
    }
    let number = |cell: &&str| parsed(cell, "range");
    scan.ranges = rest[..beams].iter().map(number).collect::<Result<_, _>>()?;
    scan.intensities = rest[beams..].iter().map(number).collect::<Result<_, _>>()?;
    let [sec, nanosec] = [cells[0].parse().unwrap_or(0), cells[1].parse().unwrap_or(0)];
    scan.header = Header { stamp: Time { sec, nanosec: nanosec as u32 }, frame_id: cells[2].to_owned() };
    Ok(scan)
}

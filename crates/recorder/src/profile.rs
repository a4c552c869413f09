//! Chart by beam: the range of each beam in the colour of its wall, and above it a row of walls.

use crosscut_stage::{Frame, Sweep};
use rerun::{AsComponents, LineStrips2D, Radius, RecordingStream, RecordingStreamResult};

use crate::beam_order::beams_of_returns;
use crate::colors::{GRID, color};
use crate::partition::runs;
use crate::polyline::simplified;
use crate::rows::Rows;
use crate::scan::ticks_m;
use crate::schema::{KMEANS_PROFILE, KMEANS_PROFILE_AXES, KMEANS_PROFILE_NAMES};
use crate::tracks::Classes;
use crate::words::words;

/// Width of the chart, whatever the number of beams.
const WIDTH: f32 = 100.0;
/// Height of the chart, whatever the range.
const HEIGHT: f32 = 85.0;
/// Where the row of walls stands; 2D views have y downwards.
const WALLS_Y: f32 = -HEIGHT - 10.0;
/// A label hangs below its point. Raised by this, its middle is level with what it names.
const LABEL_RISE: f32 = 5.0;
/// Largest distance between a range and the line that is drawn for it.
const LINE: f32 = 0.25;
/// Coordinates are multiples of this: those of few digits take less space.
const STEP: f32 = 1.0 / 128.0;
/// Ranges of neighbouring beams that differ by more are not joined by a line.
const GAP: f32 = 5.0;

/// Name of the row.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    rec.log_static(KMEANS_PROFILE.path, &LineStrips2D::update_fields().with_show_labels(false))?;
    rec.log_static(KMEANS_PROFILE_NAMES.path, &words([([-12.0, WALLS_Y - LABEL_RISE], "walls")]))
}

/// The axes: ranges up to `reach_m`, and the bearings of some beams.
pub(crate) fn log_axes(rows: &mut Rows, reach_m: f64, sweep: &Sweep) {
    let ticks_m: Vec<f64> = [0.0].into_iter().chain(ticks_m(reach_m)).collect();
    let y = |tick_m: f64| -HEIGHT * (tick_m / reach_m) as f32;
    let grid = LineStrips2D::new(ticks_m.iter().map(|&tick_m| [[0.0, y(tick_m)], [WIDTH, y(tick_m)]]))
        .with_radii([Radius::new_ui_points(0.5)])
        .with_colors([color(GRID)]);
    let ranges = ticks_m.iter().map(|&tick_m| ([-10.0, y(tick_m) - LABEL_RISE], format!("{tick_m} m")));
    let bearings = round_bearings(&sweep.bearings_rad).into_iter();
    let bearings = bearings.map(|(share, label)| ([WIDTH * share, 1.0], label));
    rows.log(&KMEANS_PROFILE_AXES, &[&grid as &dyn AsComponents, &words(ranges.chain(bearings))]);
}

/// Where along the beams the multiples of 45° lie, of 90° in a view of more than 200°, with their names.
fn round_bearings(bearings_rad: &[f64]) -> Vec<(f32, String)> {
    let turned_deg: Vec<f64> = bearings_rad
        .iter()
        .scan(None, |before: &mut Option<f64>, bearing| {
            let degrees = bearing.to_degrees();
            let turned = before.map_or(degrees, |before| before + (degrees - before + 540.0).rem_euclid(360.0) - 180.0);
            *before = Some(turned);
            Some(turned)
        })
        .collect();
    let (Some(first), Some(last)) = (turned_deg.first(), turned_deg.last()) else { return Vec::new() };
    let (low, high) = (first.min(*last), first.max(*last));
    let step = if high - low > 200.0 { 90.0 } else { 45.0 };
    let half_beam = 0.5 * (high - low) / (turned_deg.len().max(2) - 1) as f64;
    let (from, to) = (((low - half_beam) / step).ceil() as i32, ((high + half_beam) / step).floor() as i32);
    let share = |degrees: f64| ((degrees - first) / (last - first)).clamp(0.0, 1.0) as f32;
    (from..=to)
        .map(|multiple| {
            let degrees = f64::from(multiple) * step;
            let named = degrees - 360.0 * ((degrees - 180.0) / 360.0).ceil(); // in (-180, 180]
            (share(degrees), if named == 0.0 { "0°".to_owned() } else { format!("{named:+}°") })
        })
        .collect()
}

/// The ranges of one revolution, cut off at `reach_m`, and its walls.
pub(crate) fn log(rows: &mut Rows, frame: &Frame, classes: &Classes, reach_m: f64) {
    let by_return = || (frame.revolution.len(), (0..frame.revolution.len()).collect());
    let (beams, places) = beams_of_returns(&frame.revolution).unwrap_or_else(by_return);
    let along = WIDTH / beams.max(1) as f32;
    let mut lines = Vec::new();
    let bar = |(class, from, to): (u16, usize, usize)| {
        (vec![[along * from as f32, WALLS_Y], [along * to as f32, WALLS_Y]], class, Radius::new_ui_points(4.0))
    };
    lines.extend(runs(&classes.returns, &places, 1).into_iter().map(bar));
    let height = |i: usize| -HEIGHT * (frame.revolution.range_m(i) / reach_m).min(1.0) as f32;
    let placed: Vec<(u16, [f32; 3])> = (classes.returns.iter().zip(&places).enumerate().take(frame.revolution.len()))
        .map(|(i, (class, place))| (*class, [along * (*place as f32 + 0.5), height(i), 0.0]))
        .collect();
    let joined = |a: &(u16, [f32; 3]), b: &(u16, [f32; 3])| {
        a.0 == b.0 && b.1[0] - a.1[0] < 4.5 * along && (a.1[1] - b.1[1]).abs() < GAP
    };
    let ranges = placed.chunk_by(joined);
    lines.extend(ranges.map(|line| (drawn(line, along), line[0].0, Radius::new_ui_points(1.5))));
    let (lines, (colors, radii)): (Vec<_>, (Vec<_>, Vec<_>)) =
        lines.into_iter().map(|(line, class, radius)| (line, (class, radius))).unzip();
    let lines = LineStrips2D::new(lines).with_class_ids(colors).with_radii(radii);
    rows.log(&KMEANS_PROFILE, &lines);
}

/// The line through these ranges; a single range becomes a line as wide as its beam.
fn drawn(line: &[(u16, [f32; 3])], along: f32) -> Vec<[f32; 2]> {
    let coarse = |[x, y]: [f32; 2]| [x, y].map(|at| (at / STEP).round() * STEP);
    if let [(_, [x, y, _])] = *line {
        return vec![coarse([x - 0.5 * along, y]), coarse([x + 0.5 * along, y])];
    }
    let line: Vec<[f32; 3]> = line.iter().map(|(_, point)| *point).collect();
    simplified(&line, LINE).into_iter().map(|[x, y, _]| coarse([x, y])).collect()
}

/// Left, top, right and bottom of the chart.
pub(crate) fn profile_bounds() -> [f64; 4] {
    [-24.0, f64::from(WALLS_Y) - 6.0, f64::from(WIDTH) + 11.0, 10.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bearings_are_named_at_multiples_of_45_degrees() {
        let named = |from_deg: f64, to_deg: f64| {
            let bearings = |i: u32| (from_deg + (to_deg - from_deg) * f64::from(i) / 359.0).to_radians();
            let wrapped = |bearing: f64| bearing.sin().atan2(bearing.cos());
            round_bearings(&(0..360).map(|i| wrapped(bearings(i))).collect::<Vec<_>>())
        };
        let names = |from, to| named(from, to).into_iter().map(|(_, name)| name).collect::<Vec<_>>();
        assert_eq!(names(-180.0, 179.0), ["+180°", "-90°", "0°", "+90°"]);
        assert_eq!(names(-135.0, 120.0), ["-90°", "0°", "+90°"]);
        assert_eq!(names(-100.0, 60.0), ["-90°", "-45°", "0°", "+45°"]);
        assert_eq!(names(90.0, -90.0), ["-90°", "-45°", "0°", "+45°", "+90°"]);
        let places: Vec<f32> = named(-90.0, 90.0).into_iter().map(|(share, _)| share).collect();
        assert!(places.iter().zip([0.0, 0.25, 0.5, 0.75, 1.0]).all(|(a, b)| (a - b).abs() < 1e-5), "{places:?}");
        assert_eq!(round_bearings(&[]), []);
    }
}

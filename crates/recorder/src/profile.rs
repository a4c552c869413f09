//! Chart by beam: the range of each beam in the colour of its wall, and above it a row of walls and a row of clusters.

use crosscut_stage::{Frame, Sweep};
use rerun::{AsComponents, LineStrips2D, Points2D, Radius, RecordingStream, RecordingStreamResult};

use crate::beam_order::beams_of_returns;
use crate::colors::{GRID, WORDS, color};
use crate::partition::runs;
use crate::polyline::simplified;
use crate::rows::Rows;
use crate::scan::ticks_m;
use crate::schema::{KMEANS_PROFILE, KMEANS_PROFILE_AXES, KMEANS_PROFILE_NAMES};
use crate::tracks::Classes;

/// Width of the chart, whatever the number of beams.
const WIDTH: f32 = 100.0;
/// Height of the chart, whatever the range.
const HEIGHT: f32 = 85.0;
/// Where the row of clusters stands; 2D views have y downwards.
const CLUSTERS_Y: f32 = -HEIGHT - 20.0;
/// Where the row of walls stands.
const WALLS_Y: f32 = -HEIGHT - 10.0;
/// A label hangs below its point. Raised by this, its middle is level with what it names.
const LABEL_RISE: f32 = 5.0;
/// Largest distance between a range and the line that is drawn for it.
const LINE: f32 = 0.25;
/// Ranges of neighbouring beams that differ by more are not joined by a line.
const GAP: f32 = 5.0;

/// Names of the rows.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let names = [("clusters", CLUSTERS_Y), ("walls", WALLS_Y)];
    rec.log_static(
        KMEANS_PROFILE_NAMES.path,
        &marks(names.into_iter().map(|(name, y)| ([-12.0, y - LABEL_RISE], name.to_owned()))),
    )
}

/// The axes: ranges up to `reach_m`, and the bearings of some beams.
pub(crate) fn log_axes(rows: &mut Rows, reach_m: f64, sweep: &Sweep) {
    let ticks_m: Vec<f64> = [0.0].into_iter().chain(ticks_m(reach_m)).collect();
    let y = |tick_m: f64| -HEIGHT * (tick_m / reach_m) as f32;
    let grid = LineStrips2D::new(ticks_m.iter().map(|&tick_m| [[0.0, y(tick_m)], [WIDTH, y(tick_m)]]))
        .with_radii([Radius::new_ui_points(0.5)])
        .with_colors([color(GRID)]);
    let ranges = ticks_m.iter().map(|&tick_m| ([-10.0, y(tick_m) - LABEL_RISE], format!("{tick_m} m")));
    let last = sweep.len().saturating_sub(1);
    let bearings = [0.0f32, 0.25, 0.5, 0.75, 1.0].into_iter().filter_map(|share| {
        let bearing = sweep.bearings_rad.get((share * last as f32).round() as usize)?;
        let label = match bearing.to_degrees().round() as i32 {
            0 => "0°".to_owned(),
            degrees => format!("{degrees:+}°"),
        };
        Some(([WIDTH * share, 1.0], label))
    });
    rows.log(&KMEANS_PROFILE_AXES, &[&grid as &dyn AsComponents, &marks(ranges.chain(bearings))]);
}

/// The ranges of one revolution, cut off at `reach_m`, and its clusters and walls.
pub(crate) fn log(rows: &mut Rows, frame: &Frame, classes: &Classes, reach_m: f64) {
    let by_return = || (frame.revolution.len(), (0..frame.revolution.len()).collect());
    let (beams, places) = beams_of_returns(&frame.revolution).unwrap_or_else(by_return);
    let along = WIDTH / beams.max(1) as f32;
    let walls: Vec<u16> = frame.junction.wall_of_return.iter().map(|wall| classes.of_wall(*wall)).collect();
    let clusters: Vec<u16> = frame.partition.labels.iter().map(|label| classes.of_cluster(*label)).collect();
    let mut lines = Vec::new();
    for (y, row) in [(CLUSTERS_Y, &clusters), (WALLS_Y, &walls)] {
        let bar = |(class, from, to): (u16, usize, usize)| {
            (vec![[along * from as f32, y], [along * to as f32, y]], class, Radius::new_ui_points(4.0))
        };
        lines.extend(runs(row, &places).into_iter().map(bar));
    }
    let height = |i: usize| -HEIGHT * (frame.revolution.range_m(i) / reach_m).min(1.0) as f32;
    let placed: Vec<(u16, [f32; 3])> = (walls.iter().zip(&places).enumerate().take(frame.revolution.len()))
        .map(|(i, (class, place))| (*class, [along * (*place as f32 + 0.5), height(i), 0.0]))
        .collect();
    let joined = |a: &(u16, [f32; 3]), b: &(u16, [f32; 3])| {
        a.0 == b.0 && b.1[0] - a.1[0] < 4.5 * along && (a.1[1] - b.1[1]).abs() < GAP
    };
    let ranges = placed.chunk_by(joined);
    lines.extend(ranges.map(|line| (drawn(line, along), line[0].0, Radius::new_ui_points(1.5))));
    let (lines, (colors, radii)): (Vec<_>, (Vec<_>, Vec<_>)) =
        lines.into_iter().map(|(line, class, radius)| (line, (class, radius))).unzip();
    let lines = LineStrips2D::new(lines).with_class_ids(colors).with_radii(radii).with_show_labels(false);
    rows.log(&KMEANS_PROFILE, &lines);
}

/// The line through these ranges; a single range becomes a line as wide as its beam.
fn drawn(line: &[(u16, [f32; 3])], along: f32) -> Vec<[f32; 2]> {
    if let [(_, [x, y, _])] = *line {
        return vec![[x - 0.5 * along, y], [x + 0.5 * along, y]];
    }
    let line: Vec<[f32; 3]> = line.iter().map(|(_, point)| *point).collect();
    simplified(&line, LINE).into_iter().map(|[x, y, _]| [x, y]).collect()
}

fn marks(marks: impl Iterator<Item = ([f32; 2], String)>) -> Points2D {
    let (at, labels): (Vec<_>, Vec<_>) = marks.unzip();
    Points2D::new(at)
        .with_radii([Radius::new_ui_points(0.0)])
        .with_colors([color(WORDS)])
        .with_labels(labels)
        .with_show_labels(true)
}

/// Left, top, right and bottom of the chart.
pub(crate) fn profile_bounds() -> [f64; 4] {
    [-24.0, f64::from(CLUSTERS_Y) - 6.0, f64::from(WIDTH) + 11.0, 10.0]
}

//! What decides with an affinity that judges gap by gap: the room at each gap beside the room that an opening needs.

use crosscut_stage::{Frame, Verdict};
use rerun::{AsComponents, LineStrips2D, Points2D, Radius, RecordingStream, RecordingStreamResult};

use crate::colors::{GREY, GRID, TOLERANCE, WORDS, ZEROS, color};
use crate::rows::Rows;
use crate::schema::{AFFINITY_GAPS, AFFINITY_GAPS_AXIS};

/// Gaps that are drawn: of those within [`RATIOS`] the nearest to the threshold.
const DRAWN: usize = 6;
/// The least and the largest ratio of the chart.
const RATIOS: [f64; 2] = [0.1, 10.0];
/// Height of the chart above and below the threshold, and the width of a column.
const HALF: f32 = 10.0;
const COLUMN: f32 = 4.5;
const RIGHT: f32 = COLUMN * (DRAWN as f32 + 0.25);

/// The ratios along the side of the chart, and the threshold.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    let ticks = [0.1, 0.3, 1.0, 3.0, 10.0];
    let line = |ratio: f64| [[0.0, y(ratio)], [RIGHT, y(ratio)]];
    let rgba = |ratio: f64| color(if ratio == 1.0 { TOLERANCE } else { GRID });
    let lines = LineStrips2D::new(ticks.map(line))
        .with_radii(ticks.map(|ratio| ui(if ratio == 1.0 { 1.5 } else { 0.5 })))
        .with_colors(ticks.map(rgba));
    let places = ticks.map(|ratio| [-1.6, y(ratio) - 0.9]).into_iter();
    let above = ([0.5 * RIGHT, -HALF - 3.6], "above 1: an opening, between two walls".to_owned());
    let below = ([0.5 * RIGHT, HALF + 1.4], "below 1: the wall continues".to_owned());
    let names = Points2D::new(places.chain([above.0, below.0]))
        .with_labels(ticks.map(|ratio| format!("{ratio}")).into_iter().chain([above.1, below.1]))
        .with_show_labels(true)
        .with_radii([ui(0.0)])
        .with_colors([color(WORDS)]);
    rec.log_static(AFFINITY_GAPS_AXIS.path, &[&lines as &dyn AsComponents, &names])
}

/// A column for each gap from the threshold up, or down, with the width of the gap.
pub(crate) fn log(rows: &mut Rows, frame: &Frame) {
    let doubt = |verdict: &Verdict| verdict.room_ratio.ln().abs();
    let mut gaps: Vec<&Verdict> = frame.affinity.verdicts.iter().collect();
    gaps.retain(|gap| gap.room_ratio >= RATIOS[0] && gap.room_ratio <= RATIOS[1]);
    gaps.sort_by(|a, b| doubt(a).total_cmp(&doubt(b)));
    gaps.truncate(DRAWN);
    let x = |at: usize| COLUMN * (at as f32 + 0.75);
    let columns = gaps.iter().enumerate().map(|(at, gap)| [[x(at), 0.0], [x(at), y(gap.room_ratio)]]);
    let lines = LineStrips2D::new(columns)
        .with_radii([Radius::new_scene_units(0.2 * COLUMN)])
        .with_colors(gaps.iter().map(|gap| color(if gap.is_opening { ZEROS } else { GREY })));
    let points_m = &frame.revolution.points_m;
    let width_m = |gap: &Verdict| {
        let [a, b] = gap.returns.map(|i| points_m.get(i as usize));
        Some((a? - b?).norm())
    };
    let beyond = |ratio: f64| y(ratio) + if ratio > 1.0 { -3.4 } else { 1.0 };
    let widths = Points2D::new(gaps.iter().enumerate().map(|(at, gap)| [x(at), beyond(gap.room_ratio)]))
        .with_labels(gaps.iter().map(|gap| width_m(gap).map_or(String::new(), |width_m| format!("{width_m:.1} m"))))
        .with_show_labels(true)
        .with_radii([Radius::new_ui_points(0.0)])
        .with_colors([color(WORDS)]);
    rows.log(&AFFINITY_GAPS, &[&lines as &dyn AsComponents, &widths]);
}

/// Height of a ratio on the logarithmic axis; 2D views have y downwards.
fn y(ratio: f64) -> f32 {
    let [least, most] = RATIOS;
    -HALF * ratio.clamp(least, most).log10() as f32
}

/// Left, top, right and bottom of the chart.
pub(crate) fn gaps_bounds() -> [f64; 4] {
    [-4.5, f64::from(-HALF) - 5.0, f64::from(RIGHT) + 0.5, f64::from(HALF) + 4.5]
}

//! What decides with an affinity that judges gap by gap: the room at each gap beside the room that an opening needs.

use crosscut_stage::{Frame, Verdict};
use rerun::{AsComponents, LineStrips2D, Points2D, Radius, RecordingStream, RecordingStreamResult};

use crate::colors::{GRID, TOLERANCE, WORDS, color};
use crate::rows::Rows;
use crate::schema::{AFFINITY_GAPS, AFFINITY_GAPS_AXIS};
use crate::tracks::Classes;

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
    rec.log_static(AFFINITY_GAPS.path, &LineStrips2D::update_fields().with_show_labels(false))?;
    rec.log_static(AFFINITY_GAPS_AXIS.path, &[&lines as &dyn AsComponents, &names])
}

/// A column for each gap from the threshold up, or down, in the colours of the walls on its two sides; at its foot their numbers, at
/// its end how far the ends of the walls are apart.
pub(crate) fn log(rows: &mut Rows, frame: &Frame, classes: &Classes) {
    let doubt = |verdict: &Verdict| verdict.room_ratio.ln().abs();
    let mut gaps: Vec<&Verdict> = frame.affinity.verdicts.iter().collect();
    gaps.retain(|gap| gap.room_ratio >= RATIOS[0] && gap.room_ratio <= RATIOS[1]);
    gaps.sort_by(|a, b| doubt(a).total_cmp(&doubt(b)));
    gaps.truncate(DRAWN);
    let x = |at: usize| COLUMN * (at as f32 + 0.75);
    let walls_of = |gap: &Verdict| {
        let [a, b] = gap.returns.map(|i| frame.junction.wall_of_return.get(i as usize).copied().flatten());
        if a == b { vec![a] } else { vec![a, b] }
    };
    let (columns, of_walls): (Vec<_>, Vec<_>) = (gaps.iter().enumerate())
        .flat_map(|(at, gap)| {
            let walls = walls_of(gap);
            let aside = 0.1 * COLUMN * (walls.len() - 1) as f32;
            let column = move |x: f32| [[x, 0.0], [x, y(gap.room_ratio)]];
            let of_wall =
                move |(side, wall)| (column(x(at) + if side == 0 { -aside } else { aside }), classes.of_wall(wall));
            walls.into_iter().enumerate().map(of_wall).collect::<Vec<_>>()
        })
        .unzip();
    let lines =
        LineStrips2D::new(columns).with_radii([Radius::new_scene_units(0.13 * COLUMN)]).with_class_ids(of_walls);
    let points_m = &frame.revolution.points_m;
    let width_m = |gap: &Verdict| {
        let [a, b] = gap.returns.map(|i| points_m.get(i as usize));
        Some((a? - b?).norm())
    };
    let beyond = |ratio: f64| y(ratio) + if ratio > 1.0 { -3.4 } else { 1.0 };
    let foot = |ratio: f64| if ratio > 1.0 { 0.6 } else { -3.0 };
    let numbers = |gap: &Verdict| {
        let name = |wall: Option<u32>| wall.map_or_else(|| "-".to_owned(), |wall| wall.to_string());
        walls_of(gap).into_iter().map(name).collect::<Vec<_>>().join("|")
    };
    let places = |end: &dyn Fn(f64) -> f32| -> Vec<[f32; 2]> {
        gaps.iter().enumerate().map(|(at, gap)| [x(at), end(gap.room_ratio)]).collect()
    };
    let widths = gaps.iter().map(|gap| width_m(gap).map_or(String::new(), |width_m| format!("{width_m:.1} m")));
    let widths = Points2D::new(places(&beyond).into_iter().chain(places(&foot)))
        .with_labels(widths.chain(gaps.iter().map(|gap| numbers(gap))))
        .with_show_labels(true)
        .with_radii([Radius::new_ui_points(0.0)])
        .with_colors([color(WORDS)]);
    rows.log(&AFFINITY_GAPS, &[&lines as &dyn AsComponents, &widths]);
}

/// Height of a ratio on the logarithmic axis; 2D views have y downwards.
fn y(ratio: f64) -> f32 {
    let [least, most] = RATIOS;
    (-HALF * ratio.clamp(least, most).log10() as f32 * 8.0).round() / 8.0 // few digits take less space
}

/// Left, top, right and bottom of the chart.
pub(crate) fn gaps_bounds() -> [f64; 4] {
    [-4.5, f64::from(-HALF) - 5.0, f64::from(RIGHT) + 0.5, f64::from(HALF) + 4.5]
}

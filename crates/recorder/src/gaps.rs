//! What decides with an affinity that judges gap by gap: the room at each gap beside the room that an opening needs.

use crosscut_explain::{Judged, judged};
use crosscut_stage::Frame;
use rerun::{AsComponents, LineStrips2D, Radius, RecordingStream, RecordingStreamResult};

use crate::colors::{GRID, TOLERANCE, color};
use crate::rows::Rows;
use crate::schema::{AFFINITY_GAPS, AFFINITY_GAPS_AXIS};
use crate::tracks::Classes;
use crate::words::words;

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
    let above = ([0.5 * RIGHT, -HALF - 3.6], "above 1: an opening, between two walls".to_owned());
    let below = ([0.5 * RIGHT, HALF + 1.4], "below 1: the wall continues".to_owned());
    let names = ticks.map(|ratio| ([-1.6, y(ratio) - 0.9], format!("{ratio}"))).into_iter().chain([above, below]);
    rec.log_static(AFFINITY_GAPS.path, &LineStrips2D::update_fields().with_show_labels(false))?;
    rec.log_static(AFFINITY_GAPS_AXIS.path, &[&lines as &dyn AsComponents, &words(names)])
}

/// A column for each gap from the threshold up, or down, in the colours of the walls on its two sides; at its foot their numbers, at
/// its end how far the ends of the walls are apart.
pub(crate) fn log(rows: &mut Rows, frame: &Frame, classes: &Classes) {
    let is_drawn = |gap: &Judged| (RATIOS[0]..=RATIOS[1]).contains(&gap.verdict.room_ratio);
    let gaps: Vec<_> = judged(frame).into_iter().filter(is_drawn).take(DRAWN).collect();
    let x = |at: usize| COLUMN * (at as f32 + 0.75);
    let walls_of = |gap: &Judged| if gap.walls[0] == gap.walls[1] { vec![gap.walls[0]] } else { gap.walls.to_vec() };
    let (columns, of_walls): (Vec<_>, Vec<_>) = (gaps.iter().enumerate())
        .flat_map(|(at, gap)| {
            let walls = walls_of(gap);
            let aside = 0.1 * COLUMN * (walls.len() - 1) as f32;
            let column = move |x: f32| [[x, 0.0], [x, y(gap.verdict.room_ratio)]];
            let of_wall =
                move |(side, wall)| (column(x(at) + if side == 0 { -aside } else { aside }), classes.of_wall(wall));
            walls.into_iter().enumerate().map(of_wall).collect::<Vec<_>>()
        })
        .unzip();
    let lines =
        LineStrips2D::new(columns).with_radii([Radius::new_scene_units(0.13 * COLUMN)]).with_class_ids(of_walls);
    let beyond = |ratio: f64| y(ratio) + if ratio > 1.0 { -3.4 } else { 1.0 };
    let foot = |ratio: f64| if ratio > 1.0 { 0.6 } else { -3.0 };
    let numbers = |gap: &Judged| {
        let name = |wall: Option<u32>| wall.map_or_else(|| "-".to_owned(), |wall| wall.to_string());
        walls_of(gap).into_iter().map(name).collect::<Vec<_>>().join("|")
    };
    let named = gaps.iter().enumerate().flat_map(|(at, gap)| {
        let (ratio, width) = (gap.verdict.room_ratio, gap.gap_m.map_or(String::new(), |gap_m| format!("{gap_m:.1} m")));
        [([x(at), beyond(ratio)], width), ([x(at), foot(ratio)], numbers(gap))]
    });
    rows.log(&AFFINITY_GAPS, &[&lines as &dyn AsComponents, &words(named)]);
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

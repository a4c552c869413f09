//! The answer: count, place, walls and openings, as values and as text.

use crosscut_stage::{Frame, Opening, Wall, Way, counted};
use rerun::{
    MediaType, RecordingStream, RecordingStreamResult, Scalars, StateChange, StateConfiguration, TextDocument,
};

use crate::colors::{GREY, INVISIBLE, PLACES, REPORTED, color, name_of, series};
use crate::rows::Rows;
use crate::schema::{
    REPORT_AXIS, REPORT_CONFIDENCE, REPORT_JUNCTIONS, REPORT_LABELS, REPORT_PLACE, REPORT_SUMMARY, REPORT_WALLS,
};
use crate::tensors::{f64_matrix, i32_vector};
use crate::tracks::Classes;

/// The least range of plots of counts, which gives a steady count its scale.
const COUNTS: [f64; 2] = [0.0, 5.0];

/// Names and colours of the lines over time.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    rec.log_static(REPORT_JUNCTIONS.path, &series("walls", REPORTED, 4.0))?;
    rec.log_static(REPORT_SUMMARY.path, &TextDocument::update_fields().with_media_type(MediaType::MARKDOWN))?;
    rec.log_static(REPORT_CONFIDENCE.path, &series("confidence", GREY, 1.5))?;
    rec.log_static(REPORT_AXIS.path, &series("", INVISIBLE, 0.5))?;
    let (places, colors): (Vec<_>, Vec<_>) = PLACES.into_iter().unzip();
    let places = StateConfiguration::new()
        .with_labels(places.iter().map(spaced))
        .with_values(places)
        .with_colors(colors.into_iter().map(color));
    rec.log_static(REPORT_PLACE.path, &places)
}

/// Invisible points that widen the plots of counts. A fixed axis would cut off larger counts.
pub(crate) fn log_axis(rows: &mut Rows) {
    rows.log(&REPORT_AXIS, &Scalars::new(COUNTS));
}

/// Count, place, summary, walls and labels of one revolution.
pub(crate) fn log(rows: &mut Rows, frame: &Frame, classes: &Classes) {
    let junction = &frame.junction;
    rows.log(&REPORT_JUNCTIONS, &Scalars::single(junction.junctions as f64));
    rows.log(&REPORT_CONFIDENCE, &Scalars::new(junction.confidence));
    rows.log(&REPORT_PLACE, &StateChange::single(junction.place.to_string()));
    rows.log(&REPORT_SUMMARY, &TextDocument::new(summary(frame, classes)));
    rows.log_tensor(&REPORT_LABELS, i32_vector(frame.labels().into_iter(), REPORT_LABELS.dims), &[]);
    rows.log_tensor(&REPORT_WALLS, walls(frame, classes), &[]);
}

/// A row per wall.
fn walls(frame: &Frame, classes: &Classes) -> rerun::TensorData {
    let walls = &frame.junction.walls;
    let row = |wall: &Wall| {
        let [from_rad, to_rad] = wall.bearing_rad;
        let class = classes.of_wall(Some(wall.id));
        [f64::from(wall.id), wall.returns as f64, from_rad, to_rad, f64::from(u8::from(wall.island)), f64::from(class)]
    };
    f64_matrix(walls.iter().flat_map(row).collect(), [walls.len(), 6], REPORT_WALLS.dims)
}

/// Count and place as a title, then k, then tables of openings and walls.
fn summary(frame: &Frame, classes: &Classes) -> String {
    let (junction, spectrum) = (&frame.junction, &frame.spectrum);
    let (count, k, n) = (junction.junctions, spectrum.k, frame.revolution.len());
    let confidence =
        junction.confidence.map_or("unknown".to_owned(), |confidence| format!("{:.0} %", 100.0 * confidence));
    let ways = junction.ways.as_ref().map(|ways| counted(ways.len() as u64, "way") + " on · level view: ");
    let mut lines = vec![
        format!("# {}{} · {}\n", ways.unwrap_or_default(), counted(count as u64, "wall"), junction.place.words()),
        format!("k = {k}, {}, confidence {confidence}.", counted(n as u64, "return")),
    ];
    lines.extend(spectrum.margin_decades.map(|margin| format!("Margin of k: {margin:.1} decades.")));
    let holds_m = frame.affinity.holds_for_width_m;
    lines.extend(holds_m.map(|holds_m| crosscut_explain::widths(count, holds_m)));
    if let Some(ways) = &junction.ways {
        lines.push("\n| way on | colour | where to: clearance | p | cut by view |\n|---|---|---|---|---|".to_owned());
        lines.extend((0..).zip(ways).map(|(number, way)| way_row(number, way, classes)));
    }
    if !junction.openings.is_empty() {
        lines.push("\n| opening | width | between walls | seen by | known |\n|---|---|---|---|---|".to_owned());
        lines.extend(junction.openings.iter().map(opening_row));
    }
    if !junction.walls.is_empty() {
        lines.push("\n| wall | colour | returns | from | to |\n|---|---|---|---|---|".to_owned());
        lines.extend(junction.walls.iter().map(|wall| wall_row(wall, classes)));
    }
    lines.join("\n")
}

fn way_row(number: u32, way: &Way, classes: &Classes) -> String {
    let (color, cut) = (name_of(classes.of_way(Some(number))), if way.cut_by_view { "yes" } else { "no" });
    format!("| {number} | {color} | {} | {:.2} | {cut} |", way.words(), way.p)
}

fn opening_row(opening: &Opening) -> String {
    let bearing_deg = opening.bearing_rad.to_degrees();
    let [right, left] = opening.walls;
    let (evidence, known) = (spaced(&opening.evidence), opening.known);
    format!("| {bearing_deg:+.0}° | {:.1} m | {right}, {left} | {evidence} | {known} |", opening.width_m)
}

fn wall_row(wall: &Wall, classes: &Classes) -> String {
    let island = if wall.island { " (island)" } else { "" };
    let [from_deg, to_deg] = wall.bearing_rad.map(f64::to_degrees);
    let color = name_of(classes.of_wall(Some(wall.id)));
    format!("| {}{island} | {color} | {} | {from_deg:+.0}° | {to_deg:+.0}° |", wall.id, wall.returns)
}

/// A name of the results with spaces instead of underscores.
fn spaced(name: &impl ToString) -> String {
    name.to_string().replace('_', " ")
}

//! The answer: count, place, walls and openings in words; notes and timings.

use crosscut_stage::{Frame, Opening, Step, Wall};
use rerun::{RecordingStream, RecordingStreamResult, Scalars, StateChange, TextDocument, TextLog, TextLogLevel};

use crate::beam_order::LARGEST_SIDE;
use crate::colors::{REPORTED, STEPS, series};
use crate::matrices::is_drawn;

/// Names and colours of the lines over time.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    rec.log_static("report/junctions", &series("junctions (walls)", REPORTED, 5.0))?; // seen behind k where both agree
    for (step, rgba) in Step::ALL.into_iter().zip(STEPS) {
        rec.log_static(format!("timing/{step}"), &series(step.name(), rgba, 2.0))?;
    }
    Ok(())
}

/// Count, place, summary, notes and timings of one revolution.
pub(crate) fn log(rec: &RecordingStream, frame: &Frame) -> RecordingStreamResult<()> {
    let junction = &frame.junction;
    rec.log("report/junctions", &Scalars::single(junction.junctions as f64))?;
    rec.log("report/confidence", &Scalars::single(junction.confidence))?;
    rec.log("report/place", &StateChange::single(junction.place.to_string()))?;
    rec.log("report/summary", &TextDocument::from_markdown(summary(frame)))?;
    for step in Step::ALL {
        rec.log(format!("timing/{step}"), &Scalars::single(frame.timings.ns(step) as f64 * 1e-6))?;
    }
    log_notes(rec, frame)
}

/// What was noted on the way, and what this recording leaves out.
fn log_notes(rec: &RecordingStream, frame: &Frame) -> RecordingStreamResult<()> {
    for note in frame.notes.iter() {
        rec.log("log", &TextLog::new(note).with_level(TextLogLevel::INFO))?;
    }
    let n = frame.affinity.weights.n();
    if n > 0 && !is_drawn(frame) {
        let note = format!("no picture of W and L: {n} returns, pictures are made up to {LARGEST_SIDE}");
        rec.log("log", &TextLog::new(note).with_level(TextLogLevel::INFO))?;
    }
    Ok(())
}

/// The revolution in a few large words, then its openings and walls.
fn summary(frame: &Frame) -> String {
    let (junction, spectrum) = (&frame.junction, &frame.spectrum);
    let (count, k, n) = (junction.junctions, spectrum.k, frame.revolution.len());
    let confidence = 100.0 * junction.confidence;
    let mut lines = vec![
        format!("# {count} junction{} · {}\n", if count == 1 { "" } else { "s" }, spaced(&junction.place)),
        format!("k = {k}, {n} returns, confidence {confidence:.0} %."),
    ];
    lines.extend(spectrum.margin_decades.map(|margin| format!("Margin of k: {margin:.1} decades.")));
    if !junction.openings.is_empty() {
        lines.push("\n| opening | width | between walls | seen by |\n|---|---|---|---|".to_owned());
        lines.extend(junction.openings.iter().map(opening_row));
    }
    if !junction.walls.is_empty() {
        lines.push("\n| wall | returns | from | to |\n|---|---|---|---|".to_owned());
        lines.extend(junction.walls.iter().map(wall_row));
    }
    lines.join("\n")
}

fn opening_row(opening: &Opening) -> String {
    let bearing_deg = opening.bearing_rad.to_degrees();
    let [right, left] = opening.walls;
    format!("| {bearing_deg:+.0}° | {:.1} m | {right}, {left} | {} |", opening.width_m, spaced(&opening.evidence))
}

fn wall_row(wall: &Wall) -> String {
    let island = if wall.island { " (island)" } else { "" };
    let [from_deg, to_deg] = wall.bearing_rad.map(f64::to_degrees);
    format!("| {}{island} | {} | {from_deg:+.0}° | {to_deg:+.0}° |", wall.id, wall.returns)
}

/// A name as in results, without its underscores.
fn spaced(name: &impl ToString) -> String {
    name.to_string().replace('_', " ")
}
